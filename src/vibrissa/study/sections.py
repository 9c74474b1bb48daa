"""What the sections of a study file have in common."""

from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

T = TypeVar("T")


class Section(BaseModel):
    """Part of a study file: a mapping with known keys."""

    # Validators are built when the first study is read, not when a module is imported.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


def _given(value: Any) -> Any:
    """Refuse a key without a value: a key that is not needed is left out."""
    if value is None:
        raise PydanticCustomError("no_value", "no value; write one, or leave the key out")
    return value


# A key that may be left out; None stands for that.
OptionalKey = Annotated[T | None, BeforeValidator(_given)]
Count = Annotated[int, Field(strict=True, ge=1)]
Name = Annotated[str, Field(pattern="^[A-Za-z0-9][A-Za-z0-9_-]{0,99}$")]
NAME_ALLOWED = "a name of at most 100 letters, digits, _ and -"
