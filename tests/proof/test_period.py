"""Proved onsets: closed forms, known digits, and claims that are refused."""

import re
from decimal import Decimal
from types import SimpleNamespace

import pytest
from flint import acb, arb, arb_mat
from typer.testing import CliRunner

from vibrissa import solve_onset
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, NotProvedError
from vibrissa.proof import Effort, decimals, onset, spelled
from vibrissa.proof.equilibrium import Equilibrium, Rod, equations, inclined, prove
from vibrissa.proof.krawczyk import examined

# Enough for these tests, and quicker.
QUICK = Effort(bits=96, order=24, steps=12)


def test_a_ball_around_zero_has_no_sign():
    assert spelled(arb("-1e-30", 1e-3)).startswith("0.000")


@pytest.fixture(scope="module")
def proved():
    return onset(2, 0.4, 0.85)


@pytest.mark.slow
def test_the_digits_are_those_of_another_proof(proved):
    """A prototype with another integrator (order 26, 32 steps) gave these."""
    known = arb("0.05283804279573990769499541", 1e-23)
    assert known.contains(proved.x0_slip)
    assert arb("0.41732949861176354190", 5e-21).contains(proved.init.offset)
    assert proved.bent_once
    assert proved.first is None  # not asked for


def modulus(eta):
    """Enclose the k with 2E/K − 1 = η, which falls with k, between two numbers."""
    low, high = arb(0), arb(1)
    for _ in range(70):
        middle = ((low + high) / 2).mid()
        low, high = (middle, high) if height(middle) > eta else (low, middle)
    assert height(low) > eta and height(high) < eta
    return low.union(high)


def height(k):
    m = acb(k * k)
    return 2 * (m.elliptic_e() / m.elliptic_k()).real - 1


@pytest.mark.parametrize("eta", ["0.85", "0.6"])
def test_closed_forms_of_a_cylinder(eta):
    with QUICK.spent():
        k = modulus(arb(eta))
        quarter = acb(k * k).elliptic_k().real
        near = [0.0, -2.6 - 4 * (0.85 - float(eta)), -1.2 - 2 * (0.85 - float(eta))]
        found = prove(Rod(theta=arb(1), eta=arb(eta), steps=12), inclined(arb(0)), near)
        for enclosure, closed in [
            (found.f, quarter**2),
            (found.offset, 2 * k / quarter),
            (found.load.m0, -2 * k * quarter),
        ]:
            assert enclosure.overlaps(closed)
            assert enclosure.rad() < 1e-18 and closed.rad() < 1e-18


@pytest.mark.slow
@pytest.mark.parametrize("theta, mu0, eta", [(1, 0.3, 0.85), (3, 0.4, 0.85), (5, 0.25, 0.7)])
def test_the_solver_is_right_to_a_few_units_in_the_last_place(theta, mu0, eta):
    found, solved = onset(theta, mu0, eta, effort=QUICK), solve_onset(theta, mu0, eta)
    assert abs(float(found.x0_slip) - solved.x0_slip) < 2e-14
    assert abs(float(found.slip.f) - solved.slip.f) < 1e-11
    assert abs(float(found.slip.phi1) - solved.slip.phi1) < 1e-12


@pytest.mark.slow
def test_another_order_other_steps_and_another_precision_agree(proved):
    other = onset(2, 0.4, 0.85, effort=Effort(bits=160, order=26, steps=12))
    for name, value in other.columns().items():
        assert value.overlaps(proved.columns()[name]) and value.rad() < 1e-16


def moved(equilibrium, by):
    """Claim that the equilibrium is within 1e-17 of another load."""
    with Effort().spent():
        rod = Rod(theta=arb(2), eta=arb("0.85"), steps=16)
        load = arb_mat([[(value + by).mid()] for value in equilibrium.load])
        system = equations(rod, inclined(arb("0.4")))
        values, _ = system(load)
        image, _ = examined(system, load, values, arb_mat([[1e-17]] * 3))
        return image


@pytest.mark.slow
def test_an_onset_moved_by_a_1e_15_is_refused(proved):
    assert moved(proved.slip, 0)[0, 0].overlaps(proved.slip.load.fx)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        moved(proved.slip, 1e-15)
    assert not proved.x0_slip.overlaps(proved.x0_slip + arb("1e-15"))


def test_a_second_mode_is_an_equilibrium_but_not_bent_once():
    with QUICK.spent():
        k = modulus(arb("0.85"))
        quarter = acb(k * k).elliptic_k().real
        rod = Rod(theta=arb(1), eta=arb("0.85"), steps=24)
        load = [0.0, -9 * quarter**2, -6 * k * quarter]
        second = prove(rod, inclined(arb(0)), [float(value) for value in load])
    assert second.f.overlaps(9 * quarter**2)
    assert not second.bent_once()


@pytest.mark.parametrize(("phi", "once"), [("0.1", True), ("0", False), ("-0.1", False)])
def test_a_moment_that_may_vanish_has_to_grow_for_certain(phi, once):
    box = SimpleNamespace(m=arb(0), phi=arb(phi))
    state = SimpleNamespace(load=(arb("0.5"), arb(0), arb(0)), passed=[box])
    assert Equilibrium.bent_once(state) is once


def test_a_start_far_away_proves_nothing():
    with QUICK.spent(), pytest.raises(NotProvedError):
        prove(Rod(theta=arb(2), eta=arb("0.85"), steps=12), inclined(arb(0)), [9.0, 9.0, 9.0])


def test_without_an_onset_there_is_nothing_to_prove():
    with pytest.raises(NotProvedError, match=r"mu_lock is 0\.477571"):
        onset(2, 0.5, 0.85)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((2, -0.1, 0.85), "mu0 must be positive"),
        ((0.5, 0.1, 0.85), "between 1 and"),
        ((2, 0.1, 1.5), "between 0 and 1"),
        (("two", 0.1, 0.85), "^theta must be a number, got 'two'$"),
        ((2, float("nan"), 0.85), "^mu0 must be a number, got nan$"),
        ((2, 0.1, "1e400"), "^eta must be smaller than 1e308, got '1e400'$"),
    ],
)
def test_arguments_out_of_range_are_named(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        onset(*arguments)


@pytest.mark.parametrize(
    "text", ["0.0528380427957399076949954123 +/- 8e-27", "-1234.5 +/- 3e-22", "0 +/- 1e-20", "2"]
)
def test_decimals_enclose(text):
    with Effort().spent():
        ball = arb(text)
        value, radius = decimals(ball)
        assert arb(str(value), arb(str(radius))).contains(ball)
        assert radius <= Decimal(str(float(ball.rad()))) * Decimal("1.2")


def test_balls_are_spelled_for_people():
    assert spelled(arb("0.25 +/- 3e-12")) == "0.2500000000000 ± 3.1E-12"
    assert spelled(arb(2)) == "2"


@pytest.mark.slow
def test_the_command_shows_enclosures(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: QUICK)
    result = CliRunner().invoke(app, "prove --theta 1 --mu0 0.04 --eta 0.85 --first".split())
    assert result.exit_code == 0, result.output
    shown = re.search(r"^x0_slip +(\S+) ± ", result.output, re.MULTILINE)
    assert float(shown[1]) == pytest.approx(solve_onset(1, 0.04, 0.85).x0_slip, abs=1e-14)
    assert "first onset on the path from there: proved" in result.output
    assert "bent once at alpha = 0, m < 0 along the rod: proved" in result.output
