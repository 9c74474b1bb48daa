"""Batches: what is done to rows is done to every column, and nothing else."""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch, slices


@dataclass(frozen=True, eq=False, kw_only=True)
class Things(Batch):
    size: FloatArray
    shape: FloatArray
    extra: FloatArray | None = None
    kind: str = "round"


def things(n=5, **more):
    return Things(size=np.arange(n) * 1.0, shape=np.arange(2.0 * n).reshape(n, 2), **more)


def test_rows_are_taken_from_every_column_and_the_rest_stays():
    batch = things(extra=np.arange(5) * 10.0, kind="flat")
    for index in (np.array([3, 1]), batch.size > 2.0, slice(1, 3)):
        some = batch.take(index)
        assert some.kind == "flat"
        for name in ("size", "shape", "extra"):
            assert np.array_equal(getattr(some, name), getattr(batch, name)[index])
    assert things().take(np.array([0])).extra is None


def test_a_batch_with_other_rows_is_a_new_one():
    batch, other = things(), replace(things(2), size=np.array([7.0, 8.0]))
    changed = batch.with_rows(np.array([4, 0]), other)
    assert changed.size.tolist() == [8.0, 1.0, 2.0, 3.0, 7.0]
    assert changed.shape[[4, 0]].tolist() == other.shape.tolist()
    assert changed.shape[1].tolist() == [2.0, 3.0]
    assert batch.size.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert batch.shape[0].tolist() == [0.0, 1.0]


def test_joined_parts_are_the_whole():
    batch = things(kind="flat")
    joined = Things.concatenate([batch.take(slice(0, 2)), batch.take(slice(2, None))])
    assert len(joined) == 5 and joined.kind == "flat"
    assert all(np.array_equal(joined.columns[name], batch.columns[name]) for name in batch.columns)


def test_slices_have_every_row_once_and_none_is_too_long():
    for count, size in ((0, 3), (7, 3), (6, 3), (2, 3)):
        rows = [range(count)[part] for part in slices(count, size)]
        assert [row for part in rows for row in part] == list(range(count))
        assert all(1 <= len(part) <= size for part in rows)
        assert len(rows) == -(-count // size)
