"""Formatting of names and numbers for the page."""

import math
import re
from collections.abc import Sequence
from typing import Any

from markupsafe import Markup, escape

from vibrissa.outcomes import NO_RESULT
from vibrissa.tables import frames, schemas

# Significant digits of the largest number of a column, and size below which a number is a rounding
# error of zero.
DIGITS, ROUNDING = 5, 1e-15
# "theta" must come before "eta", which it contains.
GREEK = {"theta": "θ", "eta": "η", "mu": "μ", "alpha": "α", "phi": "φ"}


def symbol(column: str) -> str:
    """Return a column's name with Greek letters, such as ``θ`` for ``theta``."""
    for name, letter in GREEK.items():
        column = column.replace(name, letter)
    return column


# Names in captions, the longer ones first, and how they are written in figures.
WRITTEN = {
    "x0,max": "x<sub>0,max</sub>",
    "x1_init": "x<sub>1,init</sub>",
    "x0_slip": "x<sub>0,slip</sub>",
    "mu_lock": "μ<sub>lock</sub>",
    "mu0": "μ<sub>0</sub>",
    "dx0": "Δx<sub>0</sub>",
    "phi1": "φ<sub>1</sub>",
    "x0": "x<sub>0</sub>",
    "theta": "θ",
    "alpha": "α",
    "eta": "η",
}
_NAMES = re.compile(rf"\b({'|'.join(WRITTEN)})\b")


def with_symbols(text: str) -> Markup:
    """Write a text as HTML, with names such as ``mu0`` as symbols."""
    return Markup(_NAMES.sub(lambda found: WRITTEN[found[1]], str(escape(text))))


def spell_column(values: Sequence[Any]) -> list[str]:
    """Format numbers of a column with the same number of decimals; format other values alone."""
    numbers = [value for value in values if isinstance(value, float) and math.isfinite(value)]
    largest = max(map(abs, numbers), default=0.0)
    if not largest:
        return [spell(value) for value in values]
    decimals = max(0, DIGITS - 1 - math.floor(math.log10(largest)))
    texts = {value: f"{value:.{decimals}f}" for value in numbers}
    # Zeros at the end of all numbers are dropped.
    kept = max(len(text.rstrip("0").partition(".")[2]) for text in texts.values())
    return [
        f"{value:.{kept}f}".replace("-", "−") if value in texts else spell(value)
        for value in values
    ]


def spell(value: Any, digits: int = 5) -> str:
    """Format a table's value, with a true minus sign; a missing value becomes a dash."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, str):
        return value.replace("_", " ") if value in NO_RESULT else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if 0.0 < abs(value) < ROUNDING:
        return "< 10⁻¹⁵"
    text = f"{value:.{digits}g}"
    if exponent := re.fullmatch(r"(.*)e([+-])0*(\d+)", text):
        raised = str(exponent[3]).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{exponent[1]}·10{'⁻' if exponent[2] == '-' else ''}{raised}"
    return text.replace("-", "−").replace("inf", "∞")


def spell_unit(unit: str) -> str:
    """Format the unit of a table's column; empty if dimensionless."""
    return "" if unit == schemas.NONE else frames.spell_unit(unit)
