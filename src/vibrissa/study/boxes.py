"""Boxes: products of axes, such as the curves of a grid, handled without making their members.

A *box* has a few values of each of some axes, by name, and stands for all their combinations. What
is not a box, for example what a study gained, is several boxes that have no member in common.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

Box: TypeAlias = Mapping[str, tuple[Any, ...]]


def size(box: Box) -> int:
    """Count the members of a box."""
    return math.prod(map(len, box.values()))


def members(box: Box) -> Iterator[tuple[Any, ...]]:
    """Yield the members of a box: a value of each axis; the first axis changes slowest."""
    return product(*box.values())


def meets(box: Box) -> Callable[[Box], bool]:
    """Return what tells of other boxes of the same axes whether they have a member of this one."""
    held = {axis: frozenset(values) for axis, values in box.items()}
    return lambda other: all(
        any(value in values for value in other[axis]) for axis, values in held.items()
    )


def holds(box: Box) -> Callable[[Box], bool]:
    """Return what tells of other boxes of the same axes whether this one has all their members."""
    held = {axis: frozenset(values) for axis, values in box.items()}
    return lambda other: all(values.issuperset(other[axis]) for axis, values in held.items())


def common(box: Box, other: Box) -> Box:
    """Return what two boxes of the same axes have in common: nothing if an axis is empty."""
    held = {axis: set(other[axis]) for axis in box}
    return {axis: tuple(v for v in values if v in held[axis]) for axis, values in box.items()}


def without(box: Box, other: Box) -> list[Box]:
    """Return the members of a box that another one of the same axes does not have.

    Parameters
    ----------
    box, other : mapping of tuple

    Returns
    -------
    list of mapping
        Boxes that have no member in common, at most one for each axis.
    """
    if not meets(box)(other):
        return [box]
    parts: list[Box] = []
    rest = dict(box)
    for axis, inside in common(box, other).items():
        held = set(inside)
        if outside := tuple(value for value in box[axis] if value not in held):
            parts.append(rest | {axis: outside})
        rest[axis] = inside
    return parts


def disjoint(boxes: Iterable[Box]) -> list[Box]:
    """Return boxes that have the members of some boxes, each once."""
    found: list[Box] = []
    for box in boxes:
        found += remaining([box], found)
    return found


def remaining(boxes: Iterable[Box], others: Iterable[Box]) -> list[Box]:
    """Return boxes that have those members of some boxes that others do not have."""
    left = list(boxes)
    for other in others:
        left = [part for box in left for part in without(box, other)]
        if not left:
            break
    return left


def joined(boxes: Sequence[Box], axis: str) -> list[Box]:
    """Put boxes together that differ in the values of one axis alone."""
    values: dict[tuple[tuple[Any, ...], ...], dict[Any, None]] = {}
    for box in boxes:
        others = tuple(box[name] for name in box if name != axis)
        values.setdefault(others, {}).update(dict.fromkeys(box[axis]))
    return [
        {name: tuple(found) if name == axis else next(rest) for name in boxes[0]}
        for rest, found in ((iter(others), found) for others, found in values.items())
    ]


def cut(box: Box, most: int) -> Iterator[Box]:
    """Cut a box into boxes of at most so many members, in the order of the members.

    Of the first axis each part gets as many values as fit; if one value is too much, the next axis
    is cut.
    """
    axis, values = next(iter(box.items()))
    rest = {name: others for name, others in box.items() if name != axis}
    if (each := size(rest)) <= most:
        parts = math.ceil(len(values) / (most // each))
        for part in _batches(values, math.ceil(len(values) / parts)):
            yield {axis: part} | rest
        return
    parts_of_one = list(cut(rest, most))
    for value in values:
        yield from ({axis: (value,), **part} for part in parts_of_one)


def _batches(values: Sequence[Any], length: int) -> Iterator[tuple[Any, ...]]:
    return (tuple(values[i : i + length]) for i in range(0, len(values), length))
