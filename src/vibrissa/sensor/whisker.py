"""A whisker: a rod clamped below a surface, nondimensional or with the units of a real rod."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Kind, Units
from vibrissa.scanning.rods import MountedRod
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

if TYPE_CHECKING:
    from vibrissa.scanning.response import Response
    from vibrissa.scanning.stage import Stage
    from vibrissa.scanning.textures import Texture


@dataclass(frozen=True, kw_only=True)
class Whisker(MountedRod):
    """A mounted rod with the units and the stated tolerances of a real one.

    The first use of `response` solves it and imports SciPy; later uses do not solve it again.

    Attributes
    ----------
    theta, eta, contact, section, mounting : optional
        As in `MountedRod`.
    rod : Rod or None
        The rod in SI units; None: all quantities are nondimensional.
    tolerances : mapping of str to float
        Stated standard deviations, as from `read_tolerances`.
    wished : dict of Kind to str
        Units of its results, see `Units`.
    """

    rod: Rod | None = None
    tolerances: Mapping[str, float] = field(default_factory=dict, hash=False)
    wished: Mapping[Kind, str] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Refuse a bore that is not narrower than the tip, or is another one than that of `rod`.

        Raises
        ------
        ArgumentError
        """
        check_bore(self.mounting.bore, self.theta)
        if self.rod is not None and self.rod.bore != self.mounting.bore:
            raise ArgumentError(
                f"the bore of the rod is {self.rod.bore!r}, that of the mounting "
                f"{self.mounting.bore!r} (d0): give both the same bore"
            )

    @property
    def values(self) -> dict[str, float]:
        """Values of the quantities of a set-up that may have a tolerance.

        Modulus, diameter and length are in SI units; they are left out if `rod` is None. Of a
        series of coefficients, as in curvature, the first one counts; 0 if there is none.
        """
        values = {"theta": self.theta, "eta": self.eta, **asdict(self.mounting)}
        if self.rod is not None:
            values["modulus"] = self.rod.youngs_modulus
            values["diameter"] = self.rod.base_diameter
            values["length"] = self.rod.length
        return {name: float(np.append(value, 0.0)[0]) for name, value in values.items()}

    @property
    def spell(self) -> Callable[[float], str]:
        """Formats lengths (L) for messages, in the unit of the user."""
        return lambda length: self.units.spelled(length, Kind.LENGTH)

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
        from vibrissa.scanning.response import responses

        return responses([self])[0]

    def stage(self, positions: FloatArray, texture: "Texture | None" = None) -> "Stage":
        """Solve the response at all heights η that the clamp reaches on its stage.

        Parameters
        ----------
        positions : ndarray
            Positions of the clamp along the stage (L).
        texture : Texture, optional
            Heights of the surface.

        Raises
        ------
        NoResponseError
            If the sticking curve cannot be solved at one of these heights, or η comes too close to
            0 or to 1.
        """
        from vibrissa.scanning.stage import Stage, stage_of

        if self.mounting.stage_angle == 0.0 and texture is None:
            return Stage(response=self.response, eta=self.eta)
        return stage_of(self, positions, texture=texture)
