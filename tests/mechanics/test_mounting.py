"""Mountings: their values, their natural shapes, and the equations with them."""

import numpy as np
import pytest
from scipy.optimize import root
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from vibrissa import Mounting
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import CURVATURE, rod_columns, tail
from vibrissa.outcomes import Contact
from vibrissa.sticking.api import solve_state
from vibrissa.sticking.solving.collocation import solve_curves


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"clamp_angle": 1.6}, "clamp_angle must lie between -pi/2 and pi/2 (rad), got 1.6"),
        ({"stage_angle": -2}, "stage_angle must lie between -pi/2 and pi/2 (rad), got -2.0"),
        ({"stage_angle": float("nan")}, "stage_angle must be a finite number (rad), got nan"),
        ({"clamp_angle": "2 deg"}, "clamp_angle must be a finite number (rad), got '2 deg'"),
        ({"clamp_angle": True}, "clamp_angle must be a finite number (rad), got True"),
        ({"clamp_compliance": -0.1}, "clamp_compliance must not be negative, got -0.1 L/(E I0)"),
        ({"curvature": ()}, "curvature must be a number or a list of numbers, got ()"),
        ({"curvature": None}, "curvature must be a number or a list of numbers, got None"),
        (
            {"curvature": np.array(1.0)},
            "curvature must be a number or a list of numbers, got array(1.)",
        ),
        ({"curvature": (0.1, "a")}, "curvature must be a finite number, got 'a'"),
    ],
)
def test_a_value_out_of_range_is_named(values, said):
    with pytest.raises(ArgumentError) as error:
        Mounting(**values)
    assert str(error.value) == said


def test_a_list_or_an_array_of_coefficients_is_as_good_as_a_tuple():
    assert Mounting(curvature=[0.1, 0.2]) == Mounting(curvature=(0.1, 0.2))
    assert Mounting(curvature=np.array([0.1, 0.2])) == Mounting(curvature=(0.1, 0.2))
    assert Mounting(curvature=(0.1, 0.0)) == Mounting(curvature=0.1)


def test_natural_shapes_are_circles_and_clothoids():
    rods = rod_columns(np.ones(2), [Mounting(curvature=-2.0), Mounting(curvature=(0.0, 3.0))])
    start, stop = np.full((2, 1), 0.2), np.full((2, 1), 0.9)
    along, up, turn = tail(rods[:, CURVATURE], start, stop)
    assert turn[:, 0] == pytest.approx([-1.4, 1.5 * (0.81 - 0.04)], abs=1e-14)
    # Circle of radius 1/2 that bends to the right
    assert along[0, 0] == pytest.approx(np.sin(1.4) / 2, abs=1e-14)
    assert up[0, 0] == pytest.approx((np.cos(1.4) - 1) / 2, abs=1e-14)
    s = np.linspace(0.2, 0.9, 100_001)
    assert along[1, 0] == pytest.approx(np.trapezoid(np.cos(1.5 * (s**2 - 0.04)), s), abs=1e-9)


def closed_form(eta, beta, c, curvature):
    """Force and tip of a cylinder at α = 0 in elliptic integrals: f, x1, m(0), φ1.

    With ψ = π/2 − φ the first integral is ψ'²/2 = f·(cos ψ − cos ψm), which is a pendulum of
    amplitude ψm: sin(ψ/2) = k·sin u, du/ds = √f. It begins at ψ(0) = −β − c·m(0) and ends where
    ψ' = −κ0, as no moment acts there.
    """

    def pendulum(unknowns):
        f, k, u0, u1 = unknowns
        root_f, m = np.sqrt(f), k * k
        moment = -2 * k * root_f * np.cos(u0) - curvature
        way = (ellipkinc(u1, m) - ellipkinc(u0, m)) / root_f
        height = 2 * (ellipeinc(u1, m) - ellipeinc(u0, m)) / root_f - way
        clamp = 2 * np.arcsin(k * np.sin(u0)) + beta + c * moment
        tip = 2 * k * root_f * np.cos(u1) + curvature
        x1 = 2 * k * (np.cos(u0) - np.cos(u1)) / root_f
        phi1 = np.pi / 2 - 2 * np.arcsin(k * np.sin(u1))
        return [way - 1, height - eta, clamp, tip], (f, x1, moment, phi1)

    k = root(lambda k: 2 * ellipe(k[0] ** 2) / ellipk(k[0] ** 2) - 1 - eta, [0.5]).x[0]
    start = [ellipk(k * k) ** 2, k, 0.0, np.pi / 2]
    solution = root(lambda u: pendulum(u)[0], start, tol=1e-13)
    assert np.abs(pendulum(solution.x)[0]).max() < 1e-11
    return pendulum(solution.x)[1]


@pytest.mark.parametrize(
    ("beta", "c", "curvature"),
    [(0.1, 0, 0), (-0.1, 0, 0), (0, 0.2, 0), (0, 0, 0.2), (0, 0, -0.2), (0.05, 0.1, -0.15)],
)
@pytest.mark.parametrize("eta", [0.85, 0.6])
def test_a_cylinder_at_the_beginning_agrees_with_elliptic_integrals(eta, beta, c, curvature):
    mounting = Mounting(clamp_angle=beta, clamp_compliance=c, curvature=curvature)
    (curve,) = solve_curves(np.array([1.0]), np.array([eta]), Contact.POINT, [mounting])
    f, x1, moment, phi1 = closed_form(eta, beta, c, curvature)
    state = curve.state(0.0)
    assert curve.x1_init == pytest.approx(x1, abs=1e-11)
    assert -state.reaction_fy == pytest.approx(f, abs=1e-10)
    assert state.reaction_m == pytest.approx(moment, abs=1e-10)
    assert state.phi1 == pytest.approx(phi1, abs=1e-10)


def test_a_shape_keeps_its_clamp_and_its_tail():
    mounting = Mounting(clamp_angle=-0.1, clamp_compliance=0.2, curvature=(-0.1, -0.3))
    state = solve_state(4.0, 0.8, 0.3, "line", mounting)
    s = np.array([0.0, state.s_c, 1.0])
    x, y, phi = state.shape(s)
    assert state.s_c < 1.0
    assert phi[0] == pytest.approx(np.pi / 2 - 0.1 + 0.2 * state.reaction_m, abs=1e-11)
    assert (x[1] + 1.0 - state.s_c, y[1]) == pytest.approx((0.3, 0.8), abs=1e-11)
    # The tail turns away from the surface by its own curvature.
    turn = -0.1 * (1 - state.s_c) - 0.15 * (1 - state.s_c**2)
    assert phi[2] == pytest.approx(turn, abs=1e-11) and y[2] < 0.8
