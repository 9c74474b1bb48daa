"""A pytest plugin that tells coverage which test runs, and writes down how long each takes.

A fixture that several tests share has a context of its own: it is set up in the first of them, but
all of them depend on the lines that it reaches. Processes that a test starts inherit its context.
"""

import functools
import json
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from coverage import Coverage

FOLDER = "MUTATION_RECORDING"
CONTEXT = "MUTATION_CONTEXT"
EFFORT = pytest.StashKey[float]()


@contextmanager
def context(name: str) -> Iterator[None]:
    """Count what runs meanwhile as reached by the test or fixture of this name."""
    measuring = Coverage.current()
    before = os.environ.get(CONTEXT, "")
    try:
        os.environ[CONTEXT] = name
        if measuring:
            measuring.switch_context(name)
        yield
    finally:
        os.environ[CONTEXT] = before
        if measuring:
            measuring.switch_context(before)


def forget() -> None:
    """Empty the caches of the program and of the tests: each test reaches what it needs."""
    for name, module in list(sys.modules.items()):
        path = getattr(module, "__file__", None) or ""
        if name.startswith("vibrissa") or f"{os.sep}tests{os.sep}" in path:
            for value in list(vars(module).values()):
                if isinstance(value, functools._lru_cache_wrapper):
                    value.cache_clear()


def write(**entry: object) -> None:
    """Append an entry to the file of this process."""
    path = Path(os.environ[FOLDER]) / f"{os.getpid()}.jsonl"
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(entry) + "\n")


def spent() -> float:
    """Return the seconds of processor time of this process and of those it has started.

    The clock on the wall would also measure how busy the machine is.
    """
    return sum(os.times()[:4])


def fixture_name(fixture: pytest.FixtureDef) -> str:
    return f"fixture {fixture.baseid}::{fixture.argname}"


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef, request):
    if fixturedef.scope == "function":
        return (yield)
    begin, effort = time.perf_counter(), spent()
    with context(fixture_name(fixturedef)):
        result = yield
    seconds, effort = time.perf_counter() - begin, spent() - effort
    write(fixture=fixture_name(fixturedef), seconds=seconds, effort=effort)
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item, nextitem):
    forget()
    with context(item.nodeid):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    begin = spent()
    try:
        return (yield)
    finally:
        item.stash[EFFORT] = spent() - begin


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.when == "call" or not report.passed:
        fixtures = [
            fixture_name(found[-1])
            for found in item._fixtureinfo.name2fixturedefs.values()
            if found and found[-1].scope != "function"
        ]
        write(
            test=item.nodeid,
            outcome=report.outcome,
            seconds=call.duration,
            effort=item.stash.get(EFFORT, 0.0),
            fixtures=fixtures,
        )
    return report
