"""Tolerances: which quantities have one, how it is read, and the default where none is stated.

A tolerance is a standard deviation, in units of the rod, in rad, or relative to the value.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import ArgumentError, UnknownNameError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind, Quantity, Units, in_si, is_number

if TYPE_CHECKING:
    from vibrissa.sensor.whisker import Whisker

# In place of a size: no tolerance. In place of all: only stated tolerances count.
EXACT = "exact"


@dataclass(frozen=True, kw_only=True)
class Tolerable:
    """A quantity that has a tolerance.

    Attributes
    ----------
    kind : Kind
    what : str
        What the quantity is.
    size : float
        Default tolerance, in units of the rod, rad, or relative; with a `channel`, in standard
        deviations of one reading.
    reason : str
        Where the default is from: a standard, a data sheet, or what we expect and why.
    si : float
        The default in SI units, where the rod is known; 0 where `size` holds for every rod.
    relative : bool
        Whether the tolerance is relative to the value.
    channel : int
        Number of the channel whose noise sets the default; -1 without one.
    """

    kind: Kind
    what: str
    size: float
    reason: str
    si: float = 0.0
    relative: bool = False
    channel: int = -1

    def default(self, unit: float, noise: FloatArray) -> float:
        """Default tolerance, for a unit of the rod in SI units and the noise of the channels."""
        if self.channel >= 0:
            return self.size * float(noise[self.channel])
        return self.si / unit if self.si and unit != 1.0 else self.size


def _noisy(kind: Kind, channel: int, what: str, reason: str) -> Tolerable:
    return Tolerable(kind=kind, what=what, size=3.0, reason=reason, channel=channel)


_TARED = "no sheet; a tare is the mean of few readings, and the zero moves after it"
_WARM = (
    "ME-Messsysteme, sheet of the K3D40 (5 Oct 2016): 0.05 % of full scale per kelvin, as much "
    "creep; of 12 N that is 6 mN for a change by 1 K, two deviations of a Nano17"
)
TOLERABLE = {
    "theta": Tolerable(
        kind=Kind.NUMBER,
        what="taper",
        size=0.02,
        reason="5 um of each of two diameters of about 1 and 0.5 mm, as for the diameter",
    ),
    "eta": Tolerable(
        kind=Kind.LENGTH,
        what="height of the surface above the clamp",
        size=0.002,
        si=2e-4,
        reason="no sheet; touched off with a feeler gauge or by eye. ISO 2768-1, class m: "
        "±0.3 mm on 30 to 120 mm",
    ),
    "clamp_angle": Tolerable(
        kind=Kind.ANGLE,
        what="inclination of the clamp",
        size=np.deg2rad(0.5),
        reason="ISO 2768-1, classes f and m: ±0.5° where the shorter side has 10 to 50 mm; a "
        "hole with 0.1 mm of play over 10 mm",
    ),
    "clamp_compliance": Tolerable(
        kind=Kind.COMPLIANCE,
        what="rotational compliance of the clamp",
        size=0.005,
        reason="no sheet; half a diameter more of rod in the collet, of 1 on 100 mm",
    ),
    "curvature": Tolerable(
        kind=Kind.CURVATURE,
        what="natural curvature, at the clamp",
        size=0.02,
        reason="no sheet; a wire whose tip is 1 % of the length off the axis",
    ),
    "stage_angle": Tolerable(
        kind=Kind.ANGLE,
        what="angle of the stage to the surface",
        size=np.deg2rad(0.5),
        reason="no sheet; a surface laid on the stage: 0.9 mm on 100",
    ),
    "surface_slope": Tolerable(
        kind=Kind.ANGLE,
        what="slope of the surface from place to place, alike over 5 mm",
        size=np.deg2rad(0.5),
        reason="no sheet; ±1° over some mm of a ground or milled surface are two deviations",
    ),
    "modulus": Tolerable(
        kind=Kind.STRESS,
        what="Young's modulus",
        size=0.03,
        reason="of the same spring wire EN 10270-1 says 206 GPa, and Shigley (table 10-5) 200",
        relative=True,
    ),
    "creep": Tolerable(
        kind=Kind.NUMBER,
        what="fall of Young's modulus per decade of time, from the first sample",
        size=0.001,
        reason="no sheet; of steel less, of polymers some per cent: state it",
        relative=True,
    ),
    "diameter": Tolerable(
        kind=Kind.LENGTH,
        what="diameter at the clamp",
        size=0.005,
        reason="a micrometer: 5 um of 1 mm. ISO 286-2: a rod of 1 mm to h7 is up to 10 um thinner",
        relative=True,
    ),
    "length": Tolerable(
        kind=Kind.LENGTH,
        what="length",
        size=0.003,
        reason="ISO 2768-1, class m: ±0.3 mm on 30 to 120 mm; a calliper, and where the clamp "
        "begins",
        relative=True,
    ),
    "zero_force_x": _noisy(Kind.FORCE, 0, "reading of force_x without load", _TARED),
    "zero_force_y": _noisy(Kind.FORCE, 1, "reading of force_y without load", _TARED),
    "zero_moment_z": _noisy(Kind.MOMENT, 2, "reading of moment_z without load", _TARED),
    "drift_force_x": _noisy(Kind.FORCE, 0, "change of that zero over the recording", _WARM),
    "drift_force_y": _noisy(Kind.FORCE, 1, "change of that zero over the recording", _WARM),
    "drift_moment_z": _noisy(Kind.MOMENT, 2, "change of that zero over the recording", _WARM),
    "transducer_angle": Tolerable(
        kind=Kind.ANGLE,
        what="rotation of the transducer's axes from x to y",
        size=np.deg2rad(0.5),
        reason="ISO 273, fine: M2 in holes of 2.2 mm; 0.2 mm of play on 20 mm",
    ),
    "crosstalk": Tolerable(
        kind=Kind.NUMBER,
        what="share of each other channel, of full scale, that a channel shows as well",
        size=0.002,
        reason="ME-Messsysteme, sheet of the K3D40 (5 Oct 2016): 0.5 to 1 % as delivered; a "
        "part of it is left after a calibration with weights",
    ),
    "moment_origin_x": Tolerable(
        kind=Kind.LENGTH,
        what="origin of the moment along the surface, from the clamp",
        size=0.002,
        si=2e-4,
        reason="ISO 2768-1, class m: ±0.2 mm on 6 to 30 mm, by drawings of clamp and transducer",
    ),
    "moment_origin_y": Tolerable(
        kind=Kind.LENGTH,
        what="origin of the moment along the normal, from the clamp",
        size=0.002,
        si=2e-4,
        reason="ISO 2768-1, class m: ±0.2 mm on 6 to 30 mm, by drawings of clamp and transducer",
    ),
    "stage_scale": Tolerable(
        kind=Kind.NUMBER,
        what="scale of the clamp positions",
        size=0.001,
        reason="JIS B 1192: ball screws of grade C7 50 um on 300 mm, of C10 210 um",
        relative=True,
    ),
}
# Property of the rod that turns such a tolerance with a unit into a relative one.
_OF_ROD = {"modulus": "youngs_modulus", "diameter": "base_diameter", "length": "length"}


def check_name(name: str) -> None:
    """Refuse the name of a quantity without tolerance, and suggest the nearest.

    Raises
    ------
    ArgumentError
    """
    if name not in TOLERABLE:
        near = get_close_matches(name, TOLERABLE, 1)
        meant = f"; did you mean {near[0]}?" if near else ""
        raise UnknownNameError(
            f"a tolerance is of one of {', '.join(TOLERABLE)}, got {name!r}{meant}"
        )


def read_tolerances(
    units: Units, given: Mapping[str, Quantity], whisker: "Whisker | None" = None
) -> dict[str, float]:
    """Read tolerances such as ``{"clamp_angle": "0.5 deg", "modulus": "2 %"}``.

    Parameters
    ----------
    units : Units
    given : mapping of str to str or number
        Standard deviations by the names of `TOLERABLE`, or `EXACT`.
    whisker : Whisker, optional
        In these units; a percentage is one of its value.

    Returns
    -------
    dict of str to float
        In units of the rod, rad, or relative; 0 where a quantity is exact.

    Raises
    ------
    ArgumentError
        With a line for each name or size that is not allowed.
    """
    found, errors = {}, []
    for name, size in given.items():
        try:
            check_name(name)
            found[name] = 0.0 if size == EXACT else _read(units, name, size, whisker)
            if not 0.0 <= found[name] < np.inf:
                raise ArgumentError(f"the tolerance of {name} must not be negative, got {size!r}")
        except ArgumentError as error:
            errors.append(str(error))
    if errors:
        raise ArgumentError("\n".join(errors))
    return found


def _read(units: Units, name: str, size: Quantity, whisker: "Whisker | None") -> float:
    what, one = f"the tolerance of {name}", TOLERABLE[name]
    if isinstance(size, str) and size.strip().endswith("%"):
        part = float(units.read(size.strip()[:-1], Kind.NUMBER, what)) / 100.0
        if one.relative or name == "crosstalk":
            return part
        value = 0.0 if whisker is None else _value(whisker, name)
        if not value:
            raise ArgumentError(f"{what} is {size}, but {name} is 0 or not known: give a size")
        return part * abs(value)
    rod = None if whisker is None else whisker.rod
    if name in _OF_ROD and rod is not None and not is_number(size):
        return float(in_si(str(size), one.kind, what)) / getattr(rod, _OF_ROD[name])
    return float(units.read(size, Kind.NUMBER if one.relative else one.kind, what))


def _value(whisker: "Whisker", name: str) -> float:
    values = {"theta": whisker.theta, "eta": whisker.eta, **vars(whisker.mounting)}
    return float(np.atleast_1d(values.get(name, 0.0))[0])


def assumed_tolerances(units: Units, noise: FloatArray) -> dict[str, float]:
    """Return default tolerances.

    Parameters
    ----------
    units : Units
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each channel; NaN where there is none.

    Returns
    -------
    dict of str to float
        As from `read_tolerances`; none for a channel without noise.
    """
    found = {
        name: one.default(1.0 if one.relative else units.unit(one.kind), noise)
        for name, one in TOLERABLE.items()
    }
    return {name: size for name, size in found.items() if np.isfinite(size)}


def told(name: str, size: float, units: Units) -> tuple[float, str]:
    """Convert the tolerance of a quantity to the unit in which it is displayed."""
    one = TOLERABLE[name]
    if one.relative or name == "crosstalk":
        return 100.0 * size, "%"
    if one.kind is Kind.ANGLE:
        return float(np.rad2deg(size)), "deg"
    value, unit = units.told(size * units.unit(one.kind), one.kind)
    return value, "" if one.kind is Kind.NUMBER else unit
