from pathlib import Path

import pytest
import yaml
from hypothesis import settings

from vibrissa import records, solve_curve, solve_state, stick_slip, tables
from vibrissa.grid import readings
from vibrissa.stiction import read_curve
from vibrissa.study import parse_study

ROOT = Path(__file__).parents[1]

# A deadline would measure how busy the machine is.
settings.register_profile("vibrissa", deadline=None)
settings.load_profile("vibrissa")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


@pytest.fixture(scope="session")
def paper():
    """The paper's study."""
    schema = yaml.safe_load((ROOT / "workflow/schemas/study.schema.yaml").read_text())
    return parse_study(yaml.safe_load((ROOT / "config.yaml").read_text()), schema)


@pytest.fixture(scope="session")
def study_tables(paper):
    """Tables of the paper's study, by its code but without its workflow."""
    tapers = {theta for axes in paper.grids.values() for theta in axes.theta}
    curves = {theta: solve_curve(float(theta), 0.85) for theta in tapers}
    keys = {(format(theta, "f"), "0.85"): curve for theta, curve in curves.items()}
    points = (
        (pairs, keys[key], read_curve(keys[key], pairs.mu0, pairs.dx0))
        for key, pairs in readings(keys, paper.grids)
    )
    scans = [
        records.scan_table(name, p, stick_slip(curves[p.theta], p.mu0, p.dx0, scan.cycles))
        for name, scan in paper.scans.items()
        for p in scan.grid.points()
    ]
    states = {
        name: solve_state(*(float(value) for value in (state.theta, state.eta, state.x1)))
        for name, state in paper.states.items()
    }
    return {
        "stiction": tables.joined(list(records.stiction_tables(points)), tables.STICTION),
        "scans": tables.joined(scans, tables.SCANS),
        "states": records.states_table(states),
    }
