"""A rod, transducer or stage that is other than it was given, to tell what follows from it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from vibrissa.errors import NoResponseError
from vibrissa.sensor.identification.adjusting.properties import (
    OF_ROD,
    PROPERTIES,
    Component,
    Property,
)
from vibrissa.sensor.identification.periods import Placed, Samples
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.whisker import Whisker

# Change of each property by which its effect is told (in units of the rod, rad, or relative).
STEP = 1e-3
# The forces are singular at η = 1: there it is this part of 1 − η, downwards.
STEP_IN_GAP = 1e-2
# The same scale of all loads as the modulus has.
NOT_TOLD = ("diameter",)


@dataclass(frozen=True, eq=False, kw_only=True)
class Alternative:
    """A rod, transducer or stage that is other than it was given.

    Attributes
    ----------
    name : str
        Of the property that is larger.
    step : float
        By how much it is larger.
    corrected : callable
        Maps samples, and an error of transducer or stage, to what they would have been without it.
    branch : Branch, ObliqueStage or None
        Of the rod that has the property; None where it is the same rod.
    base : Branch, ObliqueStage or None
        Of the rod that has not, from which the effect counts; None for the one that is used.
    """

    name: str
    step: float
    corrected: Callable[[Samples, float], Samples] = lambda samples, size: samples
    branch: Placed | None = None
    base: Placed | None = None

    def undone(self, samples: Samples) -> Samples:
        """Take the error of the step off samples."""
        return self.corrected(samples, self.step)

    @property
    def before(self) -> "Alternative":
        """What the effect counts from."""
        return Alternative(name=self.name, step=self.step, branch=self.base)


def _undoing(one: Property) -> Callable[[Samples, float], Samples]:
    return lambda samples, size: one.recording(samples, size)


def alternative(
    one: Component, size: float, branch: Placed | None = None, base: Placed | None = None
) -> Alternative:
    """Make the alternative of which a property is larger.

    Parameters
    ----------
    one : Component
    size : float
        By how much it is larger.
    branch, base : Branch or ObliqueStage, optional
        The rod that has it and that which has not, if they are not the same.
    """
    return Alternative(
        name=one.name,
        step=size,
        corrected=_undoing(one.property),
        branch=branch,
        base=base,
    )


def of_readings() -> Iterator[Alternative]:
    """Make every property a little larger that does not change the rod."""
    for name, one in PROPERTIES.items():
        if name not in (*OF_ROD, *NOT_TOLD):
            yield Alternative(name=name, step=STEP, corrected=_undoing(one))


def alternatives_to(whisker: Whisker, solved: Callable[[Whisker], Placed]) -> Iterator[Alternative]:
    """Make every property a little larger, one at a time.

    Parameters
    ----------
    whisker : Whisker
        That was given.
    solved : callable
        Solves a whisker; NoResponseError where it has no such response.

    Yields
    ------
    Alternative
    """
    given = solved(whisker)
    yield from of_readings()
    for name in OF_ROD:
        if name == "stage_angle" and isinstance(given, Branch):
            # Of an oblique stage the rod would be solved at many heights.
            continue
        one = Component(name=name, of=name, property=PROPERTIES[name])
        size = step_in_height(whisker) if name == "eta" else STEP
        try:
            found = alternative(one, size, solved(one.property.whisker(whisker, size)), given)
        except NoResponseError:
            continue
        yield found
        if name == "eta" and isinstance(given, Branch) and isinstance(found.branch, Branch):
            yield inclined(given, found.branch, size)


def step_in_height(whisker: Whisker) -> float:
    """Change of the height by which its effect is told (L)."""
    return -STEP_IN_GAP * (1.0 - whisker.eta)


def inclined(given: Branch, other: Branch, step: float) -> Alternative:
    """Incline a level stage so that it approaches the surface: the height falls along the scan.

    Parameters
    ----------
    given : Branch
        At the height that was given.
    other : Branch
        At a height that is larger by `step` (L).
    step : float
    """

    def corrected(samples: Samples, size: float) -> Samples:
        x0 = other.clip(given.clip(samples.x0))
        height = -size * samples.clamp / step
        more = height * (other.demand(x0) - given.demand(x0))
        moved = replace(
            samples,
            # The contact stays where it is, but the place from which displacements count moves.
            clamp=samples.clamp + height * (other.x1_init - given.x1_init),
            # At its own height a tip with this displacement needs another friction.
            excess=more if samples.excess is None else samples.excess + more,
        )
        return moved.without(height[:, None] * (other(x0) - given(x0)))

    return Alternative(name="stage_angle", step=STEP, corrected=corrected)
