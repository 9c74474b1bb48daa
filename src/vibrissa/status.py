"""Outcomes of a computation: what a result's `status` can be."""

from enum import StrEnum


class Status(StrEnum):
    """Outcome of a computation; a numerical outcome is never an exception.

    Attributes
    ----------
    SOLVED
        A state or a curve was found to the promised accuracy.
    SLIP
        The tip slips: the onset was found.
    LOCK
        The tip never slips backward: μ0 exceeds the locking friction μ_lock(θ, η).
    FAILED
        No result of the promised accuracy; the message says which step failed and what to try.
    """

    SOLVED = "solved"
    SLIP = "slip"
    LOCK = "lock"
    FAILED = "failed"


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
