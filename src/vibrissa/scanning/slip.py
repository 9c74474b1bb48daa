"""A slip of the tip: one slide after the other, until the tip comes to rest.

While the tip slips, the clamp rests, and the tip moves along the surface.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning.slide import Lost, RestingClamp, Slide, SlideEnd
from vibrissa.scanning.slip_model import FREE_SLIP, SlipModel
from vibrissa.scanning.surfaces import Footing

# Relative excess of |tan α| over μ0 at which a tip still sticks, for rounding.
ROUNDED_EXCESS = 1e-9
# Largest number of slides in a slip: a tip that stops where it cannot stick slides back, less far.
MOST_SLIDES = 100
# Largest number of moves of a tip to the last computed state; the distance of the rod may change.
MOST_MOVES = 100


class Flight(NamedTuple):
    """A part of a slip in which the tip does not touch: where it takes off and lands (L)."""

    takes_off: float
    lands: float


class SlipEnd(NamedTuple):
    """Where a slip ends.

    Attributes
    ----------
    contact, x0 : float
        Position of the tip, and displacement from the α = 0 state (L); if the slip is lost, those
        at which it is.
    released : float
        Elastic energy that the rod and its mounting lose: the work of the tangential force
        (E·I0/L). NaN if the slip is lost, or the tip flies in it.
    dissipated : float
        Work against kinetic friction (E·I0/L). NaN also under the law ``free``, which has no
        kinetic friction. What is released and not dissipated is the loss of the rod's vibration.
    lost : Lost or None
        None if the tip comes to rest.
    flights : tuple of Flight
        Parts in which the tip does not touch. A tip that lifts off is taken to land at the next
        place at which the surface pushes it, and to slip on from there without velocity.
    """

    contact: float
    x0: float
    released: float = np.nan
    dissipated: float = np.nan
    lost: Lost | None = None
    flights: tuple[Flight, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Slip(RestingClamp):
    """A slip of the tip, during which the clamp rests.

    Attributes
    ----------
    model : SlipModel
        Where it ends.
    """

    model: SlipModel = FREE_SLIP

    def follow(self, contact: float) -> SlipEnd:
        """Follow a tip that begins to slip until it comes to rest, or is lost.

        Parameters
        ----------
        contact : float
            Position at which the tip has stuck (L).

        Raises
        ------
        ArgumentError
            If the tip reaches an unknown part of the surface, or slides to and fro for too long.
        """
        contact = self._into_known_states(contact)
        if self.model.law is SlipLaw.FREE and self.surface.texture is None:
            if (end := self._free_on_plane(contact)) is not None:
                return end
        released, dissipated = 0.0, 0.0
        flights: tuple[Flight, ...] = ()
        for _ in range(MOST_SLIDES):
            slide = self._slide(contact, self._direction(contact)).end()
            contact, x0 = slide.contact, float(self.held(slide.contact).x0)
            if slide.lost is not None:
                return SlipEnd(contact=contact, x0=x0, lost=slide.lost, flights=flights)
            released, dissipated = released + slide.released, dissipated + slide.dissipated
            if slide.takes_off is not None:
                flights = (*flights, Flight(takes_off=slide.takes_off, lands=contact))
            if self._settled(contact, slide):
                if self.model.law is SlipLaw.FREE:
                    dissipated = np.nan
                return SlipEnd(
                    contact=contact,
                    x0=x0,
                    released=released,
                    dissipated=dissipated,
                    flights=flights,
                )
        place = f"the clamp at {self.surface.spell(self.clamp)}"
        raise ArgumentError(f"with {place} a slip has over {MOST_SLIDES} slides: take another law")

    def _slide(self, contact: float, direction: int) -> Slide:
        """Return a slide from a position (L): away from the clamp (`direction` 1) or back (−1)."""
        return Slide(
            stage=self.stage,
            surface=self.surface,
            clamp=self.clamp,
            side=self.side,
            model=self.model,
            begin=contact,
            direction=direction,
        )

    def _free_on_plane(self, contact: float) -> SlipEnd | None:
        """Return the end of a free slip on a plane in the state x0 = 0; None if it ends before.

        A pushed tip that was pushed back before meets another state with α = 0 on its way.
        """
        states, x0 = self.held(contact)
        end = states.contact(float(self.stage.along(self.clamp)), 0.0, self.side)
        if x0 == 0.0:
            return SlipEnd(contact=end, x0=0.0, released=0.0)
        driven = self._slide(contact, 1 if x0 > 0.0 else -1).driven(abs(float(x0)))
        if x0 > 0.0 and driven.least < 0.0:
            return None
        return SlipEnd(contact=end, x0=0.0, released=driven.work)

    def _into_known_states(self, contact: float) -> float:
        """Move a tip that a long step has taken out of the computed states to the last of them."""
        for _ in range(MOST_MOVES):
            states, x0 = self.held(contact)
            beyond = float(x0 - states.clip(x0))
            if beyond == 0.0:
                break
            contact += self.side * beyond
        return contact

    def _excesses(self, footing: Footing) -> tuple[float, float]:
        """By how much friction is exceeded forward and backward, up to rounding (E·I0/L²)."""
        ahead, behind = footing.ahead, footing.behind
        on_ahead, on_behind = self.forces(footing.contact, ahead.slope, behind.slope)
        forward = -on_ahead.tangential - ahead.mu0 * (1.0 + ROUNDED_EXCESS) * on_ahead.normal
        backward = on_behind.tangential - behind.mu0 * (1.0 + ROUNDED_EXCESS) * on_behind.normal
        return float(forward), float(backward)

    def _direction(self, contact: float) -> int:
        """Direction in which the tip slides: 1 away from the clamp, as if pushed, or −1."""
        forward, backward = self._excesses(self.surface.footing(contact, self.side))
        return 1 if forward >= backward else -1

    def _settled(self, contact: float, slide: SlideEnd) -> bool:
        """Whether a tip at the end of a slide remains there."""
        if self.model.law is SlipLaw.FREE and slide.takes_off is None:
            return True
        footing = self.surface.footing(contact, self.side)
        if self.model.law is SlipLaw.FREE:
            # It rests after its flight in a corner, between two faces of which each pushes it back.
            slopes = footing.ahead.slope, footing.behind.slope
            ahead, behind = self.forces(contact, *slopes)
            return float(behind.tangential) <= 0.0 <= float(ahead.tangential)
        return max(self._excesses(footing)) <= 0.0
