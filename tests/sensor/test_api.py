"""What a notebook and the command line call: units, tables, estimates, refusals."""

import re
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from steel import NANO, ROD, SENSOR, SI, TRANSDUCER, WHISKER, identified
from vibrissa import Mounting, sensor, solve_onset
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.quantities.units import Kind, Units
from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, Whisker, scan, solve
from vibrissa.sensor.onset import strains_in


@pytest.fixture(scope="module")
def whisker():
    return Whisker(theta=2.0, eta=0.85, rod=ROD)


@pytest.fixture(scope="module")
def signals(whisker):
    surface = surfaces.random(5, 0.3, 0.04, 0.02)
    return scan(whisker, surface, step="50 um", to=["40 mm"]).measured(SENSOR, seed=5)


def test_every_public_name_is_there_and_units_and_tables_are_loaded_when_used():
    assert all(hasattr(sensor, name) for name in sensor.__all__)
    program = "import sys, vibrissa.sensor; print({'pandas', 'pint'} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert loaded.stdout == "set()\n"


def test_an_onset_is_in_the_units_of_the_rod(whisker):
    own = solve_onset(2.0, 0.4, 0.85, 0.001)
    columns = solve(whisker, 0.4, "0.1 mm").columns()
    assert columns["x0_max"].values == pytest.approx([own.x0_max * 0.1])
    assert columns["force_y"].values == pytest.approx([own.slip.reaction_fy * ROD.force_unit])
    locked = solve(whisker, 0.5).columns()
    assert locked["status"].values == ["lock"] and "x0_slip" not in locked


def test_results_are_told_in_the_units_in_which_the_rod_was_given(whisker):
    steel = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
    given = Setup.read(theta=2.0, eta="8.5 cm", **steel).whisker
    found, plain = solve(given, 0.4), solve(whisker, 0.4)
    lines = dict(re.split("  +", line) for line in repr(found).splitlines())
    assert lines["clamp travel at the onset of slip, x0"] == "5.2838043 mm"
    assert lines["tangential clamp force"].endswith(" N")
    assert "0.0052838043 m" in repr(plain)
    # In messages, too.
    assert lines["meaning of the status"] == "the tip slips at x0 = 5.2838 mm"
    assert "x0 = 0.0052838 m" in repr(plain)
    locked = repr(solve(given, 0.6))
    assert "buckles laterally at x0 = 41.7329 mm" in locked and "slips at x0 = 84.7969 mm" in locked
    # Tables stay in SI units.
    assert found.columns()["x0_slip"] == plain.columns()["x0_slip"]


def test_a_recording_is_told_in_the_units_of_what_was_given(whisker):
    steel = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
    given = Setup.read(theta=2.0, eta="85 mm", noise="3 mN, 4 mN, 10 N*mm", **steel).whisker
    units = given.units
    force = 0.25 / units.unit(Kind.FORCE)
    assert units.spelled(force, Kind.FORCE, 3) == "250 mN"
    assert units.spelled(0.002 / units.unit(Kind.MOMENT), Kind.MOMENT) == "2 N*mm"
    assert whisker.units.spelled(force, Kind.FORCE) == "0.25 N"
    assert Units().spelled(0.25, Kind.LENGTH) == "0.25 L"
    assert Units(si=True, wished={Kind.LENGTH: "mm"}).spelled(0.25, Kind.LENGTH) == "250 mm"


@pytest.mark.slow
@pytest.mark.parametrize("angle", [pytest.param(0.0, marks=pytest.mark.nightly), 0.002])
def test_a_channel_that_is_saturated_everywhere_is_not_used(angle, signals):
    # Newtons that are called kilonewtons: the moment alone is read.
    table = signals.to_pandas()
    wrong = table.assign(force_y=1e3 * table["force_y"])
    leaning = Whisker(theta=2.0, eta=0.85, rod=ROD, mounting=Mounting(stage_angle=angle))
    found = identified(leaning, wrong, transducer=TRANSDUCER)
    assert any("force_y is missing or saturated in 801 rows" in one for one in found.periods.notes)
    full = wrong.assign(moment_z=1e3 * table["moment_z"])
    with pytest.raises(RecordingError, match=r"0 usable rows; .*saturated in 801 rows, left out"):
        identified(leaning, full, transducer=TRANSDUCER)


def test_how_a_scan_ended_is_told_in_the_units_of_the_rod():
    steel = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
    asked = {"step": "0.2 mm", "to": ["60 mm"], "law": "energy"}
    level = Setup.read(theta=2.0, eta="85 mm", **steel).whisker
    ended = repr(scan(level, surfaces.constant(0.8), **asked))
    assert "with the clamp at 41.8 mm the rod buckles laterally" in ended
    inclined = Setup.read(theta=2.0, eta="99.98 mm", stage_angle="-0.05 rad", **steel).whisker
    with pytest.raises(ArgumentError, match=r"distances from 99\.98 mm to 100\.08 mm, but its"):
        scan(inclined, surfaces.constant(0.2), step="0.05 mm", to=["2 mm"])
    measured = surfaces.profile([0.0, 0.45], [0.3, 0.3])
    with pytest.raises(ArgumentError, match="known from x = 0 mm to 45 mm, but the tip"):
        scan(level, measured, step="1 mm", to=["60 mm"])


@pytest.mark.parametrize(("theta", "begins"), [(1.0, True), (2.0, False)])
def test_the_largest_strain_is_where_sticking_begins_in_a_cylinder_and_ends_in_a_cone(
    theta, begins
):
    found = solve(Whisker(theta=theta, eta=0.85, rod=ROD), 0.4)
    columns = {name: column.values[0] for name, column in found.columns().items()}
    curve = found.whisker.curve
    at_end = strains_in([curve], [float(curve.onset(0.4))]).strain[0]
    assert (found.most.strain[0] > 1.001 * at_end) == begins
    slenderness = ROD.base_diameter / ROD.length
    assert columns["strain_most"] == pytest.approx(found.most.strain[0] * slenderness)
    assert 0.0 <= columns["strain_place"] < 0.1


@pytest.mark.parametrize("whisker", [None, Whisker(theta=2.0, eta=0.85)])
def test_a_recording_is_named_by_its_path_or_is_a_table(whisker, tmp_path):
    method = "ratio" if whisker is None else "model"
    for source in ("scan.csv", tmp_path / "scan.csv"):
        with pytest.raises(FileNotFoundError, match=r"scan\.csv"):
            identified(whisker, source, method=method)
    with pytest.raises(RecordingError, match="a recording is a file or a DataFrame, not a dict"):
        identified(whisker, {"footpoint": [0.0, 0.1]}, method=method)


@pytest.mark.slow
def test_a_data_frame_is_identified_as_the_command_identifies_its_file(whisker, signals, tmp_path):
    found = identified(whisker, signals.to_pandas(), transducer=TRANSDUCER, method="model")
    table = found.to_pandas()
    truth = signals.truth.mu0[found.periods.last]
    slip = table["status"] == "slip"
    assert slip.sum() == len(table) - 1 > 10
    assert repr(found.periods) == f"{len(table)} periods: {slip.sum()} slip, 1 open"
    assert repr(surfaces.constant(0.3)) == "Surface(name='constant', start=-inf, stop=inf)"
    error = (table["mu0"] - truth)[slip]
    assert (np.abs(error / table["deviation"][slip]) < 4.5).all()

    series.write(tmp_path / "scan.csv", signals)
    asked = [*WHISKER, *SI, *NANO, "--method", "model", "-o", str(tmp_path / "found.csv")]
    assert CliRunner().invoke(app, ["identify", str(tmp_path / "scan.csv"), *asked]).exit_code == 0
    written = pd.read_csv(tmp_path / "found.csv")
    assert [title.partition(" [")[0] for title in written.columns] == list(table.columns)
    assert table.attrs["units"]["contact"] == "m"
    assert written["mu0 [1]"].to_numpy() == pytest.approx(table["mu0"].to_numpy(), nan_ok=True)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"method": "sound"}, "method must be one of model, ratio, got 'sound'"),
        ({"transducer": "ear"}, "transducer must be one of"),
        ({"transducer": TRANSDUCER, "noise": "1, 1, 1"}, "the noise or the transducer, not both"),
        ({"noise": "3 mN, 3 mN"}, "noise needs three values"),
        ({"noise": "3 mN, 3 m, 1"}, "noise must be a force"),
        ({"noise": "3 mN, -3 mN, 1 uN*m"}, "noise must be at least 0, and not all 0"),
        ({"noise": "0 N, 0 N, 0 N*m"}, "not all 0, got '0 N, 0 N, 0 N.m'"),
        ({"noise": "nan, 1, 1"}, "noise must be a force"),
    ],
)
def test_impossible_arguments_are_refused(whisker, signals, asked, message):
    with pytest.raises(ArgumentError, match=message):
        identified(whisker, signals.to_pandas()[:300], **asked)


@pytest.mark.slow
def test_a_channel_without_noise_is_not_used(whisker, signals):
    asked = {"assume": False, "noise": "3 mN, 3 mN, 0 N*m"}
    frame = signals.to_pandas()[:300]
    found = identified(whisker, frame, **asked)
    other = identified(whisker, frame.assign(moment_z=frame.moment_z + 1.0), **asked)
    assert found.periods.mu0 == pytest.approx(other.periods.mu0, nan_ok=True)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda frame: frame.drop(columns=["force_y", "moment_z"]),
            "needs the column moment_z, or both force_x and force_y",
        ),
        (lambda frame: frame.assign(force_x="much"), "line 1: force_x must be empty or a number"),
        (lambda frame: frame[:0], "no rows"),
        (lambda frame: pd.concat([frame, frame], axis=1), "occurs twice"),
    ],
)
def test_a_data_frame_that_is_no_recording_is_refused(whisker, signals, change, message):
    with pytest.raises(RecordingError, match=message):
        identified(whisker, change(signals.to_pandas()[:300]))


@pytest.mark.slow
def test_a_data_frame_has_its_units_in_attrs_or_in_titles(whisker, signals):
    frame = signals.to_pandas()[:300]
    known = identified(whisker, frame, transducer=TRANSDUCER, assume=False)
    bare = frame.copy()
    bare.attrs = {}
    with pytest.raises(RecordingError, match="footpoint needs its unit"):
        identified(whisker, bare, transducer=TRANSDUCER, assume=False)
    units = {"force_x": "N", "force_y": "N", "moment_z": "N*m"}
    titled = bare.assign(footpoint=1e3 * bare["footpoint"]).rename(
        columns={"footpoint": "footpoint [mm]", **{n: f"{n} [{u}]" for n, u in units.items()}}
    )
    found = identified(whisker, titled, transducer=TRANSDUCER, assume=False)
    assert found.periods.mu0 == pytest.approx(known.periods.mu0, nan_ok=True)


@pytest.mark.slow
def test_results_print(whisker, signals):
    assert "critical friction, mu_lock 0.47757141" in " ".join(repr(solve(whisker, 0.4)).split())
    assert repr(signals).startswith("801 steps, ")
    found = identified(whisker, signals.to_pandas(), transducer=TRANSDUCER)
    assert "mu0 = " in repr(found)


def test_a_transducer_needs_a_rod():
    bare = Whisker(theta=2.0, eta=0.85)
    with pytest.raises(ArgumentError, match="with a transducer, give modulus"):
        scan(bare, surfaces.constant(0.3), step=0.01, to=[0.1]).measured(SENSOR)


@pytest.mark.parametrize("step", [1e-12, "1e-400 m", 0, -1])
def test_impossible_steps_are_refused(whisker, step):
    with pytest.raises(ArgumentError, match="step"):
        scan(whisker, surfaces.constant(0.3), step=step, to=[0.1])


def test_a_mounting_is_read_with_units():
    whisker = Setup.read(
        theta=2.0,
        eta=0.85,
        modulus="210 GPa",
        diameter="0.8 mm",
        length="100 mm",
        clamp_angle="-2 deg",
        clamp_compliance="0.001 rad/(N*m)",
        curvature="3 m^-1",
        stage_angle="0.01 rad",
    ).whisker
    mounting = whisker.mounting
    assert mounting.clamp_angle == pytest.approx(np.radians(-2.0), abs=1e-15)
    assert mounting.clamp_compliance == pytest.approx(ROD.moment_unit / 1000, rel=1e-12)
    assert mounting.curvature == pytest.approx(0.3, rel=1e-12)
    assert mounting.stage_angle == 0.01
    yields = Setup.read(theta=2.0, eta=0.85, clamp_compliance=0.1, curvature=-0.2).whisker.mounting
    assert (yields.clamp_compliance, yields.curvature) == (0.1, -0.2)
    # An angle has a unit also where nothing else has one.
    assert Setup.read(theta=2.0, eta=0.85, clamp_angle="1 deg").whisker.mounting.clamp_angle > 0.017
