"""Design: against recordings that are simulated and read, other solvers, and other rods."""

import re

import numpy as np
import pytest

import reference
from responses import respond
from vibrissa import Mounting, solve_curve, solve_onset, solve_state
from vibrissa.design import MATERIALS, DesignStatus, Requirements, design, pairs
from vibrissa.design.candidate import GRAVITY
from vibrissa.design.pairs import survey
from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Contact
from vibrissa.scanning import surfaces
from vibrissa.sensor import identify, preset, scan
from vibrissa.sensor.tolerances import TOLERABLE
from vibrissa.sticking.curve import failed_curve

SENSOR = preset("nano17-si-12-0.12")
WIRE = MATERIALS["music-wire"]
PAPER = {"theta": "2", "eta": "0.85", "diameter": "5 mm", "length": "100 mm"}
GOOD = {"theta": "1.5", "eta": "0.874", "diameter": "1.2 mm", "length": "200 mm"}
FEW = {"theta": "1, 1.5, 2", "eta": "0.85, 0.87, 0.9", "length": "100 mm, 150 mm, 200 mm"}


def asked(**others):
    """Requirements for a rod of music wire."""
    usual = {"transducer": "nano17-si-12-0.12", "mu0": "0.2 to 0.4", "step": "50 um"}
    return Requirements.read(**{"material": "music-wire", **usual, **others})


def checks_of(found):
    return {check.name: check for check in found.best.checks}


@pytest.fixture(scope="module")
def best():
    return design(asked(**FEW))


@pytest.mark.slow
def test_the_best_of_all_is_chosen_and_each_meets_all_constraints(best):
    assert best.status is DesignStatus.FOUND and max(c.use for c in best.best.checks) <= 1.0
    count = int(re.search(r"the best of (\d+) rods", best.message)[1])
    assert count > 10
    others = [
        design(
            asked(**FEW | {"theta": str(theta), "diameter": f"{d} mm", "length": f"{length} mm"})
        )
        for theta, d, length in ((1, 1, 150), (1.5, 1, 200), (1.5, 1.2, 150), (2, 1, 200))
    ]
    found = [other for other in others if other.status is DesignStatus.FOUND]
    assert found and all(other.best.largest >= best.best.largest for other in found)
    assert best.rods[0].largest == best.best.largest and len(best.rods) == count
    base, tip = re.search(r"base ([\d.]+) mm, tip ([\d.]+) mm", repr(best)).groups()
    assert float(base) / float(tip) == pytest.approx(best.best.theta, rel=1e-3)
    measured_first = repr(best).partition("measure first")[2].splitlines()[1]
    assert measured_first.split()[0] == best.best.parts()[0].name


@pytest.mark.slow
def test_the_best_of_each_taper_is_told_with_what_it_costs(best):
    by_taper = {other.theta: other for other in best.alternatives}
    assert by_taper[best.best.theta].largest == best.best.largest
    cylinder = by_taper[1.0]
    alone = design(asked(**FEW | {"theta": "1"}))
    assert (cylinder.diameter, cylinder.length) == (alone.best.diameter, alone.best.length)
    assert cylinder.largest == pytest.approx(alone.best.largest)
    more = f"{cylinder.largest / best.best.largest - 1.0:.0%} more"
    (line,) = (line for line in repr(best).splitlines() if line.startswith("a cylinder"))
    assert line.endswith(more)
    assert "cylinder (theta 1)" in repr(alone)


@pytest.mark.slow
def test_a_rod_at_its_bound_meets_the_constraint():
    use = checks_of(design(asked(**GOOD)))["strain"].use
    found = design(asked(**GOOD, safety=1.5 / use))
    assert checks_of(found)["strain"].use == pytest.approx(1.0, abs=1e-12)
    assert found.status is DesignStatus.FOUND and "strain" in found.active_constraints
    beyond = design(asked(**GOOD, safety=1.5 / use * (1.0 + 1e-6)))
    assert beyond.status is DesignStatus.NONE and beyond.active_constraints == ["strain"]
    assert "violates the constraints strain (by a factor of 1)" in beyond.message


@pytest.mark.slow
def test_the_transducer_keeps_a_margin():
    used = {load: checks_of(design(asked(**GOOD, load=load)))["moment_z"] for load in (0.45, 0.9)}
    assert used[0.45].value == used[0.9].value and used[0.9].bound == 0.9 * SENSOR.limit[2]
    assert used[0.45].use == pytest.approx(2.0 * used[0.9].use)
    assert design(asked(**GOOD, load=0.45)).status is DesignStatus.NONE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mu0", "stated"),
    [
        pytest.param(0.2, {"tolerances": {"surface_slope": "exact"}}, marks=pytest.mark.nightly),
        (0.4, {"tolerances": {"surface_slope": "exact"}}),
        (0.3, {"assume": False, "tolerances": {"stage_scale": "5 %"}}),
        pytest.param(
            *(0.3, {"assume": False, "tolerances": {"stage_angle": "2 deg"}}),
            marks=pytest.mark.nightly,
        ),
        pytest.param(
            *(0.3, {"assume": False, "tolerances": {"length": "2 %"}}), marks=pytest.mark.nightly
        ),
    ],
)
def test_the_uncertainty_is_what_identify_states_of_a_recording(mu0, stated):
    found = design(asked(**GOOD, mu0=mu0, **stated))
    setup, whisker = found.best.setup, found.best.whisker
    to = 30.5 * float(whisker.curve.onset(mu0))
    signals = scan(whisker, surfaces.constant(mu0), step="50 um", to=[to]).measured(SENSOR)
    periods = identify(setup, signals.to_pandas()).periods
    slips = periods.status == "slip"
    assert slips.sum() >= 29
    predicted = found.best
    assert periods.common[slips].mean() == pytest.approx(predicted.by_tolerances[0], rel=0.1)
    stated = np.sqrt(np.mean(periods.deviation[slips] ** 2))
    assert stated == pytest.approx(predicted.whole[0], rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "unit"),
    [("length", ""), ("transducer_angle", "rad"), ("surface_slope", "rad"), ("crosstalk", "")],
)
def test_half_a_tolerance_brings_what_was_promised(name, unit):
    found = design(asked(**GOOD))
    part = {one.name: one for one in found.best.parts()}[name]
    assert not part.stated
    half = design(asked(**GOOD, tolerances={name: f"{part.size / 2.0} {unit}"}))
    worst = int(np.argmax(found.best.whole))
    fell = 1.0 - half.best.whole[worst] / found.best.whole[worst]
    assert part.halved == pytest.approx(fell, rel=0.02) and part.halved > 0.0
    assert {one.name: one.stated for one in half.best.parts()}[name]
    assert [one.halved for one in found.best.parts()] == sorted(
        (one.halved for one in found.best.parts()), reverse=True
    )


@pytest.mark.slow
def test_without_tolerances_only_noise_and_step_count():
    found = design(asked(**GOOD, assume=False))
    assert (found.best.by_tolerances == 0.0).all() and "measure first" not in repr(found)
    slope = float(respond(1.5, 0.874).demand_slope(solve_curve(1.5, 0.874).onset(0.2)))
    assert found.best.by_step[0] == pytest.approx(slope * 50e-6 / 0.2 / np.sqrt(12.0))
    noisy = design(asked(**GOOD, assume=False, step="100 um"))
    assert noisy.best.by_step == pytest.approx(2.0 * found.best.by_step)
    assert noisy.best.by_reading == pytest.approx(np.sqrt(2) * found.best.by_reading)


@pytest.mark.parametrize(
    ("theta", "eta", "mu0"), [(1.0, 0.85, 0.4), (2.0, 0.85, 0.4), (3, 0.9, 0.3)]
)
def test_strain_is_that_of_an_independent_shape(theta, eta, mu0):
    frictions = np.array([0.1, mu0])
    (pair,) = survey(np.array([float(theta)]), np.array([eta]), frictions, Contact.POINT)
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
    assert pair.stress == pytest.approx(max(strain), rel=1e-3)


def test_a_rod_that_is_given_is_checked_by_what_one_onset_says():
    result = design(asked(**PAPER))
    rod, onset = Rod(WIRE.modulus, 5e-3, 0.1), solve_onset(2, 0.4, 0.85, 0.0005)
    checks = checks_of(result)
    assert result.status is DesignStatus.NONE and "this rod cannot be used" in result.message
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
    assert result.best.x0_slip[-1] == pytest.approx(onset.x0_slip * 0.1)


def test_the_rod_of_the_paper_yields_even_if_it_is_made_of_the_most_elastic_material():
    name = max(MATERIALS, key=lambda one: MATERIALS[one].yield_strain)
    result = design(asked(**PAPER, material=name, safety=1.0))
    assert checks_of(result)["strain"].use > 2.5
    assert result.status is DesignStatus.NONE and "strain" in result.message


@pytest.mark.slow
def test_a_rod_that_lies_down_needs_contact_along_a_line():
    shape = {"theta": "3", "eta": "0.7", "diameter": "1 mm", "length": "150 mm"}
    point = design(asked(**shape))
    assert point.status is DesignStatus.NONE and "touch" in point.active_constraints
    assert "touch" not in checks_of(design(asked(**shape, contact="line")))


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "eta"), [(3, 0.801), (6, 0.921)])
def test_a_rod_that_touches_within_the_tolerance_of_its_curvature_is_no_choice(theta, eta):
    straight = solve_curve(theta, eta)
    assert not straight.x0_touch < straight.onset(0.3)
    bent = solve_curve(theta, eta, mounting=Mounting(curvature=TOLERABLE["curvature"].size))
    assert bent.x0_touch < bent.onset(0.3)
    shape = {"theta": str(theta), "eta": str(eta), "diameter": "0.5 mm", "length": "150 mm"}
    assert "touch" in design(asked(**shape, mu0="0.3")).active_constraints


def test_what_locks_is_named():
    result = design(asked(**PAPER, mu0="0.3 to 0.6"))
    assert "lock" in result.active_constraints and "the tip locks" in repr(result)
    assert np.isnan(result.best.whole[-1]) and np.isfinite(result.best.by_step[0])
    assert np.isfinite(checks_of(result)["strain"].value)


def test_the_radius_of_a_tip_is_refused():
    with pytest.raises(ArgumentError, match="leave out the tolerance of tip_radius"):
        asked(**PAPER, tolerances={"tip_radius": "0.1 mm"})


@pytest.mark.filterwarnings("error")
def test_a_friction_too_small_for_any_period_is_no_error():
    result = design(asked(**PAPER, mu0="1e-50"))
    assert result.status is DesignStatus.NONE and "steps" in result.active_constraints


@pytest.mark.slow
def test_which_constraint_leaves_nothing():
    weak = {"material": None, "modulus": "200 GPa", "yield_strain": 0.0005}
    result = design(asked(**FEW, **weak))
    assert result.status is DesignStatus.NONE
    assert re.search(r"dropping .*strain.* would allow a rod", result.message)
    assert np.isfinite(
        [result.best.theta, result.best.eta, result.best.diameter, result.best.length]
    ).all()


def test_no_curve_is_said_so(monkeypatch):
    failed = failed_curve(theta=2.0, eta=0.85, method="collocation", message="no luck")
    monkeypatch.setattr(pairs, "solve_curves", lambda theta, *_: [failed] * len(theta))
    with pytest.raises(NoResponseError, match=r"no rod of the .* could be solved; .* one: no luck"):
        design(asked(**PAPER))
