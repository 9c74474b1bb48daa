"""Layouts of reference tables: keys, columns and tolerances."""

from dataclasses import dataclass
from typing import Any

import yaml

from vibrissa.errors import ComparisonError


@dataclass(frozen=True)
class Tolerance:
    """How far a number may be from its reference: |change| ≤ absolute + relative·|reference|."""

    absolute: float
    relative: float


@dataclass(frozen=True)
class Layout:
    """A reference table: its keys identify a row; columns without tolerance must be equal."""

    keys: tuple[str, ...]
    columns: dict[str, Tolerance | None]


def parse_layouts(text: str, where: str) -> dict[str, Layout]:
    """Read the layouts of reference tables from YAML; `where` names the file in messages.

    Each table has ``keys``, a list, and ``columns``: ``exact`` or ``{absolute: a, relative: r}``.
    """
    try:
        content = yaml.safe_load(text)
        return {
            name: Layout(
                tuple(table["keys"]),
                {column: _tolerance(value) for column, value in table["columns"].items()},
            )
            for name, table in content.items()
        }
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise ComparisonError(
            f"{where} does not say what to compare ({error}); allowed: for each table keys: a "
            "list, and columns: each exact or {absolute: number, relative: number}"
        ) from None


def _tolerance(value: Any) -> Tolerance | None:
    if value == "exact":
        return None
    tolerance = Tolerance(float(value["absolute"]), float(value["relative"]))
    if len(value) > 2 or not (tolerance.absolute >= 0.0 and tolerance.relative >= 0.0):
        raise ValueError(f"{value} is no tolerance")
    return tolerance
