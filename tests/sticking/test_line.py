"""Contact along a line: against an independent shooting, exact laws and the point model."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import root

import reference
from vibrissa import Status, solve_curve, solve_state, stick_slip
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.collocation import solve_curves

LYING = [(3.0, 0.7), (5.0, 0.7), (2.0, 0.5), (1.0, 0.3), (8.0, 0.85), (15.0, 0.9)]
TOUCHING = [(3.0, 0.85), (1.0, 0.55), (4.0, 0.85)]


def line(theta, eta):
    return solve_curve(theta, eta, contact="line")


@pytest.mark.slow
@pytest.mark.parametrize("pair", LYING + TOUCHING)
def test_states_agree_with_an_independent_shooting(pair):
    curve = line(*pair)
    assert curve.status is Status.SOLVED and curve.residual <= 1e-12
    start = max(curve.x0_touch, 0.0)
    for part in (0.1, 0.6, 0.95):
        x0 = start + part * (curve.x0_lock - start)
        state = curve.state(x0)
        assert curve.contact(x0) == "line"
        guess = (state.s_c * 0.9999, -state.reaction_fy * 1.0001, state.reaction_fx * 1.0001)
        s_c, p, q = reference.solve_line_offset(*pair, curve.x1_init - x0, guess)
        assert state.s_c == pytest.approx(s_c, abs=1e-10)
        assert state.reaction_fy == pytest.approx(-p, rel=1e-9)
        assert state.reaction_fx == pytest.approx(q, rel=1e-9)
        m = reference.shoot_from_line(pair[0], s_c, p, q)[3]
        assert state.reaction_m == pytest.approx(m, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("eta", [0.3, 0.4, 0.5, 0.55])
def test_a_cylinder_locks_at_exactly_45_degrees(eta):
    # B·φ'' = f·cos(φ - α) has the first integral φ'²/2 = f·(sin(φ - α) + sin α) when φ and m
    # vanish together at s_c. At the clamp, φ = π/2, the curvature is real only if
    # cos α + sin α >= 0: the friction angle cannot pass 45 degrees.
    curve = line(1.0, eta)
    assert curve.mu_lock == pytest.approx(1.0, abs=1e-12)
    locked = curve.state(curve.x0_lock)
    assert locked.alpha == pytest.approx(-np.pi / 4, abs=1e-9)
    # There the clamp is free of moment.
    assert locked.reaction_m == pytest.approx(0.0, abs=1e-4)


def test_locking_friction_of_strong_taper():
    assert line(5.0, 0.7).mu_lock == pytest.approx(0.456, abs=5e-4)
    assert solve_curve(5.0, 0.7).mu_lock == pytest.approx(0.662, abs=5e-4)


def assert_states_agree(states, others):
    """But for the margins of stability, which are interpolated between fewer states."""
    for name in set(states.names()) - {"stability", "stability_aside"}:
        assert getattr(states, name) == pytest.approx(getattr(others, name), abs=1e-10)


@pytest.mark.slow
@settings(max_examples=6, deadline=None)
@given(st.floats(1.0, 3.0), st.floats(0.8, 0.95))
def test_both_models_agree_as_long_as_the_tip_alone_touches(theta, eta):
    point, lying = solve_curve(theta, eta), line(theta, eta)
    end = point.x0_touch if np.isfinite(point.x0_touch) else point.x0_lock
    x0 = np.linspace(0.0, min(end, lying.x0_lock), 9)
    assert_states_agree(point.state(x0), lying.state(x0))
    # Interpolated between fewer states, and higher where the rod lies down.
    margins = point.state(x0[:-1]).stability, lying.state(x0[:-1]).stability
    assert margins[0] == pytest.approx(margins[1], abs=1e-5)


@pytest.mark.parametrize("pair", TOUCHING)
def test_a_rod_rolls_on_and_off_without_a_jump(pair):
    """The contact changes back far beyond the lock."""
    curve = solve_curve(*pair, contact="line", section="planar")
    line = curve.pieces.line
    (changes,) = np.nonzero(line[1:] != line[:-1])
    assert line[changes + 1].tolist() == [True, False]
    begins = curve.pieces.first_x0[changes + 1]
    assert begins[0] == curve.x0_touch
    assert curve.x0_touch == pytest.approx(solve_curve(*pair).x0_touch, abs=1e-11)
    for begin, kinds in zip(begins, (["point", "line"], ["line", "point"]), strict=True):
        around = begin + np.array([-1e-13, 1e-13])
        assert curve.contact(around).tolist() == kinds
        assert_states_agree(*(curve.state(x0) for x0 in around))
        assert curve.state(begin).phi1 == pytest.approx(0.0, abs=1e-9)
        assert curve.state(begin).s_c == pytest.approx(1.0, abs=1e-9)


# `python -m validation survey` solves many more.
@pytest.mark.slow
@settings(max_examples=2, deadline=None)
@given(st.floats(1.0, 20.0), st.floats(0.3, 0.999))
# The contact changes just before the end of the curve
@example(1.2, 0.7109375)
@example(1.5, 0.753203125)
@example(3.5, 0.8885546875)
@example(8.0, 0.951689453125)
# and just after its beginning
@example(1.2, 0.5099609375)
@example(2.0, 0.6584130859375)
@example(3.5, 0.79525146484375)
@example(8.0, 0.914794921875)
def test_whole_range_is_solved_in_both_models(theta, eta):
    for model in Contact:
        (curve,) = solve_curves(np.array([theta]), np.array([eta]), model)
        assert curve.status is Status.SOLVED, curve.message
        # Where more than 100 nodes are needed rounding alone comes near 1e-12.
        assert curve.residual <= (1e-12 if model is Contact.LINE else 1e-11)
        if model is Contact.LINE:
            states = curve.state(np.linspace(0.0, curve.x0_lock, 50))
            assert (states.phi1 >= -1e-9).all()
            assert (states.s_c <= 1.0 + 1e-12).all() and (states.s_c > 0.0).all()


def test_scan_shows_the_rod_lying_on_the_surface():
    curve = line(3.0, 0.7)
    scan = stick_slip(curve, Decimal("0.3"), Decimal("0.005"), cycles=2)
    shapes = scan.shapes()
    assert shapes.residual.max() < 1e-11
    assert shapes.y.max() <= 0.7 + 1e-11
    lying = shapes.s > scan.state.s_c[:, None] + 1e-9
    assert lying.any(axis=1).all()
    assert shapes.y[lying] == pytest.approx(0.7, abs=1e-11)
    assert shapes.x[:, -1] == pytest.approx(scan.contact, abs=1e-11)


def test_unknown_contact_is_refused():
    with pytest.raises(ValueError, match="contact must be one of point, line"):
        solve_curve(1.0, 0.85, contact="plane")
    with pytest.raises(ValueError, match="contact 'point' alone"):
        solve_curve(1.0, 0.85, method="shooting", dx0=0.01, contact="line")


@pytest.mark.parametrize("contact", ["point", "line"])
def test_only_the_tip_alone_can_pass_through_the_surface(contact):
    x1_init = solve_curve(3.0, 0.85, contact=contact).x1_init
    states = [solve_state(3.0, 0.85, x1_init - x0, contact) for x0 in np.linspace(0.12, 0.2, 9)]
    assert {state.penetrates for state in states} == {contact == "point"}
    assert all((state.phi1 == 0.0) == (contact == "line") for state in states)


def test_a_rod_that_lies_down_is_held_more_firmly():
    # psi(s_c) = 0 is one constraint more than the same shape has in point contact: the margin of
    # stability is higher, and jumps where the contact changes.
    curve = line(3.0, 0.85)
    x1 = curve.x1_init - curve.x0_touch
    before = solve_state(3.0, 0.85, x1 + 1e-6, "line")
    after = solve_state(3.0, 0.85, x1 - 1e-6, "line")
    assert (before.contact, after.contact) == ("point", "line")
    assert after.stability > before.stability + 0.01
    # Interlacing: one constraint cannot lift the least margin above the next one.
    assert after.stability < 1.0


@pytest.mark.parametrize(("theta", "eta"), [(2.3877, 0.8215), (1.0784, 0.6471), (2.38771, 0.82151)])
def test_a_lock_in_a_kink_lies_where_the_contact_changes(theta, eta):
    curve = line(theta, eta)
    assert curve.x0_lock == curve.x0_touch == curve.pieces.first_x0[1]
    # In the kink itself only the tip touches.
    assert curve.state(curve.x0_lock).s_c == pytest.approx(1.0, abs=1e-9)
    around = curve.x0_lock + np.array([0.0, 1e-6])
    assert curve.contact(around).tolist() == ["point", "line"]
    assert curve.x0_touch == pytest.approx(solve_curve(theta, eta).x0_touch, abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["point", "line"])
@pytest.mark.parametrize("pair", [(8.0, 0.5), (8.0, 0.97), (14.0, 0.7), (20.0, 0.85)])
def test_onset_and_force_of_strong_taper_agree_with_an_independent_shooting(pair, contact):
    curve = solve_curve(*pair, contact=contact)
    mu0 = 0.9 * curve.mu_lock
    x0 = float(curve.onset(mu0))
    state = curve.state(x0)
    near = -state.reaction_fy * (1 + 1e-7), state.reaction_fx * (1 + 1e-7)
    offset = curve.x1_init - x0
    if curve.contact(x0) == "point":
        _, p, q = reference.solve_offset(*pair, offset, (state.phi1 + 1e-7, *near))
    else:
        _, p, q = reference.solve_line_offset(*pair, offset, (state.s_c * (1 - 1e-7), *near))
    assert np.hypot(p, q) == pytest.approx(float(state.f), rel=1e-10)
    # What is missing to the friction angle, as a displacement.
    h = 1e-6
    slope = (curve.mobilised_friction(x0 + h) - curve.mobilised_friction(x0 - h)) / (2 * h)
    assert (-q / p - mu0) / slope == pytest.approx(0.0, abs=1e-10)


# At the last one the displacement is steady up to the kink in which it turns back.
@pytest.mark.parametrize("eta", [0.5449, 0.5452, 0.5456, 0.5471])
def test_line_contact_ends_where_the_contact_point_reaches_the_tip(eta):
    """Beyond, the equations of line contact have solutions with s_c > 1, which no rod has."""
    curve = solve_curve(3.003, eta, contact="line", section="planar")
    last = curve.state(curve.x0_end)

    def misfit(unknowns):
        _, y, phi, _ = reference.shoot_from_line(3.003, 1.0, *unknowns)
        return [y - eta, phi - np.pi / 2]

    near = [-last.reaction_fy * (1 + 1e-5), last.reaction_fx * (1 + 1e-5)]
    p, q = root(misfit, near, tol=1e-13).x
    x0 = curve.x1_init - reference.shoot_from_line(3.003, 1.0, p, q)[0]
    # In tip contact the clamp would have to move back from there.
    assert curve.end == "snaps" and curve.x0_end == pytest.approx(x0, abs=1e-11)
