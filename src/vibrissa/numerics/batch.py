"""Batches: data classes of columns of equal length, to compute many items together."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from vibrissa.numerics.arrays import FloatArray, Index


@dataclass(frozen=True, eq=False, kw_only=True)
class Batch:
    """Base of data classes whose arrays are columns: their first axis counts the rows.

    A field may also be a batch with the same number of rows. Fields of other types hold for all
    rows.
    """

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the fields, in their order."""
        return tuple(cls.__dataclass_fields__)

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Columns by name, without those of nested batches."""
        fields = {name: self.__dict__[name] for name in self.__dataclass_fields__}
        return {n: values for n, values in fields.items() if isinstance(values, np.ndarray)}

    def __len__(self) -> int:
        """Return the number of rows."""
        for values in self.__dict__.values():
            if isinstance(values, np.ndarray):
                return len(values)
        raise TypeError(f"{type(self).__name__} has no columns")

    def each(self, change: Callable[[FloatArray], FloatArray]) -> Self:
        """Apply a function to every column, also to those of nested batches."""
        # Without the constructor, which takes as long as the solution of a small state.
        changed = object.__new__(type(self))
        for name in self.__dataclass_fields__:
            values = self.__dict__[name]
            if isinstance(values, np.ndarray):
                values = change(values)
            elif isinstance(values, Batch):
                values = values.each(change)
            changed.__dict__[name] = values
        return changed

    def take(self, index: Index) -> Self:
        """Select rows by index, mask or slice."""
        return self.each(lambda values: values[index])

    def copy(self) -> Self:
        """Copy all columns."""
        return self.each(np.ndarray.copy)

    def with_rows(self, index: Index, other: Self) -> Self:
        """Return a copy in which the rows at `index` are the rows of `other`."""
        changed = object.__new__(type(self))
        for name in self.__dataclass_fields__:
            values, rows = self.__dict__[name], other.__dict__[name]
            if isinstance(values, np.ndarray):
                values = values.copy()
                values[index] = rows
            elif isinstance(values, Batch):
                values = values.with_rows(index, rows)
            changed.__dict__[name] = values
        return changed

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Join the rows of batches; fields that hold for all rows come from the first batch."""
        joined: dict[str, Any] = {}
        for name in cls.__dataclass_fields__:
            columns = [part.__dict__[name] for part in parts]
            if isinstance(columns[0], np.ndarray):
                joined[name] = np.concatenate(columns)
            elif isinstance(columns[0], Batch):
                joined[name] = columns[0].concatenate(columns)
        return replace(parts[0], **joined)

    @classmethod
    def unknown(cls, shape: int | tuple[int, ...]) -> Self:
        """Make a batch of columns of NaN, all of one shape; all fields must be columns."""
        return cls(**{name: np.full(shape, np.nan) for name in cls.names()})

    @classmethod
    def from_matrix(cls, matrix: FloatArray, **known: FloatArray) -> Self:
        """Make a batch with the columns matrix[..., 0], matrix[..., 1], ... in the order of fields.

        Columns given as `known` replace those of the matrix.
        """
        # Without the constructor, as in `each`.
        named = object.__new__(cls)
        for index, name in enumerate(cls.__dataclass_fields__):
            named.__dict__[name] = known[name] if name in known else matrix[..., index]
        return named


def slices(count: int, size: int) -> Iterator[slice]:
    """Yield slices that cut `count` rows into blocks of `size` rows."""
    for start in range(0, count, size):
        yield slice(start, start + size)
