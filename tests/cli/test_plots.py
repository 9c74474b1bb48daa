"""What the option --picture draws, read back from the figure."""

import numpy as np
import pytest
from typer.testing import CliRunner

from vibrissa import Rod, sensor
from vibrissa.cli.app import app
from vibrissa.sensor import plots
from vibrissa.sensor.identification.periods import Grade, Periods
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.series import Column
from vibrissa.sensor.transducer import CHANNELS

STEEL = Rod(2.1e11, 1e-3, 0.1)


def whisker(**given):
    return sensor.Whisker.read(
        2.0, "85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm", **given
    )


@pytest.mark.parametrize("angle", [0.0, 3.0])
def test_the_rod_before_and_at_the_onset_with_the_tip_at_one_place(angle):
    rod = whisker(stage_angle=f"{angle} deg")
    found = sensor.solve(rod, 0.3)
    figure = plots.shapes(rod, found.onset)
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
    for n, (axes, name) in enumerate(zip(figure.axes, CHANNELS, strict=True)):
        (line,) = axes.lines
        assert list(line.get_xdata()) == [0.0, 1.0, 2.0]
        assert list(line.get_ydata()) == [n, n + 1.0, n - 1.0]
        assert axes.get_ylabel() == f"{name} / unit{n}"
    assert figure.axes[-1].get_xlabel() == "position of the clamp / mm"


def friction_map(units, **known):
    count = len(known["mu0"])
    names = [name for name in Periods.names() if name not in vars(Periods)]
    return plots.friction_map(Periods(**dict.fromkeys(names, np.full(count, "")) | known), units)


def test_friction_stands_at_the_place_of_the_tip_with_its_interval():
    figure = friction_map(
        Units(STEEL),
        mu0=np.array([0.3, 0.4]),
        low=np.array([0.28, 0.35]),
        high=np.array([0.33, 0.5]),
        contact=np.array([0.5, 0.9]),
    )
    (axes,) = figure.axes
    ((dots, _, (bars,)),) = axes.containers
    assert np.column_stack(dots.get_data()) == pytest.approx(np.array([[0.05, 0.3], [0.09, 0.4]]))
    ends = np.array(bars.get_segments())
    assert ends[:, :, 1] == pytest.approx(np.array([[0.28, 0.33], [0.35, 0.5]]))
    assert axes.get_xlabel() == "position of the tip / m"


def test_each_grade_of_doubt_has_its_sign_and_friction_without_a_tip_is_drawn_over_the_clamp():
    figure = friction_map(
        Units(),
        mu0=np.array([0.3, 0.4, 0.5, 0.6, np.nan]),
        low=np.full(5, 0.25),
        high=np.full(5, 0.65),
        contact=np.full(5, np.nan),
        footpoint=np.arange(5.0),
        grade=np.array(["", *Grade, ""]),
    )
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
