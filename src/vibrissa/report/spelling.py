"""Formatting of names and numbers for the page."""

import math
import re
from typing import Any

from vibrissa.outcomes import NO_RESULT
from vibrissa.tables import frames, schemas

# "theta" must come before "eta", which it contains.
GREEK = {"theta": "θ", "eta": "η", "mu": "μ", "alpha": "α", "phi": "φ"}


def symbol(column: str) -> str:
    """Return a column's name with Greek letters, such as ``θ`` for ``theta``."""
    for name, letter in GREEK.items():
        column = column.replace(name, letter)
    return column


def spell(value: Any, digits: int = 5) -> str:
    """Format a table's value, with a true minus sign; a missing value becomes a dash."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, str):
        return value.replace("_", " ") if value in NO_RESULT else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f"{value:.{digits}g}"
    if exponent := re.fullmatch(r"(.*)e([+-])0*(\d+)", text):
        raised = str(exponent[3]).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{exponent[1]}·10{'⁻' if exponent[2] == '-' else ''}{raised}"
    return text.replace("-", "−").replace("inf", "∞")


def spell_unit(unit: str) -> str:
    """Format the unit of a table's column; empty if dimensionless."""
    return "" if unit == schemas.NONE else frames.spell_unit(unit)
