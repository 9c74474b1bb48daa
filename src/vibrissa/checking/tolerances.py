"""Layouts of reference tables: their keys, columns and tolerances."""

from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, NonNegativeFloat, TypeAdapter
from pydantic import ValidationError as InvalidLayout

from vibrissa.errors import ComparisonError


class Tolerance(BaseModel):
    """Allowed change of a number: |change| ≤ absolute + relative·|reference|."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    absolute: NonNegativeFloat = 0.0
    relative: NonNegativeFloat = 0.0


_IN_NUMBERS = BeforeValidator(lambda written: {} if written == "exact" else written)


class TableLayout(BaseModel):
    """Layout of a reference table: keys, which identify a row, and tolerances of its columns."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    keys: list[str]
    columns: dict[str, Annotated[Tolerance, _IN_NUMBERS]]


# Names of reference tables; see `vibrissa.checking.condensing.condensed`.
Table: TypeAlias = Literal[
    "stiction", "curves", "scans", "periods", "friction", "states", "comparisons"
]


def read_layouts(path: Path) -> dict[Table, TableLayout]:
    """Read a YAML file that maps the name of each reference table to its layout.

    Raises
    ------
    ComparisonError
        If the file does not hold layouts.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        return TypeAdapter(dict[Table, TableLayout]).validate_python(content)
    except (UnicodeDecodeError, yaml.YAMLError, InvalidLayout) as error:
        raise ComparisonError(
            f"{path} cannot be used. Each table needs the entry 'keys', a list of columns, and the "
            "entry 'columns', with the word exact or {absolute: number, relative: number} for each "
            f"compared column. {error}"
        ) from None
