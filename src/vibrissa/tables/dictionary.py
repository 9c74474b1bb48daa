"""The data dictionary: what each column of a table is, for people."""

from dataclasses import dataclass

import pyarrow as pa

from vibrissa.tables import schemas

_TYPES = {
    schemas.TEXT: "text",
    schemas.NUMBER: "number",
    schemas.WHOLE: "whole number",
    schemas.FLAG: "true or false",
}


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What a column is; a text is empty where there is nothing to be said."""

    name: str
    type: str
    unit: str
    range: str
    null: str
    equation: str
    description: str


def entries(schema: pa.Schema) -> list[Entry]:
    """Return what the columns of a table are.

    Parameters
    ----------
    schema : pyarrow.Schema
        One of `vibrissa.tables.schemas`.

    Returns
    -------
    list of Entry
    """
    return [_entry(column) for column in schema]


def spell_unit(unit: str) -> str:
    """Spell the unit of a column as people do."""
    return unit.replace("*", "·").replace("^2", "²")


def _entry(column: pa.Field) -> Entry:
    said = {key: text.decode() for key, text in column.metadata.items()}
    kind = column.type.value_type if pa.types.is_list(column.type) else column.type
    return Entry(
        name=column.name,
        type=f"list: {_TYPES[kind]}" if kind is not column.type else _TYPES[kind],
        unit=spell_unit(said[schemas.UNIT]) if kind == schemas.NUMBER else "",
        range=said[schemas.RANGE],
        null=said[schemas.NULL],
        equation=said[schemas.EQUATION],
        description=said[schemas.DESCRIPTION],
    )
