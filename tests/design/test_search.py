"""Design: against scans that are simulated and read back, other solvers, and random rods."""

import doctest
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from vibrissa import solve_curve, solve_onset, solve_state
from vibrissa.design import MATERIALS, DesignStatus, Requirements, design, read_requirements, search
from vibrissa.design.limits import GRAVITY, limits_of
from vibrissa.design.pairs import survey
from vibrissa.design.sizes import best_sizes, deviations, nearest_sizes
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Contact
from vibrissa.sensor import (
    PeriodStatus,
    Recording,
    Units,
    Whisker,
    identify,
    path,
    preset,
    respond,
    simulate,
    surfaces,
)

SENSOR = preset("nano17-si-12-0.12")
WIRE = MATERIALS["music-wire"]
PAPER = {"theta": "2", "eta": "0.85", "diameter": "5 mm", "length": "100 mm"}


def asked(**others):
    """Requirements to a rod of music wire."""
    usual = {"transducer": "nano17-si-12-0.12", "mu0": "0.2 to 0.4", "step": "50 um"}
    return read_requirements(**{"material": "music-wire", **usual, **others})


@pytest.fixture(scope="module")
def best(coarse):
    return design(asked())


@pytest.mark.slow
def test_what_is_promised_is_what_comes_out_of_scans_that_are_read_back(best):
    rod = best.rod
    whisker = Whisker(theta=best.theta, eta=best.eta, rod=rod)
    response, scale = whisker.pulled, whisker.units.channels
    for i in (0, -1):
        random = np.random.default_rng(i + 5)
        # As many patches as periods, so that onsets lie anywhere in a step.
        count, travel = 250, best.x0_slip[i] / rod.length
        values = best.mu0[i] + random.uniform(-0.004, 0.004, count)
        starts = response.curve.x1_init + (np.arange(count) - 0.5) * travel
        surface = surfaces.patches([0.0, *starts[1:]], values)
        truth = simulate(response, surface, path(50e-6 / rod.length, [0.97 * count * travel]))
        readings = SENSOR.measured(truth.reactions * scale, random) / scale
        line = np.arange(len(readings))
        recording = Recording(clamp=truth.clamp, readings=readings, line=line)
        periods = identify(whisker, recording, transducer=SENSOR, assume=False).periods
        ok = periods.status == PeriodStatus.SLIP
        error = (periods.mu0 - truth.mu0[periods.last])[ok]
        predicted = best.deviations.total[i]
        assert len(error) > 200
        # Four standard deviations of a root mean square of so many.
        assert np.sqrt(np.mean(error**2)) == pytest.approx(predicted, rel=4 / np.sqrt(2 * 200))
        assert np.sqrt(np.mean(periods.deviation[ok] ** 2)) == pytest.approx(predicted, rel=0.03)


@pytest.mark.parametrize(
    ("theta", "eta", "mu0"), [(1.0, 0.85, 0.4), (2.0, 0.85, 0.4), (3, 0.9, 0.3)]
)
def test_strain_is_that_of_an_independent_shape(theta, eta, mu0):
    frictions = np.array([0.1, mu0])
    pairs, _ = survey(np.array([float(theta)]), np.array([eta]), frictions, Contact.POINT)
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
    assert pairs.strain[0] == pytest.approx(max(strain), rel=1e-3)


def test_a_rod_that_is_given_is_checked_by_what_one_onset_says():
    result = design(asked(**PAPER))
    rod, onset = Rod(WIRE.modulus, 5e-3, 0.1), solve_onset(2, 0.4, 0.85, 0.0005)
    checks = {check.name: check for check in result.checks}
    assert result.status is DesignStatus.NONE
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
    assert checks["strain"].use > 8 and "strain" in result.active_constraints


@pytest.mark.parametrize("name", MATERIALS)
def test_the_rod_of_the_paper_yields_whatever_it_is_made_of(name):
    result = design(asked(**PAPER, material=name, safety=1.0))
    (strain,) = (check for check in result.checks if check.name == "strain")
    assert strain.use > 2.5
    assert result.status is DesignStatus.NONE and "strain" in result.message


def some_size(requirements, thick, long):
    """Diameter and length so far on the way, in logarithms, through their ranges."""
    ranges = (requirements.diameter, thick), (requirements.length, long)
    return [low * (high / low) ** part for (low, high), part in ranges]


def uses(requirements, pairs, diameter, length):
    """How much of each limit is used."""
    with np.errstate(divide="ignore"):
        return [
            (limit.value(diameter, length) / limit.bound) ** (1.0 if limit.upper else -1.0)
            for limit in limits_of(requirements, pairs)
        ]


UNIT = st.floats(0, 1)


@pytest.mark.slow
@given(UNIT, UNIT, UNIT)
def test_no_other_size_within_the_limits_measures_better(best, thick, long, near):
    r, pairs = best.requirements, best.pairs
    sizes = best_sizes(r, pairs)
    possible = np.isfinite(sizes.cost)
    pairs, sizes = pairs.take(possible), sizes.take(possible)
    diameter, length = sizes.diameter, sizes.length
    assert np.max(uses(r, pairs, diameter, length)) < 1 + 1e-5
    any_diameter, any_length = some_size(r, thick, long)
    # Rods near the best as well as anywhere.
    diameter = diameter**near * any_diameter ** (1 - near)
    length = length**near * any_length ** (1 - near)
    allowed = np.max(uses(r, pairs, diameter, length), axis=0) <= 1
    other = deviations(r, pairs, diameter, length).largest
    assert (other[allowed] >= sizes.cost[allowed] * (1 - 1e-4)).all()


@pytest.mark.slow
@settings(max_examples=20)
@given(UNIT, UNIT)
def test_no_other_size_violates_the_limits_less(best, thick, long):
    r, pairs = best.requirements, best.pairs.take(np.arange(0, 24, 3))
    nearest = nearest_sizes(r, pairs)
    least = np.max(uses(r, pairs, nearest.diameter, nearest.length), axis=0)
    violated = (0 < nearest.cost) & (nearest.cost < 50)
    assert least[violated] == pytest.approx(np.exp(nearest.cost[violated]), rel=1e-6)
    other = np.max(uses(r, pairs, *some_size(r, thick, long)), axis=0)
    assert (other >= np.exp(nearest.cost) * (1 - 1e-6)).all()


@pytest.mark.slow
def test_the_best_rod_is_limited_and_less_strict_limits_help(best):
    assert best.status is DesignStatus.FOUND and best.active_constraints
    assert best.message.endswith(", ".join(best.active_constraints))
    parts = best.deviations
    largest = np.sqrt(parts.by_step**2 + parts.by_reading**2).max()
    assert best.deviation == pytest.approx(largest, rel=1e-12)
    assert {"noise", "step"} <= set(best.relaxed)
    for deviation in best.relaxed.values():
        assert 0.4 * best.deviation < deviation <= best.deviation
    assert min(best.relaxed.values()) < 0.95 * best.deviation
    rod = {name: (getattr(best, name),) * 2 for name in PAPER}
    checked = design(replace(best.requirements, **rod))
    assert checked.status is DesignStatus.FOUND
    assert checked.deviation == pytest.approx(best.deviation)


def test_units_do_not_matter():
    size = {"diameter": "1 mm", "length": "150 mm"}
    one = design(asked(**PAPER | size))
    scale = Units(Rod(WIRE.modulus, 1e-3, 0.15)).channels
    other = design(
        Requirements.nondimensional(
            mu0=(0.2, 0.4),
            step=50e-6 / 0.15,
            noise=tuple(SENSOR.deviation / scale),
            range=tuple(SENSOR.limit / scale),
            yield_strain=WIRE.yield_strain * 150,
            theta=(2.0, 2.0),
            eta=(0.85, 0.85),
        )
    )
    assert other.rod is None and one.rod.length == pytest.approx(0.15)
    assert other.deviation == pytest.approx(one.deviation)
    uses = {check.name: check.use for check in one.checks}
    for check in other.checks:
        assert check.use == pytest.approx(uses[check.name]), check.name


def test_a_rod_that_lies_down_needs_contact_along_a_line():
    shape = {"theta": "3", "eta": "0.7", "length": "150 mm"}
    point = design(asked(**shape))
    assert point.status is DesignStatus.NONE and "touch" in point.active_constraints
    line = design(asked(**shape, contact="line"))
    assert "touch" not in {check.name for check in line.checks}


def test_what_locks_is_named():
    result = design(asked(**PAPER, mu0="0.3 to 0.6"))
    assert "lock" in result.active_constraints
    assert np.isnan(result.deviations.by_step[-1]) and np.isfinite(result.deviations.by_step[0])
    assert np.isfinite([check.value for check in result.checks if check.name == "strain"]).all()


@pytest.mark.filterwarnings("error")
def test_a_friction_too_small_for_any_period_is_no_error():
    shape = {"theta": "2", "eta": "0.85", "length": "100 mm"}
    result = design(asked(**shape, mu0="1e-50"))
    assert result.status is DesignStatus.NONE and "steps" in result.active_constraints


@pytest.mark.slow
def test_which_limit_leaves_nothing(coarse):
    result = design(replace(asked(), yield_strain=0.0005))
    assert result.status is DesignStatus.NONE
    assert re.search(r"without the limit .*strain", result.message)
    assert np.isfinite([result.theta, result.eta, result.diameter, result.length]).all()


def test_no_curve_is_said_so():
    result = design(asked(**PAPER | {"theta": "50", "eta": "0.05"}))
    assert result.status is DesignStatus.FAILED and "could be solved" in result.message


def test_any_limit_may_be_the_one_that_leaves_nothing():
    """Without the limit on the diameter nothing bounds it from above."""
    free = {"yield_strain": np.inf, "range": (np.inf,) * 3, "diameter": (1e-4, 1.1e-4)}
    result = design(replace(asked(theta="2", eta="0.85", length="100 mm"), **free))
    assert result.status is DesignStatus.NONE
    assert re.search(r"without the limit .*thickest", result.message)


def test_example_in_the_docstring():
    result = doctest.testmod(search)
    assert result.attempted > 0 and result.failed == 0
