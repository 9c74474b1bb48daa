"""Work that is done ahead in threads, in order, while what is done is used."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

Given = TypeVar("Given")
Made = TypeVar("Made")


def ahead(make: Callable[[Given], Made], items: Iterable[Given], threads: int) -> Iterator[Made]:
    """Make something of each item, in order.

    What is made waits until it is asked for: one more than there are threads, at most.

    Parameters
    ----------
    make : callable
    items : iterable
    threads : int
        One: each is made when it is asked for.

    Yields
    ------
    object
    """
    if threads == 1:
        yield from map(make, items)
        return
    waiting: deque[Future[Made]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        for item in items:
            waiting.append(pool.submit(make, item))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
