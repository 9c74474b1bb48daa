"""Shapes that the model cannot describe are named, not returned."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.optimize import minimize

import vibrissa
from rod_states import made_states
from vibrissa import Mounting, Status, solve_state, stick_slip
from vibrissa.mechanics.admissibility import (
    BELOW_CLAMP,
    CROSSES_ITSELF,
    CROSSES_SURFACE,
    clearances,
)
from vibrissa.mechanics.equations import shape
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import Contact, End, RodSection
from vibrissa.sticking.solving import shooting


# A round rod swings aside before its shape is inadmissible.
def solve_curve(*arguments, **kind):
    return vibrissa.solve_curve(*arguments, section="planar", **kind)


def solve_onset(*arguments, **kind):
    return vibrissa.solve_onset(*arguments, section="planar", **kind)


def rod(slope, nodes=64):
    """A cylinder with the slope phi(s) given as a function."""
    s = gauss_rule(nodes).nodes
    return made_states(1.0, slope(s), 0.0, -1.0)


def seen(states, eta, contact=Contact.LINE):
    states.line[:] = contact is Contact.LINE
    return clearances(states, np.array([eta])).reasons(0)


def test_an_upright_rod_is_fine():
    assert seen(rod(lambda s: np.pi / 2 - 0.3 * s), 0.99) == ""


def test_a_rod_that_hangs_below_its_clamp():
    assert BELOW_CLAMP in seen(rod(lambda s: np.pi / 2 - 1.6 * np.pi * s), 0.5, Contact.POINT)


def test_a_rod_that_rises_above_the_surface_before_it_touches():
    # Up over the line, down through it and up to it again.
    arch = rod(lambda s: np.pi / 2 + 3.5 * np.sin(2 * np.pi * s) * s)
    top = shape(arch, np.linspace(0, 1, 401))[1].max()
    assert CROSSES_SURFACE in seen(arch, top - 1e-3)
    assert CROSSES_SURFACE not in seen(arch, top + 1e-3)


def test_a_loop_crosses_itself_and_an_open_bow_does_not():
    loop = rod(lambda s: np.pi / 2 + 1.7 * np.pi * (s - np.sin(2 * np.pi * s) / (2 * np.pi)))
    bow = rod(lambda s: np.pi / 2 + 1.1 * np.pi * s)
    assert CROSSES_ITSELF in seen(loop, 0.9, Contact.POINT)
    assert CROSSES_ITSELF not in seen(bow, 0.9, Contact.POINT)


@pytest.mark.parametrize("turn", [1.4, 1.6, 1.9])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_loop_overlaps_by_the_angle_at_which_it_crosses(turn, side):
    """A rod that turns most in its middle, and whose halves are mirror images."""

    def slope(s):
        bend = s - np.sin(2 * np.pi * s) / (2 * np.pi)
        return np.pi / 2 + side * turn * np.pi * bend

    states = rod(slope)
    x, y, phi = (values[0] for values in shape(states, np.linspace(0.0, 1.0, 2001)))
    # It is symmetric about its middle: s and 1 - s are in one place.
    middle = np.array([np.cos(phi[1000]), np.sin(phi[1000])])
    along = np.stack([x - x[::-1], y - y[::-1]], axis=-1) @ middle
    place = np.flatnonzero((along[:1000] > 0.0) != (along[1:1001] > 0.0))[-1]
    angle = phi[2000 - place] - phi[place]
    found = clearances(states, np.array([0.9]))
    assert found.itself[0] == pytest.approx(-abs(np.sin(angle)), abs=0.01)


# Turn from end to end, and amplitudes of sines that are added to the slope.
NEAR_ITSELF = {
    "its ends": (-5.199, 1.858, 0.401, 4.386, 0.504, 0.118),
    "behind its end": (-5.403, 1.591, 0.697, 3.73, 1.309, 0.825),
    "its clamp": (5.002, 1.996, 5.489, 3.675, 1.608, 1.012),
    "its clamp from the other side": (-3.199, -0.785, 2.258, 0.704, 1.398, 1.142),
}


@pytest.mark.parametrize("name", NEAR_ITSELF)
def test_a_rod_that_comes_near_itself_does_not_cross_itself(name):
    """Where no way from part to part is normal to both, a search for one finds none."""
    turn, *sines = NEAR_ITSELF[name]

    def slope(s):
        waves = (a / k * np.sin(np.pi * k * s) for k, a in enumerate(sines, 1))
        return np.pi / 2 + turn * s + sum(waves)

    states = rod(slope)
    found = clearances(states, np.array([0.9]))
    x, y, phi = (values[0] for values in shape(states, np.linspace(0.0, 1.0, 801)))
    assert count_crossings(x, y) == 0
    i, j = np.triu_indices(len(x), 2)
    turned = np.abs(phi[j] - phi[i]) > np.pi - 0.3
    nearest = np.hypot(x[j] - x[i], y[j] - y[i])[turned].min()
    assert CROSSES_ITSELF not in found.reasons(0)
    # Known where the parts are nearest at nodes of the rod alone.
    assert nearest * 0.999 < found.itself[0] < nearest + 0.002


@pytest.mark.slow
def test_where_a_rod_begins_to_cross_itself_agrees_with_its_drawn_shape():
    curve = solve_curve(3.0, 0.3395)
    assert curve.end is End.OUT_OF_REACH and CROSSES_ITSELF in curve.end_message

    def crossings(x0):
        state = solve_state(3.0, 0.3395, curve.x1_init - x0)
        if state.status is not Status.SOLVED:
            return None
        x, y, _ = state.shape(np.linspace(0, 1, 801))
        return count_crossings(x, y)

    assert crossings(0.995 * curve.x0_end) == 0
    beyond = solve_state(3.0, 0.3395, curve.x1_init - 1.01 * curve.x0_end)
    assert beyond.status is Status.OUT_OF_REACH and CROSSES_ITSELF in beyond.message
    assert np.isnan(beyond.f)
    with pytest.raises(ValueError, match="out_of_reach"):
        beyond.shape()


def count_crossings(x, y):
    """By orientation of triangles, which has nothing to do with intersecting segments."""
    p = np.stack([x, y], axis=-1)
    a, b = p[:-1], p[1:]

    def side(u, v, w):
        along, away = v - u, w - u
        return np.sign(along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0])

    i, j = np.triu_indices(len(a), 2)
    return int(
        (
            (side(a[i], b[i], a[j]) * side(a[i], b[i], b[j]) < 0)
            & (side(a[j], b[j], a[i]) * side(a[j], b[j], b[i]) < 0)
        ).sum()
    )


def integrated(curve, x0):
    """The shape at a displacement, integrated from the contact point, where it bears no moment."""
    state = curve.state(x0)
    fx, fy, s_c = float(state.reaction_fx), float(state.reaction_fy), float(state.s_c)

    def equations(s, u):
        stiffness = (1.0 + (1.0 / curve.theta - 1.0) * s) ** 4
        return [np.cos(u[2]), np.sin(u[2]), u[3] / stiffness, fx * np.sin(u[2]) - fy * np.cos(u[2])]

    s = np.linspace(0.0, 1.0, 20001)
    touches = curve.x1_init - float(state.x0) - (1.0 - s_c)
    start = [touches, curve.eta, float(state.phi1), 0.0]
    found = solve_ivp(
        equations, [s_c, 0.0], start, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True
    )
    x, y, phi, _ = found.sol(np.minimum(s, s_c))
    return s, (x + np.maximum(s - s_c, 0.0), y, phi)


@pytest.mark.parametrize(
    ("theta", "eta", "contact"), [(1.0, 0.3, "point"), (1.0, 0.3126, "point"), (1.0, 0.3, "line")]
)
def test_a_rod_ends_exactly_where_it_comes_down_to_its_clamps_level(theta, eta, contact):
    curve = solve_curve(theta, eta, contact=contact)
    assert curve.end is End.OUT_OF_REACH and BELOW_CLAMP in curve.end_message
    _, (_, y, _) = integrated(curve, curve.x0_end)
    # Between the points a parabola has its lowest point this far below them.
    assert y[200:].min() == pytest.approx(0.0, abs=1e-8)
    _, (_, y, _) = integrated(curve, curve.x0_end - 1e-5)
    assert y[200:].min() > 1e-7


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta"),
    [
        (2.489112441604889, 0.3041897094801299),
        (3.0, 0.3395),
        pytest.param(12.0, 0.5, marks=pytest.mark.nightly),
    ],
)
def test_a_rod_ends_exactly_where_two_parts_of_it_touch(theta, eta):
    curve = solve_curve(theta, eta)
    assert curve.end is End.OUT_OF_REACH and CROSSES_ITSELF in curve.end_message

    def nearest(x0):
        """Distance of the two parts, by a search over both places."""
        s, (x, y, phi) = integrated(curve, x0)
        place = make_interp_spline(s, np.stack([x, y], axis=-1), k=5)
        coarse = np.arange(0, len(s), 100)
        i, j = np.triu_indices(len(coarse), 2)
        far = np.abs(phi[coarse[j]] - phi[coarse[i]]) > np.pi - 0.2
        i, j = coarse[i[far]], coarse[j[far]]
        pair = np.argmin(np.hypot(x[i] - x[j], y[i] - y[j]))
        found = minimize(
            lambda at: np.hypot(*(place(at[0]) - place(at[1]))),
            [s[i[pair]], s[j[pair]]],
            method="Nelder-Mead",
            bounds=[(0.0, 1.0), (0.0, 1.0)],
            options={"xatol": 1e-13, "fatol": 1e-15, "maxiter": 2000},
        )
        return found.fun, np.hypot(x[0], y[0])

    distance, miss = nearest(curve.x0_end)
    # What integration makes of a strong taper is seen at the clamp.
    assert distance < 1e-9 + miss and miss < 1e-8
    assert nearest(curve.x0_end - 1e-4)[0] > 1e-6


def test_of_a_shape_that_only_dips_for_a_while_the_first_moment_counts():
    # It dips between two looks: from far, the branch seems to go on to where it turns back.
    dips, stays = (solve_curve(1.0, eta) for eta in (0.312745, 0.312746))
    assert dips.x0_end < 1.303 < stays.x0_end
    _, (_, y, _) = integrated(stays, 1.3026)
    assert 0.0 < y[200:].min() < 1e-5


def test_a_tip_that_slips_before_its_rod_crosses_itself_does_slip():
    curve = solve_curve(2.0, 0.15)
    assert curve.status is Status.OUT_OF_REACH and curve.message == CROSSES_ITSELF
    assert curve.x0_end == pytest.approx(0.674, abs=1.1e-3)
    assert np.isnan(curve.mu_lock) and np.isnan(curve.x0_lock)
    slips, not_known = curve.onset([0.3, 5.0])
    assert slips == pytest.approx(0.04213929, abs=1e-7) and np.isnan(not_known)
    assert float(curve.mobilised_friction(slips)) == pytest.approx(0.3, abs=1e-9)
    with pytest.raises(ValueError, match="lock of this curve is not known: the rod crosses"):
        curve.motion_end(5.0)


@pytest.mark.slow
def test_shooting_ends_in_the_step_in_which_a_rod_crosses_itself(monkeypatch):
    """In coarse steps, and searched less closely than a study does; a night has fine ones."""
    monkeypatch.setattr(shooting, "LARGEST_STEP", 0.04)
    coarse = shooting.Tolerances(rtol=1e-6, atol=1e-7, simplex=1e-6, miss=1e-4)
    curve = shooting.solve_curve(2.0, 0.15, 0.025, coarse, RodSection.PLANAR)
    assert curve.status is Status.OUT_OF_REACH and curve.message == CROSSES_ITSELF
    assert 0.0 <= curve.x0_end - solve_curve(2.0, 0.15).x0_end < 0.025


@pytest.mark.slow
def test_points_of_a_curve_that_ends_before_its_lock_slip_or_are_out_of_reach():
    known, unknown = (solve_onset(2.0, mu0, 0.15, dx0=0.001) for mu0 in (0.3, 5.0))
    assert known.status is Status.SLIP and known.x0_max == 0.042
    assert unknown.status is Status.OUT_OF_REACH and unknown.message == CROSSES_ITSELF
    assert np.isnan(unknown.x0_slip) and unknown.n_steps is None and unknown.end == ""
    curve = solve_curve(2.0, 0.15)
    assert len(stick_slip(curve, 0.3, 0.01, cycles=2).step) == 11
    assert stick_slip(curve, 5.0, 0.01, cycles=2).status is Status.OUT_OF_REACH


@pytest.mark.slow
@pytest.mark.parametrize(("eta", "hangs"), [(0.3, False), (0.15, True)])
def test_a_tail_does_not_hang_below_the_clamp(eta, hangs):
    curve = solve_curve(1.0, eta, contact="line", mounting=Mounting(curvature=-1.0))
    assert ("below the level of its clamp" in curve.message) == hangs
    if not hangs:
        tail = 1.0 - curve.state(0.0).s_c
        assert tail > 0.4 and 1.0 - np.cos(tail) < eta


def test_a_rod_has_no_tail_beyond_its_tip():
    # Up to its tip, at s = 1, this rod bends away from the surface, and beyond s = 1.02 towards it.
    curved = vibrissa.Mounting(curvature=[-0.1, *[0.0] * 7, 0.09])
    curve = vibrissa.solve_curve(3, 0.8, contact="line", mounting=curved)
    assert curve.status is Status.SOLVED and curve.end is End.SWINGS_ASIDE
