"""A whisker: a rod clamped below a surface, in units of its own or of a real rod."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor.given.tolerances import read_tolerances
from vibrissa.sensor.given.values import Given
from vibrissa.sensor.quantities import (
    MEASURED,
    Kind,
    Quantity,
    Units,
    chosen,
    read_rod,
    wished_units,
)
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

if TYPE_CHECKING:
    from vibrissa.sensor.response.branch import Response
    from vibrissa.sensor.stage import ObliqueStage

# Told what is being done, how much of it is done, and how much there is to do.
Progress = Callable[[str, int, int], None]


def quiet(what: str, done: int, total: int) -> None:
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Whisker:
    """A rod, the height of the surface above its clamp, and how it may touch the surface.

    Its response is solved when it is first used, once. What solves it is imported then, as it
    needs SciPy, which takes half a second to load.

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
        The real rod; without it everything is nondimensional.
    mounting : Mounting
        Clamp, natural shape and stage.
    tolerances : mapping of str to float
        Standard deviations that were stated, as from `read_tolerances`.
    wished : dict of Kind to str
        Units in which its results are told, see `Units`.
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
    def read(
        cls,
        theta: Quantity,
        eta: Quantity,
        *,
        contact: Contact | str = Contact.POINT,
        section: RodSection | str = RodSection.ROUND,
        modulus: str | None = None,
        diameter: str | None = None,
        length: str | None = None,
        clamp_angle: Quantity = 0,
        clamp_compliance: Quantity | None = None,
        clamp_stiffness: Quantity | None = None,
        curvature: Quantity = 0,
        stage_angle: Quantity = 0,
    ) -> "Whisker":
        """Read a whisker from quantities with units.

        All but contact and section may have a tolerance: ``"85 ± 0.1 mm"``, ``"210 GPa +/- 2 %"``.

        Parameters
        ----------
        theta : str or number
            Taper factor, at least 1.
        eta : str or number
            Height: ``"85 mm"``, or 0.85 in units of the length.
        contact : Contact
        section : RodSection
        modulus, diameter, length : str, optional
            Of the rod: ``"210 GPa"``, ``"1 mm"``, ``"100 mm"``; all three or none.
        clamp_angle, stage_angle : str or number
            ``"2 deg"``, or 0.035 in rad; see `vibrissa.Mounting`.
        clamp_compliance, clamp_stiffness : str or number, optional
            ``"0.05 rad/(N*m)"`` or ``"20 N*m/rad"``; one of them, or none where the clamp is rigid.
        curvature : str or number
            ``"2 m^-1"``, or 0.2 in units of 1/L; or, separated by commas, the coefficients of the
            powers of s, lowest first, as numbers.

        Returns
        -------
        Whisker

        Raises
        ------
        ArgumentError
            If an argument is no such quantity.

        Examples
        --------
        >>> steel = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
        >>> whisker = Whisker.read(2, "85 mm", **steel)
        >>> print(whisker.eta, f"{whisker.rod.force_unit:.3f} N")
        0.85 1.031 N
        """
        given = {
            "theta": theta,
            "eta": eta,
            "modulus": modulus,
            "diameter": diameter,
            "length": length,
            "clamp_angle": clamp_angle,
            "clamp_compliance": clamp_compliance,
            "clamp_stiffness": clamp_stiffness,
            "curvature": curvature,
            "stage_angle": stage_angle,
        }
        parts = {name: Given.read(one, name) for name, one in given.items() if one is not None}
        value = {name: one.value for name, one in parts.items()}
        rod = read_rod(*(_text(value.get(name)) for name in ("modulus", "diameter", "length")))
        units = Units(rod, wished_units([Kind.LENGTH], length, eta, diameter))
        mounting = Mounting(
            clamp_angle=float(units.read(value["clamp_angle"], Kind.ANGLE, "clamp_angle")),
            clamp_compliance=_compliance(
                units, value.get("clamp_compliance"), value.get("clamp_stiffness")
            ),
            curvature=_curvature(units, value["curvature"]),
            stage_angle=float(units.read(value["stage_angle"], Kind.ANGLE, "stage_angle")),
        )
        whisker = cls(
            theta=float(units.read(value["theta"], Kind.NUMBER, "theta")),
            eta=_height(units, value["eta"]),
            contact=chosen(Contact, contact, "contact"),
            section=chosen(RodSection, section, "section"),
            rod=rod,
            mounting=mounting,
            wished=units.wished,
        )
        tolerances = {name: one.tolerance for name, one in parts.items() if one.tolerance}
        if stiffness := tolerances.pop("clamp_stiffness", None):
            tolerances["clamp_compliance"] = _of_stiffness(units, value, stiffness)
        return replace(whisker, tolerances=read_tolerances(whisker.units, tolerances, whisker))

    def tolerating(self, tolerances: Mapping[str, float]) -> "Whisker":
        """Return the same whisker with more tolerances."""
        return replace(self, tolerances={**self.tolerances, **tolerances})

    def wishing(self, *given: object) -> "Whisker":
        """Return the same whisker with results in the units of these texts."""
        return replace(self, wished={**wished_units(MEASURED, *given), **self.wished})

    @property
    def units(self) -> Units:
        """Units of its results."""
        return Units(self.rod, self.wished)

    @cached_property
    def curve(self) -> StickingCurve:
        """Sticking curve."""
        return solve_curve(
            self.theta,
            self.eta,
            contact=self.contact,
            mounting=self.mounting,
            section=self.section,
        )

    @cached_property
    def pushed(self) -> "Response":
        """Response where the clamp pushes the tip, x0 ≥ 0."""
        return self._respond(pull=False)

    @cached_property
    def pulled(self) -> "Response":
        """Response where the clamp pushes or pulls the tip."""
        return self._respond(pull=True)

    def _respond(self, pull: bool) -> "Response":
        from vibrissa.sensor.response.branch import respond

        return respond(self.theta, self.eta, self.contact, pull, self.mounting, self.section)

    def response(self, backward: bool) -> "Response":
        """Give the response with x0 < 0 if it has been found: after a long slip the tip is pulled.

        Raises
        ------
        NoResponseError
            If it was not found although the clamp went backward, or there is no response at all.
        """
        try:
            return self.pulled
        except NoResponseError:
            if backward:
                raise
            return self.pushed

    def stage(
        self,
        positions: FloatArray,
        backward: bool,
        progress: Progress = quiet,
    ) -> "ObliqueStage":
        """Solve the response, as `response` does, at all heights that an oblique stage passes.

        Parameters
        ----------
        positions : ndarray
            Of the clamp along the stage (L).
        backward : bool
            Whether the states in which the tip is pulled are needed. They are where the stage
            leaves the surface, too.
        progress : callable

        Returns
        -------
        ObliqueStage

        Raises
        ------
        NoResponseError
            If the rod has no response at its height.
        """
        from vibrissa.sensor.response.height_range import respond_over
        from vibrissa.sensor.stage import ObliqueStage

        angle = self.mounting.stage_angle
        reached = self.eta - np.append(positions, 0.0) * np.sin(angle)
        solved = partial(
            respond_over,
            self.theta,
            self.eta,
            float(reached.min()),
            float(reached.max()),
            contact=self.contact,
            mounting=replace(self.mounting, stage_angle=0.0),
            section=self.section,
            progress=lambda part: progress("solving the rod", round(100 * part), 100),
        )
        try:
            heights = solved(pull=True)
        except NoResponseError:
            if backward or angle < 0.0:
                raise
            heights = solved(pull=False)
        return ObliqueStage(heights=heights, eta=self.eta, angle=angle)


def _height(units: Units, eta: Quantity) -> float:
    """Height of the surface (L); a rod of a length must reach it."""
    height = float(units.read(eta, Kind.LENGTH, "eta"))
    if units.rod is not None and not 0.0 < height < 1.0:
        length = units.spelled(1.0, Kind.LENGTH)
        raise ArgumentError(
            f"eta must lie between 0 and the length of the rod, {length}: write a height with its "
            f"unit, as in '85 mm', got {eta!r}"
        )
    return height


def _compliance(units: Units, compliance: Quantity | None, stiffness: Quantity | None) -> float:
    """Compliance of a clamp, given by itself or by its inverse; 0 without either."""
    if stiffness is None:
        given = 0 if compliance is None else compliance
        return float(units.read(given, Kind.COMPLIANCE, "clamp_compliance"))
    if compliance is not None:
        raise ArgumentError("give clamp_compliance or clamp_stiffness, not both")
    return 1.0 / float(units.read_positive(stiffness, Kind.STIFFNESS, "clamp_stiffness"))


def _of_stiffness(units: Units, value: Mapping[str, Quantity], tolerance: str) -> str:
    """Tolerance of a compliance, in per cent, from that of the stiffness that was given."""
    if tolerance.endswith("%"):
        return tolerance
    what = "the tolerance of clamp_stiffness"
    size = units.read(tolerance, Kind.STIFFNESS, what)
    return f"{100 * size / units.read(value['clamp_stiffness'], Kind.STIFFNESS, what)} %"


def _text(value: Quantity | None) -> str | None:
    return None if value is None else str(value)


def _curvature(units: Units, curvature: Quantity) -> float | tuple[float, ...]:
    """Natural curvature: a quantity, or coefficients without units."""
    if not isinstance(curvature, str) or "," not in curvature:
        return float(units.read(curvature, Kind.CURVATURE, "curvature"))
    parts = curvature.split(",")
    return tuple(float(units.read(part, Kind.NUMBER, "curvature")) for part in parts)
