"""Line contact: closed forms, the solver's digits, and the change from tip to line contact."""

from decimal import Decimal

import pytest
from flint import acb, arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.digits import decimals
from validation.proof.equilibrium import Rod, equations, inclined, prove, reaching, tangential
from validation.proof.flow import Load, shoot
from validation.proof.krawczyk import examined
from validation.proof.sample import prove_onset, switched
from vibrissa import solve_curve
from vibrissa.outcomes import Contact


@pytest.fixture(scope="module")
def rod():
    return Rod(theta=arb(3), eta=arb("0.7"), steps=16)


@pytest.fixture(scope="module")
def lying(rod):
    """The state α = 0 of a rod that lies on the surface from the start."""
    return prove(rod, inclined(arb(0)), [0.0, -0.9866, -0.4, 0.9479], Contact.LINE)


def test_a_free_part_that_ends_anywhere_is_a_rod_of_its_own():
    """At θ = 1 a rod of length s_c under forces is one of length 1 under s_c² times the forces."""
    load, end = Load(arb(-0.9), arb(-2.3), arb(-0.05)), arb("0.7")
    short = shoot(arb(1), load, 12, end=end).tip[0]
    whole = shoot(arb(1), Load(load.fx * end**2, load.fy * end**2, load.m0 * end), 12).tip[0]
    assert short.phi.overlaps(whole.phi) and short.m.overlaps(whole.m / end)
    assert short.x.overlaps(end * whole.x) and short.y.overlaps(end * whole.y)
    assert short.y.rad() < 1e-18


def test_the_derivatives_along_the_rod_are_derivatives():
    """By the mean value theorem, between the two ends."""
    theta, load, low, high = arb(3), Load(arb(-0.3), arb(-1.1), arb(-0.4)), arb("0.9"), arb("0.901")
    first, second = (shoot(theta, load, 12, end=end).tip for end in (low, high))
    between = shoot(theta, load, 12, end=low.union(high)).onward
    for section, other, rate in zip(first, second, between, strict=True):
        for a, b, slope in zip(section, other, rate, strict=True):
            assert ((b - a) / (high - low)).overlaps(slope)
            assert slope.rad() < 0.02 * (1 + abs(slope))


def test_a_cylinder_without_friction_has_a_closed_form():
    """At α = 0, φ'² = 2·f·sin φ. So s_c·√f = K and η·√f = 2·E − K with the modulus k² = 1/2."""
    rod = Rod(theta=arb(1), eta=arb("0.4"), steps=16)
    found = prove(rod, inclined(arb(0)), [0.0, -11.0, -4.7, 0.87], Contact.LINE)
    m = acb(arb(1) / 2)
    quarter, area = m.elliptic_k().real, m.elliptic_e().real
    assert found.keeps_contact() and found.bent_once()
    root = found.f.sqrt()
    assert (found.s_c * root).overlaps(quarter)
    assert (root * arb("0.4")).overlaps(2 * area - quarter) and root.rad() < 1e-12


def test_the_digits_are_those_of_the_solver(lying):
    solved = solve_curve(3, 0.7, contact="line").state(0.0)
    assert lying.keeps_contact() and lying.bent_once()
    assert float(lying.s_c) == pytest.approx(float(solved.s_c), abs=1e-14)
    assert float(lying.f) == pytest.approx(-float(solved.reaction_fy), abs=1e-13)
    assert lying.s_c.rad() < 1e-15 and abs(lying.phi1) < 1e-15


def test_another_condition_leads_to_the_same_state(rod, lying):
    near = [value.mid() for value in (*lying.load, lying.s_c)]
    same = prove(rod, reaching(lying.offset), near, Contact.LINE)
    assert same.load.fy.overlaps(lying.load.fy) and same.s_c.overlaps(lying.s_c)


def test_a_contact_point_moved_by_1e_14_is_refused(rod, lying):
    system = equations(rod, inclined(arb(0)), Contact.LINE)

    def claimed(by):
        unknowns = [*lying.load, lying.s_c + by]
        centre = arb_mat([[value.mid()] for value in unknowns])
        values, _ = system(centre)
        return examined(system, centre, values, arb_mat([[1e-15]] * 4))

    assert claimed(0)[0][3, 0].overlaps(lying.s_c)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        claimed(1e-14)


@pytest.mark.parametrize("contact", Contact)
def test_a_rod_that_lies_down_on_the_way(contact):
    """At θ = 3, η = 0.85 the rod lies down at x0 = 0.1157, or goes through the surface."""
    rod, curve = Rod(theta=arb(3), eta=arb("0.85"), steps=16), solve_curve(3, 0.85, contact=contact)
    found = prove_onset(curve, rod, Decimal("0.45"), contact)
    x0_slip = float(curve.onset([0.45])[0])
    assert float(found.x0_slip) == pytest.approx(x0_slip, abs=1e-12)
    assert (found.init.contact, found.slip.contact) == (Contact.POINT, contact)
    if contact is Contact.POINT:
        assert found.slip.phi1 < 0 and not found.slip.keeps_contact() and not found.x0_switch
        return
    (switch,) = found.x0_switch
    assert float(switch) == pytest.approx(0.11567006419982273, abs=1e-13)
    assert switched(curve, x0_slip) == pytest.approx([float(switch)], abs=1e-11)


def test_at_the_change_of_contact_its_kind_is_open():
    rod, curve = Rod(theta=arb(3), eta=arb("0.85"), steps=16), solve_curve(3, 0.85, contact="line")
    (near,) = (curve.state(x0) for x0 in switched(curve, 1.0)[:1])
    load = [float(near.reaction_fx), float(near.reaction_fy), float(near.reaction_m)]
    switch = prove(rod, tangential(), load)
    line = prove(rod, inclined(switch.mu), [*load, 1.0], Contact.LINE)
    assert line.s_c.overlaps(arb(1)) and line.load.fx.overlaps(switch.load.fx)
    assert not line.keeps_contact() and not switch.keeps_contact()
    with pytest.raises(NotProvedError, match="too near a change of contact"):
        prove_onset(curve, rod, round(decimals(switch.mu)[0], 17), Contact.LINE)
