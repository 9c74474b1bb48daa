"""Enumerations: the outcomes of results, and kinds of contact, section and solver.

Light enough for a Snakefile.
"""

from enum import StrEnum


class Status(StrEnum):
    """Outcome of a computation; it is a result, not an exception.

    Attributes
    ----------
    SOLVED
        A state or a curve was found to the promised accuracy.
    SLIP
        The tip slips forward: the onset was found.
    LOCK
        The tip never slips forward: μ0 exceeds the locking friction μ_lock(θ, η).
    OUT_OF_REACH
        The shape is not admissible (see `vibrissa.mechanics.admissibility`); the message says how.
    FAILED
        No result of the promised accuracy; the message says which step failed and what to try.
    """

    SOLVED = "solved"
    SLIP = "slip"
    LOCK = "lock"
    OUT_OF_REACH = "out_of_reach"
    FAILED = "failed"


# Statuses of rows without a result.
NO_RESULT = (Status.FAILED, Status.OUT_OF_REACH)


class End(StrEnum):
    """How sticking ends after self-locking.

    Attributes
    ----------
    SLIPS_BACK
        tan α = +μ0: the tip slips against the direction in which the clamp moves.
    SWINGS_ASIDE
        A round rod buckles laterally, with the contact point on or near the clamp's axis
        (docs/lateral.md). It then trails the clamp until its tip slips: computed for the ideal
        mounting alone.
    SNAPS
        Limit point: a rod that stays in its plane snaps through, as x0 has a maximum.
    OUT_OF_REACH
        The shape is not admissible (see `vibrissa.mechanics.admissibility`).
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
        With its tip alone.
    LINE
        Tangentially at an inner point, with the rest lying on the surface.
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


class Solver(StrEnum):
    """How a sticking curve is solved.

    Attributes
    ----------
    COLLOCATION
        All states of a curve at once, spectrally; one curve serves all steps Δx0.
    SHOOTING
        The paper's own procedure, step by step.
    """

    COLLOCATION = "collocation"
    SHOOTING = "shooting"

    @property
    def by_step(self) -> bool:
        """Whether a curve belongs to one Δx0, because the solver walks along its steps."""
        return self is Solver.SHOOTING
