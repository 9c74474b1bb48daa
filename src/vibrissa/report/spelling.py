"""Names and numbers as a reader finds them on the page."""

import math
import re
from collections.abc import Mapping
from typing import Any

from vibrissa.tables import frames, schemas

SYMBOLS = {
    "theta": "θ",
    "mu0": "μ0",
    "eta": "η",
    "dx0": "Δx0",
    "x0_slip": "exact onset",
    "x0_max": "x0,max",
    "mu_lock": "μ_lock",
    "f_slip": "force at onset",
    "phi1_slip": "φ1 at onset",
    "reaction_m_slip": "moment at onset",
    "x1_init": "x1 at α = 0",
    "f_init": "force at α = 0",
    "reaction_m_init": "moment at α = 0",
    "f": "force",
    "alpha": "α",
    "phi1": "φ1",
    "reaction_fx": "Fx",
    "reaction_fy": "Fy",
    "reaction_m": "M",
    "x0_slip_point": "onset, tip",
    "x0_slip_line": "onset, line",
    "mu_lock_point": "μ_lock, tip",
    "mu_lock_line": "μ_lock, line",
    "status_point": "tip contact",
    "status_line": "line contact",
}
# Statuses of rows without a result.
NO_RESULT = ("failed", "out_of_reach")


def symbol(column: str) -> str:
    """Symbol of a table's column, or its name where it has none."""
    return SYMBOLS.get(column, column)


def spell(value: Any, digits: int = 5) -> str:
    """Spell a value of a table: some digits, a true minus sign, and a dash for nothing."""
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
    """Spell the unit of a table's column; nothing for a plain number."""
    return "" if unit == schemas.NONE else frames.spell_unit(unit)


def spell_counts(statuses: Mapping[str, int]) -> str:
    """Spell the total number, and the number with each status."""
    counts, total = sorted(statuses.items()), sum(statuses.values())
    if len(counts) < 2:
        return f"{total:,}" + "".join(f", {'all ' * (n > 1)}{spell(s)}" for s, n in counts)
    return f"{total:,}: " + ", ".join(f"{n:,} {spell(s)}" for s, n in counts)
