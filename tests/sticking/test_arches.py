"""Where a rod that is curved towards the surface first arches over it, by an independent scan."""

from decimal import Decimal

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.outcomes import End
from vibrissa.sticking.periods import read_curve

# Curvature, and where the first arch begins (L), of rods of one taper, height and clamp angle.
ARCHES = [(0.3, 0.2370), (0.4, 0.2500), (0.5, 0.2638)]


def rise(theta, curvature, state, height):
    """Height of the rod's highest point above the surface (L), the tip left out.

    The rod is integrated from its tip, where it bears no moment, by the force of a state.
    """
    fx, fy, phi1 = state.reaction_fx[0], state.reaction_fy[0], state.phi1[0]

    def equations(s, u):
        stiffness = (1.0 + (1.0 / theta - 1.0) * s) ** 4
        moment = fx * np.sin(u[2]) - fy * np.cos(u[2])
        natural = np.polynomial.polynomial.polyval(s, curvature)
        return [np.cos(u[2]), np.sin(u[2]), u[3] / stiffness + natural, moment]

    start = [0.0, 0.0, phi1, 0.0]
    found = solve_ivp(
        equations, [1.0, 0.0], start, "DOP853", rtol=1e-12, atol=1e-15, dense_output=True
    )
    assert abs(found.y[1, -1] + height) < 1e-11  # the clamp
    assert found.y[3, -1] == pytest.approx(state.reaction_m[0], abs=1e-10)
    return float(found.sol(1.0 - np.geomspace(1e-6, 1.0, 20_001))[1].max())


@pytest.mark.parametrize("section", ["round", pytest.param("planar", marks=pytest.mark.nightly)])
@pytest.mark.parametrize(("curvature", "begins"), ARCHES)
def test_a_rod_penetrates_from_where_the_first_arch_begins(curvature, begins, section):
    theta, eta = 1.2, 0.7192
    mounting = Mounting(clamp_angle=-0.0251, curvature=curvature)
    curve = solve_curve(theta, eta, mounting=mounting, section=section)
    # In the model in which only the tip may touch, the path goes on.
    assert curve.end is not End.OUT_OF_REACH and curve.x0_end > begins + 0.1
    before, after = (curve.state(np.array([begins + d])) for d in (-1e-4, 1e-4))
    # φ1 is still positive there: the tip itself does not pass through.
    assert after.phi1[0] > 0.0
    assert rise(theta, curvature, before, eta) < 0.0 < rise(theta, curvature, after, eta)
    states = [
        solve_state(theta, eta, curve.x1_init - begins - d, mounting=mounting)
        for d in (-1e-4, 1e-4)
    ]
    assert [state.penetrates for state in states] == [False, True]
    assert curve.x0_lock < begins and np.isnan(curve.x0_touch)


@pytest.mark.parametrize(("curvature", "begins"), ARCHES[:1])
def test_a_rod_that_may_lie_down_ends_where_the_first_arch_begins(curvature, begins):
    mounting = Mounting(clamp_angle=-0.0251, curvature=curvature)
    curve = solve_curve(1.2, 0.7192, contact="line", mounting=mounting, section="planar")
    assert curve.end is End.OUT_OF_REACH and curve.x0_end == pytest.approx(begins, abs=5e-5)
    assert "crosses the surface away from its contact point" in curve.end_message


def test_a_path_does_not_end_where_a_penetration_ends():
    """The rod is above the surface all along; first its tip comes down to it, later it does not."""
    mounting = Mounting(clamp_angle=0.2345, curvature=(0.499, 0.195), stage_angle=0.0366)
    curve = solve_curve(2.7468, 0.6336, mounting=mounting, section="planar")
    assert curve.end is End.SNAPS and curve.x0_end == pytest.approx(0.93904358, abs=1e-8)
    assert curve.x0_touch == 0.0
    state = curve.state(np.array([0.8016]))
    assert state.phi1[0] > 0.0
    height = 0.6336 - 0.8016 * np.sin(0.0366)
    assert rise(2.7468, mounting.coefficients, state, height) > 1e-8


# Taper, height, mounting, and by how much the rod rises where its tip is level (L).
LEVEL_TIPS = [
    (
        6.237525713536285,
        0.9082606802611423,
        Mounting(
            clamp_angle=0.1419331470857091,
            clamp_compliance=0.024164059372607426,
            curvature=(-0.19173317355200437, 0.19599117117486464),
            stage_angle=-0.059616152586255966,
        ),
        2.2e-13,
    ),
    (2.0, 0.78, Mounting(curvature=1e-9), 0.0),
]


@pytest.mark.parametrize(("theta", "eta", "mounting", "rises"), LEVEL_TIPS)
def test_an_arch_below_the_tolerance_is_none(theta, eta, mounting, rises):
    """A level tip that is curved towards the surface makes an arch, be it of atoms."""
    curve = solve_curve(theta, eta, mounting=mounting, contact="point")
    assert curve.end is End.SWINGS_ASIDE and curve.x0_touch < curve.x0_lock
    level = curve.state(np.array([curve.x0_touch]))
    assert abs(level.phi1[0]) < 1e-12
    height = curve.contact_point(curve.x0_touch)[1]
    assert rise(theta, mounting.coefficients, level, height) == pytest.approx(rises, abs=3e-14)


def test_a_rod_without_an_arch_goes_on():
    """Straight, or curved away, it touches the surface tangentially without one."""
    for curvature in (0.0, -0.2):
        curve = solve_curve(2.0, 0.6, mounting=Mounting(clamp_angle=0.05, curvature=curvature))
        assert curve.end is not End.OUT_OF_REACH and curve.x0_touch >= 0.0


def test_an_arch_before_the_lock_is_the_first_touch():
    theta, eta = 1.809360141291611, 0.6122920571808584
    mounting = Mounting(clamp_angle=-0.1, curvature=0.5821770123928727)
    curve = solve_curve(theta, eta, mounting=mounting, section="planar")
    assert curve.x0_touch == pytest.approx(0.00473966, abs=1e-7) and curve.x0_touch < curve.x0_lock
    before, at = (curve.state(np.array([curve.x0_touch - d])) for d in (1e-4, 0.0))
    assert at.phi1[0] > 1e-3
    assert rise(theta, mounting.coefficients, before, eta) < 0.0
    assert abs(rise(theta, mounting.coefficients, at, eta)) < 1e-8
    period = read_curve(curve, [Decimal("0.3")], [Decimal("0.01")])
    assert period.status == ["slip"] and period.x0_slip[0] > curve.x0_touch
    assert period.penetrates.tolist() == [True]
