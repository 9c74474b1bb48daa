"""Ask tests about a mutant, in a process of their own: the first that fails is the answer."""

import os
import signal
import sys
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

IMPORTING = 120.0
OPTIONS = "-x -q -p no:benchmark -p no:cacheprovider -p no:xdist -p no:faulthandler".split()


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The test that failed, if one did.

    Attributes
    ----------
    failed
        The test's name, or an empty text.
    timed_out
        A test took longer than its time.
    broke
        The tests could not even run: the fault is one that stops the program from being imported.

    """

    failed: str
    timed_out: bool = False
    broke: bool = False


class Asking:
    """A pytest plugin: tests in the given order, each with a limit of its own."""

    def __init__(self, limits: dict[str, float]) -> None:
        self.limits = limits
        self.failed = ""

    def pytest_collection_modifyitems(self, items: list) -> None:
        order = {test: place for place, test in enumerate(self.limits)}
        items.sort(key=lambda item: order.get(item.nodeid, len(order)))

    def pytest_runtest_logstart(self, nodeid: str, location: object) -> None:
        # The system ends the process where the time is up, in whatever the test hangs.
        signal.setitimer(signal.ITIMER_REAL, self.limits.get(nodeid, 60.0))

    def pytest_runtest_logfinish(self, nodeid: str, location: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)

    def pytest_runtest_logreport(self, report) -> None:
        if report.failed:
            self.failed = report.nodeid


def ask(root: Path, limits: dict[str, float], sender: Connection) -> None:
    """Run tests in a copy of the project until one fails, and send the answer."""
    import pytest

    os.setsid()
    os.chdir(root)
    with open(os.devnull, "r+b") as nothing:
        for stream in (0, 1, 2):
            os.dup2(nothing.fileno(), stream)
    folders = [str(root / "src"), str(root / "validation")]
    sys.path[:0] = folders
    os.environ["PYTHONPATH"] = os.pathsep.join(folders)
    asking = Asking(limits)
    # Importing may hang, too.
    signal.setitimer(signal.ITIMER_REAL, IMPORTING)
    code = pytest.main(
        [*OPTIONS, f"--basetemp={root.parent / 'tmp'}", "--hypothesis-seed=0", *limits],
        plugins=[asking],
    )
    sender.send(Answer(failed=asking.failed, broke=code not in (0, 1)))
    sender.close()
