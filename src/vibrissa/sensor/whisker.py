"""A whisker: a rod clamped below a surface, nondimensional or with the units of a real rod."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, RodSection
from vibrissa.quantities.units import Kind, Quantity, Units
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

if TYPE_CHECKING:
    from vibrissa.sensor.response.branch import Response
    from vibrissa.sensor.response.heights import Stage


@dataclass(frozen=True, kw_only=True)
class Whisker:
    """A rod, the height of the surface above its clamp, and how it may touch the surface.

    The first use of `response` solves it and imports SciPy; later uses do not solve it again.

    Attributes
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height, 0 < eta < 1 (L).
    contact : Contact
        ``point``: the tip alone touches; ``line``: the rod may lie flat along the surface.
    section : RodSection
        ``round``: the rod may leave its plane; ``planar``: a strip or a guided rod stays in it.
    rod : Rod or None
        The rod in SI units; None: all quantities are nondimensional.
    mounting : Mounting
        Inclination and compliance of the clamp, natural curvature, angle of the stage.
    tolerances : mapping of str to float
        Stated standard deviations, as from `read_tolerances`.
    wished : dict of Kind to str
        Units of its results, see `Units`.
    """

    theta: float
    eta: float
    contact: Contact = Contact.POINT
    section: RodSection = RodSection.ROUND
    rod: Rod | None = None
    mounting: Mounting = IDEAL
    tolerances: Mapping[str, float] = field(default_factory=dict, hash=False)
    wished: Mapping[Kind, str] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def read(cls, theta: Quantity, eta: Quantity, **properties: Any) -> "Whisker":
        """Read a whisker from quantities with units and tolerances.

        Parameters
        ----------
        eta : str or number
            Height: ``"85 ± 0.1 mm"``, or 0.85 in units of the length.
        **properties
            ``modulus``, ``diameter`` and ``length``, all three or none; ``contact``, ``section``,
            ``clamp_angle``, ``clamp_compliance``, ``curvature`` and ``stage_angle``: see
            `vibrissa.sensor.Setup`.

        Raises
        ------
        ArgumentError
            With a line for each argument that is not allowed.

        Examples
        --------
        >>> steel = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
        >>> whisker = Whisker.read(2, "85 mm", **steel)
        >>> print(whisker.eta, f"{whisker.rod.force_unit:.3f} N")
        0.85 1.031 N
        """
        from vibrissa.sensor.setup import Setup

        return Setup.read(theta=theta, eta=eta, **properties).whisker

    @property
    def units(self) -> Units:
        """Units of the results."""
        return Units(self.rod, self.wished)

    @cached_property
    def curve(self) -> StickingCurve:
        """Sticking curve: the equilibrium path of the rod from α = 0."""
        return solve_curve(
            self.theta, self.eta, contact=self.contact, mounting=self.mounting, section=self.section
        )

    @cached_property
    def response(self) -> "Response":
        """Clamp reactions over x0.

        For x0 < 0 the clamp is pulled back, as far as states were solved.

        Raises
        ------
        NoResponseError
            If the sticking curve cannot be solved, or the stage is oblique.
        """
        from vibrissa.sensor.response.branch import responses

        return responses([self])[0]

    def height(self, clamp: ArrayLike) -> FloatArray:
        """Height (L) of the surface above the clamp, at given positions of the clamp (L)."""
        return height_at(clamp, self.eta, self.mounting.stage_angle)

    def level(self, eta: float) -> "Whisker":
        """Return the same rod at another height, on a level stage."""
        return replace(self, eta=eta, mounting=replace(self.mounting, stage_angle=0.0))

    def stage(self, positions: FloatArray) -> "Stage":
        """Solve the response at all heights η that the clamp reaches on its stage.

        Parameters
        ----------
        positions : ndarray
            Positions of the clamp along the stage (L).

        Raises
        ------
        NoResponseError
            If the sticking curve cannot be solved at one of these heights, or η comes too close to
            0 or to 1.
        """
        from vibrissa.sensor.response.heights import Stage, respond_over

        angle = self.mounting.stage_angle
        if angle == 0.0:
            return Stage(rod=self.response, eta=self.eta)
        reached = self.height(np.append(positions, 0.0))
        heights = respond_over(self.level(self.eta), float(reached.min()), float(reached.max()))
        return Stage(rod=heights, eta=self.eta, angle=angle)


def height_at(clamp: ArrayLike, eta: float, stage_angle: float) -> FloatArray:
    """Height h(X) = η − X·sin δ of the surface above the clamp at the position X (L)."""
    return np.asarray(eta - np.asarray(clamp) * np.sin(stage_angle))
