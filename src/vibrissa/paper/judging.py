"""What several claims are judged with."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pandas as pd

from vibrissa.mechanics.bending import Bending
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Status
from vibrissa.paper.ledger import Verdict
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving import collocation

HOLDS, CONDITION, AMBIGUOUS, CONTRADICTED = Verdict

# The paper's example of a rod: steel, E = 2.1e5 MPa, d0 = 5 mm, L = 100 mm.
EXAMPLE = Rod(youngs_modulus=2.1e11, base_diameter=5e-3, length=0.1)
# Residual of a state, and of what follows from it, that counts as none.
NEGLIGIBLE = 1e-9
# Tapers of the sweep beyond Figure 6.
WIDE_TAPERS = np.arange(1.0, 20.5, 0.5)


@lru_cache(maxsize=4)
def wide_sweep(eta: float) -> tuple[StickingCurve, ...]:
    """Sticking curves of the tapers of `WIDE_TAPERS` in tip contact."""
    curves = collocation.solve_curves(WIDE_TAPERS, np.full_like(WIDE_TAPERS, eta))
    return tuple(curve for curve in curves if curve.status is Status.SOLVED)


def holds_if(condition: bool) -> Verdict:
    """Say that a statement holds, or else is contradicted."""
    return HOLDS if condition else CONTRADICTED


def rises(values: FloatArray | pd.DataFrame, axis: int = 0) -> bool:
    """Whether values rise strictly along an axis."""
    return bool((np.diff(np.asarray(values), axis=axis) > 0.0).all())


@dataclass(frozen=True, kw_only=True)
class Line:
    """The straight line through points: slope, R², and the largest deviation of a point from it."""

    slope: float
    r_squared: float
    deviation: float


def line_fit(x: FloatArray, y: FloatArray) -> Line:
    """Fit a straight line by least squares."""
    line = np.polynomial.Polynomial.fit(x, y, 1)
    off = y - line(x)
    return Line(
        slope=float(line.deriv()(0.0)),
        r_squared=1.0 - float(off @ off) / float(((y - y.mean()) ** 2).sum()),
        deviation=float(np.abs(off).max()),
    )


def neighbours(series: Sequence[Bending]) -> tuple[Bending, Bending]:
    """All rods of several series but the last of each, and the rod that follows each of them."""
    before = [rods.take(np.arange(len(rods) - 1)) for rods in series]
    after = [rods.take(np.arange(1, len(rods))) for rods in series]
    return Bending.concatenate(before), Bending.concatenate(after)


def by_bending(what: str, before: Bending, after: Bending) -> tuple[Verdict, str]:
    """Judge whether each rod is bent more after than before, by every measure of bending.

    Parameters
    ----------
    what : str
        What holds if they are bent more.
    before, after : Bending
        Of the same number of rods.
    """
    measures = {
        "bending energy": after.energy > before.energy,
        "turn of the tip": after.turn > before.turn,
        "largest curvature": after.curvature > before.curvature,
        "largest strain": after.strain > before.strain,
    }
    more = [name for name, is_more in measures.items() if is_more.all()]
    others = [name for name in measures if name not in more]
    if not others:
        return HOLDS, f"{what} by every measure: {', '.join(more)}"
    if not more:
        return CONTRADICTED, f"no measure ({', '.join(others)}) shows throughout that {what}"
    # The energy belongs to the whole rod, the other measures to one place of it.
    verdict = CONDITION if "bending energy" in more else AMBIGUOUS
    return (
        verdict,
        f"{what} as measured by {', '.join(more)}, but not throughout by {', '.join(others)}",
    )
