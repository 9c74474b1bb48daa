"""What the option --picture draws, read back from the figure."""

from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from vibrissa import sensor
from vibrissa.cli.app import app
from vibrissa.design import plots as plots_of_design
from vibrissa.sensor import plots
from vibrissa.sensor.identification.friction import Periods
from vibrissa.sensor.quantities import Units, read_rod
from vibrissa.sensor.series import Column
from vibrissa.sensor.transducer import CHANNELS

STEEL = read_rod("210 GPa", "1 mm", "100 mm")


def whisker(**given):
    return sensor.Whisker.read(
        2.0, "85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm", **given
    )


@pytest.mark.parametrize("angle", [0.0, 3.0])
def test_the_rod_before_and_at_the_onset_with_the_tip_at_one_place(angle):
    rod = whisker(stage_angle=f"{angle} deg")
    found = sensor.solve(rod, 0.3)
    (axes,) = plots.shapes(rod, found.onset).axes
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
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["α = 0", "onset of slip"]


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
    (axes,) = figure.axes
    ((dots, _, (bars,)),) = axes.containers
    assert np.column_stack(dots.get_data()) == pytest.approx(np.array([[0.05, 0.3], [0.09, 0.4]]))
    ends = np.array(bars.get_segments())
    assert ends == pytest.approx(
        np.array([[[0.05, 0.28], [0.05, 0.33]], [[0.09, 0.35], [0.09, 0.5]]])
    )
    assert axes.get_xlabel() == "position of the tip / m"


@pytest.mark.parametrize("with_pairs", [True, False])
def test_a_design_stands_among_the_pairs_that_were_solved(with_pairs):
    found = SimpleNamespace(
        mu0=np.array([0.2, 0.3, 0.4]),
        deviations=SimpleNamespace(
            total=np.array([5.0, 6.0, 7.0]),
            by_step=np.array([4.0, 4.5, 5.0]),
            by_reading=np.array([3.0, 4.0, 5.0]),
        ),
        pairs=SimpleNamespace(theta=np.array([1.0, 2.0, 3.0]), eta=np.array([0.7, 0.8, 0.9]))
        if with_pairs
        else None,
        pair_deviation=np.array([0.1, np.nan, 0.3]),
        theta=3.0,
        eta=0.9,
    )
    left, right, *_ = plots_of_design.design(found).axes
    drawn = {line.get_label(): list(line.get_ydata()) for line in left.lines}
    assert drawn == {
        "together": [5.0, 6.0, 7.0],
        "by the step": [4.0, 4.5, 5.0],
        "by the readings": [3.0, 4.0, 5.0],
    }
    assert all(list(line.get_xdata()) == [0.2, 0.3, 0.4] for line in left.lines)
    assert left.get_ylim()[0] == 0.0
    drawn = {line.get_label(): np.column_stack(line.get_data()) for line in right.lines}
    if not with_pairs:
        assert not drawn and not right.collections
        return
    assert drawn["no rod"] == pytest.approx(np.array([[2.0, 0.8]]))
    assert drawn["the rod"] == pytest.approx(np.array([[3.0, 0.9]]))
    (dots,) = right.collections
    assert dots.get_offsets().data == pytest.approx(np.array([[1.0, 0.7], [3.0, 0.9]]))
    assert list(dots.get_array()) == [0.1, 0.3]


def test_a_picture_is_drawn_of_a_rod_that_slips_alone(tmp_path):
    def run(*arguments):
        return CliRunner().invoke(app, ["solve", "--theta", "2", "--eta", "0.85", *arguments])

    picture = tmp_path / "rod.svg"
    assert run("--mu0", "0.4", "--picture", str(picture)).exit_code == 0
    assert picture.read_bytes().startswith(b"<?xml")
    none = tmp_path / "none.svg"
    result = run("--mu0", "0.5", "--picture", str(none))
    assert result.exit_code == 2 and "no picture of a rod with status lock" in result.output
    assert not none.exists()
    for where, said in (("rod.gif", "the ending must be one of"), ("no/rod.svg", "no folder")):
        result = run("--mu0", "0.4", "--picture", str(tmp_path / where))
        assert result.exit_code == 2 and said in result.output
