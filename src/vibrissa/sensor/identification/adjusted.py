"""What the recording tells of the parameters: how far from what was given, and how well known."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.tolerances import told

# So many standard deviations are far from what was given, and an adjustment as a whole of a lower
# probability; and less of a variance than this is not told by a recording.
FAR, UNLIKELY, LITTLE = 3.0, 1e-3, 0.01
# What the recording tells at least this part of, by the variance, is tested as a whole.
TOLD = 0.5


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """Something that is known to a tolerance, and what the recording tells of it.

    Attributes
    ----------
    name : str
    of : str
        Name of the tolerance, which may have several parts.
    tolerance : float
        Standard deviation of what was given.
    adjusted, deviation : float
        By how much it is larger by the recording, and the standard deviation that remains.
    wave : int
        Number of the wave of a drift; 0 for all else.
    stated : bool
        Whether the tolerance was stated; otherwise it was assumed.
    """

    name: str
    of: str
    tolerance: float
    adjusted: float
    deviation: float
    wave: int = 0
    stated: bool = True

    @property
    def surprise(self) -> float:
        """How far the recording is from what was given, in standard deviations.

        An adjustment p has before the variance σ² − s², where s² is what remains of the tolerance
        σ². The sum that is minimised would fall by the square of this without the tolerance.
        """
        told_of = 1.0 - (self.deviation / self.tolerance) ** 2
        score = abs(self.adjusted) / self.tolerance
        return float(score / np.sqrt(told_of)) if told_of > LITTLE else 0.0

    def moved(self, units: Units) -> str:
        """Say by how much it is other than given, and how surprising that is."""
        size, unit = told(self.of, abs(self.adjusted), units)
        way = "larger" if self.adjusted > 0.0 else "smaller"
        by = f"{size:.3g} {unit}".rstrip()
        return f"{self.name} {way} by {by} than given ({self.surprise:.1f} standard deviations)"

    def spelled(self, units: Units) -> str:
        """Say it in a person's units."""
        adjusted, unit = told(self.of, self.adjusted, units)
        deviation, tolerance = (
            told(self.of, size, units)[0] for size in (self.deviation, self.tolerance)
        )
        text = (
            f"{self.name}: given to ± {tolerance:.3g} {unit}, by the recording {adjusted:+.3g} ± "
            f"{deviation:.2g} {unit} beside that"
        )
        return text.replace("  ", " ").replace(" ,", ",")


def tolerances_of(fit: Fit) -> tuple[Tolerance, ...]:
    """Say what the fit tells of each parameter that has a tolerance."""
    left = np.sqrt(np.diag(fit.covariance))
    parameters = [one for one in fit.forward.parameters if one.deviation > 0.0]
    return tuple(
        Tolerance(
            name=one.name,
            of=one.of,
            tolerance=one.deviation,
            adjusted=float(size),
            deviation=float(deviation),
            wave=one.wave,
            stated=one.stated,
        )
        for one, size, deviation in zip(parameters, fit.p[fit.free], left, strict=True)
    )


def far_of(fit: Fit) -> tuple[Tolerance, ...]:
    """Parameters that are far from what was given for their tolerance, the farthest first."""
    known = [one for one in tolerances_of(fit) if not one.wave]
    known.sort(key=lambda one: -one.surprise)
    far = tuple(one for one in known if one.surprise > FAR)
    return far or tuple(known[:1] if _chance(fit) < UNLIKELY else ())


def _chance(fit: Fit) -> float:
    """Probability of such adjustments: before, their covariance is what the recording tells."""
    if not len(fit.scores):
        return 1.0
    part, axes = np.linalg.eigh(np.eye(len(fit.scores)) - fit.remaining)
    along = axes.T @ fit.scores
    told_of = part > TOLD
    squares = float((along[told_of] ** 2 / part[told_of]).sum())
    return float(chdtrc(max(int(told_of.sum()), 1), squares))
