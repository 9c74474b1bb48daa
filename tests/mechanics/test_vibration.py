"""Natural frequencies of the rod: closed forms, limits, and the margin of stability."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

from rod_states import first_states, made_states
from vibrissa import Mounting
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.vibration import (
    natural_frequencies,
    squared_frequencies,
    unloaded_states,
)
from vibrissa.outcomes import Contact, TipMotion

FREE, STICKS, SLIDES = TipMotion.FREE, TipMotion.STICKS, TipMotion.SLIDES


def free(theta, count, mounting=IDEAL):
    return natural_frequencies(unloaded_states(np.array([theta]), [mounting]), count, FREE)[0]


def test_a_uniform_rod_before_contact_is_the_clamped_free_beam():
    roots = [
        brentq(lambda k: np.cos(k) * np.cosh(k) + 1.0, *ends, xtol=1e-15)
        for ends in ((1.5, 2.0), (4.5, 5.0))
    ]
    assert free(1.0, 2) == pytest.approx(np.square(roots), abs=1e-9)
    assert free(1.0, 2) == pytest.approx([3.5160152687, 22.0344915647], abs=1e-9)


def test_a_straight_rod_with_its_tip_held_is_the_clamped_pinned_beam():
    roots = [
        brentq(lambda k: np.tan(k) - np.tanh(k), *ends, xtol=1e-15)
        for ends in ((3.5, 4.5), (6.9, 7.5))
    ]
    straight = made_states(1.0, np.full(24, np.pi / 2), 0.0, 0.0)
    assert natural_frequencies(straight, 2, STICKS)[0] == pytest.approx(np.square(roots), abs=1e-9)
    assert natural_frequencies(straight, 2)[0] == pytest.approx(
        [15.418205717, 49.96486203], abs=1e-8
    )


@pytest.mark.parametrize("theta", [1.2, 2.0, 4.0, 10.0, 50.0])
def test_a_cone_before_contact_has_the_frequencies_of_bessel_functions(theta):
    """Solutions y = C(2λ√z)/z of (z⁴·y'')'' = λ⁴·z²·y with C = J2, Y2, I2, K2; z ∝ d.

    G. Kirchhoff 1879; H. D. Conway, E. C. H. Becker, J. F. Dubil 1964.
    """
    short = 1.0 - 1.0 / theta

    def determinant(omega):
        # z runs from 1 at the clamp to 1/θ at the tip; λ⁴ = ω²/(1 − 1/θ)⁴.
        a, b = 2.0 * np.sqrt(omega) / short * np.sqrt([1.0, 1.0 / theta])
        rows = [
            # y and y' at the clamp, y'' and (z⁴·y'')' at the tip, without common factors
            [jv(2, a), yv(2, a), iv(2, a), kv(2, a)],
            [-jv(3, a), -yv(3, a), iv(3, a), -kv(3, a)],
            [jv(4, b), yv(4, b), iv(4, b), kv(4, b)],
            [jv(3, b), yv(3, b), iv(3, b), -kv(3, b)],
        ]
        matrix = np.array(rows)
        return np.linalg.det(matrix / np.abs(matrix).max(axis=0))

    for omega in free(theta, 3):
        near = omega * (1.0 + 1e-9 * np.array([-1.0, 1.0]))
        assert determinant(near[0]) * determinant(near[1]) < 0.0


def test_a_long_cone_tends_to_the_complete_cone():
    assert free(50.0, 3) == pytest.approx([8.7192, 21.1457, 38.4538], rel=0.05)
    assert free(50.0, 1)[0] < 8.7192


def test_a_clamp_that_yields_is_a_hinge_with_a_spring():
    # Rigid body on a soft spring: ω² = (1/c)/(1/3).
    soft = free(1.0, 1, Mounting(clamp_compliance=1e4))
    assert soft == pytest.approx([np.sqrt(3.0e-4)], rel=1e-3)
    # The hinged-free beam: tan k = tanh k again.
    hinged = free(1.0, 2, Mounting(clamp_compliance=1e8))[1]
    assert hinged == pytest.approx(15.418205717, rel=1e-6)


def test_the_first_frequency_vanishes_with_the_margin_of_stability():
    """Loads beyond the limit of stability: ω1² and the margin have the same sign and zero."""
    state = first_states(2.0, 0.85, 32)

    def loaded(factor):
        unknowns = state.unknowns.copy()
        unknowns[:, -3:-1] *= factor
        return state.with_unknowns(unknowns)

    def margin(factor):
        return float(stability(loaded(factor))[0])

    limit = brentq(margin, 1.0, 100.0, xtol=1e-12)
    near = np.array([-2e-3, -1e-3, 1e-3, 2e-3])
    squares = np.array([squared_frequencies(loaded(limit * (1.0 + e)), 1)[0, 0] for e in near])
    assert squared_frequencies(loaded(limit), 1)[0, 0] == pytest.approx(0.0, abs=1e-4)
    # Linear in the load.
    assert squares[0] / squares[1] == pytest.approx(2.0, rel=1e-2)
    assert squares[3] / squares[2] == pytest.approx(2.0, rel=1e-2)
    assert (np.sign(squares) == np.sign([margin(limit * (1.0 + e)) for e in near])).all()
    assert np.isnan(natural_frequencies(loaded(2.0 * limit), 1)).all()


def test_a_tip_that_slides_has_one_condition_less():
    state = first_states(2.0, 0.85, 32)
    sticks, slides = (squared_frequencies(state, 3, tip)[0] for tip in (STICKS, SLIDES))
    # Interlacing of the eigenvalues of a problem and of the same problem with a condition more.
    assert (slides < sticks).all()
    assert (sticks[:-1] < slides[1:]).all()


@pytest.mark.slow
def test_the_flat_part_rests_and_moves_as_a_whole():
    state = first_states(4.0, 0.6, 40, Contact.LINE)
    assert state.line[0]
    s_c, d = float(state.s_c[0]), 1.0 - 0.75 * float(state.s_c[0])
    # The same rod cut off at the contact point, clamped there: a cone of its own.
    cut = made_states(1.0 / d, state.phi, state.fx * s_c**2, state.fy * s_c**2)
    cut = type(cut)(rods=cut.rods, unknowns=cut.unknowns, line=state.line)
    assert natural_frequencies(cut, 2)[0] / s_c**2 == pytest.approx(
        natural_frequencies(state, 2)[0]
    )
    # With the mass of the flat part, a sliding tip vibrates more slowly.
    assert (
        natural_frequencies(state, 2, SLIDES) < natural_frequencies(cut, 2, SLIDES) / s_c**2
    ).all()


@pytest.mark.slow
def test_the_part_beyond_a_rolling_contact_vibrates():
    """If κ0 at the contact point is small, the part beyond is clamped there."""
    mounting = Mounting(curvature=-1e-4)
    rods = first_states(4.0, 0.6, 40, Contact.LINE, [mounting])
    assert rods.line[0]
    s_c = float(rods.s_c[0])
    d = 1.0 - 0.75 * s_c
    tail = free(4.0 * d, 1)[0] * d / (1.0 - s_c) ** 2
    found = natural_frequencies(rods, 6)[0]
    assert np.abs(found / tail - 1.0).min() < 1e-3


def test_an_unknown_state_has_no_frequencies():
    state = first_states(2.0, 0.85, 24)
    assert np.isnan(natural_frequencies(state.with_unknowns(np.nan * state.unknowns), 2)).all()
