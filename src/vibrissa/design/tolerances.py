"""Which tolerance limits the friction that a rod reads, and what halving it brings.

The rod is moved over a surface of one friction, without noise, and `identify` reads this recording
as one with the noise of the transducer: it adjusts what was given within its tolerances. With D the
mean change of the frictions per unit of each quantity, and C the covariance of what remains, the
variance that all periods share is D·C·Dᵀ. The quantities of one tolerance, with its variances S,
have half of it if they are measured once more with the covariance S/3. By then it falls by

    D·Cₖ·(S/3 + Cₖₖ)⁻¹·Cₖᵀ·Dᵀ,

with the columns k of these quantities in C. So correlations are kept: who measures a length better
tells of the modulus, too.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vibrissa.design.requirements import Requirements
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor import surfaces
from vibrissa.sensor.given.tolerances import TOLERABLE, told
from vibrissa.sensor.identification.friction import PeriodStatus
from vibrissa.sensor.identification.identify import identify
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.simulation.scanning import simulate
from vibrissa.sensor.simulation.slips import SlipLaw
from vibrissa.sensor.whisker import Whisker

# So many periods of sticking are read.
PERIODS = 30
# Told are those whose halving brings so much, and those that alone were such a part of the whole.
BRINGS, COSTS = 0.005, 0.3


@dataclass(frozen=True, kw_only=True)
class TolerancePart:
    """What one tolerance costs in the uncertainty of μ0.

    Attributes
    ----------
    name : str
    tolerance : float
        Standard deviation, in units of the rod, rad, or relative.
    stated : bool
        Whether it was stated, or is assumed.
    alone : float
        Standard deviation of μ0 by it, if nothing is adjusted to the recording.
    halved : float
        By which part the standard deviation of μ0, with all tolerances, falls if it is halved.
    """

    name: str
    tolerance: float
    stated: bool
    alone: float
    halved: float


@dataclass(frozen=True, kw_only=True)
class ToleranceLimits:
    """Which tolerances limit μ0; prints as a table.

    Attributes
    ----------
    parts : tuple of TolerancePart
        The one whose halving brings most is the first.
    common : float
        Standard deviation of μ0 by all of them, after `identify` has adjusted what was given.
    periods : int
        Of the recording to which it was adjusted.
    units : Units
    """

    parts: tuple[TolerancePart, ...]
    common: float
    periods: int
    units: Units

    def __str__(self) -> str:
        """Say which count, the most first."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        if not self.parts:
            yield "\nno tolerances: what was given is taken as exact"
            return
        yield "\nstandard deviation of mu0 by tolerances, which all periods share"
        yield f"{self.common:<9.2g} after identify has adjusted them to {self.periods} periods"
        yield f"{'tolerance':<18}{'':<26}{'alone':<10}halving it brings"
        for one in self.parts:
            if one.halved >= BRINGS or one.alone >= COSTS * self.common:
                size, unit = told(one.name, one.tolerance, self.units)
                given = f"{f'{size:.2g} {unit}'.strip()}{'' if one.stated else ', assumed'}"
                yield f"{one.name:<18}{given:<26}{one.alone:<10.2g}{one.halved:.1%}"


def tolerance_limits(
    requirements: Requirements, whisker: Whisker, mu0: float, deviation: float
) -> ToleranceLimits:
    """Tell which tolerances limit the uncertainty of μ0.

    Parameters
    ----------
    requirements : Requirements
    whisker : Whisker
        The rod that was found, with the tolerances that were stated.
    mu0 : float
        Friction of the surface.
    deviation : float
        Standard deviation of μ0 from one period, without tolerances.

    Returns
    -------
    ToleranceLimits

    Raises
    ------
    NoResponseError
        If the response of the rod is not found, or that of one that is a little other.
    RecordingError
        If its periods cannot be told apart.
    """
    step = requirements.step / whisker.units.unit(Kind.LENGTH)
    found = identify(
        whisker,
        _recorded(whisker, mu0, step),
        noise=np.array(requirements.noise) / whisker.units.channels,
        assume=requirements.assume,
    )
    slips = found.periods.status == PeriodStatus.SLIP
    parts, common = [], 0.0
    if found.tolerances:
        effect = found.periods.effects[slips].mean(axis=0)
        common = float(effect @ found.covariance @ effect)
        parts = sorted(_parts(found, effect, deviation**2 + common), key=lambda one: -one.halved)
    return ToleranceLimits(
        parts=tuple(parts),
        common=float(np.sqrt(common)),
        periods=int(slips.sum()),
        units=whisker.units,
    )


def _parts(found: Identification, effect: FloatArray, total: float) -> Iterator[TolerancePart]:
    """Tell of each tolerance what it costs alone, and what halving it brings; `total` is all."""
    names = np.array([one.of for one in found.tolerances])
    for name in TOLERABLE:
        own = np.flatnonzero(names == name)
        if not len(own):
            continue
        variance = np.array([found.tolerances[i].tolerance ** 2 for i in own])
        measured = np.diag(variance / 3.0) + found.covariance[np.ix_(own, own)]
        shared = found.covariance[own] @ effect
        falls = float(shared @ np.linalg.solve(measured, shared))
        yield TolerancePart(
            name=name,
            tolerance=max(found.tolerances[i].tolerance for i in own),
            stated=found.tolerances[own[0]].stated,
            alone=float(np.sqrt(variance @ effect[own] ** 2)),
            halved=1.0 - float(np.sqrt(1.0 - falls / total)),
        )


def _recorded(whisker: Whisker, mu0: float, step: float) -> Recording:
    """Record some periods of sticking on a surface of one friction, without noise."""
    travel = float(whisker.curve.onset(np.array([mu0]))[0])
    steps = int(np.ceil((PERIODS + 0.5) * travel / step))
    scan = simulate(
        whisker.response(False), surfaces.constant(mu0), step * np.arange(steps + 1.0), SlipLaw.FREE
    )
    return Recording(
        clamp=scan.clamp, readings=scan.reactions, line=np.arange(1, len(scan.clamp) + 1)
    )
