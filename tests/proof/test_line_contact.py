"""Line contact: closed forms, the solver's digits, and the change from tip to line contact."""

import pytest
from flint import acb, arb, arb_mat
from typer.testing import CliRunner

from vibrissa import solve_curve, solve_onset
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, NotProvedError
from vibrissa.outcomes import Contact
from vibrissa.proof import Effort, decimals, onset
from vibrissa.proof.equilibrium import Rod, equations, inclined, prove, reaching, tangential
from vibrissa.proof.flow import Load, shoot
from vibrissa.proof.krawczyk import examined

QUICK = Effort(bits=96, order=24, steps=16)


@pytest.fixture(autouse=True)
def _precision():
    with QUICK.spent():
        yield


@pytest.fixture(scope="module")
def rod():
    with QUICK.spent():
        return Rod(theta=arb(3), eta=arb("0.7"), steps=16)


@pytest.fixture(scope="module")
def lying(rod):
    """The state α = 0 of a rod that lies on the surface from the start."""
    with QUICK.spent():
        return prove(rod, inclined(arb(0)), [0.0, -0.9866, -0.4, 0.9479], Contact.LINE)


def test_a_free_part_that_ends_anywhere_is_a_rod_of_its_own():
    """At θ = 1 a rod of length s_c under forces is one of length 1 under s_c² times the forces."""
    load, end = Load(arb(-0.9), arb(-2.3), arb(-0.05)), arb("0.7")
    short = shoot(arb(1), load, 12, end=end).tip[0]
    whole = shoot(arb(1), Load(load.fx * end**2, load.fy * end**2, load.m0 * end), 12).tip[0]
    assert short.phi.overlaps(whole.phi) and short.m.overlaps(whole.m / end)
    assert short.x.overlaps(end * whole.x) and short.y.overlaps(end * whole.y)
    assert short.y.rad() < 1e-18


def test_an_end_that_is_a_ball_holds_all_ends():
    theta, load = arb(3), Load(arb(-0.3), arb(-1.1), arb(-0.4))
    wide = shoot(theta, load, 12, end=arb("0.9", "0.01"))
    for end in ("0.8901", "0.9", "0.9099"):
        shot = shoot(theta, load, 12, end=arb(end))
        for every, sections in ((wide.tip, shot.tip), (wide.onward, shot.onward)):
            for whole, section in zip(every, sections, strict=True):
                assert all(a.overlaps(b) for a, b in zip(whole, section, strict=True))


def test_the_derivatives_along_the_rod_are_derivatives():
    """By the mean value theorem, between the two ends."""
    theta, load, low, high = arb(3), Load(arb(-0.3), arb(-1.1), arb(-0.4)), arb("0.9"), arb("0.901")
    first, second = (shoot(theta, load, 12, end=end).tip for end in (low, high))
    between = shoot(theta, load, 12, end=low.union(high)).onward
    for section, other, rate in zip(first, second, between, strict=True):
        for a, b, slope in zip(section, other, rate, strict=True):
            assert ((b - a) / (high - low)).overlaps(slope)
            assert slope.rad() < 0.02 * (1 + abs(slope))


@pytest.mark.slow
def test_a_cylinder_without_friction_has_a_closed_form():
    """At α = 0, φ'² = 2·f·sin φ. So s_c·√f = K and η·√f = 2·E − K with the modulus k² = 1/2."""
    found = prove(
        Rod(theta=arb(1), eta=arb("0.4"), steps=16),
        inclined(arb(0)),
        [0.0, -11.0, -4.7, 0.87],
        Contact.LINE,
    )
    m = acb(arb(1) / 2)
    quarter, area = m.elliptic_k().real, m.elliptic_e().real
    assert found.keeps_contact() and found.bent_once()
    root = found.f.sqrt()
    assert (found.s_c * root).overlaps(quarter)
    assert (root * arb("0.4")).overlaps(2 * area - quarter) and root.rad() < 1e-12


@pytest.mark.slow
def test_the_digits_are_those_of_the_solver(lying):
    solved = solve_curve(3, 0.7, contact="line").state(0.0)
    assert lying.keeps_contact() and lying.bent_once()
    assert float(lying.s_c) == pytest.approx(float(solved.s_c), abs=1e-14)
    assert float(lying.f) == pytest.approx(-float(solved.reaction_fy), abs=1e-13)
    assert lying.s_c.rad() < 1e-15 and abs(lying.phi1) < 1e-15


@pytest.mark.slow
def test_another_condition_leads_to_the_same_state(rod, lying):
    near = [*lying.load, lying.s_c]
    same = prove(rod, reaching(lying.offset), [value.mid() for value in near], Contact.LINE)
    assert same.load.fy.overlaps(lying.load.fy) and same.s_c.overlaps(lying.s_c)


@pytest.mark.slow
def test_a_contact_point_moved_by_1e_14_is_refused(rod, lying):
    system = equations(rod, inclined(arb(0)), Contact.LINE)

    def claimed(by):
        unknowns = [*lying.load, lying.s_c + by]
        centre = arb_mat([[value.mid()] for value in unknowns])
        values, _ = system(centre)
        return examined(system, centre, values, arb_mat([[1e-15]] * 4))

    image, _ = claimed(0)
    assert image[3, 0].overlaps(lying.s_c)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        claimed(1e-14)


@pytest.fixture(scope="module")
def switching():
    return onset(3, "0.45", 0.85, contact="line", effort=QUICK)


@pytest.mark.slow
def test_a_rod_that_lies_down_on_the_way(switching):
    """At θ = 3, η = 0.85 the contact changes at x0 = 0.1157."""
    solved = solve_onset(3, 0.45, 0.85, contact="line")
    (switch,) = switching.switches
    assert (switching.init.contact, switching.slip.contact) == ("point", "line")
    shown = switching.columns()
    assert shown["x0_switch_1"] > 0 and shown["x0_switch_1"] < switching.x0_slip
    assert float(shown["x0_switch_1"]) == pytest.approx(0.11567006419982273, abs=1e-13)
    assert float(shown["s_c_slip"]) == pytest.approx(float(solved.slip.s_c), abs=1e-12)
    assert "s_c_init" not in shown
    assert float(switching.x0_slip) == pytest.approx(solved.x0_slip, abs=1e-12)
    assert switch.phi1.contains(0) and switch.phi1.rad() < 1e-12


@pytest.mark.slow
def test_both_kinds_of_contact_have_the_state_in_which_they_change(switching):
    (switch,) = switching.switches
    rod = Rod(theta=arb(3), eta=arb("0.85"), steps=16)
    near = [value.mid() for value in switch.load]
    again = prove(rod, tangential(), near)
    line = prove(rod, inclined(again.mu), [*near, 1.0], Contact.LINE)
    assert line.s_c.overlaps(arb(1)) and line.load.fx.overlaps(switch.load.fx)
    # There it is open which kind it is.
    assert not line.keeps_contact() and not again.keeps_contact()


@pytest.mark.slow
def test_tip_contact_is_not_line_contact(switching):
    through = onset(3, "0.45", 0.85, effort=QUICK)
    assert through.slip.phi1 < 0 and not through.slip.keeps_contact()
    assert not through.x0_slip.overlaps(switching.x0_slip)
    assert through.switches == ()


@pytest.mark.slow
def test_an_onset_at_the_change_of_contact_is_not_told_apart(switching):
    (switch,) = switching.switches
    mu0 = round(decimals(switch.mu)[0], 17)
    with pytest.raises(NotProvedError, match="too near a change of contact"):
        onset(3, mu0, 0.85, contact="line", effort=QUICK)


def test_what_is_not_proved_in_line_contact_is_refused():
    with pytest.raises(ArgumentError, match="tip contact alone"):
        onset(3, 0.45, 0.85, contact="line", first=True)
    with pytest.raises(ArgumentError, match="contact must be one of point, line"):
        onset(3, 0.45, 0.85, contact="plane")


@pytest.mark.slow
def test_the_command_takes_the_contact(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: QUICK)
    arguments = "prove --theta 3 --eta 0.7 --contact line"
    result = CliRunner().invoke(app, f"{arguments} --mu0 0.3".split())
    assert result.exit_code == 0, result.output
    assert "\ns_c_init           0.947895262313298" in result.output
    refused = CliRunner().invoke(app, arguments.split())
    assert refused.exit_code == 2
    assert "tip contact alone" in refused.output + str(refused.exception or "")
