import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

import made_tables
from vibrissa import solve_state
from vibrissa.sticking import api
from vibrissa.study.reading import read_study
from vibrissa.tables import records, schemas, store

ROOT = Path(__file__).parents[1]

# What a shell starts in the background ignores Ctrl-C, and so would the programs that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# How wide and colourful a terminal is, and whether it is GitHub's, must not decide what is shown.
for name in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "PY_COLORS", "GITHUB_ACTIONS"):
    os.environ.pop(name, None)

# A deadline would measure how busy the machine is.
settings.register_profile("vibrissa", deadline=None)
settings.load_profile("vibrissa")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


@pytest.fixture(scope="session", autouse=True)
def _caches(tmp_path_factory):
    """What tests start keeps its caches here, also where the home folder cannot be written."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("caches")))
        yield


@pytest.fixture(autouse=True)
def _no_kept_curves():
    """No test gets a curve that another one has solved."""
    api._kept_curve.cache_clear()


@pytest.fixture(scope="session")
def paper():
    """The paper's study."""
    return read_study(ROOT / "config.yaml")


@pytest.fixture(scope="session")
def study_tables(paper):
    """Tables of the paper's study, by its code but without its workflow."""
    states = {
        name: solve_state(state.theta, state.eta, state.x1) for name, state in paper.states.items()
    }
    grids = [made_tables.points(name, grid.axes) for name, grid in paper.grids.items()]
    scans = [made_tables.scans(name, scan) for name, scan in paper.scans.items()]
    return {
        "stiction": store.joined(grids, schemas.STICTION),
        "scans": store.joined(scans, schemas.SCANS),
        "states": records.states_table(states, paper.name),
    }
