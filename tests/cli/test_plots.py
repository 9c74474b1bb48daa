"""What the option --picture draws, read back from the figure."""

from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from known import Known
from looks import figure_described
from vibrissa import sensor
from vibrissa.cli import options
from vibrissa.cli.app import app
from vibrissa.design import plots as plots_of_design
from vibrissa.sensor import plots
from vibrissa.sensor.identification.checks import Grade
from vibrissa.sensor.identification.periods import Periods
from vibrissa.sensor.quantities import Units, read_rod
from vibrissa.sensor.series import Column
from vibrissa.sensor.transducer import CHANNELS

KNOWN = Known(__file__)
STEEL = read_rod("210 GPa", "1 mm", "100 mm")


def whisker(**given):
    return sensor.Whisker.read(
        2.0, "85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm", **given
    )


@pytest.mark.parametrize("angle", [0.0, 3.0])
def test_the_rod_before_and_at_the_onset_with_the_tip_at_one_place(angle):
    rod = whisker(stage_angle=f"{angle} deg")
    found = sensor.solve(rod, 0.3)
    figure = plots.shapes(rod, found.onset)
    KNOWN.check(f"shapes on a stage at {angle:g}°", figure_described(figure))
    (axes,) = figure.axes
    # In the unit in which the rod was given.
    first, last, surface = (1e-3 * np.column_stack(line.get_data()) for line in axes.lines)
    x0 = found.onset.x0_slip * 0.1
    way = np.deg2rad(angle)
    assert first[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert last[0] == pytest.approx([x0 * np.cos(way), x0 * np.sin(way)], abs=1e-12)
    # The tip sticks: it has not moved on the surface.
    assert first[-1] == pytest.approx(last[-1], abs=1e-9)
    assert first[-1, 1] == pytest.approx(0.085) and surface[:, 1] == pytest.approx(0.085)
    for line in (first, last):
        assert np.hypot(*np.diff(line, axis=0).T).sum() == pytest.approx(0.1, rel=1e-3)
    assert axes.get_xlabel() == "x / mm" and axes.get_ylabel() == "y / mm"
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["α = 0", "onset of slip"]


def test_signals_are_each_in_a_panel_with_its_unit():
    clamp = Column([0.0, 1.0, 2.0], "mm", "")
    columns = {"footpoint": clamp} | {
        name: Column([n, n + 1.0, n - 1.0], f"unit{n}", "") for n, name in enumerate(CHANNELS)
    }
    figure = plots.signals(columns)
    KNOWN.check("signals", figure_described(figure))
    for n, (axes, name) in enumerate(zip(figure.axes, CHANNELS, strict=True)):
        (line,) = axes.lines
        assert list(line.get_xdata()) == [0.0, 1.0, 2.0]
        assert list(line.get_ydata()) == [n, n + 1.0, n - 1.0]
        assert axes.get_ylabel() == f"{name} / unit{n}"
    assert figure.axes[-1].get_xlabel() == "position of the clamp / mm"


def test_friction_stands_at_the_place_of_the_tip_with_its_interval():
    known = {
        "mu0": np.array([0.3, 0.4]),
        "low": np.array([0.28, 0.35]),
        "high": np.array([0.33, 0.5]),
        "contact": np.array([0.5, 0.9]),
    }
    columns = [name for name in Periods.names() if name not in vars(Periods)]
    periods = Periods(**dict.fromkeys(columns, np.full(2, "")) | known)
    figure = plots.friction_map(periods, Units(STEEL))
    KNOWN.check("friction", figure_described(figure))
    (axes,) = figure.axes
    ((dots, _, (bars,)),) = axes.containers
    assert np.column_stack(dots.get_data()) == pytest.approx(np.array([[0.05, 0.3], [0.09, 0.4]]))
    ends = np.array(bars.get_segments())
    assert ends == pytest.approx(
        np.array([[[0.05, 0.28], [0.05, 0.33]], [[0.09, 0.35], [0.09, 0.5]]])
    )
    assert axes.get_xlabel() == "position of the tip / m"


def test_each_grade_of_doubt_has_its_sign_and_friction_without_a_tip_is_drawn_over_the_clamp():
    grades = np.array(["", *Grade, ""])
    known = {
        "mu0": np.array([0.3, 0.4, 0.5, 0.6, np.nan]),
        "low": np.full(5, 0.25),
        "high": np.full(5, 0.65),
        "contact": np.full(5, np.nan),
        "footpoint": np.arange(5.0),
        "grade": grades,
    }
    columns = [name for name in Periods.names() if name not in vars(Periods)]
    periods = Periods(**dict.fromkeys(columns, np.full(5, "")) | known)
    figure = plots.friction_map(periods, Units())
    KNOWN.check("friction with doubts", figure_described(figure))
    (axes,) = figure.axes
    drawn = {}
    for one in axes.containers:
        dots = one.lines[0]
        drawn[one.get_label()] = [dots.get_marker(), dots.get_color(), *dots.get_xydata().tolist()]
    assert drawn == {
        "no doubt": ["o", "C0", [0.0, 0.3]],
        "information": ["s", "C0", [1.0, 0.4]],
        "doubtful": ["^", "C1", [2.0, 0.5]],
        "wrong": ["x", "C3", [3.0, 0.6]],
    }
    assert axes.get_legend().get_title().get_text() == "doubts"
    assert axes.get_xlabel() == "position of the clamp / L"
    assert axes.get_ylabel() == "static friction μ0, 95 %"


class Bar:
    """What a bar of progress is told."""

    def __init__(self, length, label, file):
        self.length, self.label, self.pos, self.finished = length, label, 0, False

    def update(self, steps):
        self.pos += steps

    def render_finish(self):
        self.finished = True


def test_a_bar_stands_where_the_work_is_once_it_has_taken_long(monkeypatch):
    bars, now = [], [0.0]

    def made(**given):
        bars.append(Bar(**given))
        return bars[-1]

    monkeypatch.setattr("typer.progressbar", made)
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    tell = options.progress_bars()
    places = []
    # When, which work, and how much of it is done.
    for at, what, done in (
        *((0.0, "a", 2), (1.9, "a", 3), (2.1, "a", 5), (2.2, "a", 9)),
        *((3.0, "b", 1), (4.9, "b", 8), (5.1, "b", 9), (5.2, "b", 10), (5.3, "a", 10)),
    ):
        now[0] = at
        tell(what, done, 10)
        places.append([(bar.label, bar.pos, bar.finished) for bar in bars][-1])
    assert places == [
        *(("a", 0, False), ("a", 0, False), ("a", 5, False), ("a", 9, False)),
        *(("b", 0, False), ("b", 0, False), ("b", 9, False), ("b", 10, True), ("b", 10, True)),
    ]
    assert [(bar.length, bar.pos, bar.finished) for bar in bars] == [(10, 10, True)] * 2


@pytest.mark.parametrize("with_pairs", [True, False])
def test_a_design_stands_among_the_pairs_that_were_solved(with_pairs):
    found = SimpleNamespace(
        mu0=np.array([0.2, 0.3, 0.4]),
        uncertainty=SimpleNamespace(
            whole=np.array([5.0, 6.0, 7.0]),
            by_step=np.array([4.0, 4.5, 5.0]),
            by_reading=np.array([3.0, 4.0, 5.0]),
            by_tolerances=np.array([1.0, 2.0, 3.0]),
        ),
        pairs=SimpleNamespace(theta=np.array([1.0, 2.0, 3.0]), eta=np.array([0.7, 0.8, 0.9])),
        pair_uncertainty=np.array([0.1, np.nan, 0.3] if with_pairs else []),
        theta=3.0,
        eta=0.9,
    )
    figure = plots_of_design.design(found)
    KNOWN.check(f"design, {with_pairs=}", figure_described(figure))
    left, right, *_ = figure.axes
    drawn = {line.get_label(): list(line.get_ydata()) for line in left.lines}
    assert drawn == {
        "whole": [5.0, 6.0, 7.0],
        "by the step": [4.0, 4.5, 5.0],
        "by the noise": [3.0, 4.0, 5.0],
        "by the tolerances": [1.0, 2.0, 3.0],
    }
    assert all(list(line.get_xdata()) == [0.2, 0.3, 0.4] for line in left.lines)
    assert left.get_ylim()[0] == 0.0
    drawn = {line.get_label(): np.column_stack(line.get_data()) for line in right.lines}
    if not with_pairs:
        assert list(drawn) == ["the rod"] and not right.collections
        return
    assert drawn["no rod"] == pytest.approx(np.array([[2.0, 0.8]]))
    assert drawn["the rod"] == pytest.approx(np.array([[3.0, 0.9]]))
    (dots,) = right.collections
    assert dots.get_offsets().data == pytest.approx(np.array([[1.0, 0.7], [3.0, 0.9]]))
    assert list(dots.get_array()) == [0.1, 0.3]


def test_a_picture_is_drawn_of_a_rod_that_slips_or_locks(tmp_path):
    def run(*arguments):
        return CliRunner().invoke(app, ["solve", "--theta", "2", "--eta", "0.85", *arguments])

    picture = tmp_path / "rod.svg"
    assert run("--mu0", "0.4", "--picture", str(picture)).exit_code == 0
    assert picture.read_bytes().startswith(b"<?xml")
    lock = tmp_path / "lock.svg"
    assert run("--mu0", "0.5", "--picture", str(lock)).exit_code == 0
    assert lock.read_bytes().startswith(b"<?xml")
    none = tmp_path / "none.svg"
    result = run("--mu0", "0.4", "--set", "curvature=-1", "--picture", str(none))
    assert result.exit_code == 1 and not none.exists()
    assert result.stderr == f"{none} is not drawn: there is no state to draw\n"
    for where, said in (("rod.gif", "the ending must be one of"), ("no/rod.svg", "no folder")):
        result = run("--mu0", "0.4", "--picture", str(tmp_path / where))
        assert result.exit_code == 2 and said in result.output
