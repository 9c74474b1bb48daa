"""Enumerations: outcomes of computations, kinds of contact, cross-section, slip law and solver.

A Snakefile can import this module quickly, as it loads no other library.
"""

from enum import StrEnum
from typing import TypeVar

from vibrissa.errors import ArgumentError

Choice = TypeVar("Choice", bound=StrEnum)


class Status(StrEnum):
    """Outcome of a computation; it is a result, not an exception.

    Attributes
    ----------
    SOLVED
        A state or a curve was found to the promised accuracy.
    SLIP
        The tip slips forward: the onset was found.
    LOCK
        The tip does not slip forward: μ0 exceeds the critical friction coefficient μ_lock, or the
        tip slips back before −tan α reaches μ0.
    OUT_OF_REACH
        The shape is inadmissible (see `vibrissa.mechanics.admissibility`), or the rod has no state
        with α = 0; the message gives the reason.
    FAILED
        No result of the promised accuracy was found; the message names the failed step and a
        remedy.
    """

    SOLVED = "solved"
    SLIP = "slip"
    LOCK = "lock"
    OUT_OF_REACH = "out_of_reach"
    FAILED = "failed"


# Statuses of rows without a result.
NO_RESULT = (Status.FAILED, Status.OUT_OF_REACH)


class End(StrEnum):
    """How sticking of a locked tip ends.

    Attributes
    ----------
    SLIPS_BACK
        tan α = +μ0: the tip slips in the direction opposite to the motion of the clamp. In a
        mounting that is not ideal this may happen before −tan α is largest.
    SWINGS_ASIDE
        A round rod buckles laterally, with the contact point on or near the clamp's axis
        (docs/lateral.md). The rod then trails behind the clamp until its tip slips; this motion is
        computed for the ideal mounting only.
    SNAPS
        Limit point: x0 has a maximum, and a rod that stays in its plane snaps through.
    OUT_OF_REACH
        The shape is inadmissible (see `vibrissa.mechanics.admissibility`).
    LIFTS_OFF
        The normal force vanishes.
    NOT_FOLLOWED
        The curve was not followed, or not resolved, to its end.
    """

    SLIPS_BACK = "slips_back"
    SWINGS_ASIDE = "swings_aside"
    SNAPS = "snaps"
    OUT_OF_REACH = "out_of_reach"
    LIFTS_OFF = "lifts_off"
    NOT_FOLLOWED = "not_followed"


class Contact(StrEnum):
    """How the rod touches the surface.

    Attributes
    ----------
    POINT
        Only the tip touches.
    LINE
        The rod touches tangentially at an inner point. The part beyond lies on the surface, or
        hangs free if the rod is curved.
    """

    POINT = "point"
    LINE = "line"


class RodSection(StrEnum):
    """Cross-section of the rod.

    Attributes
    ----------
    ROUND
        Equally stiff in every direction: the rod may buckle laterally.
    PLANAR
        A strip, or a guided rod, which stays in its plane.
    """

    ROUND = "round"
    PLANAR = "planar"


class SlipLaw(StrEnum):
    """Where a slip ends.

    Attributes
    ----------
    FREE
        Where the tangential force is 0, so that no friction is needed: on a plane at α = 0 (the
        paper's assumption).
    KINETIC
        Where the tangential force is μk times the normal force: the tip slides so slowly that
        inertia plays no part.
    ENERGY
        Where kinetic friction has dissipated the released bending energy, at zero velocity.
    DAMPED
        Where kinetic friction, and the vibration of the rod by its damping ratio, have dissipated
        the released bending energy.
    """

    FREE = "free"
    KINETIC = "kinetic"
    ENERGY = "energy"
    DAMPED = "damped"

    @property
    def overshoots(self) -> bool:
        """Whether a slip may pass the place at which no friction is needed, by its inertia."""
        return self in (SlipLaw.ENERGY, SlipLaw.DAMPED)


class Solver(StrEnum):
    """How a sticking curve is solved.

    Attributes
    ----------
    COLLOCATION
        All states of a curve are solved together, by spectral collocation; one curve serves all
        steps Δx0.
    SHOOTING
        The paper's procedure: states are solved one after the other, in steps of Δx0.
    """

    COLLOCATION = "collocation"
    SHOOTING = "shooting"

    @property
    def by_step(self) -> bool:
        """Whether a curve serves one Δx0 only, because the solver advances in steps of Δx0."""
        return self is Solver.SHOOTING


class TipMotion(StrEnum):
    """What the tip of a vibrating rod may do.

    Attributes
    ----------
    FREE
        It does not touch the surface: the rod before contact.
    STICKS
        It does not move.
    SLIDES
        It moves along the surface, under a constant force along the surface.
    """

    FREE = "free"
    STICKS = "sticks"
    SLIDES = "slides"


class ReadingStatus(StrEnum):
    """Outcome of reading friction from a simulated recording.

    Attributes
    ----------
    READ
        Friction was estimated; the estimate may be in doubt.
    NO_SLIP
        The recording has no period that ends with a slip.
    REFUSED
        The recording does not fit the stated rod, or cannot be used; the message has the reason.
    SATURATED
        No friction was estimated, and readings are at the limits of the transducer.
    YIELDED
        The strain in the rod exceeds its yield strain: a real rod would not come back.
    LOCK
        The tip locks before its first slip.
    OUT_OF_REACH
        The rod has no states at a distance from the surface.
    FAILED
        The scan could not be computed.
    """

    READ = "read"
    NO_SLIP = "no_slip"
    REFUSED = "refused"
    SATURATED = "saturated"
    YIELDED = "yielded"
    LOCK = "lock"
    OUT_OF_REACH = "out_of_reach"
    FAILED = "failed"


class Method(StrEnum):
    """Method of estimating μ0 from a recording.

    Attributes
    ----------
    MODEL
        By the model of the rod, fitted to all samples of all channels, with one contact point for
        each period. Needs the moment or both forces.
    RATIO
        By the ratio of the forces at the onset, from a smooth fit to the last samples. Needs both
        forces, and no rod.
    """

    MODEL = "model"
    RATIO = "ratio"


def chosen(kind: type[Choice], value: str, what: str) -> Choice:
    """Look up a member of the enumeration `kind` by its value.

    Raises
    ------
    ArgumentError
        If there is no such member.
    """
    if value not in tuple(kind):
        raise ArgumentError(f"{what} must be one of {', '.join(kind)}, got {value!r}")
    return kind(value)
