"""Both sides of each limit of a study file: what is just allowed, and what is no longer."""

import pytest

from vibrissa.errors import StudyError
from vibrissa.study.parsing import parse_study

POINT = {"theta": [2], "mu0": [0.3], "eta": [0.85], "dx0": [0.01]}
SCAN = POINT | {"cycles": 1}
STATE = {"theta": 2, "eta": 0.8, "x1": 0.3}


def study(grid=(), scan=None, state=None, comparison=None, **others):
    sections = {"scans": scan, "states": state, "comparisons": comparison}
    named = {name: {"a": section} for name, section in sections.items() if section}
    return {"study": "a", "grids": {"a": POINT | dict(grid)}, **named, **others}


def refused(config):
    """Whether a study is refused, with one message that names where."""
    try:
        parse_study(config)
    except StudyError as error:
        return ": " in str(error)
    return False


@pytest.mark.parametrize(
    ("axis", "allowed", "beyond"),
    [
        ("theta", [1], [0.999999]),
        ("mu0", [1e-9], [0, -0.1]),
        ("eta", [1e-9, 0.999999], [0, 1]),
        ("dx0", [1e-9], [0.99e-9]),
        ("clamp_angle", [-1.5, 1.5], [-1.500001, 1.500001]),
        ("clamp_compliance", [0], [-1e-9]),
        ("curvature", [-10, 10, [-10, 10]], [-10.00001, 10.00001, [0, 10.00001], []]),
        ("stage_angle", [-1.5, 1.5], [-1.500001, 1.500001]),
    ],
)
def test_values_of_an_axis_have_ends(axis, allowed, beyond):
    assert not any(refused(study({axis: [value]})) for value in allowed)
    assert all(refused(study({axis: [value]})) for value in beyond)
    assert refused(study({axis: []}))
    numbers = [value for value in allowed if not isinstance(value, list)]
    for value in numbers:
        assert not refused(study({axis: {"start": value, "stop": value, "step": 1}}))
        assert refused(study({axis: {"start": value, "stop": value, "step": 0}}))
    for value in (value for value in beyond if not isinstance(value, list)):
        assert refused(study({axis: {"start": value, "stop": value, "step": 1}}))


@pytest.mark.parametrize(
    ("allowed", "beyond"),
    [
        (study(scan=SCAN), study(scan=SCAN | {"cycles": 0})),
        (study(block_size=1), study(block_size=0)),
        (study(max_points=1), study(max_points=0)),
        ({**study(), "study": "a" * 100}, {**study(), "study": "a" * 101}),
        # The tip must be within reach, not at its end.
        (study(state=STATE | {"x1": 0.599999}), study(state=STATE | {"x1": 0.6})),
        (study(state=STATE | {"x1": -0.59}), study(state=STATE | {"x1": -0.6})),
        # (cycles + 1)/dx0
        (
            study(scan=SCAN | {"dx0": [0.001], "cycles": 999}),
            study(scan=SCAN | {"dx0": [0.001], "cycles": 1000}),
        ),
        # Steps of a scan, by the travel of 0.1 in a cycle: 10 and the first.
        (study(scan=SCAN, max_points=11), study(scan=SCAN, max_points=10)),
        (
            study(scan=SCAN | {"mu0": [0.2, 0.3], "dx0": [0.01, 0.02]}, max_points=32),
            study(scan=SCAN | {"mu0": [0.2, 0.3], "dx0": [0.01, 0.02]}, max_points=31),
        ),
        # Points of all sections together.
        (study({"mu0": [0.1, 0.2]}, max_points=2), study({"mu0": [0.1, 0.2]}, max_points=1)),
        (
            study(comparison={"theta": [2], "mu0": [0.3, 0.4], "eta": [0.8]}, max_points=3),
            study(comparison={"theta": [2], "mu0": [0.3, 0.4], "eta": [0.8]}, max_points=2),
        ),
    ],
)
def test_counts_and_sizes_have_ends(allowed, beyond):
    assert not refused(allowed) and refused(beyond)


def test_what_refinement_may_add_has_ends():
    def refined(closest=0.05, tolerance=0.01):
        return study(
            {"mu0": [0.2, 0.3], "refine": {"closest": {"mu0": closest}, "tolerance": tolerance}}
        )

    assert not refused(refined(0.05)) and refused(refined(0.050001))
    assert not refused(refined(1e-6)) and refused(refined(0.99e-6))
    assert not refused(refined(tolerance=1e-12)) and refused(refined(tolerance=0))
    assert refused(study({"refine": {"closest": {}, "tolerance": 0.01}}))
