"""Messages of a scan: where and why it ends early, where the rod buckles, and where the tip flies.

Positions are written by `Surface.spell`, in the units of the rod.
"""

from collections.abc import Sequence

import numpy as np

from vibrissa.scanning.slide import Lost
from vibrissa.scanning.slip import Flight
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.tip import EndOfSticking, Tip
from vibrissa.wording import counted

LOCKS = "the tip locks at x = {x}, where mu0 = {mu0:.6g}{slope} and mu_lock = {mu_lock:.6g}; "
ON_SLOPE = " on a slope of {angle:.4g} deg"
SWINGS = (
    LOCKS + "with the clamp at {clamp} the rod buckles laterally, and its tip is dragged behind"
)
STAYS = LOCKS + (
    "pushed further, it sticks until the clamp is at {clamp}; the motion after that is not computed"
)
LOST_ON_PLANE = (
    "the slip from x = {x}, with the clamp at {clamp}, releases so much energy that the tip lifts "
    "off the surface, or the rod is bent beyond its computed states"
)
LOST_ON_TEXTURE = {
    Lost.LIFTS: (
        "in the slip from x = {x}, with the clamp at {clamp}, the tip lifts off the surface at "
        "x = {at}, and nowhere ahead does the surface push it"
    ),
    Lost.BENT: (
        "in the slip from x = {x}, with the clamp at {clamp}, the rod comes to the end of its "
        "computed states at x = {at}"
    ),
    Lost.DEEP: (
        "in the slip from x = {x}, with the clamp at {clamp}, the tip comes at x = {at} to a "
        "height that the rod does not reach"
    ),
}
LEAVES_HEIGHTS = (
    "with the clamp at {clamp}, the tip at x = {x} comes to a height that the rod does not reach"
)
FLIES = (
    "{times} in a slip the tip lifts off, first at x = {lifts}; the flight is not computed, and "
    "the tip is taken to land where the surface pushes it again, first at x = {lands}"
)


def of_lateral_buckling(tip: Tip, sticking: EndOfSticking, clamp: float, surface: Surface) -> str:
    """Return where a locked rod buckles laterally; `clamp` is at the first step after that (L)."""
    return _of_lock(SWINGS, tip, sticking, clamp, surface)


def of_locked_tip(tip: Tip, sticking: EndOfSticking, clamp: float, surface: Surface) -> str:
    """Return where a tip has locked; `clamp` is at the last step at which the tip sticks (L)."""
    return _of_lock(STAYS, tip, sticking, clamp, surface)


def _of_lock(text: str, tip: Tip, sticking: EndOfSticking, clamp: float, surface: Surface) -> str:
    angle = np.degrees(np.arctan(tip.footing.ahead.slope))
    return text.format(
        x=surface.spell(tip.contact),
        mu0=tip.mu0,
        slope=ON_SLOPE.format(angle=angle) if angle else "",
        mu_lock=tip.held(sticking.until).states.mu_lock,
        clamp=surface.spell(clamp),
    )


def of_height_out_of_reach(tip: Tip, sticking: EndOfSticking, surface: Surface) -> str:
    """Return where a sticking tip comes to a height that the rod does not reach."""
    return LEAVES_HEIGHTS.format(x=surface.spell(tip.contact), clamp=surface.spell(sticking.until))


def of_lost_slip(lost: Lost, begin: float, end: float, clamp: float, surface: Surface) -> str:
    """Return why a slip is lost that begins and ends with the tip at these positions (L)."""
    text = LOST_ON_PLANE if surface.texture is None else LOST_ON_TEXTURE[lost]
    return text.format(x=surface.spell(begin), at=surface.spell(end), clamp=surface.spell(clamp))


def of_flights(flights: Sequence[Flight], surface: Surface) -> str:
    """Return how often the tip has lifted off in slips; empty if it has not."""
    if not flights:
        return ""
    first = flights[0]
    return FLIES.format(
        times=counted(len(flights), "time"),
        lifts=surface.spell(first.takes_off),
        lands=surface.spell(first.lands),
    )
