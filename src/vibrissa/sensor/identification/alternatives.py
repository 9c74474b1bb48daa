"""What may be other than it was given: the rod, its clamp and height, the transducer, the stage."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.periods import Placed, Samples
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.whisker import Whisker

# Change of each property by which its effect is told (in units of the rod, rad, or relative).
STEP = 1e-3
# The forces are singular at η = 1.
STEP_IN_GAP = 1e-2


@dataclass(frozen=True, eq=False, kw_only=True)
class Alternative:
    """One property that is larger than it was given.

    Attributes
    ----------
    name : str
    kind : Kind
        What it measures; NUMBER where the change is relative.
    step : float
        By how much it is larger.
    corrected : callable
        Maps samples to what they would have been without that error of transducer or stage.
    branch : Branch, ObliqueStage or None
        Of the rod that has the property; None where it is the same rod.
    """

    name: str
    kind: Kind
    step: float
    corrected: Callable[[Samples], Samples] = lambda samples: samples
    branch: Placed | None = None


def _of_readings(name: str, kind: Kind, error: Callable[[FloatArray], FloatArray]) -> Alternative:
    """Make an alternative that adds an error to the readings, to first order."""

    def corrected(samples: Samples) -> Samples:
        return replace(samples, readings=samples.readings - STEP * error(samples.readings))

    return Alternative(name=name, kind=kind, step=STEP, corrected=corrected)


def _moved(samples: Samples) -> Samples:
    return replace(samples, clamp=samples.clamp * (1.0 + STEP))


def of_transducer() -> list[Alternative]:
    """Errors of transducer and stage, and of what scales all loads alike."""

    def zero(channel: int) -> Callable[[FloatArray], FloatArray]:
        return lambda readings: np.broadcast_to(np.eye(3)[channel], readings.shape)

    def linear(*rows: tuple[float, float, float]) -> Callable[[FloatArray], FloatArray]:
        return lambda readings: readings @ np.array(rows).T

    none = (0.0, 0.0, 0.0)
    return [
        _of_readings("zero of force_x", Kind.FORCE, zero(0)),
        _of_readings("zero of force_y", Kind.FORCE, zero(1)),
        _of_readings("zero of moment_z", Kind.MOMENT, zero(2)),
        # E and d0⁴ alike.
        _of_readings("modulus", Kind.NUMBER, lambda readings: readings),
        # Axes that are turned from x to y.
        _of_readings("transducer angle", Kind.ANGLE, linear((0, 1, 0), (-1, 0, 0), none)),
        # The moment about a point (a, b) is that about the clamp less a·fy − b·fx.
        _of_readings("origin of moment_z in x", Kind.LENGTH, linear(none, none, (0, -1, 0))),
        _of_readings("origin of moment_z in y", Kind.LENGTH, linear(none, none, (1, 0, 0))),
        Alternative(name="scale of the stage", kind=Kind.NUMBER, step=STEP, corrected=_moved),
    ]


def of_rod(whisker: Whisker, solved: Callable[[Whisker], Placed]) -> Iterator[Alternative]:
    """Solve rods that differ a little from the one that was given.

    Parameters
    ----------
    whisker : Whisker
    solved : callable
        Solves one of them; NoResponseError where it has no such response.

    Yields
    ------
    Alternative
    """
    mounting = whisker.mounting
    gap = STEP_IN_GAP * (1.0 - whisker.eta)
    curvature = np.atleast_1d(np.asarray(mounting.curvature, dtype=float))
    bent = (float(curvature[0]) + STEP, *map(float, curvature[1:]))

    def mounted(**changed: object) -> Whisker:
        return replace(whisker, mounting=replace(mounting, **changed))  # type: ignore[arg-type]

    rods = {
        "theta": (Kind.NUMBER, STEP, replace(whisker, theta=whisker.theta + STEP)),
        "eta": (Kind.LENGTH, -gap, replace(whisker, eta=whisker.eta - gap)),
        "clamp_angle": (Kind.ANGLE, STEP, mounted(clamp_angle=mounting.clamp_angle + STEP)),
        "clamp_compliance": (
            Kind.COMPLIANCE,
            STEP,
            mounted(clamp_compliance=mounting.clamp_compliance + STEP),
        ),
        "curvature": (Kind.CURVATURE, STEP, mounted(curvature=bent)),
    }
    for name, (kind, step, rod) in rods.items():
        try:
            branch = solved(rod)
        except NoResponseError:
            continue
        yield Alternative(name=name, kind=kind, step=step, branch=branch)
        if name == "eta" and isinstance(branch, Branch):
            yield _of_stage(solved(whisker), branch, step)


def _of_stage(given: Placed, lower: Placed, step: float) -> Alternative:
    """Stage that approaches the surface: the height decreases along the scan.

    Parameters
    ----------
    given : Branch or ObliqueStage
        At the height that was given.
    lower : Branch or ObliqueStage
        At a height that differs by `step` (L).
    step : float
    """

    def corrected(samples: Samples) -> Samples:
        states, other = (branch.above(samples.clamp)[0] for branch in (given, lower))
        x0 = other.clip(states.clip(samples.x0))
        # The contact stays where it is, but the place from which displacements count moves.
        moved = (lower.x1_init - given.x1_init) * states.slope(x0)
        per_height = (other(x0) - states(x0) + moved) / step
        error = -STEP * samples.clamp[:, None] * per_height
        return replace(samples, readings=samples.readings - error)

    return Alternative(name="stage_angle", kind=Kind.ANGLE, step=STEP, corrected=corrected)
