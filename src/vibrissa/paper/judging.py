"""Functions that the judgements of several statements share."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from vibrissa.mechanics.bending import Bending
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Status
from vibrissa.paper.ledger import Finding, Quantities, Verdict
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving import collocation

HOLDS, CONDITION, AMBIGUOUS, CONTRADICTED = Verdict

# The paper's example of a rod: steel, E = 2.1e5 MPa, d0 = 5 mm, L = 100 mm.
EXAMPLE = Rod(youngs_modulus=2.1e11, base_diameter=5e-3, length=0.1)
# Unit of energies and moments.
ENERGY = "E*I0/L"
# Residuals and differences below this count as zero.
NEGLIGIBLE = 1e-9
# Measures of bending, by their names.
MEASURES = {
    "bending energy": attrgetter("energy"),
    "turn of the tip": attrgetter("turn"),
    "largest curvature": attrgetter("curvature"),
    "largest strain": attrgetter("strain"),
}
# Tapers of the sweep beyond Figure 6.
WIDE_TAPERS = np.arange(1.0, 20.5, 0.5)


@lru_cache(maxsize=4)
def wide_sweep(eta: float) -> tuple[StickingCurve, ...]:
    """Solve the equilibrium paths of all `WIDE_TAPERS` in tip contact; omit those that fail."""
    curves = collocation.solve_curves(WIDE_TAPERS, np.full_like(WIDE_TAPERS, eta))
    return tuple(curve for curve in curves if curve.status is Status.SOLVED)


def spread(what: str, values: ArrayLike, unit: str) -> Quantities:
    """Return the smallest and the largest value as quantities; `what` names the values."""
    found = np.asarray(values)
    return {f"smallest {what}": (found.min(), unit), f"largest {what}": (found.max(), unit)}


def ends(what: str, values: ArrayLike, unit: str) -> Quantities:
    """Return the first and the last value as quantities; `what` names the values.

    The values are ordered by μ0.
    """
    found = np.asarray(values)
    return {
        f"{what} at the smallest μ0": (found[0], unit),
        f"{what} at the largest": (found[-1], unit),
    }


def judged(
    quantities: Quantities,
    *,
    contradicted: bool,
    condition: bool = False,
    ambiguous: bool = False,
    reason: str = "",
) -> Finding:
    """Return a finding with the verdict of the first flag that is true.

    If no flag is true, the statement holds.
    """
    verdicts = {CONTRADICTED: contradicted, CONDITION: condition, AMBIGUOUS: ambiguous}
    verdict = next((verdict for verdict, applies in verdicts.items() if applies), HOLDS)
    return Finding(verdict=verdict, quantities=quantities, reason=reason)


def rises(values: FloatArray | pd.DataFrame, *axes: int) -> bool:
    """Whether values rise strictly along each of `axes`, by default along the first axis."""
    return all((np.diff(np.asarray(values), axis=axis) > 0.0).all() for axis in axes or (0,))


@dataclass(frozen=True, kw_only=True)
class LineFit:
    """A straight line fitted to points: its slope, R², and the largest deviation of a point."""

    slope: float
    r_squared: float
    deviation: float


def line_fit(x: FloatArray, y: FloatArray) -> LineFit:
    """Fit a straight line by least squares."""
    line = np.polynomial.Polynomial.fit(x, y, 1)
    off = y - line(x)
    return LineFit(
        slope=float(line.deriv()(0.0)),
        r_squared=1.0 - float(off @ off) / float(((y - y.mean()) ** 2).sum()),
        deviation=float(np.abs(off).max()),
    )


def neighbours(series: Sequence[Bending]) -> tuple[Bending, Bending]:
    """Pair each rod with the next of its series; return the first and second rods of all pairs."""
    before = [rods.take(np.arange(len(rods) - 1)) for rods in series]
    after = [rods.take(np.arange(1, len(rods))) for rods in series]
    return Bending.concatenate(before), Bending.concatenate(after)


def by_bending(what: str, before: Bending, after: Bending, quantities: Quantities) -> Finding:
    """Judge by each measure of bending whether every rod is bent more in `after` than in `before`.

    Parameters
    ----------
    what : str
        Statement that is judged, such as "the rod is deformed further".
    """
    more = [name for name, one in MEASURES.items() if (one(after) > one(before)).all()]
    others = ", ".join(name for name in MEASURES if name not in more)
    reason = f"{what} as measured by {', '.join(more)}, but not throughout by {others}"
    if not others:
        reason = f"{what} by every measure: {', '.join(more)}"
    if not more:
        reason = f"no measure ({others}) shows throughout that {what}"
    return judged(
        quantities,
        contradicted=not more,
        # The energy belongs to the whole rod, the other measures to one place of it.
        condition=bool(others) and "bending energy" in more,
        ambiguous=bool(others),
        reason=reason,
    )
