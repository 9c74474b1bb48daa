"""Proofs beside tables: enclosures of their numbers, as `python -m validation proof` writes them.

They are decimals, so that nothing is needed to read them.
"""

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

from vibrissa.errors import TableError

FILE = "enclosures.csv"
# Columns by which a proof names a row of each table.
KEYS = {
    "stiction": ("theta", "mu0", "eta", "dx0"),
    "curves": ("theta", "eta"),
    "scans": ("scan", "theta", "mu0", "eta", "dx0", "cycle"),
    "states": ("state",),
}


@dataclass(frozen=True, kw_only=True)
class Proof:
    """What is proved of a row of a table: one of its numbers, or what the note says.

    Attributes
    ----------
    row : mapping of str
        Keys of the row.
    quantity : str
        Column; empty where there is only a note.
    midpoint, radius : Decimal
        The true number lies between midpoint − radius and midpoint + radius.
    on_path : bool
        Whether it is proved, too, that the path from α = 0 leads there first, or that the tip
        locks.
    """

    table: str
    row: Mapping[str, str]
    quantity: str
    midpoint: Decimal
    radius: Decimal
    on_path: bool
    note: str


def read(path: Path, keys: Mapping[str, Sequence[str]]) -> list[Proof]:
    """Read a file of enclosures.

    Parameters
    ----------
    keys : mapping
        Columns that tell the rows of each table apart; other tables are left out.

    Raises
    ------
    TableError
        If the file is none of enclosures.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            lines = [line for line in csv.DictReader(file) if line["table"] in keys]
        return [_proof(line, keys[line["table"]]) for line in lines]
    except (ValueError, KeyError, TypeError, InvalidOperation) as error:
        raise TableError(
            f"{path} has no enclosures ({error!r}); restore it from version control, or delete it "
            "and make it anew with: python -m validation proof"
        ) from None


def _proof(line: Mapping[str, str], keys: Sequence[str]) -> Proof:
    known = bool(line["quantity"])
    return Proof(
        table=line["table"],
        row={name: line[name] for name in keys},
        quantity=line["quantity"],
        midpoint=Decimal(line["midpoint"]) if known else Decimal("NaN"),
        radius=Decimal(line["radius"]) if known else Decimal("NaN"),
        on_path=line.get("on_path") == "yes",
        note=line["note"],
    )


def spell_key(values: Iterable[object]) -> str:
    """Spell the keys of a row the same from a table and from a file."""
    return " ".join(map(_spell, values))


def _spell(value: object) -> str:
    try:
        return repr(float(value))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return str(value)
