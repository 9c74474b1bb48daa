"""Rods whose modulus changes along them, and tubes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation import stiffness, vibration
from vibrissa import Mounting, solve_curve, solve_onset, solve_state
from vibrissa.errors import ArgumentError
from vibrissa.limits import check_stiffening
from vibrissa.mechanics import taper
from vibrissa.mechanics.fitting import fitted_stiffness
from vibrissa.mechanics.rod import Rod


@given(st.floats(1.0, 8.0), st.floats(0.0, 0.95), st.floats(-0.4, 3.0), st.floats(-0.4, 3.0))
def test_the_stiffness_is_modulus_times_second_moment_over_those_of_the_base(theta, part, c1, c2):
    bore, s, step = part / theta, np.linspace(0.01, 0.99, 7), 1e-6
    making = Mounting(stiffening=(c1, c2), bore=bore).making
    outer = taper.diameter(s, theta)
    young, base = 1 + c1 * s + c2 * s**2, 1 - bore**4
    moments = (outer**4 - bore**4) / base
    assert taper.stiffness(s, theta, making) == pytest.approx(young * moments, rel=1e-9)
    assert taper.stiffness(0.0, theta, making) == pytest.approx(1.0, rel=1e-12)
    after, before = (np.log(taper.stiffness_factor(s + h, theta, making)) for h in (step, -step))
    growth = taper.stiffness_growth(s, theta, making)
    assert growth == pytest.approx((after - before) / (2 * step), rel=1e-5, abs=1e-8)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"stiffening": -1.0}, "+ ... is 0 at s = 1 L, got -1"),
        ({"stiffening": (-4.0, 3.5)}, "+ ... is -0.1429 at s = 0.5714 L, got -4, 3.5"),
        ({"stiffening": ()}, "stiffening must be a number or a list of numbers, got ()"),
        ({"stiffening": (0.1, np.inf)}, "stiffening must be a finite number, got inf"),
        ({"stiffening": [0.1] * 9}, "stiffening must have at most 8 coefficients, got 9"),
        ({"bore": 1.0}, "bore must be at least 0 and below the diameter of the tip, 1/theta = 1"),
        ({"bore": -0.1}, "bore must be at least 0"),
        ({"bore": True}, "bore must be a finite number, got True"),
    ],
)
def test_a_rod_that_cannot_be_made_is_refused(values, said):
    with pytest.raises(ArgumentError) as error:
        Mounting(**values)
    assert said in str(error.value)


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=4))
def test_a_stiffening_is_refused_exactly_if_the_modulus_vanishes_on_the_rod(powers):
    least = np.polynomial.Polynomial([1.0, *powers])(np.linspace(0, 1, 2001)).min()
    if least > 1e-5:
        check_stiffening(powers)
    elif least <= 0.0:
        with pytest.raises(ArgumentError):
            check_stiffening(powers)


def test_a_bore_must_be_narrower_than_the_tip():
    mounting = Mounting(bore=0.5)
    with pytest.raises(ArgumentError, match=r"1/theta = 0\.5 d0, got 0\.5"):
        solve_curve(2.0, 0.85, mounting=mounting)
    with pytest.raises(ArgumentError, match="below the diameter of the tip"):
        solve_state(2.0, 0.85, 0.3, mounting=mounting)
    with pytest.raises(ArgumentError, match=r"between 0 and 1|below the diameter"):
        Rod(2.1e11, 1e-3, 0.1, bore=1.5)


def test_a_tube_without_taper_has_the_results_of_a_rod_in_its_own_units():
    """B = 1 and w = 1 again; in SI the units change as I and A of a ring do."""
    tube, solid = (
        solve_onset(1.0, 0.3, 0.85, 0.001, mounting=Mounting(bore=bore)) for bore in (0.8, 0.0)
    )
    assert tube.x0_slip == pytest.approx(solid.x0_slip, abs=1e-12)
    assert tube.slip.stability_aside == pytest.approx(solid.slip.stability_aside, abs=1e-9)
    assert tube.slip.reaction_m == pytest.approx(solid.slip.reaction_m, abs=1e-11)
    ring, disc = (Rod(2.1e11, 1e-3, 0.1, bore=bore) for bore in (0.8, 0.0))
    assert ring.force_unit / disc.force_unit == pytest.approx(1 - 0.8**4)
    area = 1 - 0.8**2
    assert ring.frequency_unit(7800.0) / disc.frequency_unit(7800.0) == pytest.approx(
        np.sqrt((1 - 0.8**4) / area)
    )


@pytest.mark.slow
def test_a_modulus_that_makes_up_for_the_taper_gives_the_loads_of_a_cylinder():
    """B = 1 where E ∝ d⁻⁴: onset, lock and shape differ as the fit of d⁻⁴ does."""
    theta, s = 1.2, np.linspace(0.0, 1.0, 401)
    cylinder = solve_curve(1.0, 0.8, contact="line")
    shape = solve_state(1.0, 0.8, 0.4).shape(s)
    errors, gaps = [], []
    for degree in (2, 4, 6):
        _, powers = fitted_stiffness(s, 1.0 / taper.diameter(s, theta) ** 4, degree)
        mounting = Mounting(stiffening=powers)
        errors.append(np.abs(taper.stiffness(s, theta, mounting.making) - 1.0).max())
        cone = solve_curve(theta, 0.8, contact="line", mounting=mounting)
        bent = solve_state(theta, 0.8, 0.4, mounting=mounting).shape(s)
        gaps.append(
            max(
                abs(cone.mu_lock - cylinder.mu_lock),
                abs(float(cone.onset(0.3)) - float(cylinder.onset(0.3))),
                np.abs(np.array(bent) - np.array(shape)).max(),
            )
        )
    assert errors[0] > 20 * errors[1] > 400 * errors[2]
    assert all(gap < 2 * error for gap, error in zip(gaps, errors, strict=True))
    assert gaps[-1] < 1e-6


@pytest.mark.slow
def test_rods_of_any_stiffness_are_those_of_an_independent_shooting():
    random = np.random.default_rng(3)
    found = [stiffness.compare(stiffness.sample(random, number)) for number in range(5)]
    assert sum(one.status == "slip" for one in found) >= 4
    assert np.nanmax([one.gap for one in found]) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_frequencies_are_those_of_a_chain_of_links(number):
    random = np.random.default_rng(11)
    bore, powers = random.uniform(0, 0.45), tuple(random.uniform(-0.3, 1.0, 3))
    mounting = Mounting(stiffening=powers, bore=bore)
    case = vibration.Bent(theta=2.0, eta=0.8, part=0.3, contact="point", mounting=mounting)
    if number:
        case = vibration.Bent(
            theta=2.0, eta=0.5, part=0.3, contact="line", slides=number > 1, mounting=mounting
        )
    found = vibration.compare(case, counts=(50, 100))
    assert np.abs(found.extrapolated).max() < 2e-4
