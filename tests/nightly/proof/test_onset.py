"""Proved onsets: closed forms, known digits, and claims that are refused."""

from decimal import Decimal
from types import SimpleNamespace

import pytest
from flint import acb, arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.digits import decimals
from validation.proof.equilibrium import Equilibrium, Rod, equations, inclined, prove
from validation.proof.flow import Effort
from validation.proof.krawczyk import krawczyk
from validation.proof.starting import ball, prove_at, rod_of
from vibrissa import solve_curve

THETA, ETA, MU0 = Decimal(2), Decimal("0.85"), Decimal("0.4")


def onset(theta, eta, mu0, effort):
    """States α = 0 and at the onset of slip, and the displacement between them."""
    curve = solve_curve(float(theta), float(eta))
    with effort.spent():
        rod = rod_of(theta, eta, effort)
        init = prove_at(rod, inclined(arb(0)), curve, 0.0)
        slip = prove_at(rod, inclined(ball(mu0)), curve, float(curve.onset(float(mu0))))
        return SimpleNamespace(init=init, slip=slip, x0_slip=init.offset - slip.offset)


@pytest.fixture(scope="module")
def proved():
    return onset(THETA, ETA, MU0, Effort())


def test_the_digits_are_those_of_another_proof(proved):
    """A prototype with another integrator (order 26, 32 steps) gave these."""
    assert arb("0.05283804279573990769499541", 1e-23).contains(proved.x0_slip)
    assert arb("0.41732949861176354190", 5e-21).contains(proved.init.offset)
    assert proved.init.bent_once()


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
    k = modulus(arb(eta))
    quarter = acb(k * k).elliptic_k().real
    near = [0.0, -2.6 - 4 * (0.85 - float(eta)), -1.2 - 2 * (0.85 - float(eta))]
    found = prove(Rod(theta=arb(1), eta=arb(eta), steps=16), inclined(arb(0)), near)
    for enclosure, closed in [
        (found.f, quarter**2),
        (found.offset, 2 * k / quarter),
        (found.load.m0, -2 * k * quarter),
    ]:
        assert enclosure.overlaps(closed)
        assert enclosure.rad() < 1e-18 and closed.rad() < 1e-18


@pytest.mark.parametrize("theta, mu0, eta", [("1", "0.3", "0.85"), ("5", "0.25", "0.7")])
def test_the_solver_is_right_to_a_few_units_in_the_last_place(theta, mu0, eta):
    found = onset(Decimal(theta), Decimal(eta), Decimal(mu0), Effort(bits=96, order=24, steps=24))
    curve = solve_curve(float(theta), float(eta))
    x0 = curve.onset([float(mu0)])[0]
    slip = curve.state(x0)
    assert abs(float(found.x0_slip) - x0) < 2e-14
    assert abs(float(found.slip.f) - float(slip.f)) < 1e-11
    assert abs(float(found.slip.phi1) - float(slip.phi1)) < 1e-12


def test_another_order_other_steps_and_another_precision_agree(proved):
    other = onset(THETA, ETA, MU0, Effort(bits=160, order=26, steps=12))
    for name in ("f", "alpha", "offset", "phi1"):
        one, two = getattr(proved.slip, name), getattr(other.slip, name)
        assert one.overlaps(two) and two.rad() < 1e-16


def moved(equilibrium, by):
    """Claim that the equilibrium is within 1e-17 of another load."""
    with Effort().spent():
        rod = Rod(theta=ball(THETA), eta=ball(ETA), steps=16)
        load = arb_mat([[(value + by).mid()] for value in equilibrium.load])
        return krawczyk(equations(rod, inclined(ball(MU0))), load, [1e-17] * 3)


def test_an_onset_moved_by_a_1e_15_is_refused(proved):
    assert moved(proved.slip, 0)[0, 0].overlaps(proved.slip.load.fx)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        moved(proved.slip, 1e-15)
    assert not proved.x0_slip.overlaps(proved.x0_slip + arb("1e-15"))


def test_a_second_mode_is_an_equilibrium_but_not_bent_once():
    k = modulus(arb("0.85"))
    quarter = acb(k * k).elliptic_k().real
    load = [0.0, float(-9 * quarter**2), float(-6 * k * quarter)]
    second = prove(Rod(theta=arb(1), eta=arb("0.85"), steps=24), inclined(arb(0)), load)
    assert second.f.overlaps(9 * quarter**2)
    assert not second.bent_once()


@pytest.mark.parametrize(("phi", "once"), [("0.1", True), ("0", False), ("-0.1", False)])
def test_a_moment_that_may_vanish_has_to_grow_for_certain(phi, once):
    box = SimpleNamespace(m=arb(0), phi=arb(phi))
    state = SimpleNamespace(load=(arb("0.5"), arb(0), arb(0)), passed=[box])
    assert Equilibrium.bent_once(state) is once


def test_a_start_far_away_proves_nothing():
    with pytest.raises(NotProvedError):
        prove(Rod(theta=arb(2), eta=arb("0.85"), steps=12), inclined(arb(0)), [9.0, 9.0, 9.0])


@pytest.mark.parametrize(
    "text", ["0.0528380427957399076949954123 +/- 8e-27", "-1234.5 +/- 3e-22", "0 +/- 1e-20", "2"]
)
def test_decimals_enclose(text):
    with Effort().spent():
        number = arb(text)
        value, radius = decimals(number)
        assert arb(str(value), arb(str(radius))).contains(number)
        assert radius <= Decimal(str(float(number.rad()))) * Decimal("1.2")
