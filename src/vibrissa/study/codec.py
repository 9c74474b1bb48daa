"""The one plain form of exact values: their text, wherever they leave the program.

The plan of blocks, the names of blocks, the parameters of jobs and the tables of curves all have
it. Everywhere else a value is a `Decimal`, or a tuple of them: the coefficients of a polynomial.
"""

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any

from vibrissa.decimals import Value, exact, read_value, spell
from vibrissa.study.grid import MOUNTING_AXES, CurveKey, Grid


def encode_values(values: Iterable[Value]) -> list[str]:
    """Plain form of exact values, such as an axis."""
    return [spell(value) for value in values]


def encode_key(key: CurveKey) -> list[str]:
    """Plain form of a curve key: θ, η and, where it has one, Δx0; of its mounting what is not 0."""
    numbers = encode_values(value for value in key[:3] if value is not None)
    mounting = zip(MOUNTING_AXES, key.mounting, strict=True)
    return [*numbers, *(f"{name}={spell(value)}" for name, value in mounting if value)]


def decode_key(texts: Sequence[str]) -> CurveKey:
    """Inverse of `encode_key`.

    Parameters
    ----------
    texts : sequence of str
        Two or three decimals, then any of the mounting's axes as ``axis=value``.

    Returns
    -------
    CurveKey

    Raises
    ------
    TypeError
        If one is no text, or names an unknown axis.
    ValueError
        If there are more or fewer values, or one is not a finite number.
    """
    named = [text for text in texts if "=" in text]
    theta, eta, *step = (exact(text) for text in texts if text not in named)
    if len(step) > 1:
        raise ValueError(f"no curve key has so many values: {texts!r}")
    mounting: Any = {name: read_value(value) for name, value in (text.split("=") for text in named)}
    return CurveKey(theta, eta, *step, **mounting)


def decode_columns(row: Mapping[str, str | None]) -> CurveKey:
    """Inverse of `encode_columns` for one row."""
    texts = {name: row[name] for name in CurveKey._fields}
    values: Any = {name: read_value(text) for name, text in texts.items() if text is not None}
    return CurveKey(**values)


def encode_columns(keys: Sequence[CurveKey]) -> dict[str, list[str | None]]:
    """Plain form of curve keys as columns of a table, with nothing where a key has no Δx0."""
    return {
        name: [None if value is None else spell(value) for value in map(attrgetter(name), keys)]
        for name in CurveKey._fields
    }


def encode_grid(grid: Grid) -> dict[str, list[str]]:
    """Plain form of a grid: its axes by name."""
    return {name: encode_values(values) for name, values in grid.axes.items()}


def decode_grid(axes: Mapping[str, Sequence[str]]) -> Grid:
    """Inverse of `encode_grid`.

    Parameters
    ----------
    axes : mapping of sequence of str
        Decimals of ``theta``, ``mu0``, ``eta`` and ``dx0``, and of any axis of the mounting.

    Returns
    -------
    Grid

    Raises
    ------
    ValueError
        If a text is not a finite number.
    """
    values: Any = {name: tuple(map(read_value, texts)) for name, texts in axes.items()}
    return Grid(**values)
