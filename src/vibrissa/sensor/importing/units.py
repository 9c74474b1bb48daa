"""Titles with units as laboratories write them: ``Fz [mN]``, ``Fz (mN)``, ``Fz / mN``."""

import re
from typing import NamedTuple

from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import SI, Kind, in_si

# A moment without a sign between its units, which a library reads as something else.
RUN_TOGETHER = re.compile(r"([kmuµμn]?N)([kcmuµμ]?m)")
BRACKETS = re.compile(r"\[(.*)\]|\((.*)\)")
TITLE = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\)|/\s*(?P<per>\S+)"
    r"|\bin\s+(?P<word>\S+))"
)
MEASURED = (Kind.LENGTH, Kind.FORCE, Kind.MOMENT, Kind.TIME)


class Title(NamedTuple):
    """Name of a column and its unit; empty if there is none."""

    name: str
    unit: str


def title_of(text: str) -> Title:
    """Take a title apart."""
    parts = TITLE.fullmatch(text.strip())
    if parts is None or not parts["name"]:
        return Title(text.strip(), "")
    unit = next(filter(None, (parts[i] for i in ("square", "round", "per", "word"))), "")
    return Title(parts["name"], unit.strip())


def usual(unit: str) -> str:
    """Write a unit in the usual way: ``N*mm`` for ``Nmm``."""
    text = unit.strip()
    together = RUN_TOGETHER.fullmatch(text)
    return f"{together[1]}*{together[2]}" if together else text


def unit_size(unit: str, kind: Kind, what: str) -> float:
    """Give the size of a unit in SI units.

    Parameters
    ----------
    unit : str
        As a laboratory writes it: ``mN``, ``N·mm``, ``Nmm``.
    kind : Kind
        What it must measure.
    what : str
        How a message names the column.

    Raises
    ------
    ArgumentError
        If it is no such unit.
    """
    try:
        return float(in_si(f"1 {usual(unit)}", kind, what))
    except ArgumentError:
        raise ArgumentError(
            f"{what} must have the unit of a {kind}, such as {SI[kind]}, got {unit!r}"
        ) from None


def is_unit(text: str) -> bool:
    """Whether a cell is the unit of something that a recording may have, or stands for none."""
    inside = BRACKETS.fullmatch(text.strip())
    unit = next(filter(None, inside.groups()), "") if inside else text.strip()
    if unit in {"", "-", "1", "%", "V", "mV", "°C", "C"}:
        return True
    return any(size_of(unit, kind) is not None for kind in MEASURED)


def size_of(unit: str, kind: Kind) -> float | None:
    """Size of a unit in SI units; None if it is none of this kind."""
    try:
        return unit_size(unit, kind, "unit")
    except ArgumentError:
        return None
