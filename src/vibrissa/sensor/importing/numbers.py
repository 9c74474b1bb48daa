"""Cells of a table as texts: numbers in the spellings of many programs, and missing values."""

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.series import NUMBER, numbers
from vibrissa.sensor.importing.clock import CLOCK

if TYPE_CHECKING:
    from pandas import DataFrame, Series

DECIMALS = {".": "decimal point", ",": "decimal comma"}
# Error values of spreadsheets, English and German.
ERRORS = r"#(?:n/a|nv|value!|wert!|div/0!|num!|zahl!|ref!|bezug!|name\?|null!)"
# No value, as programs and languages write it: 1.#QNAN is Windows', NaN(ind) newer Windows'.
MISSING = (
    r"(?i:|-+|#{3,}|<?n/?a>?|nat|null|nil|none|missing|[-+]?nan(?:\(\w*\))?"
    rf"|[-+]?(?:inf|infinity|∞)|[-+]?1[.,]#\w+(?:[-+][0-9]+)?|{ERRORS})"
)
# Signs between groups of three digits. The point or comma that is no decimal sign, and a blank,
# count only if some number proves them.
APOSTROPHES = "'’\u00a0\u202f"
BLANK = " "
SIGNED = "[-+]?"
EXPONENT = "(?:[eEdD][-+]?[0-9]+)?"
# A number with a decimal sign, in place of the braces.
DECIMAL = SIGNED + "(?:[0-9]+{0}[0-9]*|{0}[0-9]+)" + EXPONENT
# A number such as 1.234, whose sign may separate decimals or thousands.
EITHER_SIGN = SIGNED + "[1-9][0-9]{0,2}[.,][0-9]{3}"
# A number whose decimal sign is certain, as another sign or two equal ones separate its groups.
GROUPED = SIGNED + "[1-9][0-9]{{0,2}}(?:(?:[{1}][0-9]{{3}})+{0}[0-9]+|(?:[{2}][0-9]{{3}}){{2,}})"
# A number with groups.
THOUSANDS = SIGNED + f"[0-9]{{1,3}}(?:[.,{APOSTROPHES}{BLANK}][0-9]{{3}})+(?:[.,][0-9]+)?"

_VALUE = re.compile(f"{NUMBER.format('[.,]')}|{DECIMAL.format('[.,]')}|{THOUSANDS}|{CLOCK.pattern}")
_WHOLE = re.compile(SIGNED + "[0-9]+" + EXPONENT)
_MISSING = re.compile(MISSING)
_THOUSANDS = re.compile(THOUSANDS)


def is_missing(cell: str) -> bool:
    """Whether a cell has no value."""
    return _MISSING.fullmatch(cell) is not None


def is_empty(cells: Iterable[str]) -> bool:
    """Whether no cell has a value."""
    return all(map(is_missing, cells))


def share_of_numbers(cells: Iterable[str]) -> float:
    """Share of numbers and times among the cells that have a value; 0 without such cells."""
    filled = [cell for cell in cells if not is_missing(cell)]
    return sum(1 for cell in filled if _VALUE.fullmatch(cell)) / max(len(filled), 1)


def is_whole(cell: str) -> bool:
    """Whether a cell is a number without a decimal sign."""
    return _WHOLE.fullmatch(cell) is not None


def without_value(cells: "DataFrame") -> BoolArray:
    """Whether no cell has a value, for each row."""
    empty = np.ones(len(cells), dtype=bool)
    for _, column in cells.items():
        # A row that has a value in one column is not searched further.
        texts = column[empty].astype(str).str.strip()
        empty[empty] = texts.str.fullmatch(MISSING).to_numpy(dtype=bool)
    return empty


class Signs(NamedTuple):
    """Decimal sign of a table, and the signs that may separate groups of three digits."""

    decimal: str
    groups: str = ""

    @property
    def note(self) -> str:
        """As in ``decimal comma, thousands separated by '.'``."""
        proved = self.groups.removeprefix(APOSTROPHES)
        more = f", thousands separated by {proved!r}" if proved else ""
        return DECIMALS[self.decimal] + more


def signs_of(cells: "DataFrame", name: str, stated: str | None) -> Signs:
    """Find the decimal sign from the numbers in which it is certain.

    A point or comma separates thousands only if some number proves it, such as ``1.234,5``.

    Raises
    ------
    RecordingError
        If no number decides; the message names the option to add.
    """
    proofs = dict.fromkeys(DECIMALS, 0)
    grouped = dict.fromkeys(DECIMALS, "")
    doubtful: dict[int, str] = {}
    for _, column in cells.items():
        text = column.astype(str).str.strip()
        signed = text[text.str.contains("[.,]")]
        either = signed.str.fullmatch(EITHER_SIGN)
        if either.any():
            line = int(signed.index[either.to_numpy().argmax()])
            doubtful[line] = doubtful.get(line, signed[line])
        for sign, other in (".,", ",."):
            proofs[sign] += int((signed.str.fullmatch(DECIMAL.format(f"[{sign}]")) & ~either).sum())
            pattern = GROUPED.format(f"[{sign}]", other + APOSTROPHES + BLANK, other)
            certain = signed[signed.str.fullmatch(pattern)]
            proofs[sign] += len(certain)
            proved = [
                group for group in (other, BLANK) if certain.str.contains(group, regex=False).any()
            ]
            grouped[sign] += "".join(group for group in proved if group not in grouped[sign])
    if stated is None and doubtful and not any(proofs.values()):
        line = min(doubtful)
        raise RecordingError(
            f"{name}, line {line}: the separator in {doubtful[line]!r} may mark decimals or "
            "thousands: add --decimal ',' or --decimal '.', whichever marks decimals"
        )
    decimal = stated or max(proofs, key=lambda sign: proofs[sign])
    return Signs(decimal, APOSTROPHES + grouped[decimal])


def values_of(
    columns: Mapping[str, "Series[str]"], name: str, signs: Signs
) -> dict[str, FloatArray]:
    """Convert columns of cells to numbers; NaN where a value is missing.

    Raises
    ------
    RecordingError
        With a line for each cell that is no finite number.
    """
    plain = {target: _plain(column, signs) for target, column in columns.items()}
    try:
        return numbers(plain, name, signs.decimal)
    except RecordingError as error:
        grouped = [cell for column in plain.values() for cell in column if _has_groups(cell)]
        if not grouped:
            raise
        raise RecordingError(
            f"{error}\n{name}: {grouped[0]!r} seems to have a separator of thousands: it is read "
            "only where other numbers prove it, such as 1.234,5; or write numbers without it"
        ) from None


def _has_groups(cell: object) -> bool:
    return isinstance(cell, str) and _THOUSANDS.fullmatch(cell.strip()) is not None


def _plain(column: "Series[str]", signs: Signs) -> "Series[str]":
    """Write numbers without groups and with the exponent e, and missing values as nan."""
    if column.dtype.kind in "fiu":
        return column
    usual = column.str.strip().str.fullmatch(NUMBER.format(f"[{signs.decimal}]")).to_numpy(bool)
    if usual.all():
        return column
    plain = column.astype(object)
    plain[~usual] = [_plain_cell(cell, signs) for cell in plain[~usual]]
    return plain


def _plain_cell(cell: object, signs: Signs) -> object:
    text = str(cell).strip()
    if is_missing(text):
        return "nan"
    if re.fullmatch(DECIMAL.format(f"[{signs.decimal}]?"), text):
        return re.sub("[dD]", "e", text)
    parts = text.split(signs.decimal)
    groups = re.fullmatch(rf"[-+]?[0-9]{{1,3}}(?:[{signs.groups}][0-9]{{3}})+", parts[0])
    if signs.groups and groups and len(parts) <= 2:
        return signs.decimal.join([re.sub(f"[{signs.groups}]", "", parts[0]), *parts[1:]])
    return cell
