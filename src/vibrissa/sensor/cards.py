"""Material or transducer data in a file of one's own: TOML, a key and a text in each line."""

from collections.abc import Sequence
from pathlib import Path

from vibrissa.errors import UnknownNameError
from vibrissa.sensor.keys import read_keys

ENDING = ".toml"


def is_card(name: str) -> bool:
    """Whether a name is the path of a TOML file."""
    return name.lower().endswith(ENDING)


def read_card(path: Path, needed: Sequence[str], optional: Sequence[str] = ()) -> dict[str, str]:
    """Read the values of some keys as texts, such as ``modulus = "3.5 GPa"``."""
    found = read_keys(path)
    unknown = [name for name in found if name not in (*needed, *optional)]
    missing = [name for name in needed if name not in found]
    if unknown or missing:
        said = f"{', '.join(missing)} missing" if missing else f"{unknown[0]} is not known"
        keys = ", ".join((*needed, *optional))
        raise UnknownNameError(f"{path}: {said}; the keys are {keys}")
    return {name: str(value) for name, value in found.items()}
