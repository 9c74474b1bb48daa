"""Pydantic models whose fields are keys of a TOML file or options; messages for their errors."""

import tomllib
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator

from vibrissa.errors import ArgumentError
from vibrissa.files import write_atomically
from vibrissa.quantities.units import Kind

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class Keyed(BaseModel):
    """Fields that are read from a TOML file, from options, or from both.

    A field marked with a `Kind` is read from a text with a unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    # Pairs of keys for one property: an option for one of them overrides both in a file.
    either: ClassVar[tuple[tuple[str, str], ...]] = ()

    @classmethod
    def read(cls, path: Path | str | None = None, **options: Any) -> Self:
        """Read fields from a TOML file, from options or both; an option overrides the file.

        Raises
        ------
        ArgumentError
            With a line for each key or value that is not allowed.
        """
        keys = {} if path is None else read_keys(path)
        return cls.validated(with_options(keys, options, cls.either), path, keys)

    @classmethod
    def validated(
        cls, given: Mapping[str, Any], path: Path | str | None = None, keys: Container[str] = ()
    ) -> Self:
        """Check the values of fields, and make a model with them.

        Parameters
        ----------
        given : mapping
            Values by field.
        path : Path or str, optional
            File from which some of the values come.
        keys : container of str
            Fields whose values come from the file; messages about these fields name the file.

        Raises
        ------
        ArgumentError
            With a line for each key or value that is not allowed.
        """
        try:
            return cls.model_validate(given)
        except ValidationError as error:
            errors = error.errors()
        lines = [f"{path}: " * (_key(each) in keys) + _line(each, cls) for each in errors]
        raise ArgumentError("\n".join(dict.fromkeys(lines)))

    @field_validator("*", mode="before")
    @classmethod
    def _read_text(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        kind = cls.kinds().get(name)
        return kind.read(value, name) if kind and isinstance(value, str) else value

    @classmethod
    def kinds(cls) -> dict[str, Kind]:
        """Return the kind of each field that is marked with one."""
        return {
            name: mark
            for name, field in cls.model_fields.items()
            for mark in field.metadata
            if isinstance(mark, Kind)
        }


class Card(Keyed):
    """Data of a material or a transducer, in SI units.

    Attributes
    ----------
    name, source : str
        Description of the material or transducer, and the source of its values.
    """

    name: str
    source: str

    @classmethod
    def named(cls, name: str, presets: Mapping[str, Self]) -> Self:
        """Look up a preset by its name, or read the user's file, such as ``"my.toml"``.

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


CardType = TypeVar("CardType", bound=Card)


class Presets(Mapping[str, CardType]):
    """Cards of a TOML file, which has a table for each. A card is read when it is asked for.

    Its units need Pint, which takes longer to load than a command without them.
    """

    def __init__(self, card_type: type[CardType], path: Path) -> None:
        self._card_type, self._path = card_type, path

    @cached_property
    def _texts(self) -> dict[str, Any]:
        return tomllib.loads(self._path.read_text(encoding="utf-8-sig"))

    def __getitem__(self, name: str) -> CardType:
        """Return the card of a name."""
        return self._card_type.validated(self._texts[name])

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._texts)

    def __len__(self) -> int:
        """Return the number of cards."""
        return len(self._texts)


def read_keys(path: Path | str) -> dict[str, Any]:
    """Read the keys of a TOML file and their values.

    Raises
    ------
    ArgumentError
        If the file is not written in TOML; the message names the line.
    """
    path = Path(path)
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError as error:  # no UTF-8, or no TOML
        raise ArgumentError(
            f"{path} cannot be read as TOML in UTF-8: {error}. Save it as UTF-8; write key = 2.5, "
            'with a point and not a comma, or key = "2.5 mm", in quotes'
        ) from None


def write_keys(path: Path, keys: Mapping[str, Any], comment: str) -> None:
    """Write keys and tables to a TOML file, below a comment."""
    given = {name: value for name, value in keys.items() if value != {}}
    with write_atomically(path) as temporary:
        temporary.write_text(f"# {comment}\n\n{tomli_w.dumps(given)}", encoding="utf-8")


def with_options(
    keys: Mapping[str, Any], options: Mapping[str, Any], either: Iterable[Sequence[str]] = ()
) -> dict[str, Any]:
    """Combine the keys of a file with options: an option other than None overrides its key.

    An option that is a table replaces only those keys of the file's table that it gives. Numbers
    become texts without a unit.

    Parameters
    ----------
    either : iterable of sequence of str
        Groups of keys that state one property in different ways. An option for one key of a group
        overrides all keys of the group in the file.
    """
    given = {name: value for name, value in options.items() if value is not None}
    replaced = {name for names in either if set(names) & given.keys() for name in names}
    for name, value in keys.items():
        if isinstance(value, Mapping) and isinstance(given.get(name), Mapping):
            given[name] = {**value, **given[name]}
    every = {name: value for name, value in keys.items() if name not in replaced} | given
    return {
        name: str(value) if type(value) in (int, float) else value for name, value in every.items()
    }


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return text such as ``; did you mean eta?``; empty if no known name is similar."""
    near = get_close_matches(name, known, 1)
    return f"; did you mean {near[0]}?" if near else ""


def _key(error: Any) -> str:
    return str(error["loc"][0]) if error["loc"] else ""


def _line(error: Any, model: type[BaseModel]) -> str:
    """Message for an error of pydantic."""
    name = _key(error)
    if error["type"] == "extra_forbidden":
        allowed = [field.alias or key for key, field in model.model_fields.items()]
        keys = f"; the keys are {', '.join(allowed)}"
        return f"{name!r} is not a key{suggestion(name, allowed) or keys}"
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    if error["type"] == "missing":
        return f"the key {name} is missing"
    return f"{name}: {error['msg'].lower()}, got {error['input']!r}"
