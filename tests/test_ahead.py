"""Work in threads, in order."""

from threading import Barrier, current_thread, main_thread

import pytest

from vibrissa.ahead import ahead


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_what_is_made_comes_in_order(threads):
    assert list(ahead(lambda n: n * n, range(20), threads)) == [n * n for n in range(20)]
    assert list(ahead(abs, [], threads)) == []


@pytest.mark.parametrize(("threads", "taken"), [(1, 1), (2, 3), (5, 6)])
def test_no_more_is_taken_than_threads_need(threads, taken):
    items = iter(range(20))
    made = ahead(lambda n: n, items, threads)
    assert next(made) == 0
    assert next(items) == taken
    made.close()


def test_threads_work_at_the_same_time():
    # Each waits for the two others.
    together = Barrier(3, timeout=20)
    assert sorted(ahead(lambda _: together.wait(), range(3), 3)) == [0, 1, 2]


def test_one_thread_is_the_one_that_asks():
    assert list(ahead(lambda _: current_thread(), [0], 1)) == [main_thread()]


@pytest.mark.parametrize("threads", [1, 3])
def test_an_error_comes_in_its_turn(threads):
    made = ahead(lambda n: 1 / n, [1, 2, 0, 4], threads)
    assert [next(made), next(made)] == [1.0, 0.5]
    with pytest.raises(ZeroDivisionError):
        next(made)
