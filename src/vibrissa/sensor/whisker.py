"""A whisker: a rod clamped below a surface, nondimensional or with the units of a real rod."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Kind, Quantity, Units
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

    @classmethod
    def read(cls, theta: Quantity, eta: Quantity, **properties: Any) -> "Whisker":
        """Read a whisker from quantities with units and tolerances.

        Parameters
        ----------
        eta : str or number
            Height: ``"85 ± 0.1 mm"``, or 0.85 in units of the length.
        **properties
            ``modulus``, ``diameter`` and ``length``, all three or none; ``contact``, ``section``,
            ``clamp_angle``, ``clamp_compliance``, ``curvature``, ``stiffening``, ``bore`` and
            ``stage_angle``: see
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
