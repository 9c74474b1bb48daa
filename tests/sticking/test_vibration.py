"""Natural frequencies of the states of a path, and chains of links that confirm them."""

import numpy as np
import pytest

from validation.vibration import Bent, compare
from vibrissa import Mounting, Rod, free_frequencies, solve_curve, solve_state
from vibrissa.errors import ArgumentError
from vibrissa.sticking.curve import failed_curve

LEANING = Mounting(clamp_angle=0.05, clamp_compliance=0.2, curvature=-0.3)


@pytest.mark.parametrize(
    ("theta", "eta", "contact", "mounting"),
    [
        (1.0, 0.85, "point", Mounting()),
        (2.0, 0.85, "point", LEANING),
        (4.0, 0.6, "line", Mounting()),
        (4.0, 0.6, "line", LEANING),
    ],
)
def test_a_path_has_the_frequencies_of_its_states(theta, eta, contact, mounting):
    curve = solve_curve(theta, eta, contact=contact, mounting=mounting)
    x0 = curve.x0_end * np.array([0.2, 0.7])
    for tip in ("sticks", "slides"):
        found = curve.frequencies(x0, 2, tip)
        assert found.shape == (2, 2)
        for at, of_path in zip(x0, found, strict=True):
            state = solve_state(theta, eta, curve.x1_init - at, contact, mounting)
            assert of_path == pytest.approx(state.frequencies(2, tip), rel=1e-8, nan_ok=True)


def test_a_state_in_retraction_has_frequencies():
    curve = solve_curve(2.0, 0.85)
    across = curve.frequencies(np.array([-1e-6, 0.0, 1e-6]), 1)[:, 0]
    assert across == pytest.approx(across[1], rel=1e-4)
    assert np.diff(across)[0] == pytest.approx(np.diff(across)[1], rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "bent",
    [
        Bent(theta=2.0, eta=0.85, part=0.5),
        Bent(theta=4.0, eta=0.6, part=0.4, contact="line"),
        Bent(theta=2.0, eta=0.85, part=0.1, slides=True),
        Bent(theta=2.0, eta=0.8, part=0.3, mounting=LEANING),
    ],
    ids=str,
)
def test_chains_of_links_converge_to_the_frequencies(bent):
    found = compare(bent, (25, 50, 100))
    assert np.abs(found.extrapolated).max() < 1e-4
    assert found.order == pytest.approx(2.0, abs=0.1)


def test_frequencies_in_hertz():
    # A uniform steel cantilever: f = 3.516/(2π)·√(E·I/(ρA·L⁴)), I/A = d²/16.
    rod = Rod(youngs_modulus=2.1e11, base_diameter=1e-3, length=0.1)
    hertz = free_frequencies(1.0, 1)[0] * rod.frequency_unit(7850.0)
    assert hertz == pytest.approx(
        3.5160153 / (2 * np.pi) * 1e-3 / 4 / 0.01 * np.sqrt(2.1e11 / 7850)
    )
    with pytest.raises(ArgumentError, match="density of a rod must lie between"):
        rod.frequency_unit(0.0)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"count": 0}, "count must be a whole number from 1 to 20, got 0"),
        ({"count": 1.5}, "count must be"),
        ({"tip": "free"}, "tip must be one of sticks, slides, got 'free'; free_frequencies"),
        ({"tip": 3}, "tip must be one of"),
        ({"x0": 9.0}, "x0 must lie on the curve"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments, named):
    with pytest.raises(ArgumentError, match=named):
        solve_curve(2.0, 0.85).frequencies(**{"x0": 0.01} | arguments)


def test_a_rod_before_contact_is_checked():
    with pytest.raises(ArgumentError, match=r"theta must lie between 1 and 50, got 0\.5"):
        free_frequencies(0.5)
    with pytest.raises(ArgumentError, match="count must be"):
        free_frequencies(2.0, 0)


def test_a_state_that_was_not_solved_has_no_frequencies():
    state = solve_state(2.0, 0.85, -0.5)
    with pytest.raises(ArgumentError, match="has no frequencies"):
        state.frequencies()
    with pytest.raises(ArgumentError, match="has no states"):
        failed_curve(2.0, 0.05, "no luck").frequencies(0.0)
