"""Stability out of the plane, against finite elements and a chain in space."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from validation.rod_chain import Chain
from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.mechanics import aside
from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.offsets import solve_offsets

POISSON_RATIO = 0.3


def solved(theta, eta, offset, contact="point", mounting=IDEAL):
    rod = np.array([theta]), np.array([eta]), np.array([0])
    return solve_offsets(*rod, np.array([offset]), Contact(contact), [mounting])[0].state


def margin(theta, eta, offset, contact="point", mounting=IDEAL):
    return float(stability_aside(solved(theta, eta, offset, contact, mounting))[0])


def clamp_turn(mounting, turn):
    """Turn of a yielding clamp out of the plane, from its energy at finite rotations.

    Its spring resists the rotation vector from the unloaded clamp, which does not turn about its
    own axis. Returns the direction of the turn and its stiffness.
    """
    beta, in_plane = mounting.clamp_angle, Rotation.from_rotvec([0, 0, turn])
    axis = np.array([-np.sin(beta), np.cos(beta), 0])

    def vector(angle, size):
        out = Rotation.from_rotvec(size * np.array([np.cos(angle), np.sin(angle), 0]))
        return (out * in_plane).as_rotvec()

    twist = lambda angle: vector(angle, 1e-3) @ axis - vector(angle, -1e-3) @ axis  # noqa: E731
    angle = brentq(twist, beta - 1, beta + 1, xtol=1e-13)
    energy = [vector(angle, size) @ vector(angle, size) for size in (-1e-3, 0, 1e-3)]
    return angle, (energy[0] - 2 * energy[1] + energy[2]) / (2e-6 * mounting.clamp_compliance)


def finite_elements(theta, state, count, mounting=IDEAL):
    """Least second variation, of linear elements for the rotations about tangent and normal."""
    s_c, fx, fy = float(state.s_c[0]), float(state.fx[0]), float(state.fy[0])
    # Nodes are dense where the rod is thin.
    tau = np.linspace(0, 1, count + 1)
    tip = 1 - (1 - 1 / theta) * s_c
    s = s_c * tau / (tau + (1 - tau) * tip)
    middle = 0.5 * (s[1:] + s[:-1])
    natural = np.polynomial.Polynomial(mounting.coefficients)
    phi, moment, clamp_moment = integrated(theta, state, natural, middle)
    h = np.diff(s)
    bend = (1 - (1 - 1 / theta) * middle) ** 4
    turn = natural(middle) + moment / bend
    ahead, up = fx * np.cos(phi) + fy * np.sin(phi), -fx * np.sin(phi) + fy * np.cos(phi)
    elastic, load = np.zeros((2, 2 * count + 2, 2 * count + 2))
    held = np.zeros(2 * count + 2)
    mean, slope = np.array([0.5, 0.5]), np.array([-1.0, 1.0])
    for k in range(count):
        at = [2 * k, 2 * k + 2, 2 * k + 1, 2 * k + 3]
        t, n = np.r_[mean, 0, 0], np.r_[0, 0, mean]
        twist, bending = np.r_[slope / h[k], -turn[k] * mean], np.r_[turn[k] * mean, slope / h[k]]
        part = np.ix_(at, at)
        stiff = np.outer(twist, twist) / (1 + POISSON_RATIO) + np.outer(bending, bending)
        elastic[part] += h[k] * bend[k] * stiff
        work = moment[k] * (np.outer(t, bending) - np.outer(n, twist))
        work += up[k] * np.outer(t, n) - ahead[k] * np.outer(n, n)
        load[part] -= h[k] * 0.5 * (work + work.T)
        held[at] += h[k] * n
    unknowns = np.eye(2 * count + 2)[:, 2:]
    if mounting.clamp_compliance:
        clamp = mounting.clamp_compliance * clamp_moment
        angle, stiffness = clamp_turn(mounting, clamp)
        slope = np.pi / 2 + mounting.clamp_angle + clamp
        of_clamp = [np.cos(angle - slope), np.sin(angle - slope)]
        elastic[:2, :2] += stiffness * np.outer(of_clamp, of_clamp)
        unknowns = np.column_stack([np.r_[of_clamp, np.zeros(2 * count)], unknowns])
    free = unknowns @ null_space((held @ unknowns)[None])
    return 1 + eigh(free.T @ load @ free, free.T @ elastic @ free)[0][0]


def integrated(theta, state, natural, s):
    """Tangent angle and moment at arc lengths, and at the clamp, from the contact point on."""
    s_c, fx, fy = float(state.s_c[0]), float(state.fx[0]), float(state.fy[0])

    def derivative(s, unknowns):
        phi, m = unknowns
        bend = (1 - (1 - 1 / theta) * s) ** 4
        return [natural(s) + m / bend, fx * np.sin(phi) - fy * np.cos(phi)]

    begin = [float(ends(state).phi1[0]), 0.0]
    places = np.append(s[::-1], 0.0)
    found = solve_ivp(derivative, (s_c, 0.0), begin, "DOP853", places, rtol=1e-11, atol=1e-11).y
    return found[0, -2::-1], found[1, -2::-1], found[1, -1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "place", "contact"),
    [
        (1.0, 0.85, 0.0, "point"),
        (4.0, 0.6, 0.8, "point"),
        (2.0, 0.85, 1.3, "point"),
        (12.0, 0.9, -0.2, "point"),
        (2.0, 0.5, 0.3, "line"),
        (8.0, 0.5, 0.6, "line"),
    ],
)
def test_the_margin_is_that_of_finite_elements(theta, eta, place, contact):
    x1_init = solve_curve(theta, eta, contact=contact).x1_init
    state = solved(theta, eta, x1_init * (1 - place), contact)
    coarse, fine = (finite_elements(theta, state, count) for count in (60, 120))
    # Linear elements: the error falls with the square of their length.
    assert float(stability_aside(state)[0]) == pytest.approx((4 * fine - coarse) / 3, abs=3e-4)


MOUNTED = [
    (1.0, 0.85, 0.5, "point", Mounting(clamp_angle=0.2)),
    (2.0, 0.7, 0.8, "point", Mounting(clamp_compliance=0.5)),
    (4.0, 0.6, 1.1, "point", Mounting(clamp_angle=-0.1, clamp_compliance=0.3)),
    (3.0, 0.8, 0.9, "point", Mounting(curvature=(0.2, 0.3))),
    (3.0, 0.8, 0.9, "line", Mounting(curvature=-0.3)),
    (
        8.0,
        0.7,
        0.6,
        "line",
        Mounting(clamp_angle=-0.05, clamp_compliance=0.2, curvature=(-0.1, -0.4)),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "eta", "place", "contact", "mounting"), MOUNTED)
def test_the_margin_of_a_mounted_rod_is_that_of_finite_elements(
    theta, eta, place, contact, mounting
):
    x1_init = solve_curve(theta, eta, contact=contact, mounting=mounting).x1_init
    state = solved(theta, eta, x1_init * (1 - place), contact, mounting)
    coarse, fine = (finite_elements(theta, state, count, mounting) for count in (40, 80))
    assert float(stability_aside(state)[0]) == pytest.approx((4 * fine - coarse) / 3, abs=3e-4)


@pytest.mark.parametrize(
    ("theta", "eta", "mounting"),
    [
        (1.0, 0.85, Mounting(clamp_angle=0.1)),
        (4.0, 0.6, Mounting(clamp_angle=-0.1)),
        (2.0, 0.7, Mounting(clamp_compliance=0.5)),
        (12.0, 0.8, Mounting(clamp_angle=-0.05, clamp_compliance=0.2)),
    ],
)
def test_of_a_straight_rod_it_vanishes_on_the_axis_of_the_unloaded_clamp(theta, eta, mounting):
    on_axis = -eta * np.tan(mounting.clamp_angle)
    margins = [margin(theta, eta, on_axis + d, mounting=mounting) for d in (-0.02, 0.0, 0.02)]
    assert margins[0] < 0 < margins[2]
    assert margins[1] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.slow
def test_of_a_curved_rod_it_vanishes_elsewhere():
    # To first order where the mean bend, in the sense of the curvature, makes up for the way.
    places = [
        brentq(lambda x: margin(3.0, 0.8, x, mounting=Mounting(curvature=k)), -0.1, 0.1, xtol=1e-10)  # noqa: B023
        for k in (-0.02, -0.01, 0.01)
    ]
    assert places[0] == pytest.approx(2 * places[1], rel=0.05)
    assert places[1] == pytest.approx(-places[2], rel=0.1)
    assert 1e-4 < places[1] < 1e-2


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.4, 0.95))
def test_the_margin_vanishes_where_the_clamp_passes_under_the_tip(theta, eta):
    assert margin(theta, eta, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, 0.02) > 0 > margin(theta, eta, -0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "eta"), [(1.0, 0.5), (4.0, 0.6), (12.0, 0.4)])
def test_in_line_contact_it_vanishes_where_the_clamp_passes_under_the_contact_point(theta, eta):
    ahead = lambda x1: x1 - 1 + float(solved(theta, eta, x1, "line").s_c[0])  # noqa: E731
    x1 = brentq(ahead, 0.02, 0.9 * solve_curve(theta, eta, contact="line").x1_init, xtol=1e-13)
    assert x1 > 0.1
    assert margin(theta, eta, x1, "line") == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, x1 + 0.02, "line") > 0 > margin(theta, eta, x1 - 0.02, "line")


def test_where_it_vanishes_does_not_depend_on_the_torsional_stiffness(monkeypatch):
    stiff = margin(2.0, 0.85, 0.2)
    monkeypatch.setattr(aside, "POISSON_RATIO", 0.49)
    assert margin(2.0, 0.85, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(2.0, 0.85, 0.2) < stiff


@pytest.mark.slow
@settings(max_examples=4, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.4, 0.95), st.sampled_from(["point", "line"]))
@example(5.0, 0.4375, "line")
def test_the_rod_stays_in_its_plane_up_to_the_lock_and_where_it_is_pulled(theta, eta, contact):
    curve = solve_curve(theta, eta, contact=contact)
    # Pulled farther, a tip on a steep path lifts off.
    for x0 in (max(-0.1 * curve.x1_init, curve.x0_pull), curve.x0_lock):
        assert 0 < margin(theta, eta, curve.x1_init - x0, contact) < 1


def test_a_state_that_was_not_found_has_no_margin():
    state = solved(1.0, 0.85, 0.3)
    lost = state.with_unknowns(np.nan * state.unknowns)
    assert np.isnan(stability_aside(lost)).all()


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "eta", "contact"), [(1.0, 0.85, "point"), (4.0, 0.6, "line")])
def test_a_chain_in_space_stays_in_its_plane_until_there_and_then_swings_round(theta, eta, contact):
    # The state on the other side of the clamp at the same distance is the mirror image.
    x1_init = solve_curve(theta, eta, contact=contact).x1_init
    over = 0.0
    if contact == "line":
        ahead = lambda x1: x1 - 1 + solve_state(theta, eta, x1, contact).s_c  # noqa: E731
        over = brentq(ahead, 0.02, 0.9 * x1_init, xtol=1e-10)
    random = np.random.default_rng(4)
    state = solve_state(theta, eta, over + 0.03 * x1_init, contact)
    chain = Chain(theta, 20, state.s_c)
    start = chain.planar(lambda s: state.shape(s)[2])
    target = np.array([over + 0.03 * x1_init - 1 + state.s_c, eta, 0.0])
    mirrored = target * [-1, 1, 1]

    def push():
        return start + 0.02 * np.abs(start).max() * random.normal(size=start.shape)

    before, force = chain.minimum(target, start)
    swept, _ = chain.minimum(target, push())
    assert chain.energy(swept) == pytest.approx(chain.energy(before), abs=1e-6)
    beyond, other = chain.minimum(mirrored, start)
    aside, turned = chain.minimum(mirrored, push())
    assert chain.energy(beyond) > chain.energy(before) + 1e-3
    assert chain.energy(aside) == pytest.approx(chain.energy(before), abs=1e-6)
    # In the plane the chain is pushed on; swung round it pulls the other way, as strongly.
    assert other[0] == pytest.approx(force[0], rel=0.2)
    assert turned == pytest.approx(force * [-1, 1, 1], abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "offset", "mounting"),
    [
        (1.0, 0.85, 0.2, Mounting(clamp_angle=0.1)),
        (2.0, 0.8, 0.1, Mounting(curvature=(0.3, -0.6))),
        (2.0, 0.8, -0.1, Mounting(curvature=(0.3, -0.6))),
        (2.0, 0.7, 0.2, Mounting(clamp_angle=-0.1, clamp_compliance=0.3, curvature=0.4)),
    ],
)
def test_the_margin_is_that_of_a_chain_in_space(theta, eta, offset, mounting):
    state = solve_state(theta, eta, offset, mounting=mounting)
    margins = []
    for count in (10, 20):
        chain = Chain(
            theta,
            count,
            clamp_angle=mounting.clamp_angle,
            compliance=mounting.clamp_compliance,
            curvature=mounting.coefficients,
        )
        start = chain.planar(lambda s: state.shape(s)[2])
        margins.append(chain.margin_aside(*chain.minimum(np.array([offset, eta, 0.0]), start)))
    coarse, fine = margins
    assert state.stability_aside == pytest.approx((4 * fine - coarse) / 3, abs=2e-5)


@pytest.mark.slow
def test_a_chain_in_an_inclined_clamp_swings_to_the_rod_that_leans_the_other_way():
    beta, eta = -0.1, 0.85
    offset = -eta * np.tan(beta) - 0.02
    state = solve_state(1.0, eta, offset, mounting=Mounting(clamp_angle=beta))
    assert state.stability_aside < 0
    chain = Chain(1.0, 16, clamp_angle=beta)
    target = np.array([offset, eta, 0.0])
    start = chain.planar(lambda s: state.shape(s)[2])
    random = np.random.default_rng(4)
    planar, _ = chain.minimum(target, start)
    aside, force = chain.minimum(target, start + 0.02 * random.normal(size=start.shape))
    other = Chain(1.0, 16, clamp_angle=-beta)
    state = solve_state(1.0, eta, -offset, mounting=Mounting(clamp_angle=-beta))
    mirrored, pull = other.minimum(target * [-1, 1, 1], other.planar(lambda s: state.shape(s)[2]))
    assert chain.energy(planar) > chain.energy(aside) + 1e-3
    assert chain.energy(aside) == pytest.approx(other.energy(mirrored), abs=1e-6)
    assert force == pytest.approx(pull * [-1, 1, 1], abs=2e-3)
