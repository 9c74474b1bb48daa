"""Tolerances: of what there may be one, how it is read, and what is assumed where none is stated.

A tolerance is a standard deviation, in units of the rod, in rad, or as a part of the value.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrissa.errors import ArgumentError, UnknownNameError
from vibrissa.sensor.quantities import Kind, Quantity, Units, in_si

if TYPE_CHECKING:
    from vibrissa.sensor.whisker import Whisker

# In place of a size: it has no tolerance. In place of all: nothing has but what is stated.
EXACT = "exact"


@dataclass(frozen=True, kw_only=True)
class Assumed:
    """The tolerance of something for which none was stated.

    Attributes
    ----------
    size : float
        In units of the rod, rad, or relative; for `of_noise` in deviations of one reading.
    si : float
        The same in SI units where the rod is known; 0 where `size` holds for every rod.
    of_noise : bool
    reason : str
        Where it is from: a standard, a sheet, or what we would expect and why.
    """

    size: float
    reason: str
    si: float = 0.0
    of_noise: bool = False

    def of(self, unit: float, noise: float) -> float:
        """Give it for a unit of the rod in SI units, or for the noise of a channel."""
        if self.of_noise:
            return self.size * noise
        return self.si / unit if self.si and unit != 1.0 else self.size


@dataclass(frozen=True, kw_only=True)
class Tolerable:
    """Something that may have a tolerance.

    Attributes
    ----------
    kind : Kind
        What it measures.
    what : str
        In words.
    assumed : Assumed
    relative : bool
        Whether its tolerance is a part of its value.
    channel : int
        Number of the channel whose noise counts; −1 without one.
    """

    kind: Kind
    what: str
    assumed: Assumed
    relative: bool = False
    channel: int = -1


def _noisy(kind: Kind, channel: int, what: str, reason: str) -> Tolerable:
    assumed = Assumed(size=3.0, of_noise=True, reason=reason)
    return Tolerable(kind=kind, what=what, assumed=assumed, channel=channel)


_TARED = "no sheet; a tare is the mean of few readings, and the zero moves after it"
_WARM = (
    "ME-Messsysteme, sheet of the K3D40 (5 Oct 2016): 0.05 % of full scale per kelvin, as much "
    "creep; of 12 N that is 6 mN for a change by 1 K, two deviations of a Nano17"
)
TOLERABLE = {
    "theta": Tolerable(
        kind=Kind.NUMBER,
        what="taper",
        assumed=Assumed(
            size=0.02,
            reason="5 um of each of two diameters of about 1 and 0.5 mm, as for the diameter",
        ),
    ),
    "eta": Tolerable(
        kind=Kind.LENGTH,
        what="height of the surface above the clamp",
        assumed=Assumed(
            size=0.002,
            si=2e-4,
            reason="no sheet; touched off with a feeler gauge or by eye. ISO 2768-1, class m: "
            "±0.3 mm on 30 to 120 mm",
        ),
    ),
    "clamp_angle": Tolerable(
        kind=Kind.ANGLE,
        what="inclination of the clamp",
        assumed=Assumed(
            size=np.deg2rad(0.5),
            reason="ISO 2768-1, classes f and m: ±0.5° where the shorter side has 10 to 50 mm; a "
            "hole with 0.1 mm of play over 10 mm",
        ),
    ),
    "clamp_compliance": Tolerable(
        kind=Kind.COMPLIANCE,
        what="turn of the clamp per moment",
        assumed=Assumed(
            size=0.005, reason="no sheet; half a diameter more of rod in the collet, of 1 on 100 mm"
        ),
    ),
    "curvature": Tolerable(
        kind=Kind.CURVATURE,
        what="natural curvature, at the clamp",
        assumed=Assumed(
            size=0.02, reason="no sheet; a wire whose tip is 1 % of the length off the axis"
        ),
    ),
    "stage_angle": Tolerable(
        kind=Kind.ANGLE,
        what="angle of the stage to the surface",
        assumed=Assumed(
            size=np.deg2rad(0.5), reason="no sheet; a surface laid on the stage: 0.9 mm on 100"
        ),
    ),
    "surface_slope": Tolerable(
        kind=Kind.ANGLE,
        what="slope of the surface from place to place, alike over 5 mm",
        assumed=Assumed(
            size=np.deg2rad(0.5),
            reason="no sheet; ±1° over some mm of a ground or milled surface are two deviations",
        ),
    ),
    "modulus": Tolerable(
        kind=Kind.STRESS,
        what="Young's modulus",
        assumed=Assumed(
            size=0.03,
            reason="of the same spring wire EN 10270-1 says 206 GPa, and Shigley (table 10-5) 200",
        ),
        relative=True,
    ),
    "creep": Tolerable(
        kind=Kind.NUMBER,
        what="fall of Young's modulus per decade of time, from the first sample",
        assumed=Assumed(
            size=0.001, reason="no sheet; of steel less, of polymers some per cent: state it"
        ),
        relative=True,
    ),
    "diameter": Tolerable(
        kind=Kind.LENGTH,
        what="diameter at the clamp",
        assumed=Assumed(
            size=0.005,
            reason="a micrometer: 5 um of 1 mm. ISO 286-2: a rod of 1 mm to h7 is up to 10 um "
            "thinner",
        ),
        relative=True,
    ),
    "length": Tolerable(
        kind=Kind.LENGTH,
        what="length",
        assumed=Assumed(
            size=0.003,
            reason="ISO 2768-1, class m: ±0.3 mm on 30 to 120 mm; a calliper, and where the clamp "
            "begins",
        ),
        relative=True,
    ),
    "zero_force_x": _noisy(Kind.FORCE, 0, "reading of force_x without load", _TARED),
    "zero_force_y": _noisy(Kind.FORCE, 1, "reading of force_y without load", _TARED),
    "zero_moment_z": _noisy(Kind.MOMENT, 2, "reading of moment_z without load", _TARED),
    "drift_force_x": _noisy(Kind.FORCE, 0, "its change over the recording", _WARM),
    "drift_force_y": _noisy(Kind.FORCE, 1, "its change over the recording", _WARM),
    "drift_moment_z": _noisy(Kind.MOMENT, 2, "its change over the recording", _WARM),
    "transducer_angle": Tolerable(
        kind=Kind.ANGLE,
        what="turn of the transducer's axes from x to y",
        assumed=Assumed(
            size=np.deg2rad(0.5),
            reason="ISO 273, fine: M2 in holes of 2.2 mm; 0.2 mm of play on 20 mm",
        ),
    ),
    "crosstalk": Tolerable(
        kind=Kind.NUMBER,
        what="part of each other channel, of full scale, that a channel shows too",
        assumed=Assumed(
            size=0.002,
            reason="ME-Messsysteme, sheet of the K3D40 (5 Oct 2016): 0.5 to 1 % as delivered; a "
            "part of it is left after a calibration with weights",
        ),
    ),
    "moment_origin_x": Tolerable(
        kind=Kind.LENGTH,
        what="where along the surface the moment is taken, from the clamp",
        assumed=Assumed(
            size=0.002,
            si=2e-4,
            reason="ISO 2768-1, class m: ±0.2 mm on 6 to 30 mm, by drawings of clamp and "
            "transducer",
        ),
    ),
    "moment_origin_y": Tolerable(
        kind=Kind.LENGTH,
        what="the same along the normal",
        assumed=Assumed(
            size=0.002,
            si=2e-4,
            reason="ISO 2768-1, class m: ±0.2 mm on 6 to 30 mm, by drawings of clamp and "
            "transducer",
        ),
    ),
    "stage_scale": Tolerable(
        kind=Kind.NUMBER,
        what="scale of the clamp positions",
        assumed=Assumed(
            size=0.001, reason="JIS B 1192: ball screws of grade C7 50 um on 300 mm, of C10 210 um"
        ),
        relative=True,
    ),
}
# What a rod has that sets its tolerance in SI units.
OF_SIZE = {"modulus": "youngs_modulus", "diameter": "base_diameter", "length": "length"}


def check_name(name: str, what: str = "a tolerance is of") -> None:
    """Refuse the name of something that has no tolerance, and say the nearest.

    Parameters
    ----------
    name : str
    what : str
        How a message begins.

    Raises
    ------
    ArgumentError
    """
    if name not in TOLERABLE:
        near = get_close_matches(name, TOLERABLE, 1)
        meant = f"; did you mean {near[0]}?" if near else ""
        raise UnknownNameError(f"{what} one of {', '.join(TOLERABLE)}, got {name!r}{meant}")


def read_tolerances(
    units: Units,
    given: Mapping[str, Quantity],
    whisker: "Whisker | None" = None,
) -> dict[str, float]:
    """Read tolerances such as ``{"clamp_angle": "0.5 deg", "modulus": "2 %"}``.

    Parameters
    ----------
    units : Units
    given : mapping of str to str or number
        Standard deviations of some of `TOLERABLE`, or `EXACT`.
    whisker : Whisker, optional
        That was given, in these units; a percentage is one of its value.

    Returns
    -------
    dict of str to float
        In units of the rod, rad, or relative; 0 where something is exact.

    Raises
    ------
    ArgumentError
        If one is no such property or quantity, or negative.
    """
    found = {}
    for name, value in given.items():
        check_name(name)
        found[name] = 0.0 if value == EXACT else _read(units, name, value, whisker)
        if not 0.0 <= found[name] < np.inf:
            raise ArgumentError(f"the tolerance of {name} must not be negative, got {value!r}")
    return found


def _read(
    units: Units,
    name: str,
    value: Quantity,
    whisker: "Whisker | None",
) -> float:
    what, one = f"the tolerance of {name}", TOLERABLE[name]
    if isinstance(value, str) and value.strip().endswith("%"):
        part = float(units.read(value.strip()[:-1], Kind.NUMBER, what)) / 100.0
        if one.relative or name == "crosstalk":
            return part
        of: dict[str, Any] = {}
        if whisker is not None:
            of = {"theta": whisker.theta, "eta": whisker.eta} | vars(whisker.mounting)
        size = of.get(name)
        if size is None or not np.atleast_1d(size)[0]:
            raise ArgumentError(f"{what} has no value of which it could be {value}: give a size")
        return part * abs(float(np.atleast_1d(size)[0]))
    rod = None if whisker is None else whisker.rod
    if name in OF_SIZE and rod is not None and not _is_number(value):
        return float(in_si(str(value), one.kind, what)) / getattr(rod, OF_SIZE[name])
    kind = Kind.NUMBER if one.relative else one.kind
    return float(units.read(value, kind, what))


def _is_number(value: Quantity) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True


def assumed_tolerances(units: Units, noise: np.ndarray) -> dict[str, float]:
    """Give the tolerances of what nothing is stated about.

    Parameters
    ----------
    units : Units
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each channel; NaN where there is none.

    Returns
    -------
    dict of str to float
        As from `read_tolerances`.
    """
    found = {}
    for name, one in TOLERABLE.items():
        unit = 1.0 if one.relative else units.unit(one.kind)
        own = float(noise[one.channel]) if one.channel >= 0 else 0.0
        if np.isfinite(own):
            found[name] = one.assumed.of(unit, own)
    return found


def told(name: str, size: float, units: Units) -> tuple[float, str]:
    """Give a size of a property in a person's unit, and this unit."""
    one = TOLERABLE[name]
    if one.relative or name == "crosstalk":
        return 100.0 * size, "%"
    if one.kind is Kind.ANGLE:
        return float(np.rad2deg(size)), "deg"
    value, unit = units.told(size * units.unit(one.kind), one.kind)
    return value, "" if one.kind is Kind.NUMBER else unit
