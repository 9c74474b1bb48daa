"""Design: against scans that are simulated and read back, other solvers, and random rods."""

import csv
import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import reference
from vibrissa import solve_curve, solve_onset, solve_state
from vibrissa.sensor import design as designing
from vibrissa.sensor import friction
from vibrissa.sensor.cli import app
from vibrissa.sensor.design import Verdict, best_sizes, design, nearest_sizes
from vibrissa.sensor.identification import Found, Method, Recording, identify
from vibrissa.sensor.limits import GRAVITY, deviations, limits_of, survey
from vibrissa.sensor.materials import MATERIALS, material
from vibrissa.sensor.quantities import range_of
from vibrissa.sensor.requirements import Requirements, without_units
from vibrissa.sensor.response import respond
from vibrissa.sensor.scanning import path, scan
from vibrissa.sensor.transducer import preset
from vibrissa.status import Contact
from vibrissa.units import Rod

SENSOR = preset("nano17-si-12-0.12")
WIRE = material("music-wire")
ASKED = {
    "modulus": WIRE.modulus,
    "yield_strain": WIRE.yield_strain,
    "density": WIRE.density,
    "mu0": (0.2, 0.4),
    "step": 50e-6,
    "noise": SENSOR.deviation,
    "range": SENSOR.limit,
}
PAPER = {
    "theta": (2.0, 2.0),
    "eta": (0.85, 0.85),
    "diameter": (5e-3, 5e-3),
    "length": (0.1, 0.1),
}


@pytest.fixture(scope="module")
def coarse():
    """Searches on a coarser mesh: of a rod as good to some percent."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"TAPERS": 4, "HEIGHTS": 6, "ROUNDS": 3}.items():
            patch.setattr(designing, name, value)
        yield


@pytest.fixture(scope="module", params=[Method.FORCES, Method.MOMENT])
def best(coarse, request):
    return design(Requirements(**ASKED, method=request.param))


def whole(result, **changes):
    """The rod of a design, as one that is given."""
    rod = {name: (getattr(result, name),) * 2 for name in PAPER}
    return Requirements(**ASKED | rod | changes)


def test_what_is_promised_is_what_comes_out_of_scans_that_are_read_back(best):
    rod, response = best.rod, respond(best.theta, best.eta)
    scale = np.array([rod.force_unit, rod.force_unit, rod.moment_unit])
    for i in (0, -1):
        random = np.random.default_rng(i + 5)
        # As many patches as periods, so that onsets lie anywhere in a step.
        count, travel = 250, best.x0_slip[i] / rod.length
        values = best.mu0[i] + random.uniform(-0.004, 0.004, count)
        starts = response.curve.x1_init + (np.arange(count) - 0.5) * travel
        surface = friction.patches([0.0, *starts[1:]], values)
        truth = scan(response, surface, path(50e-6 / rod.length, [0.97 * count * travel]))
        reactions = np.stack([truth.fx, truth.fy, truth.m], axis=1) * scale
        readings = SENSOR.measured(reactions, random) / scale
        recording = Recording(truth.footpoint, readings, np.arange(len(readings)))
        method = best.requirements.method
        periods = identify(response, recording, np.array(SENSOR.deviation) / scale, method)
        ok = np.array([status is Found.SLIP for status in periods.status])
        error = (periods.mu0 - truth.mu0[periods.last])[ok]
        predicted = np.hypot(best.by_step[i], best.by_reading[i])
        assert len(error) > 200
        # Four standard deviations of a root mean square of so many.
        assert np.sqrt(np.mean(error**2)) == pytest.approx(predicted, rel=4 / np.sqrt(2 * 200))
        assert np.sqrt(np.mean(periods.deviation[ok] ** 2)) == pytest.approx(predicted, rel=0.03)


@pytest.mark.parametrize(
    ("theta", "eta", "mu0"), [(1.0, 0.85, 0.4), (2.0, 0.85, 0.4), (3, 0.9, 0.3)]
)
def test_strain_is_that_of_an_independent_shape(theta, eta, mu0):
    shapes, _ = survey(np.array([float(theta)]), np.array([eta]), (0.1, mu0), Contact.POINT)
    curve = solve_curve(theta, eta)
    r = np.linspace(0, 1, 2001)
    middle = 1 - 0.5 * (r[1:] + r[:-1])
    diameter = 1 - (1 - 1 / theta) * middle
    # Of a cylinder it is largest where sticking begins, of a cone where it ends.
    strain = []
    for x0, tan in ((0.0, 0.0), (float(curve.onset(mu0)), -mu0)):
        state = curve.state(x0)
        guess = float(state.phi1), -float(state.reaction_fy)
        phi1, p = reference.solve_inclination(theta, eta, tan, guess)
        phi = reference.integrated(theta, 1.0, phi1, p, tan * p, r)[2]
        strain.append((np.abs(np.diff(phi) / np.diff(r)) * diameter / 2).max())
    assert (strain[0] > strain[1]) == (theta == 1)
    assert shapes.strain[0] == pytest.approx(max(strain), rel=1e-3)


def test_a_rod_that_is_given_is_checked_by_what_one_onset_says():
    result = design(Requirements(**ASKED | PAPER))
    rod, onset = Rod(WIRE.modulus, 5e-3, 0.1), solve_onset(2, 0.4, 0.85, 0.0005)
    checks = {check.name: check for check in result.checks}
    assert result.verdict is Verdict.NONE
    assert checks["force_x"].value == pytest.approx(-onset.slip.reaction_fx * rod.force_unit)
    assert checks["force_y"].value == pytest.approx(-onset.slip.reaction_fy * rod.force_unit)
    assert checks["lock"].value == pytest.approx(onset.mu_lock)
    first = solve_onset(2, 0.2, 0.85, 0.0005)
    assert checks["steps"].value == pytest.approx(first.x0_slip / 0.0005)
    # The rod weighs 7/12 of a cylinder; the tip is pressed on least where sticking begins.
    start = solve_state(2, 0.85, respond(2, 0.85).curve.x1_init)
    weight = WIRE.density * GRAVITY * np.pi * 5e-3**2 * 0.1 * 7 / 48
    least = -start.reaction_fy * rod.force_unit
    assert checks["weight"].value == pytest.approx(weight / least)
    assert result.x0_slip[-1] == pytest.approx(onset.x0_slip * 0.1)
    assert {"diameter", "length", "thickest"}.isdisjoint(checks)
    # The example rod of the paper cannot be made of any of these.
    assert checks["strain"].use > 8 and "strain" in result.limited_by


@pytest.mark.parametrize("name", MATERIALS)
def test_the_rod_of_the_paper_yields_whatever_it_is_made_of(name):
    stuff = material(name)
    made = {"modulus": stuff.modulus, "yield_strain": stuff.yield_strain, "safety": 1.0}
    result = design(Requirements(**ASKED | PAPER | made))
    (strain,) = (check for check in result.checks if check.name == "strain")
    assert strain.use > 2.5
    assert result.verdict is Verdict.NONE and "strain" in result.message


def some_size(requirements, thick, long):
    """Diameter and length so far on the way, in logarithms, through their ranges."""
    ranges = (requirements.diameter, thick), (requirements.length, long)
    return [low * (high / low) ** part for (low, high), part in ranges]


def uses(requirements, shapes, diameter, length):
    """How much of each limit is used."""
    with np.errstate(divide="ignore"):
        return [
            (limit.value(diameter, length) / limit.bound) ** (1.0 if limit.upper else -1.0)
            for limit in limits_of(requirements, shapes)
        ]


UNIT = st.floats(0, 1)


@given(UNIT, UNIT, UNIT)
def test_no_other_size_within_the_limits_measures_better(best, thick, long, near):
    r, shapes = best.requirements, best.shapes
    found, diameter, length = best_sizes(r, shapes)
    shapes, found, diameter, length = (
        values.take(np.isfinite(found).nonzero()[0]) for values in (shapes, found, diameter, length)
    )
    assert np.max(uses(r, shapes, diameter, length)) < 1 + 1e-5
    any_diameter, any_length = some_size(r, thick, long)
    # Rods near the best as well as anywhere.
    diameter = diameter**near * any_diameter ** (1 - near)
    length = length**near * any_length ** (1 - near)
    allowed = np.max(uses(r, shapes, diameter, length), axis=0) <= 1
    other = np.hypot(*deviations(r, shapes, diameter, length)).max(axis=1)
    assert (other[allowed] >= found[allowed] * (1 - 1e-4)).all()


@settings(max_examples=20)
@given(UNIT, UNIT)
def test_no_other_size_exceeds_the_limits_less(best, thick, long):
    r, shapes = best.requirements, best.shapes.take(np.arange(0, 24, 3))
    excess, diameter, length = nearest_sizes(r, shapes)
    least = np.max(uses(r, shapes, diameter, length), axis=0)
    exceeded = (0 < excess) & (excess < 50)
    assert least[exceeded] == pytest.approx(np.exp(excess[exceeded]), rel=1e-6)
    other = np.max(uses(r, shapes, *some_size(r, thick, long)), axis=0)
    assert (other >= np.exp(excess) * (1 - 1e-6)).all()


def test_the_best_rod_is_limited_and_less_strict_limits_help(best):
    assert best.verdict is Verdict.FOUND and best.limited_by
    assert best.message.endswith(", ".join(best.limited_by))
    assert best.deviation == pytest.approx(np.hypot(best.by_step, best.by_reading).max())
    assert {"noise", "step"} <= set(best.helps)
    for deviation in best.helps.values():
        assert 0.4 * best.deviation < deviation <= best.deviation
    assert min(best.helps.values()) < 0.95 * best.deviation
    checked = design(whole(best, method=best.requirements.method))
    assert checked.verdict is Verdict.FOUND
    assert checked.deviation == pytest.approx(best.deviation)


def test_units_do_not_matter():
    size = {"diameter": (1e-3, 1e-3), "length": (0.15, 0.15)}
    one = design(Requirements(**ASKED | PAPER | size, method="moment"))
    rod = Rod(WIRE.modulus, 1e-3, 0.15)
    scale = np.array([rod.force_unit, rod.force_unit, rod.moment_unit])
    other = design(
        without_units(
            mu0=ASKED["mu0"],
            step=50e-6 / 0.15,
            noise=tuple(SENSOR.deviation / scale),
            range=tuple(SENSOR.limit / scale),
            yield_strain=WIRE.yield_strain * 150,
            theta=(2.0, 2.0),
            eta=(0.85, 0.85),
            method="moment",
        )
    )
    assert other.deviation == pytest.approx(one.deviation)
    uses = {check.name: check.use for check in one.checks}
    for check in other.checks:
        assert check.use == pytest.approx(uses[check.name]), check.name


def test_a_rod_that_lies_down_needs_contact_along_a_line():
    shape = {"theta": (3.0, 3.0), "eta": (0.7, 0.7), "length": (0.15, 0.15)}
    point = design(Requirements(**ASKED | shape))
    assert point.verdict is Verdict.NONE and "touch" in point.limited_by
    line = design(Requirements(**ASKED | shape, contact="line"))
    assert "touch" not in {check.name for check in line.checks}


def test_what_locks_is_named():
    result = design(Requirements(**ASKED | PAPER | {"mu0": (0.3, 0.6)}))
    assert "lock" in result.limited_by
    assert np.isnan(result.by_step[-1]) and np.isfinite(result.by_step[0])
    assert np.isfinite([check.value for check in result.checks if check.name == "strain"]).all()


def test_which_limit_leaves_nothing(coarse):
    soft = {"yield_strain": 0.0005}
    result = design(Requirements(**ASKED | soft))
    assert result.verdict is Verdict.NONE
    assert "without the limit on" in result.message and "strain" in result.message
    assert np.isfinite([result.theta, result.eta, result.diameter, result.length]).all()


def test_no_curve_is_said_so():
    result = design(Requirements(**ASKED | PAPER | {"eta": (0.05, 0.05)}))
    assert result.verdict is Verdict.FAILED and "could be solved" in result.message


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu0": (0.4, 0.2)}, "mu0 must be a range"),
        ({"mu0": (0.0, 0.2)}, "mu0 must be a range"),
        ({"theta": (0.5, 2.0)}, "theta must be a range"),
        ({"eta": (0.5, 1.0)}, "eta must be a range"),
        ({"eta": (0.5, float("nan"))}, "eta must be a range"),
        ({"step": 0.0}, "step must be positive"),
        ({"noise": (0.0, 1.0, 1.0)}, "noise must be three positive"),
        ({"noise": (1.0, 1.0, float("nan"))}, "noise must be three positive"),
        ({"noise": (1.0, 1.0, float("inf"))}, "noise must be finite"),
        ({"lock_factor": float("inf")}, "lock_factor must be at least 1"),
        ({"steps": float("inf")}, "steps must be positive and finite"),
        ({"tip": -1e-4}, "tip must not be negative"),
        ({"safety": 0.5}, "at least 1"),
        ({"density": -1.0}, "density must be positive"),
        ({"method": "guess"}, "guess"),
    ],
)
def test_impossible_requirements_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Requirements(**ASKED | change)


def test_materials_say_where_their_figures_stand():
    for stuff in MATERIALS.values():
        assert len(stuff.source) > 20 and 1e-4 < stuff.yield_strain < 0.05
        assert 1e9 < stuff.modulus < 3e11 and 500 < stuff.density < 1e4
    with pytest.raises(ValueError, match="music-wire"):
        material("unobtainium")


def test_ranges():
    assert range_of("0.2 to 0.4") == ("0.2", "0.4")
    assert range_of("20 to 200 mm") == ("20 mm", "200 mm")
    assert range_of("20 um to 2 mm") == ("20 um", "2 mm")
    assert range_of(" 5 mm") == ("5 mm", "5 mm")


def run(*arguments):
    return CliRunner().invoke(app, ["design", *(str(argument) for argument in arguments)])


NANO = ["--transducer", "nano17-si-12-0.12", "--step", "50 um", "--mu0", "0.2 to 0.4"]
SHAPE = ["--theta", "2", "--eta", "0.85"]


def test_the_rod_of_the_paper_on_the_command_line(tmp_path):
    out = tmp_path / "d.csv"
    size = ["--diameter", "5 mm", "--length", "100 mm"]
    result = run("--material", "steel-s235", *NANO, *SHAPE, *size, "-o", out)
    assert result.exit_code == 1
    assert result.output.startswith("this rod cannot be used: it exceeds moment_z (259 times")
    assert re.search(r"strain +0\.0363 +< 0\.000746 +48\.6 times", result.output)
    (row,) = csv.DictReader(out.open())
    assert row["verdict"] == "none" and "strain" in row["limited_by"]
    assert float(row["force_y_value [N]"]) == pytest.approx(1472, rel=1e-3)


def test_a_search_on_the_command_line(coarse, tmp_path):
    out, picture = tmp_path / "d.parquet", tmp_path / "d.png"
    where = ["--length", "50 to 150 mm", "-o", out, "--picture", picture]
    result = run("--material", "music-wire", *NANO, "--theta", "2", *where)
    assert result.exit_code == 0, result.output
    table = pq.read_table(out)
    (row,) = table.to_pylist()
    assert row["verdict"] == "found" and row["length"] <= 0.15 * (1 + 1e-6)
    assert table.schema.field("diameter").metadata[b"unit"] == b"m"
    assert row["relaxed_step"] < row["deviation"]
    assert picture.read_bytes().startswith(b"\x89PNG")
    for name in row["limited_by"].split():
        assert name in result.output


def test_without_units_on_the_command_line():
    own = ["--step", "0.0005", "--mu0", "0.2 to 0.4", "--noise", "0.003, 0.003, 0.0002"]
    result = run(*own, *SHAPE, "--yield-strain", "1.2")
    assert result.exit_code == 0, result.output
    assert "diameter" not in result.output and " L" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*NANO, "--material", "cheese"], "material must be one of"),
        ([*NANO, "--material", "music-wire", "--modulus", "1 GPa"], "not both"),
        ([*NANO, "--modulus", "1 GPa"], "needs a yield strain"),
        ([*NANO, "--material", "music-wire", "--noise", "1 N, 1 N, 1 N*m"], "not both"),
        ([*NANO[2:], "--material", "music-wire"], "give a transducer or the noise"),
        ([*NANO[2:], "--material", "music-wire", "--noise", "1 N"], "three values"),
        ([*NANO, *SHAPE], "cannot be used without the material"),
        ([*NANO, "--material", "music-wire", "--eta", "85 mm"], "the rod is not given"),
        ([*NANO, "--material", "music-wire", "--length", "3"], "length must be a length"),
        ([*NANO, "--material", "music-wire", "--theta", "0.5"], "theta must be a range"),
        ([*NANO, "--material", "music-wire", "--theta", "much"], "theta must be a number"),
        ([*NANO, "--material", "music-wire", "--tip", "1 to 2 mm"], "tip must be a length"),
        ([*NANO, "--material", "music-wire", "-o", "d.txt"], "ending must be"),
        ([*NANO, "--material", "music-wire", *SHAPE[:3], "0.05"], "could be solved"),
    ],
)
def test_mistakes_get_one_line(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert result.output.startswith("vibrissa: ") and result.output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_help_has_examples():
    assert "vibrissa design --material" in run("--help").output.replace("\n", " ")


def test_the_documentation_has_every_material_as_it_is():
    page = (Path(__file__).parents[1] / "docs/sensor.md").read_text(encoding="utf-8")
    for name, stuff in MATERIALS.items():
        row = f"| `{name}` | {stuff.modulus / 1e9:.4g} | {stuff.yield_strain:.2%} | {stuff.name}. "
        assert row + stuff.source in page
