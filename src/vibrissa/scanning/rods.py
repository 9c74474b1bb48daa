"""A rod on its mounting at one clamp–surface distance: a whisker without units."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sticking.curve import StickingCurve


def in_rod_lengths(length: float) -> str:
    """Format a length (L) for a message."""
    return f"{length:.6g} L"


@dataclass(frozen=True, kw_only=True)
class MountedRod:
    """A rod, the distance of the surface from its clamp, and how it may touch the surface.

    Attributes
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Clamp–surface distance with the clamp at 0, 0 < eta < 1 (L).
    contact : Contact
        ``point``: the tip alone touches; ``line``: the rod may lie flat along the surface.
    section : RodSection
        ``round``: the rod may leave its plane; ``planar``: a strip or a guided rod stays in it.
    mounting : Mounting
        Inclination and compliance of the clamp, natural curvature, angle of the stage.
    """

    theta: float
    eta: float
    contact: Contact = Contact.POINT
    section: RodSection = RodSection.ROUND
    mounting: Mounting = IDEAL

    @classmethod
    def of(cls, curve: StickingCurve) -> "MountedRod":
        """Return the rod of a sticking curve."""
        return MountedRod(
            theta=curve.theta,
            eta=curve.eta,
            contact=curve.contact_model,
            section=curve.section,
            mounting=curve.mounting,
        )

    @property
    def spell(self) -> Callable[[float], str]:
        """Formats lengths (L) for messages."""
        return in_rod_lengths

    def distance(self, clamp: ArrayLike) -> FloatArray:
        """Clamp–surface distance (L) at positions of the clamp (L)."""
        return distance_at(clamp, self.eta, self.mounting.stage_angle)

    def level(self, eta: float) -> Self:
        """Return the same rod at another distance, on a level stage."""
        return replace(self, eta=eta, mounting=replace(self.mounting, stage_angle=0.0))


def distance_at(clamp: ArrayLike, eta: float, stage_angle: float) -> FloatArray:
    """Clamp–surface distance η(X) = η − X·sin δ with the clamp at X (L)."""
    return np.asarray(eta - np.asarray(clamp) * np.sin(stage_angle))
