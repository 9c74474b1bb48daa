from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.decimals import exact, spell
from vibrissa.numerics.steps import ONSET_ACCURACY, last_step_within, step_position

numbers = st.floats(allow_nan=False, allow_infinity=False)
# What a person writes as a step: a few digits, from 1e-9 up to 1e6.
steps = st.builds(
    lambda digits, places: Decimal(digits).scaleb(-places), st.integers(1, 10**6), st.integers(0, 9)
)


@given(numbers)
def test_a_float_is_its_shortest_decimal(x):
    decimal = exact(x)
    assert float(decimal) == x
    assert len(decimal.normalize().as_tuple().digits) <= 17


@pytest.mark.parametrize("value", [0.1, "0.1", "0.10", "1e-1", Decimal("0.100"), np.float64(0.1)])
def test_equal_values_have_one_spelling(value):
    assert spell(exact(value)) == "0.1"


@pytest.mark.parametrize(
    "zero", [0, 0.0, -0.0, "-0", "-0.000", "0e5", Decimal("-0e-9"), np.int64(0)]
)
def test_zero_has_no_sign_and_no_places(zero):
    assert spell(exact(zero)) == "0"


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), -float("inf"), "nan", "sNaN", "-Infinity", Decimal("inf")]
)
def test_only_finite_numbers(value):
    with pytest.raises(ValueError, match=r"not a finite number: .*(?i:nan|inf)"):
        exact(value)


@pytest.mark.parametrize("text", ["", "one", "0.1.2", "1,5", "0x10"])
def test_other_text_is_refused(text):
    with pytest.raises(ValueError, match=f"not a number: '{text}'"):
        exact(text)


@given(st.one_of(numbers, st.decimals(allow_nan=False, allow_infinity=False, places=30)))
def test_spelling_has_no_exponent_and_reads_back(value):
    decimal = exact(value)
    assert set(spell(decimal)) <= set("-.0123456789")
    assert Decimal(spell(decimal)) == decimal


@given(st.lists(st.integers(0, 2**63 - 1)), steps)
def test_step_position_is_the_rounded_exact_product(counts, dx0):
    expected = [float(k * Fraction(dx0)) for k in counts]
    assert step_position(np.array(counts, dtype=np.int64), dx0).tolist() == expected


@given(st.integers(0, 2**50), steps)
def test_a_step_is_within_its_own_position_and_not_below(k, dx0):
    position = step_position(np.array([k]), dx0)
    assert last_step_within(position, dx0) == k
    # An onset is known to 1e-12: so close before it the step ends on it.
    below = position - np.maximum(2.0 * ONSET_ACCURACY, 2.0 * np.spacing(position))
    if k and float(dx0) > 4.0 * (position - below):
        assert last_step_within(below, dx0) == k - 1


@given(st.lists(st.floats(0, 1000), min_size=1), steps)
def test_the_last_step_does_not_pass_and_the_next_does(x0, dx0):
    x0 = np.array(x0)
    count = last_step_within(x0, dx0)
    assert np.all(step_position(count, dx0) <= x0 + ONSET_ACCURACY)
    assert np.all(step_position(count + 1, dx0) > x0 + ONSET_ACCURACY)


@pytest.mark.parametrize("dx0", ["1", "12345", "1e15", "1e18", "1e30"])
def test_a_step_larger_than_the_displacement_fits_no_time(dx0):
    assert last_step_within(np.array([0.0, 0.03]), Decimal(dx0)).tolist() == [0, 0]


def test_a_step_too_small_to_count_is_refused():
    with pytest.raises(ValueError, match="a step of 1E-20 is too small"):
        last_step_within(np.array([0.1]), Decimal("1e-20"))
    # Doubles count up to 2**53.
    count = last_step_within(np.array([float(2**53 - 1)]), Decimal(1))
    assert count.tolist() == [2**53 - 1]
    with pytest.raises(ValueError, match=r"step of 1 is too small .* up to 9\.0072e\+15"):
        last_step_within(np.array([float(2**53 + 2)]), Decimal(1))
