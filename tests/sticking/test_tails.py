"""Where the free tail of a strongly curved rod comes to lie against the rod itself."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibrissa import Mounting, solve_curve
from vibrissa.outcomes import End

THETA, ETA = 8.0, 0.4


def halves(curvature, state):
    """Points of the free part and of the tail, integrated from the contact point both ways."""
    fx, fy, s_c = state.reaction_fx[0], state.reaction_fy[0], state.s_c[0]

    def equations(s, u, load):
        natural = curvature[0] + curvature[1] * s
        stiffness = (1.0 + (1.0 / THETA - 1.0) * s) ** 4
        moment = load * (fx * np.sin(u[2]) - fy * np.cos(u[2]))
        return [np.cos(u[2]), np.sin(u[2]), u[3] / stiffness + natural, moment]

    def part(end, load):
        start = [0.0, ETA, 0.0, 0.0]
        tight = {"rtol": 1e-12, "atol": 1e-13, "dense_output": True}
        found = solve_ivp(equations, [s_c, end], start, "DOP853", args=(load,), **tight)
        return found.sol(np.linspace(s_c, end, 4001))[:2]

    free, tail = part(0.0, 1.0), part(1.0, 0.0)
    assert abs(free[1, -1]) < 1e-9  # the clamp
    return free, tail


def gap(free, tail):
    """Distance of the tip from the free part (L), with a sign for the side on which it lies."""
    way = tail[:, -1:] - free
    nearest = int(np.argmin(np.hypot(*way)))
    tangent = free[:, nearest + 1] - free[:, nearest - 1]
    x, y = way[:, nearest]
    return float((tangent[0] * y - tangent[1] * x) / np.hypot(*tangent))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("curvature", "section"),
    [
        ((1.0, -12.0), "round"),
        pytest.param((1.0, -12.0), "planar", marks=pytest.mark.nightly),
        pytest.param((0.0, -4.0), "planar", marks=pytest.mark.nightly),
    ],
)
def test_the_path_ends_where_the_tail_touches_the_rod(curvature, section):
    mounting = Mounting(curvature=curvature)
    curve = solve_curve(THETA, ETA, mounting=mounting, contact="line", section=section)
    assert curve.end is End.OUT_OF_REACH and curve.end_message == "the rod crosses itself"
    earlier, before, at = (curve.state(np.array([curve.x0_end - d])) for d in (4e-3, 1e-3, 0.0))
    gaps = [gap(*halves(curvature, state)) for state in (earlier, before, at)]
    assert abs(gaps[2]) < 1e-8
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.2)  # it closes evenly


def test_a_tail_that_comes_near_the_rod_may_stay_clear_of_it():
    curvature = (1.0, -3.0)
    mounting = Mounting(curvature=curvature)
    curve = solve_curve(THETA, ETA, mounting=mounting, contact="line", section="planar")
    assert curve.end is End.SNAPS
    assert 2e-3 < gap(*halves(curvature, curve.state(np.array([curve.x0_end])))) < 4e-3
