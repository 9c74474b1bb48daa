"""What several claims are judged with."""

from functools import lru_cache

import numpy as np
import pandas as pd

from vibrissa import collocation
from vibrissa.arrays import FloatArray
from vibrissa.bending import Bending
from vibrissa.curve import StickingCurve
from vibrissa.ledger import Verdict
from vibrissa.status import Status
from vibrissa.units import Rod

HOLDS, CONDITION, AMBIGUOUS, CONTRADICTED = Verdict

# The paper's example of a rod: steel, E = 2.1e5 MPa, d0 = 5 mm, L = 100 mm.
EXAMPLE = Rod(youngs_modulus=2.1e11, base_diameter=5e-3, length=0.1)
# Misfit of a state, and of what follows from it, that counts as none.
NEGLIGIBLE = 1e-9
# Tapers of the sweep beyond Figure 6.
WIDE_TAPERS = np.arange(1.0, 20.5, 0.5)


@lru_cache(maxsize=4)
def wide_sweep(eta: float) -> tuple[StickingCurve, ...]:
    """Sticking curves of the tapers of `WIDE_TAPERS`."""
    curves = collocation.solve_curves(WIDE_TAPERS, np.full_like(WIDE_TAPERS, eta))
    return tuple(curve for curve in curves if curve.status is Status.SOLVED)


def rises(values: FloatArray | pd.DataFrame, axis: int = 0) -> bool:
    """Whether values rise strictly along an axis."""
    return bool((np.diff(np.asarray(values), axis=axis) > 0.0).all())


def line_fit(x: FloatArray, y: FloatArray) -> tuple[float, float, float]:
    """Slope of the straight line through points, its R² and its largest misfit."""
    line = np.polynomial.Polynomial.fit(x, y, 1)
    misfit = y - line(x)
    share = 1.0 - float(misfit @ misfit) / float(((y - y.mean()) ** 2).sum())
    return float(line.deriv()(0.0)), share, float(np.abs(misfit).max())


def by_bending(what: str, before: Bending, after: Bending) -> tuple[Verdict, str]:
    """Verdict on whether rods are bent more after than before, by every measure of bending."""
    measures = {
        "bending energy": (before.energy, after.energy),
        "turn of the tip": (before.turn, after.turn),
        "largest curvature": (before.curvature, after.curvature),
        "largest strain": (before.strain, after.strain),
    }
    up = [name for name, (old, new) in measures.items() if (new > old).all()]
    others = [name for name in measures if name not in up]
    if not others:
        return HOLDS, f"{what} by every measure: {', '.join(up)}"
    if not up:
        return CONTRADICTED, f"{what} by none of the measures {', '.join(others)} throughout"
    # The energy is of the rod as a whole; the others look at one place of it.
    verdict = CONDITION if "bending energy" in up else AMBIGUOUS
    return verdict, f"{what} throughout as measured by {', '.join(up)}, not by {', '.join(others)}"
