import os
import signal
from pathlib import Path

import pytest
import yaml
from hypothesis import settings

from vibrissa import solve_curve, solve_state, stick_slip
from vibrissa.design import search
from vibrissa.sticking import api
from vibrissa.study.grid import points_on_curves
from vibrissa.study.parsing import parse_study
from vibrissa.tables import records, schemas, store
from vibrissa.tables.points import points_tables

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
    return parse_study(yaml.safe_load((ROOT / "config.yaml").read_text()))


@pytest.fixture(scope="session")
def study_tables(paper):
    """Tables of the paper's study, by its code but without its workflow."""
    curves = {key: solve_curve(float(key.theta), float(key.eta)) for key in paper.curve_keys}
    points = ((points, curves[key]) for key, points in points_on_curves(curves, paper.point_grids))
    scans = [
        records.scan_table(
            name,
            point,
            stick_slip(curve, point.mu0, point.dx0, scan.cycles),
            study=paper.name,
            method=curve.method,
        )
        for name, scan in paper.scans.items()
        for point in scan.grid.points()
        for curve in [curves[point.curve_key(by_step=False)]]
    ]
    states = {
        name: solve_state(*(float(value) for value in (state.theta, state.eta, state.x1)))
        for name, state in paper.states.items()
    }
    return {
        "stiction": store.joined(list(points_tables(points, paper.name)), schemas.STICTION),
        "scans": store.joined(scans, schemas.SCANS),
        "states": records.states_table(states, paper.name),
    }


@pytest.fixture(scope="module")
def coarse():
    """Designs on a coarser mesh: the rod is as good to some percent."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"TAPERS": 4, "HEIGHTS": 6, "ROUNDS": 3}.items():
            patch.setattr(search, name, value)
        yield
