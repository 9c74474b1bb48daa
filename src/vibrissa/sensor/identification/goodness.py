"""Whether a recording as a whole fits what was given, and if not, what may be the cause.

Each period is tested by itself, too. Small misfits that all periods share show in their sum alone.
A cause is judged by what it would explain if it were the only one: to first order, with the best
contact of each period.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import chdtrc, fdtrc

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.tolerances import told
from vibrissa.sensor.transducer import CHANNELS

# Those that have the effect of another one, or would explain anything.
NOT_NAMED = ("diameter", "crosstalk", "drift_force_x", "drift_force_y", "drift_moment_z", "delay")
# Probability with which a recording that fits is said not to.
LEVEL = 1e-3
# Independent values per second difference of readings, from which noise is estimated: neighbours
# are correlated by −2/3, the next ones by 1/6.
PER_DIFFERENCE = 18.0 / 35.0
# Readings that scatter by this factor more than their noise have another noise.
NOISY = 1.25


@dataclass(frozen=True, kw_only=True)
class Goodness:
    """Sum of the squared residuals of a recording, in standard deviations, and how likely it is.

    Attributes
    ----------
    chi2 : float
    degrees : int
        Means of readings, less what was fitted to them.
    noise_degrees : float
        Degrees of freedom of the noise; infinite where it was given.
    noisier : dict of str to float
        Channels that scatter by more than the noise that was given, and by which factor.
    """

    chi2: float
    degrees: int
    noise_degrees: float = np.inf
    noisier: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, fit: Fit, noise_is_given: bool) -> "Goodness":
        """Test the periods to which the set-up was fitted."""
        rows = int(fit.kept[fit.forward.blocks.period].sum()) * len(fit.noise.used)
        differences = fit.forward.rows * len(fit.noise.used) * PER_DIFFERENCE
        return cls(
            chi2=float(fit.squares[fit.kept].sum() + fit.penalty),
            degrees=rows - int(fit.kept.sum()),
            noise_degrees=np.inf if noise_is_given else differences,
        )

    def with_scatter(self, scatter: FloatArray, noise: FloatArray) -> "Goodness":
        """Name the channels that scatter by more than their noise, shape (3,) each."""
        parts = zip(CHANNELS, scatter, noise, strict=True)
        noisier = {n: float(own / given) for n, own, given in parts if own > NOISY * given > 0.0}
        return replace(self, noisier=noisier)

    @property
    def ratio(self) -> float:
        """χ² per degree of freedom: 1 where the recording fits; NaN without any."""
        return self.chi2 / self.degrees if self.degrees > 0 else np.nan

    @property
    def chance(self) -> float:
        """Probability of such a χ², or a larger one, where the recording fits."""
        if self.degrees <= 0:
            return 1.0
        if np.isinf(self.noise_degrees):
            return float(chdtrc(self.degrees, self.chi2))
        return float(fdtrc(self.degrees, self.noise_degrees, self.ratio))

    @property
    def fits(self) -> bool:
        """Whether the recording fits what was given."""
        return self.chance >= LEVEL


@dataclass(frozen=True, kw_only=True)
class Cause:
    """What may be other than it was given, if nothing else is.

    Attributes
    ----------
    name, of : str
        And the tolerance to which it belongs.
    size, deviation : float
        By how much it would be larger, and the standard deviation of that.
    explained : float
        Part of χ², as far as it is too large, that this explains.
    """

    name: str
    of: str
    size: float
    deviation: float
    explained: float

    def spelled(self, units: Units) -> str:
        """Say what it is and by how much, in a person's units."""
        way = "larger" if self.size > 0.0 else "smaller"
        size, unit = told(self.of, abs(self.size), units)
        deviation, _ = told(self.of, self.deviation, units)
        return f"{self.name} {way} by {size:.3g} ± {deviation:.1g} {unit}".rstrip()


def causes_of(fit: Fit, goodness: Goodness) -> tuple[Cause, ...]:
    """Fit each parameter alone to the residuals, the one that explains most first."""
    causes = []
    rows = fit.kept[fit.forward.blocks.period]
    for one, change in zip(fit.forward.parameters, fit.changes, strict=True):
        with np.errstate(over="ignore"):
            information = float((change[rows] ** 2).sum())
        if one.of in NOT_NAMED or not 0.0 < information < np.inf:
            continue
        product = float((change[rows] * fit.residuals[rows]).sum())
        causes.append(
            Cause(
                name=one.name,
                of=one.of,
                size=product / information,
                deviation=information**-0.5,
                explained=product * (product / information) / (goodness.chi2 - goodness.degrees),
            )
        )
    return tuple(sorted(causes, key=lambda cause: -cause.explained))
