"""Where a rod that is curved towards the surface first arches over it, by an independent scan."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibrissa import Mounting, solve_curve
from vibrissa.outcomes import End

# Taper, height, clamp angle, curvature, and where the first arch begins (L).
ARCHES = [
    (1.2, 0.7192, -0.0251, 0.3, 0.2370),
    (1.2, 0.7192, -0.0251, 0.4, 0.2500),
    (1.2, 0.7192, -0.0251, 0.5, 0.2638),
]


def rise(rod, state, eta):
    """Height of the rod's highest point above the surface (L), the tip left out.

    The rod is integrated from its tip, where it bears no moment, by the force of a state.
    """
    theta, _, _, curvature = rod
    fx, fy, phi1 = state.reaction_fx[0], state.reaction_fy[0], state.phi1[0]

    def equations(s, u):
        stiffness = (1.0 + (1.0 / theta - 1.0) * s) ** 4
        moment = fx * np.sin(u[2]) - fy * np.cos(u[2])
        return [np.cos(u[2]), np.sin(u[2]), u[3] / stiffness + curvature, moment]

    start = [0.0, eta, phi1, 0.0]
    found = solve_ivp(
        equations, [1.0, 0.0], start, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True
    )
    assert abs(found.y[1, -1]) < 1e-11  # the clamp
    assert found.y[3, -1] == pytest.approx(state.reaction_m[0], abs=1e-10)
    return float((found.sol(np.linspace(0.0, 0.9999, 20_001))[1] - eta).max())


@pytest.mark.parametrize("section", ["round", "planar"])
@pytest.mark.parametrize("rod", ARCHES, ids=lambda rod: f"{rod[3]}")
def test_the_path_ends_where_the_first_arch_begins(rod, section):
    theta, eta, angle, curvature, begins = rod
    mounting = Mounting(clamp_angle=angle, curvature=curvature)
    curve = solve_curve(theta, eta, mounting=mounting, section=section)
    assert curve.end is End.OUT_OF_REACH and curve.x0_end == pytest.approx(begins, abs=5e-5)
    assert "crosses the surface away from its contact point" in curve.end_message
    # φ1 is still positive there: the tip itself does not pass through.
    before, at = (curve.state(np.array([curve.x0_end - d])) for d in (1e-4, 0.0))
    assert at.phi1[0] > 0.0
    assert rise(rod[:4], before, eta) < 0.0
    assert abs(rise(rod[:4], at, eta)) < 1e-8


def test_an_arch_where_the_tip_comes_back_up_is_found():
    """For a way of 2e-4 after φ1 has become positive again the rod is 1e-5 above the surface."""
    theta, eta, angle, curvature = 1.5843943577967505, 0.5315886669620499, 0.133237, 0.433397
    mounting = Mounting(clamp_angle=angle, curvature=curvature)
    curve = solve_curve(theta, eta, mounting=mounting, section="planar")
    assert curve.end is End.OUT_OF_REACH
    state = curve.state(np.array([curve.x0_end]))
    assert abs(state.phi1[0]) < 1e-4
    assert rise((theta, eta, angle, curvature), state, eta) > 5e-6


def test_a_rod_without_an_arch_goes_on():
    """Straight, or curved away, it touches the surface tangentially without one."""
    for curvature in (0.0, -0.2):
        curve = solve_curve(2.0, 0.6, mounting=Mounting(clamp_angle=0.05, curvature=curvature))
        assert curve.end is not End.OUT_OF_REACH and curve.x0_touch >= 0.0
