"""The response of a rod that is pulled and pushed."""

import numpy as np
import pytest

import reference
from responses import respond
from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.errors import NoResponseError
from vibrissa.mechanics.bending import measure
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.mechanics.taper import diameter
from vibrissa.outcomes import Contact
from vibrissa.scanning import response_over_eta
from vibrissa.scanning.response import Response
from vibrissa.scanning.response_over_eta import agrees
from vibrissa.sensor import Whisker
from vibrissa.sensor.onset import strains_in

TILTED = Mounting(clamp_angle=0.035, clamp_compliance=0.1, curvature=-0.1)


@pytest.fixture(scope="module", params=[(2.0, 0.85, "point"), (2.0, 0.6, "line")])
def response(request):
    return respond(*request.param)


def contact_of(response):
    return "point" if response.curve.eta == 0.85 else "line"


def integral(response, start, stop):
    """Integrals of fx, fy and m over x0, on one smooth stretch."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    half = 0.5 * (stop - start)
    return half * (weights @ response.reactions(start + half * (1.0 + nodes)))


def test_pushed_it_is_the_sticking_curve(response):
    x0 = np.linspace(0.0, response.curve.x0_lock, 400)
    state = response.curve.state(x0)
    expected = np.array([state.reaction_fx, state.reaction_fy, state.reaction_m]).T
    assert response.reactions(x0) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("part", [0.02, 0.37, 0.71, 0.98])
def test_pulled_it_is_the_equilibrium(response, part):
    x0 = part * response.x0_pull
    curve = response.curve
    state = solve_state(curve.theta, curve.eta, curve.x1_init - x0, contact_of(response))
    expected = [state.reaction_fx, state.reaction_fy, state.reaction_m]
    assert response.reactions(x0) == pytest.approx(expected, abs=1e-7)


def test_pulling_ends_where_the_surface_would_have_to_pull(response):
    fx, fy, _ = response.reactions(response.x0_pull)
    assert fx > 0.1
    assert fy == pytest.approx(0.0, abs=1e-7)


def test_the_work_of_the_clamp_bends_the_rod():
    response = respond(2.0, 0.85)
    x0 = np.array([0.0, 0.03, 0.1, 0.6 * response.x0_pull])
    fx, fy, _ = response.reactions(x0).T
    x1, one = response.curve.x1_init - x0, np.ones_like(x0)
    bent = measure(2 * one, np.hypot(fx, fy), np.arctan2(fx, -fy), x1, 0.85 * one)
    work = [-integral(response, 0.0, end)[0] for end in x0]
    assert work == pytest.approx(bent.energy - bent.energy[0], abs=1e-5)


@pytest.mark.parametrize("mounting", [Mounting(), TILTED])
def test_strain_of_a_rod_without_taper_is_largest_where_the_moment_is(mounting):
    curve = solve_curve(1.0, 0.85, mounting=mounting)
    state = curve.state(0.0)
    # |φ' − κ0| is the moment, at the clamp; the radius is half the diameter.
    strain = strains_in([curve], [0.0]).strain[0]
    assert strain == pytest.approx(abs(state.reaction_m) / 2.0, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "pull"),
    [pytest.param(8.0, 0.7, -0.067879, marks=pytest.mark.nightly), (6.0, 0.5, -0.050911)],
)
def test_strongly_tapered_rod_in_line_contact_is_pulled_to_where_it_has_no_normal_force(
    theta, eta, pull
):
    response = respond(theta, eta, "line")
    assert response.x0_pull == pytest.approx(pull, abs=5e-6)
    fx, fy, _ = response.reactions(response.x0_pull)
    assert fx > 0.0 and fy == pytest.approx(0.0, abs=1e-9)
    # Near where the tip alone is left s_c runs steeply.
    tip = response.bounds[1]
    for x0 in (0.5 * tip, tip + 1e-4, tip + 1e-5):
        state = solve_state(theta, eta, response.x1_init - x0, "line")
        near = (state.s_c + 1e-6, -state.reaction_fy, state.reaction_fx)
        _, p, q = reference.solve_line_offset(theta, eta, response.x1_init - x0, near)
        assert response.reactions(x0)[:2] == pytest.approx([q, -p], abs=1e-6 * q)


@pytest.mark.parametrize("part", [0.15, 0.45, 0.6])
def test_largest_strain_is_that_between_the_points_too(part):
    # In a strongly tapered rod it is a sharp peak near the tip.
    curve = solve_curve(6.0, 0.7)
    x0 = part * curve.x0_lock
    state = curve.state(np.array(x0))
    f, alpha, x1 = float(state.f), float(state.alpha), curve.x1_init - x0
    s = np.linspace(0.0, 1.0, 20001)
    x, y, _ = deformed_shape(6.0, f, alpha, x1, 0.7, s)
    moment = f * (np.cos(alpha) * (x - x1) + np.sin(alpha) * (y - 0.7))
    expected = (0.5 * np.abs(moment) / (1.0 - s * 5.0 / 6.0) ** 3).max()
    assert strains_in([curve], [x0]).strain[0] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("theta", [2.0, 4.0, 20.0])
def test_a_hardly_bent_cone_is_strained_most_where_it_is_half_as_thick_again_as_its_tip(theta):
    # A cantilever with a load at its tip: m ∝ 1 − s, and (1 − s)/d³ is largest at d = 1.5/θ.
    one = np.ones(1)
    found = measure(theta * one, 1e-4 * one, 0.5 * np.pi * one, 0.0 * one, one, one)
    assert diameter(found.place, theta) * theta == pytest.approx(1.5, abs=0.02)
    assert found.strain == pytest.approx(0.5e-4 * 4 * theta**3 / 27 / (theta - 1), rel=1e-3)


def test_a_hardly_bent_cylinder_is_strained_most_at_the_clamp():
    one = np.ones(1)
    for theta in (1.0, 1.4):
        found = measure(theta * one, 1e-4 * one, 0.5 * np.pi * one, 0.0 * one, one, one)
        assert found.place == [0.0] and found.strain == pytest.approx(0.5e-4, rel=1e-3)


def test_a_response_has_the_mounting_where_the_clamp_pushes_and_pulls():
    response = respond(2.0, 0.85, mounting=TILTED)
    assert response.x0_pull < 0.0
    for x0 in (0.8 * response.x0_pull, 0.5 * response.x0_lock):
        state = solve_state(2.0, 0.85, response.x1_init - x0, mounting=TILTED)
        expected = [state.reaction_fx, state.reaction_fy, state.reaction_m]
        assert response.reactions(x0) == pytest.approx(expected, abs=1e-7)


@pytest.mark.nightly
@pytest.mark.slow
def test_a_tiny_last_piece_of_a_curve_is_left_out():
    mounting = Mounting(stage_angle=np.deg2rad(3.0))
    rod = Whisker(theta=1.0, eta=0.75, contact=Contact.LINE, mounting=mounting)
    with pytest.raises(NoResponseError, match="is not known: the sticking curve has status failed"):
        rod.stage(np.array([0.0, 1.0]))


def test_an_oblique_stage_has_no_response():
    with pytest.raises(NoResponseError, match="a response at one distance needs stage_angle 0"):
        respond(2.0, 0.85, mounting=Mounting(stage_angle=0.01))


class Scaled(Response):
    """A response with reactions that are larger by a factor beyond some x0."""

    def __init__(self, curve, factor, beyond=-np.inf):
        super().__init__(curve=curve)
        object.__setattr__(self, "factor", factor)
        object.__setattr__(self, "beyond", beyond)

    def derivative(self, x0, order):
        factor = np.where(np.asarray(x0) > self.beyond, self.factor, 1.0)
        return factor[..., None] * super().derivative(x0, order)


def test_a_branch_agrees_up_to_the_lock_within_the_tolerance_of_its_largest_reaction():
    branch = respond(2.0, 0.85)
    for factor in (1.0, 1.009, 0.991, 1.011, 0.98):
        assert agrees(Scaled(branch.curve, factor), branch, 0.01) == (abs(factor - 1.0) < 0.01)
    other = Scaled(branch.curve, 2.0, beyond=1.05 * branch.x0_lock)
    assert agrees(other, branch, 1e-9)
    assert not agrees(Scaled(branch.curve, 1.0 + 2e-9), branch, 1e-9)


def parts_of(monkeypatch, low, high, fails):
    """Parts of a range of heights, of which some fail to be interpolated."""

    def made(whisker, low, high):
        if fails(low, high):
            raise NoResponseError("no contact")
        return low, high

    monkeypatch.setattr(response_over_eta, "interpolated", made)
    return np.array(response_over_eta.respond_over(Whisker(theta=2.0, eta=0.6), low, high).parts)


def test_a_range_is_solved_in_parts_of_a_twentieth_around_the_height_of_the_rod(monkeypatch):
    parts = parts_of(monkeypatch, 0.53, 0.68, lambda low, high: False)
    edges = np.array([0.53, 0.55, 0.6, 0.65, 0.68])
    assert parts == pytest.approx(np.stack([edges[:-1], edges[1:]], axis=1))


def test_a_range_is_solved_in_smaller_parts_where_these_are_resolved(monkeypatch):
    parts = parts_of(monkeypatch, 0.6, 0.7, lambda low, high: low < 0.65 and high - low > 0.03)
    assert np.diff(parts)[:, 0] == pytest.approx([0.025, 0.025, 0.05])


def test_a_height_without_a_response_is_named(monkeypatch):
    said = (
        r"distances from 0\.6699\d* L to 0\.6703\d* L, where the response is not known: no contact"
    )
    with pytest.raises(NoResponseError, match=said):
        parts_of(monkeypatch, 0.6, 0.9, lambda low, high: low < 0.67 < high)
