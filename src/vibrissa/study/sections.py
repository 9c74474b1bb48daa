"""Common base of the sections of a study file."""

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import ErrorDetails, PydanticCustomError

from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore

# Place of a mistake in a section, and its message.
Mistake: TypeAlias = tuple[tuple[str | int, ...], str]


def _whole(written: Any) -> Any:
    """Return a number such as 1e7 as the whole number that it is."""
    return int(written) if isinstance(written, float) and written.is_integer() else written


Count = Annotated[int, Field(strict=True, ge=1), BeforeValidator(_whole)]
Name = Annotated[str, Field(pattern="^[A-Za-z0-9][A-Za-z0-9_-]{0,99}$")]
# What is allowed where Pydantic names a type of Python.
ALLOWED = {
    "model_type": "keys with their values, as in {key: value}",
    "dict_type": "keys with their values, as in {key: value}",
    "tuple_type": "a list",
}
# Characters of a wrong value that a message shows.
SHOWN_CHARACTERS = 60
NAME_ALLOWED = "a name of at most 100 letters, digits, _ and -"


def shown(written: object) -> str:
    """Format a value as in the file, shortened if it is long."""
    text = repr(written)
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}..."


class Section(BaseModel):
    """Part of a study file: a mapping with known keys."""

    # Validators are built when the first study is read, not when a module is imported.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Mistakes(list[Mistake]):
    """Mistakes in a part of a study file, which are reported together."""

    def add(self, text: str, *place: str | int) -> None:
        """Add a mistake; `place` is its place relative to this part of the file."""
        self.append((place, text))

    def refuse(self) -> None:
        """Raise an error if there are mistakes."""
        if self:
            raise PydanticCustomError("mistakes", "mistakes", {"mistakes": list(self)})


def check_bores(mistakes: Mistakes, bores: Sequence[Any], tapers: Sequence[Any]) -> None:
    """Find a bore that is not narrower than the thinnest tip."""
    try:
        check_bore(max(bores), max(tapers))
    except ArgumentError as error:
        mistakes.add(f"{error} at theta = {max(tapers):g}", "bore")


def in_words(error: ErrorDetails) -> str:
    """Describe a wrong value in plain words."""
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    if error["type"] in ALLOWED:
        return f"{shown(error['input'])} is not allowed; allowed: {ALLOWED[error['type']]}"
    # Pydantic's words as the end of a sentence.
    words = f"{error['msg'][:1].lower()}{error['msg'][1:]}"
    return f"{shown(error['input'])} is not allowed: {words}"
