"""Whether a recording fits the given set-up within its tolerances, and if not, likely causes.

A lifted tolerance σ lowers the sum that was minimised by (p/σ)²/(1 − s²/σ²), to first order, for
a parameter adjusted by p and known to s. Its square root is the surprise.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, fdtrc

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.fit import TINY, Fit, searched
from vibrissa.sensor.identification.parameters import Parameter
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.tolerances import told

# So many standard deviations are far from what was given, and less of a variance than this is not
# told by a recording.
FAR, LITTLE = 3.0, 0.01
# Those that have the effect of another one, or would explain anything.
NOT_NAMED = ("diameter", "crosstalk", "drift_force_x", "drift_force_y", "drift_moment_z")
# Probability with which a recording that fits is said not to.
LEVEL = 1e-3
# Independent values per second difference of readings, from which noise is estimated: neighbours
# are correlated by −2/3, the next ones by 1/6.
PER_DIFFERENCE = 18.0 / 35.0
# So many causes are sought, with this tolerance, and named if they explain this part of a misfit.
SOUGHT, WIDE, EXPLAINS = 3, 1.0, 0.1


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """A quantity with a tolerance: its estimate from the recording.

    Attributes
    ----------
    adjusted, deviation : float
        By how much it is larger by the recording, and the standard deviation that remains.
    wave : int
        Number of the wave of a drift; 0 for all else.
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
        """Distance of the recording from the given set-up, in standard deviations."""
        known = 1.0 - (self.deviation / self.tolerance) ** 2
        score = abs(self.adjusted) / self.tolerance
        return float(score / np.sqrt(known)) if known > LITTLE else 0.0

    @property
    def far(self) -> bool:
        """Whether that is far."""
        return not self.wave and self.surprise > FAR

    def spelled(self, units: Units) -> str:
        """Format it in the user's units."""
        adjusted, unit = told(self.of, self.adjusted, units)
        deviation, tolerance = (
            told(self.of, size, units)[0] for size in (self.deviation, self.tolerance)
        )
        text = (
            f"{self.name}: given to ± {tolerance:.3g} {unit}, off by {adjusted:+.3g} ± "
            f"{deviation:.2g} {unit} according to the recording"
        )
        return text.replace("  ", " ").replace(" ,", ",")


def tolerances_of(
    parameters: Iterable[Parameter], adjusted: FloatArray, covariance: FloatArray
) -> tuple[Tolerance, ...]:
    """Estimates of parameters, by their sizes and the covariance of the remaining errors."""
    left = np.sqrt(np.diag(covariance))
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
        for one, size, deviation in zip(parameters, adjusted, left, strict=True)
    )


@dataclass(frozen=True, kw_only=True)
class Goodness:
    """Sum of the squared residuals of a recording, in standard deviations, and how likely it is.

    Attributes
    ----------
    noise_degrees : float
        Degrees of freedom of the noise; infinite where it was given.
    uneven : bool
        Whether the surface rises and falls by more than its slope may.
    """

    chi2: float
    degrees: int
    noise_degrees: float = np.inf
    uneven: bool = False

    @classmethod
    def of(cls, fit: Fit, noise_is_given: bool) -> "Goodness":
        """Test the periods to which the set-up was fitted."""
        channels = len(fit.noise.used)
        heights, number = fit.unevenness
        return cls(
            chi2=fit.misfit - heights,
            degrees=fit.degrees - number,
            noise_degrees=np.inf
            if noise_is_given
            else fit.forward.rows * channels * PER_DIFFERENCE,
            uneven=number > 0 and chdtrc(number, heights) < LEVEL,
        )

    @property
    def ratio(self) -> float:
        """χ² per degree of freedom: 1 where the recording fits; NaN without any."""
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
    def fits(self) -> bool:
        """Whether the recording fits the given set-up."""
        return self.chance >= LEVEL and not self.uneven


@dataclass(frozen=True, kw_only=True)
class Cause:
    """What may be other than it was given, if its tolerance is lifted and no other one.

    Attributes
    ----------
    size, deviation : float
        By how much it is larger, and the standard deviation of that.
    """

    name: str
    of: str
    size: float
    deviation: float
    explained: float

    def spelled(self, units: Units) -> str:
        """Format the quantity and its change in the user's units."""
        way = "larger" if self.size > 0.0 else "smaller"
        size, unit = told(self.of, abs(self.size), units)
        deviation, _ = told(self.of, self.deviation, units)
        by = f"{size:.3g} ± {deviation:.1g} {unit}".rstrip()
        return f"{self.name} {way} by {by} (explains {self.explained:.0%} of the misfit)"


def causes_of(fit: Fit, fits: bool) -> tuple[Cause, ...]:
    """Lift the tolerances that hold the recording back, one by one; the likeliest cause first."""
    excess = float((fit.scores**2).sum()) if fits else fit.misfit - fit.degrees
    falls = _falls(fit)
    likely = sorted(np.flatnonzero(falls > 0.0).tolist(), key=lambda k: -falls[k])[:SOUGHT]
    causes = [_lifted(fit, k, excess) for k in likely]
    named = [cause for cause in causes if cause is not None and cause.explained >= EXPLAINS]
    return tuple(sorted(named, key=lambda cause: -cause.explained))


def _falls(fit: Fit) -> FloatArray:
    """By how much the sum falls where a tolerance is lifted, to first order, shape (k,)."""
    changes, miss = fit.changes[:, fit.rows], fit.residuals[fit.rows]
    along = (changes * miss).sum(axis=(1, 2))
    known = (changes**2).sum(axis=(1, 2))
    adjusted = fit.settled and bool(fit.free.any())
    if adjusted:
        shared = fit.jacobian @ changes.reshape(len(changes), -1).T
        known -= (shared * (fit.remaining @ shared)).sum(axis=0)
    falls = np.where(known > TINY, along**2 / np.maximum(known, TINY), 0.0)
    if adjusted:
        part = 1.0 - np.diag(fit.remaining)
        falls[fit.free] = np.where(part > LITTLE, fit.scores**2 / np.maximum(part, LITTLE), 0.0)
    for k, one in enumerate(fit.forward.parameters):
        if one.of in NOT_NAMED:
            falls[k] = 0.0
    return np.asarray(falls)


def _lifted(fit: Fit, k: int, excess: float) -> Cause | None:
    """Fit once more with one tolerance lifted; where nothing was adjusted, with that one alone."""
    one, others = fit.forward.parameters[k], fit.forward.parameters
    if not fit.settled:
        others = tuple(replace(other, deviation=0.0) for other in others)
    parameters = (*others[:k], replace(one, deviation=WIDE), *others[k + 1 :])
    try:
        found = searched(replace(fit, forward=replace(fit.forward, parameters=parameters)))
        variance = found.covariance[(row := int(found.free[:k].sum())), row]
    except NoResponseError:
        return None
    off = max(found.misfit / max(fit.degrees, 1), 1.0)
    return Cause(
        name=one.name,
        of=one.of,
        size=float(found.p[k]),
        deviation=float(np.sqrt(variance * off)),
        explained=min((fit.misfit - found.misfit) / excess, 1.0) if found.settled else 0.0,
    )
