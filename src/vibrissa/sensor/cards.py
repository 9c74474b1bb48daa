"""Material or transducer data in a file of one's own: TOML, a key and a text in each line."""

import tomllib
from collections.abc import Sequence
from pathlib import Path

from vibrissa.errors import ArgumentError, UnknownNameError

ENDING = ".toml"


def is_card(name: str) -> bool:
    """Whether a name is the path of a TOML file."""
    return name.lower().endswith(ENDING)


def read_card(path: Path, needed: Sequence[str], optional: Sequence[str] = ()) -> dict[str, str]:
    """Read the values of some keys as texts, such as ``modulus = "3.5 GPa"``."""
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ArgumentError(f"no such file: {path}") from None
    except OSError as error:
        raise ArgumentError(f"{path} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ArgumentError(f'{path}: {error}; a line is name = "value unit"') from None
    unknown = [name for name in found if name not in (*needed, *optional)]
    missing = [name for name in needed if name not in found]
    if unknown or missing:
        said = f"{', '.join(missing)} missing" if missing else f"{unknown[0]} is not known"
        keys = ", ".join((*needed, *optional))
        raise UnknownNameError(f"{path}: {said}; the keys are {keys}")
    return {name: str(value) for name, value in found.items()}
