"""The one plain form of exact values: a decimal as its text, wherever it leaves the program.

The plan of blocks, the names of blocks, the parameters of jobs and the tables of curves all have
it. Everywhere else a value is a `Decimal`.
"""

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from operator import attrgetter

from vibrissa.decimals import exact, spell
from vibrissa.study.grid import CurveKey, Grid


def encode_values(values: Iterable[Decimal]) -> list[str]:
    """Plain form of exact values, such as an axis."""
    return [spell(value) for value in values]


def encode_key(key: CurveKey) -> list[str]:
    """Plain form of a curve key: θ, η and, where it has one, Δx0."""
    return encode_values(value for value in key if value is not None)


def decode_key(texts: Iterable[str]) -> CurveKey:
    """Inverse of `encode_key`.

    Parameters
    ----------
    texts : iterable of str
        Two or three decimals.

    Returns
    -------
    CurveKey

    Raises
    ------
    TypeError
        If there are more or fewer values.
    ValueError
        If a text is not a finite number.
    """
    return CurveKey(*map(exact, texts))


def encode_columns(keys: Sequence[CurveKey]) -> dict[str, list[str | None]]:
    """Plain form of curve keys as columns of a table, with nothing where a key has no Δx0."""
    return {
        name: [None if value is None else spell(value) for value in map(attrgetter(name), keys)]
        for name in CurveKey._fields
    }


def encode_grid(grid: Grid) -> dict[str, list[str]]:
    """Plain form of a grid: its axes by name."""
    return {name: encode_values(values) for name, values in vars(grid).items()}


def decode_grid(axes: Mapping[str, Sequence[str]]) -> Grid:
    """Inverse of `encode_grid`.

    Parameters
    ----------
    axes : mapping of sequence of str
        Decimals of ``theta``, ``mu0``, ``eta`` and ``dx0``.

    Returns
    -------
    Grid

    Raises
    ------
    ValueError
        If a text is not a finite number.
    """
    return Grid(**{name: tuple(map(exact, texts)) for name, texts in axes.items()})
