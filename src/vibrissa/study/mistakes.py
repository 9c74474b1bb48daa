"""Mistakes in a study file: where each is, and what is allowed there."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibrissa.decimals import Value, spell

# Characters of a value that a message shows, and values of an axis.
SHOWN_CHARACTERS = 60
SHOWN_VALUES = 10
# Keys, names and places in lists that lead to a value.
Location = tuple[str | int, ...]


@dataclass(frozen=True, kw_only=True)
class Mistake:
    """One mistake in a study file.

    Attributes
    ----------
    location : tuple
        The keys and places in lists that lead to it; empty for the file as a whole.
    text : str
        The value and what is allowed.
    line : int
        Of the file, from 1, where the location does not say it.
    key : str or int or None
        Below the location, which then is of a section, what the mistake is about.
    """

    location: Location
    text: str
    line: int = 0
    key: str | int | None = None

    @property
    def path(self) -> Location:
        """Where it is, with the key that it is about."""
        return self.location if self.key is None else (*self.location, self.key)

    def __str__(self) -> str:
        """Return the message: one line."""
        return f"{spell_location(self.location) or 'the study file'}: {self.text}"


@dataclass(frozen=True, kw_only=True)
class UnknownName(Mistake):
    """A name that nothing has."""


def spell_location(location: Location) -> str:
    """Spell a place in the file as in ``grids.main.theta[1]``."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in location]
    text = "".join(parts).removeprefix(".")
    return text if text.isprintable() else repr(text)


def at(value: Any, location: Location) -> Any:
    """Look up what stands at a place; None where there is nothing."""
    for step in location:
        if isinstance(value, Mapping):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value


def spell_value(value: object) -> str:
    """Spell a value as it stands in the file, cut where it is long."""
    text = repr(value)
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}..."


def spell_axis(values: Sequence[Value]) -> str:
    """Spell the first values of an axis."""
    shown = values[:SHOWN_VALUES]
    return ", ".join(f"[{spell(v)}]" if isinstance(v, tuple) else spell(v) for v in shown)


def unknown_name(location: Location, name: str, what: str, known: Iterable[str]) -> UnknownName:
    """Mistake of a name that nothing has.

    Parameters
    ----------
    location : tuple
        Of the name.
    name : str
    what : str
        What should have the name, such as ``grid``.
    known : iterable of str
        Names that there are.

    Returns
    -------
    UnknownName
    """
    allowed = ", ".join(sorted(known)) or "none is defined"
    text = f"{name!r} is not the name of a {what}; allowed: {allowed}"
    return UnknownName(location=location, text=text)
