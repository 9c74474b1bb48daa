"""Data of a material or a transducer: a preset, or a TOML file with a text for each key."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.keys import Keyed, read_keys, with_options


class Card(Keyed):
    """Quantities in SI units.

    Attributes
    ----------
    name, source : str
        Description, and the source of the values.
    """

    name: str
    source: str

    @classmethod
    def presets(cls, path: Path) -> dict[str, Self]:
        """Read a file with a table for each name."""
        cards = tomllib.loads(path.read_text(encoding="utf-8"))
        return {name: cls.validated(card) for name, card in cards.items()}

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
            card = {"name": path.stem, "source": name} | with_options(read_keys(path), {})
            return cls.validated(card, path, cls.model_fields)
        if name.lower() not in presets:
            raise ArgumentError(
                f"{cls.__name__.lower()} must be one of {', '.join(presets)}, or a file .toml, got "
                f"{name!r}"
            )
        return presets[name.lower()]
