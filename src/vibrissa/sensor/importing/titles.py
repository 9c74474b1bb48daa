"""Titles of columns and the units in them, as files and options write them."""

import re
from typing import NamedTuple

from vibrissa.errors import ArgumentError
from vibrissa.quantities.units import CHANNEL_KINDS, Kind, is_number, unit_size
from vibrissa.sensor.transducer import CHANNELS

# Columns of a recording and what they measure.
KINDS = {
    "time": Kind.TIME,
    "footpoint": Kind.LENGTH,
    **dict(zip(CHANNELS, CHANNEL_KINDS, strict=True)),
}
# Titles with units: Fz [mN], Fz (mN); Fz / mN and Fz in mN if this is a unit of the quantity that
# the column must hold.
TITLE = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]")
DIVIDED = re.compile(r"(.+?)\s*(?:/\s*|\s+in\s+)([^\s_/]+)")
# Fz_mN, Fz mN: the ending may be a word. It is a unit only if it is in SI units or a usual one.
ENDING = re.compile(r"(.+?)\s*[_ ]\s*([^\s_/]+)")
USUAL_ENDING = re.compile(
    r"[kmcunµμ]?[mN]|[mMkuµμ]?N[*·]?[mc]?m|[munµμ]?s|inch|lbf|kgf|kp|Newtons?|sec|cNm"
)
# Column in an option, with sign, unit and factor: -Fz [mN], Fz * 12.5 N/V.
SOURCE = re.compile(
    r"(?P<minus>-?)\s*(?P<title>.*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?"
    r"(?:\s*[*×]\s*(?P<factor>[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(?:\s*(?P<per>[^\W\d_].*))?)?"
)
# Weights that stand for forces, and products of them with a length.
WEIGHTS = {"kg": "kgf", "g": "gf", "lb": "lbf", "lbs": "lbf", "oz": "ozf"}
WEIGHT = re.compile(r"\b(kg|g|lbs?|oz)\b")


class NamedUnit(NamedTuple):
    """A unit as Pint spells it, its size in SI units, and how it was understood."""

    name: str
    size: float
    remark: str = ""


class Stated(NamedTuple):
    """Column in an option: sign, title, unit, and a factor with its unit; empty if not stated."""

    minus: bool
    title: str
    unit: str
    factor: float
    per: str


def unit_named(text: str, kind: Kind) -> NamedUnit | None:
    """Find the unit of a kind that a file calls so; None if there is none.

    Capitals may be wrong where no other unit is meant, as in ``MM``; a weight is a force.

    Examples
    --------
    >>> unit_named("Sec", Kind.TIME)
    NamedUnit(name='sec', size=1.0, remark='')
    """
    for name in (text, text.lower(), text.capitalize()):
        if size := unit_size(name, kind):
            return NamedUnit(name, float(size))
    if kind in CHANNEL_KINDS:
        force = WEIGHT.sub(lambda weight: WEIGHTS[weight[0]], text.lower().replace("-", "*"))
        if size := unit_size(force, kind):
            return NamedUnit(force, float(size), f" ({text} taken as a force)")
    return None


def stated_in(source: str) -> Stated:
    """Split a column in an option, such as ``-Fz [mN]`` or ``Ch1 * 12.5 N/V``."""
    parts = SOURCE.fullmatch(source.strip()).groupdict(default="")  # type: ignore[union-attr]
    factor = parts["factor"]
    if factor and not is_number(factor):
        raise ArgumentError(
            f"the factor of column {parts['title']} must be a number, got {factor!r}"
        )
    return Stated(
        minus=bool(parts["minus"]),
        title=parts["title"],
        unit=parts["unit"].strip(),
        factor=float(factor or 1.0),
        per=parts["per"].strip(),
    )


def title_of(text: str, kind: Kind) -> tuple[str, str]:
    """Split a title into the name of a column and its unit, which is empty if there is none.

    Examples
    --------
    >>> title_of("Fx / mN", Kind.FORCE)
    ('Fx', 'mN')
    """
    if parts := TITLE.fullmatch(text):
        return parts[1], parts[2].strip()
    parts = DIVIDED.fullmatch(text)
    return (parts[1], parts[2]) if parts and unit_named(parts[2], kind) else (text, "")


def ending_of(text: str, kind: Kind) -> tuple[str, str]:
    """Split a title such as ``Fx_mN``, whose ending may be a unit; it is empty if it is none.

    Examples
    --------
    >>> ending_of("F_dyn", Kind.FORCE)
    ('F_dyn', '')
    """
    parts = ENDING.fullmatch(text)
    usual = parts and USUAL_ENDING.fullmatch(parts[2]) and unit_named(parts[2], kind)
    return (parts[1], parts[2]) if parts and usual else (text, "")
