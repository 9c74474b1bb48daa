"""The one plain form of exact values: their text, wherever they leave the program.

The plan of blocks, the names of blocks, the parameters of jobs and the tables of curves all have
it. Everywhere else a value is a `Decimal`, or a tuple of them: the coefficients of a polynomial.
"""

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from functools import lru_cache
from itertools import islice, pairwise
from operator import attrgetter
from typing import Any

from vibrissa.decimals import Value, exact, read_value, spell
from vibrissa.study.boxes import Box
from vibrissa.study.grid import (
    CURVE_AXES,
    MOUNTING_AXES,
    ZERO,
    CurveKey,
    Grid,
    Refinement,
    equal_steps,
)

# Two neighbouring values of an axis.
Gap = tuple[Decimal, Decimal]
# So many values in equal steps have the short form of a range.
LEAST_RANGE = 4


def encode_values(values: Iterable[Value]) -> list[str]:
    """Plain form of exact values, such as an axis."""
    return [spell(value) for value in values]


def encode_axis(values: Iterable[Value]) -> list[str]:
    """Plain form of distinct values of an axis: ``start:stop:step`` where steps are equal."""
    return list(_axis_texts(tuple(values)))


# Many blocks have the same values of an axis.
@lru_cache(maxsize=1024)
def _axis_texts(values: Sequence[Any]) -> tuple[str, ...]:
    texts: list[str] = []
    first = 0
    while first < len(values):
        count = _equal_steps_from(values, first)
        if count < LEAST_RANGE:
            texts.append(spell(values[first]))
            first += 1
            continue
        last = values[first + count - 1]
        step = values[first + 1] - values[first]
        texts.append(":".join(map(spell, (values[first], last, step))))
        first += count
    return tuple(texts)


def _equal_steps_from(values: Sequence[Any], first: int) -> int:
    """Count the values from one on that are numbers in equal steps."""
    step, last = None, first
    for value, following in pairwise(islice(values, first, None)):
        if isinstance(value, tuple) or isinstance(following, tuple):
            break
        step = following - value if step is None else step
        if following - value != step:
            break
        last += 1
    return last - first + 1


def decode_axis(texts: Iterable[str]) -> tuple[Any, ...]:
    """Inverse of `encode_axis`.

    Raises
    ------
    ValueError
        If a text is neither a finite number nor a range of them.
    """
    return _axis_values(tuple(texts))


@lru_cache(maxsize=1024)
def _axis_values(texts: Sequence[str]) -> tuple[Any, ...]:
    values: list[Value] = []
    for text in texts:
        if ":" in text:
            start, stop, step = map(exact, text.split(":"))
            values += equal_steps(start, stop, step)
        else:
            values.append(read_value(text))
    return tuple(values)


def encode_box(curves: Box) -> dict[str, list[str]]:
    """Plain form of a box of curves: its axes by name, without those that say nothing."""
    return {
        axis: encode_axis(curves[axis])
        for axis in CURVE_AXES
        if curves[axis] not in ((None,), (ZERO,))
    }


def decode_box(axes: Mapping[str, Sequence[str]]) -> Box:
    """Inverse of `encode_box`.

    Raises
    ------
    KeyError
        If an axis is missing, or there is no such axis.
    ValueError
        As `decode_axis`.
    """
    absent = dict.fromkeys(MOUNTING_AXES, (ZERO,)) | {"dx0": (None,)}
    if unknown := set(axes) - set(CURVE_AXES):
        raise KeyError(f"unknown axes: {unknown}")
    return {name: decode_axis(axes[name]) if name in axes else absent[name] for name in CURVE_AXES}


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
    return {name: encode_axis(values) for name, values in grid.axes.items()}


def decode_grid(axes: Mapping[str, Sequence[str]]) -> Grid:
    """Inverse of `encode_grid`.

    Parameters
    ----------
    axes : mapping of sequence of str
        Decimals of ``theta``, ``mu0``, ``eta`` and ``dx0``, and of any axis of the mounting; or
        ranges, as `encode_axis` makes them.

    Returns
    -------
    Grid

    Raises
    ------
    ValueError
        As `decode_axis`.
    """
    values: Any = {name: decode_axis(texts) for name, texts in axes.items()}
    return Grid(**values)


def encode_refinement(refinement: Refinement) -> dict[str, Any]:
    """Plain form of a refinement: its attributes by name."""
    return {
        "column": refinement.column,
        "tolerance": spell(refinement.tolerance),
        "closest": {axis: spell(value) for axis, value in refinement.closest.items()},
    }


def decode_refinement(texts: Mapping[str, Any]) -> Refinement:
    """Inverse of `encode_refinement`.

    Raises
    ------
    KeyError
        If an attribute is missing.
    ValueError
        If a number is none.
    """
    return Refinement(
        column=texts["column"],
        tolerance=exact(texts["tolerance"]),
        closest={axis: exact(text) for axis, text in texts["closest"].items()},
    )


def encode_gaps(gaps: Mapping[str, Sequence[Gap]]) -> dict[str, list[list[str]]]:
    """Plain form of gaps between values of some axes: the starts, then the stops."""
    return {
        axis: [encode_axis(start for start, _ in some), encode_axis(stop for _, stop in some)]
        for axis, some in gaps.items()
    }


def decode_gaps(texts: Mapping[str, Sequence[Sequence[str]]]) -> dict[str, list[Gap]]:
    """Inverse of `encode_gaps`.

    Raises
    ------
    ValueError
        As `decode_axis`, or if there are more starts or more stops.
    """
    return {
        axis: list(zip(decode_axis(starts), decode_axis(stops), strict=True))
        for axis, (starts, stops) in texts.items()
    }
