"""Words with one meaning: what a result's `status` can be, and the kinds that results name.

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
        The tip slips forward, ahead of the clamp: the onset was found.
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


class End(StrEnum):
    """How sticking ends that goes on past the lock.

    Attributes
    ----------
    SLIPS_BACK
        tan α = +μ0: the tip slips against the direction in which the clamp moves.
    SWINGS_ASIDE
        The contact point lies on the clamp's axis: a round rod leaves its plane, and swings round
        to the other side (docs/lateral.md). It then trails behind the clamp until its tip slips. A
        naturally curved one leaves its plane elsewhere; where it goes then is not computed.
    SNAPS
        The equilibrium of a rod that cannot leave its plane loses its stability: the branch turns
        back in x0, the rod snaps through.
    OUT_OF_REACH
        The shape is not admissible (see `vibrissa.mechanics.admissibility`).
    LIFTS_OFF
        The surface would have to pull. Where μ_lock is infinite the tip has slipped ahead before,
        for every μ0; else it has slipped back.
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
    """What the rod's cross-section lets it do.

    Attributes
    ----------
    ROUND
        It bends as easily in every direction: the rod may leave its plane.
    PLANAR
        It keeps the rod in its plane: a strip, or a rod that is guided.
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


class Parameter(StrEnum):
    """What counts the states along a piece of a curve.

    Attributes
    ----------
    X0
        The footpoint displacement.
    ADVANCE
        The way along a direction in which displacement and force change (equation E3c of
        `vibrissa.mechanics.equations`): where the force changes fast or x0 turns back.
    """

    X0 = "x0"
    ADVANCE = "advance"
