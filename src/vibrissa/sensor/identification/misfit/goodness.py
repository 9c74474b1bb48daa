"""Whether a recording as a whole fits what was given, and if not, what may be the cause.

Each period is tested by itself, too (`doubts`). Small misfits that all periods share show in their
sum alone. A cause is judged by what it would explain if it were the only one: to first order, with
the best contact of each period.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from scipy.special import chdtrc, fdtrc

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import told
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.transducer import CHANNELS

# Probability with which a recording that fits is said not to.
LEVEL = 1e-3
# Independent values per second difference of readings, from which noise is estimated: neighbours
# are correlated by −2/3, the next ones by 1/6.
PER_DIFFERENCE = 18.0 / 35.0
# Readings that scatter by this factor more than their noise have another noise.
NOISY = 1.25


def noisier(scatter: FloatArray, noise: FloatArray) -> dict[str, float]:
    """Channels that scatter by more than the noise that was given, shape (3,) each."""
    parts = zip(CHANNELS, scatter, noise, strict=True)
    return {name: float(own / given) for name, own, given in parts if own > NOISY * given > 0.0}


@dataclass(frozen=True, kw_only=True)
class Goodness:
    """Sum of the squared residuals of a recording, in standard deviations, and how likely it is.

    Attributes
    ----------
    chi2 : float
    degrees : int
        Readings, less what was fitted to them.
    noise_degrees : float
        Degrees of freedom of the noise; infinite where it was given.
    noisier : dict of str to float
        Channels that scatter by more than the noise that was given, and by which factor.
    """

    chi2: float
    degrees: int
    noise_degrees: float
    noisier: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, seen: Seen, noise_is_given: bool, penalty: float = 0.0) -> Self:
        """Add up the residuals of a recording.

        Parameters
        ----------
        seen : Seen
        noise_is_given : bool
            Otherwise it was estimated from the same readings.
        penalty : float
            Squares of what was adjusted, in tolerances.
        """
        readings = seen.residuals.size
        return cls(
            chi2=float((seen.residuals**2).sum()) + penalty,
            degrees=readings - len(seen.periods),
            noise_degrees=np.inf if noise_is_given else PER_DIFFERENCE * readings,
        )

    @property
    def ratio(self) -> float:
        """χ² per degree of freedom, about 1 where the recording fits; NaN without any."""
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
    name : str
    size, deviation : float
        By how much it would be larger, and the standard deviation of that.
    explained : float
        Part of χ², as far as it is too large, that this explains.
    """

    name: str
    size: float
    deviation: float
    explained: float

    def spelled(self, units: Units) -> str:
        """Say what it is and by how much, in a person's units."""
        way = "larger" if self.size > 0.0 else "smaller"
        size, unit = told(self.name, abs(self.size), units)
        deviation, _ = told(self.name, self.deviation, units)
        return f"{self.name} {way} by {size:.3g} ± {deviation:.1g} {unit}".rstrip()


def likeliest(
    seen: Seen, alternatives: Iterable[Alternative], goodness: Goodness
) -> tuple[Cause, ...]:
    """Fit each alternative to the residuals, the one that explains most first.

    Parameters
    ----------
    seen : Seen
    alternatives : iterable of Alternative
    goodness : Goodness
        Of these periods.

    Returns
    -------
    tuple of Cause
    """
    causes = []
    for other in alternatives:
        column = seen.effect_of(other)
        information = float((column**2).sum())
        if information > 0.0:
            product = float((column * seen.residuals).sum())
            causes.append(
                Cause(
                    name=other.name,
                    size=product / information,
                    deviation=information**-0.5,
                    explained=product**2 / information / (goodness.chi2 - goodness.degrees),
                )
            )
    return tuple(sorted(causes, key=lambda cause: -cause.explained))
