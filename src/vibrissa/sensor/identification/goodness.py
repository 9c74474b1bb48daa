"""Whether a recording fits the given set-up within its tolerances, and if not, likely causes.

A parameter has the tolerance σ, and the fit changes it by p ± s. If the tolerance were infinite,
the minimised sum would be lower by (p/σ)²/(1 − s²/σ²), to first order. The square root of this
difference is the surprise of the parameter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, fdtrc, ndtri

from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Units
from vibrissa.sensor.identification.fit import LEAST_WEIGHT
from vibrissa.sensor.identification.fitted_set_up import FittedSetUp
from vibrissa.sensor.identification.parameters import Parameter
from vibrissa.sensor.tolerances import displayed

# Least part of a parameter's variance that a recording must remove: less is rounding.
LEAST_REMOVED = 1e-9
# Quantities that are not named as causes: they act like another quantity, or explain any misfit.
NOT_NAMED = (
    "diameter",
    "stiffening",
    "crosstalk",
    "drift_force_x",
    "drift_force_y",
    "drift_moment_z",
)
# Significance level: probability that a recording which fits is called one that does not fit.
SIGNIFICANCE = 1e-3
# Degrees of freedom per reading, for noise that is estimated from second differences: neighbours
# are correlated by −2/3, the next ones by 1/6. Differences of pairs at rest have as many.
PER_READING = 18.0 / 35.0
# Largest number of causes that are named.
NAMED_CAUSES = 3
# Least part of the misfit that a cause must explain.
CAUSE_EXPLAINS = 0.1


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Estimate of a parameter from a recording.

    Attributes
    ----------
    size, deviation : float
        Excess of the parameter over its given value, and the standard deviation of the excess.
    most : float
        Largest surprise that is due to chance: see `most_surprise`.
    """

    parameter: Parameter
    size: float
    deviation: float
    most: float

    @property
    def surprise(self) -> float:
        """Surprise, see this module; 0 if the recording hardly determines the parameter."""
        tolerance = self.parameter.deviation
        known = 1.0 - (self.deviation / tolerance) ** 2
        return float(abs(self.size) / tolerance / np.sqrt(known)) if known > LEAST_REMOVED else 0.0

    @property
    def far(self) -> bool:
        """Whether the surprise exceeds `most`; false for half waves, which are parts of a drift."""
        return not self.parameter.wave and self.surprise > self.most

    def spelled(self, units: Units) -> str:
        """Format the estimate in the user's units."""
        of = self.parameter.of
        stated = self.parameter.deviation
        size, unit = displayed(of, self.size, units)
        deviation, tolerance = (
            displayed(of, error, units)[0] for error in (self.deviation, stated)
        )
        text = (
            f"{self.parameter.name}: given to ± {tolerance:.3g} {unit}, off by {size:+.3g} ± "
            f"{deviation:.2g} {unit} according to the recording"
        )
        return text.replace("  ", " ").replace(" ,", ",")


def most_surprise(number: int) -> float:
    """Return the surprise that the largest of `number` surprises exceeds by chance.

    The surprises are those of a recording that fits, absolute values of standard normal numbers;
    the probability of this chance is `SIGNIFICANCE`.
    """
    return float(-ndtri(0.5 * SIGNIFICANCE / max(number, 1)))


def estimates_of(
    parameters: Sequence[Parameter], sizes: FloatArray, covariance: FloatArray
) -> tuple[Estimate, ...]:
    """Make estimates from parameters, their sizes and the covariance of their remaining errors."""
    left = np.sqrt(np.diag(covariance))
    most = most_surprise(sum(not parameter.wave for parameter in parameters))
    return tuple(
        Estimate(parameter=parameter, size=float(size), deviation=float(deviation), most=most)
        for parameter, size, deviation in zip(parameters, sizes, left, strict=True)
    )


@dataclass(frozen=True, kw_only=True)
class Goodness:
    """χ² of a recording, and the probability of this χ² if the recording fits.

    Attributes
    ----------
    chi2 : float
        Sum of the squared residuals, in standard deviations.
    degrees : int
        Degrees of freedom of the sum.
    noise_degrees : float
        Degrees of freedom of the estimated noise; infinite if the noise was given.
    uneven : bool
        Whether the heights of the tips scatter more than the tolerance of the surface's slope
        allows.
    """

    chi2: float
    degrees: int
    noise_degrees: float = np.inf
    uneven: bool = False

    @classmethod
    def of(cls, fitted: FittedSetUp) -> "Goodness":
        """Test the periods to which the set-up was fitted."""
        readings = len(fitted.task.recording) * len(fitted.task.used)
        return cls(
            chi2=fitted.misfit - fitted.unevenness.chi2,
            degrees=fitted.degrees,
            noise_degrees=np.inf if fitted.task.noise_is_given else PER_READING * readings,
            uneven=fitted.unevenness.chance < SIGNIFICANCE,
        )

    @property
    def ratio(self) -> float:
        """χ² per degree of freedom: about 1 if the recording fits; NaN without such degrees."""
        return self.chi2 / self.degrees if self.degrees > 0 else np.nan

    @property
    def chance(self) -> float:
        """Probability of this χ² or a larger one, if the recording fits."""
        if self.degrees <= 0:
            return 1.0
        if np.isinf(self.noise_degrees):
            return float(chdtrc(self.degrees, self.chi2))
        return float(fdtrc(self.degrees, self.noise_degrees, self.ratio))

    @property
    def only_uneven(self) -> bool:
        """Whether the recording fits but for the heights of the surface."""
        return self.uneven and self.chance >= SIGNIFICANCE

    @property
    def fits(self) -> bool:
        """Whether the recording fits the given set-up."""
        return self.chance >= SIGNIFICANCE and not self.uneven


@dataclass(frozen=True, kw_only=True)
class Cause:
    """A quantity whose given value may be wrong, estimated as if its tolerance were infinite.

    Attributes
    ----------
    size, deviation : float
        Excess of the parameter over its given value, and the standard deviation of the excess.
    explained : float
        Part of the misfit that this quantity explains.
    """

    parameter: Parameter
    size: float
    deviation: float
    explained: float

    def spelled(self, units: Units) -> str:
        """Format the quantity and its change in the user's units."""
        way = "larger" if self.size > 0.0 else "smaller"
        of = self.parameter.of
        size, unit = displayed(of, abs(self.size), units)
        by = f"{size:.3g} ± {displayed(of, self.deviation, units)[0]:.1g} {unit}".rstrip()
        return f"{self.parameter.name} {way} by {by} (explains {self.explained:.0%} of the misfit)"


class _EachAlone(NamedTuple):
    """Each of k parameters, estimated as if it alone had an infinite tolerance, to first order.

    Attributes
    ----------
    size, deviation : ndarray, shape (k,)
        Excess of the parameter over its given value, and its standard deviation.
    fall : ndarray, shape (k,)
        Fall of the minimised sum; 0 for a parameter that is not named as a cause.
    """

    size: FloatArray
    deviation: FloatArray
    fall: FloatArray


def causes_of(fitted: FittedSetUp, fits: bool) -> tuple[Cause, ...]:
    """Find quantities whose given values may be wrong, the likeliest first."""
    parameters = fitted.task.parameters
    degrees = fitted.degrees + fitted.unevenness.number
    excess = float((fitted.fit.scores**2).sum()) if fits else fitted.misfit - degrees
    if excess <= 0.0:
        return ()  # nothing to explain
    size, deviation, fall = _each_alone(fitted)
    # A cause outside the bounds of its parameter, such as an angle of 300°, is none.
    possible = [
        parameter.low <= excess_of <= parameter.high
        for parameter, excess_of in zip(parameters, size.tolist(), strict=True)
    ]
    explained = np.where(possible, np.minimum(fall / excess, 1.0), 0.0)
    likely = sorted(np.flatnonzero(explained >= CAUSE_EXPLAINS).tolist(), key=lambda k: -fall[k])
    # Readings that fit badly for other reasons, too, make each size less certain.
    scatter = np.sqrt(max(fitted.misfit / max(degrees, 1), 1.0))
    return tuple(
        Cause(
            parameter=parameters[k],
            size=float(size[k]),
            deviation=float(scatter * deviation[k]),
            explained=float(explained[k]),
        )
        for k in likely[:NAMED_CAUSES]
    )


def _each_alone(fitted: FittedSetUp) -> _EachAlone:
    """Estimate each parameter alone.

    An exact one is fitted together with the contact points and, if the fit has converged, with
    those that are not exact.
    """
    fit = fitted.fit
    line = fitted.line
    task = fitted.task
    changes = line.changes[:, fit.rows]
    along = (changes * fitted.misses[fit.rows]).sum(axis=(1, 2))
    known = (changes**2).sum(axis=(1, 2))
    if fitted.adjusted:
        shared = line.jacobian @ changes.reshape(len(changes), -1).T
        known = known - (shared * (fitted.remaining @ shared)).sum(axis=0)
    named = (known > LEAST_WEIGHT) & [
        parameter.of not in NOT_NAMED for parameter in task.parameters
    ]
    known = np.where(named, known, np.inf)
    size = along / known
    deviation = 1.0 / np.sqrt(known)
    fall = size * along
    if fitted.adjusted:
        # Of a fitted parameter the fit itself says how far it would go: see this module.
        free = task.free
        left = np.diag(fitted.remaining)
        part = np.where(1.0 - left > LEAST_REMOVED, 1.0 - left, np.inf)
        size[free] = fit.p[free] / part
        deviation[free] = task.sigma[free] * np.sqrt(left / part)
        fall[free] = named[free] * fit.scores**2 / part
    return _EachAlone(size=size, deviation=deviation, fall=fall)
