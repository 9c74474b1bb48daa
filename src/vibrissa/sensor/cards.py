"""Data of a material or a transducer: a preset, or a TOML file with a text for each key."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator

from vibrissa.errors import ArgumentError
from vibrissa.sensor.keys import read_keys, validated
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind, channels_of, in_si


class Card(BaseModel):
    """Quantities in SI units: fields that are marked with a `Kind`, or with one for each channel.

    Attributes
    ----------
    name, source : str
        Description, and the source of the values.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    source: str

    @classmethod
    def read(cls, card: Mapping[str, Any], name: str, where: Path) -> Self:
        """Read the texts of a file, such as ``modulus = "3.5 GPa"``."""
        texts = {key: str(value) for key, value in card.items()}
        given = {"name": name, "source": str(where)} | texts
        return validated(cls, given, where, cls.model_fields)

    @classmethod
    def presets(cls, path: Path) -> dict[str, Self]:
        """Read a file with a table for each name."""
        cards = tomllib.loads(path.read_text(encoding="utf-8"))
        return {name: cls.read(card, name, path) for name, card in cards.items()}

    @classmethod
    def named(cls, name: str, presets: Mapping[str, Self]) -> Self:
        """Look up a preset by its name, or read a file of one's own: ``"my.toml"``.

        Raises
        ------
        ArgumentError
            If there is no such preset or file.
        """
        if name.lower().endswith(".toml"):
            path = Path(name)
            return cls.read(read_keys(path), path.stem, path)
        if name.lower() not in presets:
            raise ArgumentError(
                f"{cls.__name__.lower()} must be one of {', '.join(presets)}, or a file .toml, got "
                f"{name!r}"
            )
        return presets[name.lower()]

    @field_validator("*", mode="before")
    @classmethod
    def _read_field(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        for mark in cls.model_fields[name].metadata:
            if isinstance(mark, Kind) and isinstance(value, str):
                return float(in_si(value, mark, name))
            if mark is CHANNEL_KINDS and isinstance(value, str):
                parts = channels_of(value, name)
                return tuple(float(in_si(part, kind, name)) for part, kind in parts)
        return value
