"""Requirements from text: quantities with units, names of materials and transducers."""

from typing import Any

from vibrissa.design.materials import material as material_named
from vibrissa.design.requirements import Channels, Requirements
from vibrissa.design.stock import read_stock
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.rod import Rod
from vibrissa.sensor.quantities import Kind, Units, channels_of, in_si, range_of
from vibrissa.sensor.transducer import preset

# Has a meaning in SI units only.
DIMENSIONAL = ("modulus", "density", "diameter", "length", "tip")
# What is no single length.
RANGES = ("mu0", "theta", "eta", "diameter", "length")
CHANNELS = ("noise", "range")
KINDS = {
    "modulus": Kind.STRESS,
    "density": Kind.DENSITY,
    "mu0": Kind.NUMBER,
    "theta": Kind.NUMBER,
}


def read_requirements(
    *, material: str | None = None, transducer: str | None = None, **asked: Any
) -> Requirements:
    """Read requirements from text.

    Parameters
    ----------
    material : str, optional
        Name of a material, instead of modulus and yield strain.
    transducer : str, optional
        Name of a transducer, instead of noise and range.
    **asked
        As in `Requirements`, None for the default. Quantities are text: ``"20 um"``,
        ``"20 to 200 mm"``, ``"3 mN, 3 mN, 10 uN*m"``. A bare number is in units of the rod, as far
        as its modulus, diameter and length are single values. Without a material and a modulus
        everything is in units of the rod.

    Returns
    -------
    Requirements

    Raises
    ------
    ArgumentError
        If something is missing, given twice, out of range, or no such quantity.
    """
    given = {name: value for name, value in asked.items() if value is not None}

    def read(names: tuple[str, ...], units: Units | None) -> dict[str, Any]:
        return {name: _read(name, given[name], units) for name in names if name in given}

    values = given | read(DIMENSIONAL, None)
    if "stock" in given:
        values["stock"] = read_stock(given["stock"])
    values |= _of_material(material, values)
    if "modulus" not in values:
        _refuse_dimensions(values, transducer)
    lengths, reactions = _known_units(values)
    values |= read(("mu0", "theta"), Units()) | read(("eta",), lengths or Units())
    values |= read(("step", "spacing"), lengths) | read(("noise", "range"), reactions)
    values |= _of_transducer(transducer, values)
    return (Requirements if "modulus" in values else Requirements.nondimensional)(**values)


def _of_material(name: str | None, values: dict[str, Any]) -> dict[str, float]:
    """Give modulus, yield strain and density of a material, if one is named."""
    if name is None:
        if "modulus" in values and "yield_strain" not in values:
            raise ArgumentError("a modulus needs a yield strain, too")
        return {}
    if "modulus" in values or "yield_strain" in values:
        raise ArgumentError("give the material, or its modulus and yield strain, not both")
    found = material_named(name)
    density = values.get("density", found.density)
    return {"modulus": found.modulus, "yield_strain": found.yield_strain, "density": density}


def _of_transducer(name: str | None, values: dict[str, Any]) -> dict[str, Channels]:
    """Give noise and range of a transducer, if one is named."""
    if name is None:
        if "noise" not in values:
            raise ArgumentError("give a transducer or the noise of its readings")
        return {}
    if "noise" in values or "range" in values:
        raise ArgumentError("give the transducer, or its noise and range, not both")
    return {"noise": preset(name).deviation, "range": preset(name).limit}


def _refuse_dimensions(values: dict[str, Any], transducer: str | None) -> None:
    """Refuse what has no meaning in units of the rod."""
    surplus = [name for name in values if name in (*DIMENSIONAL, "stock")]
    surplus += [] if transducer is None else ["transducer"]
    if surplus:
        raise ArgumentError(
            f"{', '.join(surplus)} cannot be used without the material: give the material, or its "
            "modulus and yield strain"
        )


def _known_units(values: dict[str, Any]) -> tuple[Units | None, Units | None]:
    """Units of bare lengths, and of bare forces and moments; None where the rod is not known."""
    if "modulus" not in values:
        return Units(), Units()
    # A size that is a range, or not given, is not known.
    diameter, length = (
        low if low == high else None
        for low, high in (values.get(name, (0.0, 1.0)) for name in ("diameter", "length"))
    )
    if length is None:
        return None, None
    units = Units(Rod(values["modulus"], diameter or 1.0, length))
    return units, None if diameter is None else units


def _read(name: str, text: str, units: Units | None) -> Any:
    """Read a value, the ends of a range, or a value for each channel of a transducer."""

    def value(part: str, kind: Kind) -> float:
        if units is None:
            return float(in_si(part, kind, name))
        # Heights stay in units of the length.
        return float(units.read(part, kind, name)) * (1.0 if name == "eta" else units.unit(kind))

    if name in CHANNELS:
        return tuple(value(part, kind) for part, kind in channels_of(text, name))
    kind = KINDS.get(name, Kind.LENGTH)
    if name in RANGES:
        return tuple(value(end, kind) for end in range_of(text))
    return value(text, kind)
