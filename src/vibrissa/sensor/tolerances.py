"""Tolerances: the quantities that have one, how it is read, and the default if none is stated.

A tolerance is a standard deviation, in units of the rod, in rad, or relative to the value.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from vibrissa.errors import ArgumentError, UnknownNameError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.keys import suggestion
from vibrissa.quantities.units import Kind, Quantity, Units, is_number

# For one quantity: it has no tolerance. For all: only stated tolerances count.
EXACT = "exact"


@dataclass(frozen=True, kw_only=True)
class Tolerable:
    """A quantity that has a tolerance; see tolerances.toml.

    Attributes
    ----------
    size : float
        Default tolerance, 0 if the quantity is exact: nondimensional, in rad, or relative to the
        value. With a `channel` it is in standard deviations of one reading of that channel.
    reason : str
        Source of the default: a standard, a data sheet, or an estimate with its reason.
    si : float
        Default tolerance in SI units, which replaces `size` if the rod is in SI units; 0: `size`
        holds for these rods, too.
    relative : bool
        Whether the tolerance is relative to the value.
    channel : int
        Transducer channel whose noise sets the default, 0 to 2 (force_x, force_y, moment_z); −1:
        none.
    """

    kind: Kind
    what: str
    size: float
    reason: str
    si: float = 0.0
    relative: bool = False
    channel: int = -1

    @classmethod
    def read(cls, entry: Mapping[str, Any]) -> Self:
        """Read an entry of tolerances.toml, where angles are in degrees."""
        kind = Kind[entry["kind"].upper()]
        size = float(entry["size"])
        radians = float(np.deg2rad(size))
        return cls(**{**entry, "kind": kind, "size": radians if kind is Kind.ANGLE else size})

    def default(self, units: Units, noise: FloatArray) -> float:
        """Default tolerance: nondimensional, in rad, or relative to the value.

        Parameters
        ----------
        units : Units
            Units of the rod.
        noise : ndarray, shape (3,)
            Standard deviation of a reading of each channel (E·I0/L² and E·I0/L).
        """
        if self.channel >= 0:
            return self.size * float(noise[self.channel])
        return self.si / units.unit(self.kind) if self.si and units.rod else self.size


_FILE = Path(__file__).with_name("tolerances.toml")
TOLERABLE = {
    name: Tolerable.read(entry)
    for name, entry in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()
}


def check_name(name: str) -> None:
    """Refuse a name that is not in `TOLERABLE`; the message suggests the nearest one.

    Raises
    ------
    ArgumentError
    """
    if name not in TOLERABLE:
        raise UnknownNameError(
            f"a tolerance must be for one of {', '.join(TOLERABLE)}, got {name!r}"
            f"{suggestion(name, TOLERABLE)}"
        )


def read_tolerances(
    units: Units, given: Mapping[str, Quantity], values: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Read tolerances such as ``{"clamp_angle": "0.5 deg", "modulus": "2 %"}``.

    Parameters
    ----------
    units : Units
        Units of the rod.
    given : mapping of str to str or number
        Names of quantities, and their tolerances as the user states them.
    values : mapping of str to float, optional
        The quantities that are known, as in `Whisker.values`: a tolerance in percent is relative to
        the value.

    Returns
    -------
    dict of str to float
        Tolerances: nondimensional, in rad, or relative to the value; 0 for an exact quantity.

    Raises
    ------
    ArgumentError
        If a name or a size is not allowed.
    """
    known = values or {}
    tolerances = {}
    for name, size in given.items():
        check_name(name)
        tolerances[name] = (
            0.0 if size == EXACT else _read(units, name, size, abs(known.get(name, 0.0)))
        )
        if not 0.0 <= tolerances[name] < np.inf:
            raise ArgumentError(f"the tolerance of {name} must not be negative, got {size!r}")
    return tolerances


def _read(units: Units, name: str, size: Quantity, value: float) -> float:
    """Read the tolerance of a quantity whose size is `value`; 0: it is 0 or not known."""
    what = f"the tolerance of {name}"
    quantity = TOLERABLE[name]
    text = str(size).strip()
    if text.endswith("%"):
        part = float(units.read(text[:-1], Kind.NUMBER, what)) / 100.0
        if not (quantity.relative or value):
            raise ArgumentError(
                f"{what} is {size}, but {name} is 0 or not given: state the tolerance with a unit"
            )
        return part if quantity.relative else part * value
    if quantity.relative and value and not is_number(text):
        return quantity.kind.read(text, what) / value
    return float(units.read(text, Kind.NUMBER if quantity.relative else quantity.kind, what))


def assumed_tolerances(units: Units, noise: FloatArray) -> dict[str, float]:
    """Return the default tolerances, without those that are 0; see `Tolerable.default`."""
    tolerances = {name: quantity.default(units, noise) for name, quantity in TOLERABLE.items()}
    return {name: size for name, size in tolerances.items() if size > 0.0}


def displayed(name: str, size: float, units: Units) -> tuple[float, str]:
    """Convert a tolerance to the unit in which it is displayed; return value and unit."""
    quantity = TOLERABLE[name]
    if quantity.relative:
        return 100.0 * size, "%"
    if quantity.kind is Kind.ANGLE:
        return float(np.rad2deg(size)), "deg"
    value, unit = units.displayed(size * units.unit(quantity.kind), quantity.kind)
    return value, "" if quantity.kind is Kind.NUMBER else unit
