"""Scans as tables of steps and of periods: the same numbers as those of commands and functions."""

import numpy as np
import pyarrow as pa
import pytest
from typer.testing import CliRunner

import made_tables
from vibrissa import Mounting, sensor, solve_curve, stick_slip
from vibrissa.cli.app import app
from vibrissa.computing.scans import ScanTables, computed_scans
from vibrissa.computing.surfaces import surface_of, texture_of
from vibrissa.outcomes import Contact
from vibrissa.quantities import series
from vibrissa.scanning import surfaces, textures
from vibrissa.sensor import Whisker

ROD = {"theta": (2.0,), "eta": (0.85,), "dx0": (0.001,), **made_tables.IDEAL}
PLANE = {"surface": "plane", "mu0": 0.3}
STRIPES = {"surface": "stripes", "patches": [[0.0, 0.25], [0.5, 0.4]]}


def law_of(law, ratio=None, zeta=None):
    """A slip law of a study file: with the values that bear on it."""
    values = {"law": law, "kinetic_ratio": ratio, "damping": zeta}
    return {name: value for name, value in values.items() if value is not None}


def computed(
    surface=PLANE, law=("free",), shapes=False, each_step=True, contact="point", rod=None, **end
):
    end = {"to": None, "cycles": None} | end
    (found,) = computed_scans(
        scan_name="s",
        axes=ROD | (rod or {}),
        surfaces=[surface],
        laws=[law_of(*law)],
        shapes=shapes,
        study="a",
        **end,
        solver=made_tables.SOLVER._replace(contact=Contact(contact)),
        each_step=each_step,
    )
    return found


def columns(table, *names):
    return [table.column(name).to_numpy() for name in names]


# Columns of the command `scan`, and those of a study.
COLUMNS = {
    "footpoint": "footpoint",
    "contact": "x1",
    "mu0": "mu0_tip",
    "force_x": "reaction_fx",
    "force_y": "reaction_fy",
    "moment_z": "reaction_m",
}


def commanded(path, law, *options):
    """The columns that the command `scan` writes."""
    told = "scan --theta 2 --eta 0.85 --step 0.001".split()
    for name, value in law_of(*law).items():
        told += [f"--{name.replace('_', '-')}", str(value)]
    result = CliRunner().invoke(app, [*told, *options, "-o", str(path)])
    assert result.exit_code == 0, result.output
    return series.read(path, list(COLUMNS)).columns


@pytest.fixture(scope="module")
def there_and_back():
    return computed(STRIPES, ("energy", 0.6), to=[0.3, 0.1])


def test_a_scan_there_and_back_is_that_of_the_command_bit_for_bit(there_and_back, tmp_path):
    patches = ["--patches", "0: 0.25, 0.5: 0.4", "--to", "0.3", "--to", "0.1"]
    signals = commanded(tmp_path / "scan.csv", ("energy", 0.6), *patches)
    for ours, theirs in COLUMNS.items():
        assert (signals[ours] == there_and_back.steps.column(theirs).to_numpy()).all(), ours


@pytest.mark.slow
@pytest.mark.parametrize(
    "law", [("free",), ("kinetic", 0.7), ("energy", 0.6), ("damped", 0.7, 0.1)]
)
def test_study_command_and_python_scan_a_profile_alike_bit_for_bit(law, tmp_path):
    profile = tmp_path / "friction.csv"
    profile.write_text("x, mu0\n0.4, 0.3\n0.6, 0.35\n0.7, 0.25\n")
    found = computed({"surface": "measured", "profile": str(profile)}, law, to=[0.15])
    assert "slip" in found.periods.column("ends_by").to_pylist()
    signals = commanded(tmp_path / "scan.csv", law, "--profile", str(profile), "--to", "0.15")
    for ours, theirs in COLUMNS.items():
        assert (signals[ours] == found.steps.column(theirs).to_numpy()).all(), ours
    surface = surfaces.profile([0.4, 0.6, 0.7], [0.3, 0.35, 0.25])
    whisker = Whisker(theta=2.0, eta=0.85)
    scan = sensor.scan(whisker, surface, step=0.001, to=0.15, **law_of(*law))
    x1, *loads = columns(found.steps, "x1", "reaction_fx", "reaction_fy", "reaction_m")
    assert (scan.truth.contact == x1).all()
    for place, load in enumerate(loads):
        assert (scan.readings[:, place] == load).all()
    onset, released = columns(found.periods, "footpoint_onset", "released")
    assert np.array_equal(scan.truth.periods.onset, onset, equal_nan=True)
    assert np.array_equal(scan.truth.periods.released, released, equal_nan=True)


def test_a_scan_of_a_study_is_that_of_python_bit_for_bit(there_and_back):
    surface = surfaces.patches([0.0, 0.5], [0.25, 0.4])
    whisker = Whisker(theta=2.0, eta=0.85)
    signals = sensor.scan(
        whisker, surface, step=0.001, to=[0.3, 0.1], law="energy", kinetic_ratio=0.6
    )
    x1, fx = columns(there_and_back.steps, "x1", "reaction_fx")
    assert (signals.truth.contact == x1).all() and (signals.readings[:, 0] == fx).all()
    periods = signals.truth.periods
    onset, released = columns(there_and_back.periods, "footpoint_onset", "released")
    assert np.array_equal(periods.onset, onset, equal_nan=True)
    assert np.array_equal(periods.released, released, equal_nan=True)


@pytest.mark.parametrize("law", [("free",), ("kinetic", 0.7), ("damped", 0.7, 0.1)])
def test_cycles_of_a_study_are_those_of_python_bit_for_bit(law):
    found = computed(law=law, cycles=3, shapes=True)
    scan = stick_slip(solve_curve(2.0, 0.85), 0.3, 0.001, 3, **law_of(*law))
    assert (found.steps.column("x1").to_numpy() == scan.contact).all()
    assert (np.vstack(found.steps.column("shape_x").to_pylist()) == scan.shapes().x).all()
    assert len(found.periods) == 3 and set(found.periods.column("ends_by").to_pylist()) == {"slip"}
    for name, value in {"kinetic_ratio": None, "damping": None, **law_of(*law)}.items():
        assert found.periods.column(name).to_pylist() == [value] * 3


def test_shapes_are_empty_where_nobody_asks_for_them():
    without, kept = computed(cycles=1), computed(cycles=1, shapes=True)
    assert set(map(len, without.steps.column("shape_x").to_pylist())) == {0}
    assert without.steps.column("residual").null_count == len(without.steps)
    assert kept.steps.column("residual").null_count == 0
    others = [name for name in kept.steps.schema.names if name[:5] not in ("shape", "resid")]
    assert without.steps.select(others) == kept.steps.select(others)


def test_the_last_step_alone_is_that_of_all_steps(there_and_back):
    last = computed(STRIPES, ("energy", 0.6), to=[0.3, 0.1], each_step=False)
    assert last.steps == there_and_back.steps.slice(len(there_and_back.steps) - 1)
    assert last.periods == there_and_back.periods


def test_steps_and_periods_tell_the_same(there_and_back):
    steps, periods = (table.to_pandas() for table in there_and_back)
    slips = steps[steps["phase"] == "slip"]
    ended = periods[periods["ends_by"] == "slip"]
    assert (ended["footpoint_slip"].to_numpy() == slips["footpoint"].to_numpy()).all()
    assert (ended["x1_rest"].to_numpy() == slips["x1"].to_numpy()).all()
    assert (ended["reaction_m_rest"] - slips["reaction_m"].to_numpy()).abs().max() < 1e-14
    assert ended["released"].to_numpy() == pytest.approx(ended["dissipated"].to_numpy(), abs=1e-9)
    assert (periods["steps"] + 1).sum() == len(steps)
    straight = (periods["footpoint_onset"] - periods["footpoint_begin"]).abs()
    # The clamp turns in one of the periods, whose way is longer.
    longer = periods["travel"] > straight + 1e-12
    assert longer.sum() == 1 and (periods["travel"] > straight - 1e-12)[:-1].all()
    assert periods["ends_by"].iloc[-1] == "path"
    assert periods["footpoint_onset"].isna().tolist() == [False] * len(ended) + [True]


def test_a_scan_without_result_is_a_row_in_each_table():
    profile = {"surface": "short", "mean": 0.3, "deviation": 0.05, "correlation": 0.02, "seed": 1}
    fine = computed(profile, to=[0.05])
    assert fine.steps.column("mu0").null_count == len(fine.steps)
    assert set(fine.periods.column("seed").to_pylist()) == {1}
    oblique = computed(rod={"stage_angle": (0.3,), "dx0": (3.0,)}, to=[6.0])
    assert isinstance(oblique, ScanTables)
    for table in oblique:
        (row,) = table.to_pylist()
        assert row["status"] == "out_of_reach" and "shorten the path" in row["message"]


def test_a_tip_that_leaves_its_surface_tells_where(tmp_path):
    path = tmp_path / "friction.csv"
    path.write_text("x,mu0\n0.3,0.3\n0.5,0.4\n0.55,0.4\n")
    measured = {"surface": "measured", "profile": str(path), "content": "1"}
    assert surface_of(measured)(0.4) == pytest.approx(0.35)
    found = computed(measured, to=[0.3])
    whole = computed({"surface": "plane", "mu0": 0.3}, to=[0.001])
    assert found.steps.column("x1")[0] == whole.steps.column("x1")[0]
    for table in found:
        assert set(table.column("status").to_pylist()) == {"slip"}
        assert all(
            "known from x = 0.3 L to 0.55 L" in text for text in table["message"].to_pylist()
        )
    *slips, last = found.periods.to_pylist()
    assert len(slips) > 1 and {row["ends_by"] for row in slips} == {"slip"}
    assert last["ends_by"] == "unknown" and last["x1_rest"] is None
    assert last["apparent_friction"] == pytest.approx(last["mu0_tip"], abs=1e-9)
    # The steps end before the one in which the tip leaves the surface.
    assert found.steps.column("footpoint")[-1].as_py() == last["footpoint_last"]
    assert last["x1"] < 0.55 < last["x1"] + last["x0_onset"]
    path.write_text("x,mu0\n0.6,0.3\n0.9,0.4\n")
    (row,) = computed(measured, to=[0.3]).steps.to_pylist()
    assert row["status"] == "failed" and "known from x = 0.6 L to 0.9 L" in row["message"]


@pytest.mark.slow
def test_a_scan_over_heights_is_that_of_python_bit_for_bit():
    """Two textures in one scan, lay, and a ball that bridges grooves."""
    heights = {"wave_amplitude": 2e-4, "wave_wavelength": 0.02, "wave_phase": 1.0, "lay": 0.6}
    heights |= {"grooves_width": 1e-3, "grooves_depth": 2e-4, "grooves_pitch": 0.01}
    heights |= {"grooves_wall": 1.2, "tip_radius": 2e-3}
    steps, periods = computed({"surface": "s", "mu0": 0.3} | heights, to=[0.1])
    wave = textures.wave(2e-4, 0.02, 1.0) + textures.grooves(1e-3, 2e-4, 0.01, 1.2)
    surface = surfaces.constant(0.3).with_texture(wave.with_lay(0.6))
    whisker = Whisker(theta=2.0, eta=0.85)
    truth = sensor.scan(whisker, surface, step=0.001, to=0.1, tip_radius=2e-3).truth
    assert (truth.contact == steps.column("x1").to_numpy()).all()
    assert (truth.height == steps.column("height").to_numpy()).all()
    assert (truth.inclination == steps.column("inclination").to_numpy()).all()
    (row, *_) = [one for one in periods.to_pylist() if one["ends_by"] == "slip"]
    both = np.tan(np.arctan(0.3) - row["inclination"])
    assert row["apparent_friction"] == pytest.approx(both, abs=1e-9)
    assert row["height"] == truth.height[1] and row["tip_radius"] == 2e-3 and row["lay"] == 0.6


def test_measured_heights_and_random_ones_are_added(tmp_path):
    path = tmp_path / "heights.csv"
    path.write_text("x,height\n0,0\n1,0.001\n")
    heights = {"heights": str(path), "rough_deviation": 1e-5, "rough_correlation": 0.01}
    texture = texture_of(heights | {"rough_seed": 3})
    expected = 5e-4 + textures.rough(1e-5, 0.01, 3).height(np.array([0.5]))
    assert texture.height(np.array([0.5])) == pytest.approx(expected)
    assert texture.stop == 1.0


@pytest.mark.slow
def test_mountings_and_line_contact_are_as_in_python():
    mounted = {"clamp_angle": (0.05,), "stage_angle": (0.02,)}
    found = computed(rod=mounted, cycles=2)
    curve = solve_curve(2.0, 0.85, mounting=Mounting(clamp_angle=0.05, stage_angle=0.02))
    assert (found.steps.column("x1").to_numpy() == stick_slip(curve, 0.3, 0.001, 2).contact).all()
    line = computed(rod={"theta": (3.0,), "eta": (0.7,)}, contact="line", cycles=2)
    assert (line.steps.column("s_c").to_numpy() < 1.0).any()


def test_a_rod_that_buckles_is_dragged_on():
    rod = {"theta": (4.0,), "eta": (0.6,), "dx0": (0.004,)}
    found = computed({"surface": "plane", "mu0": 0.9}, cycles=2, rod=rod)
    assert set(found.periods.column("side").to_pylist()) == {"behind"}
    travel, slip = columns(found.periods, "travel", "slip_length")
    assert travel[0] > 1.0 > 0.1 > travel[1] and (slip > 0.0).all()
    assert pa.compute.all(pa.compute.equal(found.steps.column("status"), "lock")).as_py()


def test_a_job_solves_a_rod_once_for_its_scans_in_several_steps(capsys):
    rods = {"dx0": (0.01, 0.02), "clamp_compliance": (0.0, 0.1)}
    scans = computed_scans(
        scan_name="s",
        axes=ROD | rods,
        surfaces=[PLANE],
        laws=[law_of("free")],
        to=(0.04,),
        cycles=None,
        shapes=False,
        study="a",
        solver=made_tables.SOLVER,
    )
    assert len(list(scans)) == 4
    assert capsys.readouterr().out.count("residual") == 2
