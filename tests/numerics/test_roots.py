"""Roots in brackets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly
from scipy.special import lambertw

from vibrissa.numerics.roots import (
    bracketed_root,
    first_fall,
    first_integral_fall,
    first_reached,
    sampled_root,
)


@given(st.lists(st.floats(1e-6, 50.0), min_size=1, max_size=5))
def test_roots_are_those_of_a_closed_form(values):
    c = np.array(values)
    low, high = np.zeros_like(c), 1.0 + np.log1p(c)
    root = bracketed_root(lambda x, c: (x * np.exp(x) - c, (1 + x) * np.exp(x)), low, high, c)
    assert root == pytest.approx(lambertw(c).real, rel=1e-14, abs=1e-15)


def test_a_root_that_is_not_simple_is_found_without_slopes():
    root = bracketed_root(lambda x: ((x - 0.3) ** 3, 0.0 * x), np.array([0.0]), np.array([1.0]))
    assert root[0] == pytest.approx(0.3, abs=1e-5)


@pytest.mark.parametrize("end", [0.25, 0.5])
def test_an_end_that_is_a_root_up_to_rounding_is_returned(end):
    offset = 1e-17 if end == 0.25 else -1e-17
    root = bracketed_root(
        lambda x: (x - end + offset, np.ones_like(x)), np.array([0.25]), np.array([0.5])
    )
    assert root[0] == end


def test_newton_leads_out_of_no_bracket():
    # From the middle it goes far beyond.
    root = bracketed_root(
        lambda x: (np.arctan(20 * (x - 0.9)), 20 / (1 + (20 * (x - 0.9)) ** 2)),
        np.array([0.0, 0.8]),
        np.array([1.0, 1.0]),
    )
    assert root == pytest.approx([0.9, 0.9], abs=1e-14)


def test_rounding_beside_a_narrow_bracket_takes_no_further_steps():
    # 1 + 1e-4·(x − r) − 1 is off by 1e-16: the root by 1e-12, where the bracket is 3e-5 wide.
    r, calls = 0.99984879, []

    def excess(x):
        calls.append(x)
        return (1.0 + 1e-4 * (x - r) + (x - r) ** 2) - 1.0, 1e-4 + 2.0 * (x - r)

    root = bracketed_root(excess, np.array([r - 1e-5]), np.array([r + 2e-5]))
    assert root == pytest.approx([r], abs=3e-12)
    assert len(calls) < 9


def bernstein(*pieces):
    """Piecewise polynomial on [0, 1], [1, 2] ... from its Bernstein coefficients."""
    return BPoly(np.array(pieces, dtype=float).T, np.arange(len(pieces) + 1.0))


@pytest.mark.parametrize(
    ("pieces", "expected"),
    [
        ([[1, 1, 1], [1, 1, 2]], np.nan),
        ([[1, 0, -1]], 0.5),
        ([[1, 1, 1], [1, 0, -1]], 1.5),
        ([[1, 1, 1], [-1, 1, 1]], 1.0),  # a jump
        ([[0, 1, 1], [1, 0, -1]], 1.5),  # it may begin at zero
        ([[0, 1, -1]], 2 / 3),
        ([[0, -1, 1]], 0.0),
        ([[2, 1, 0], [0, 0, 0]], 1.0),  # it stays zero
        ([[1, -0.5, 1]], np.nan),  # a coefficient below zero without a root
        ([[1, -2, 1]], 0.5 - np.sqrt(1 / 12)),  # two roots in one piece
        # ((t − 0.5)² + 0.001)·(t − 1.2)·(t − 1.4): the roots lie beyond the piece.
        ([[0.42168, -0.16147, 0.01054666666666667, 0.03773, 0.02008]], np.nan),
    ],
)
def test_first_fall(pieces, expected):
    assert first_fall(bernstein(*pieces)) == pytest.approx(expected, abs=1e-14, nan_ok=True)


def test_levels_are_reached_where_searchsorted_says():
    random = np.random.default_rng(3)
    rising = np.sort(random.integers(0, 40, (5, 33)).astype(float), axis=1)
    which, level = random.integers(0, 5, 400), random.uniform(-2, 42, 400).round()
    expected = [np.searchsorted(rising[row], at) for row, at in zip(which, level, strict=True)]
    assert np.array_equal(first_reached(rising, which, level), expected)
    assert first_reached(rising, which[:1], np.array([np.nan])) == [33]


def test_a_root_does_not_depend_on_what_else_is_sought():
    c = np.geomspace(1e-6, 50.0, 9)
    low, high = np.zeros_like(c), 1.0 + np.log1p(c)

    def excess(x, c):
        return x * np.exp(x) - c, (1 + x) * np.exp(x)

    together = bracketed_root(excess, low, high, c)
    for row in range(len(c)):
        only = slice(row, row + 1)
        assert bracketed_root(excess, low[only], high[only], c[only]) == together[only]


def filled(pieces, part):
    """First place at which an integral is spent, by brute force on a fine grid."""
    rate, x = bernstein(*pieces), np.linspace(0.0, len(pieces), 20001)
    values = rate.antiderivative()(x)
    spent = (values <= part * np.maximum.accumulate(values)) & (rate(x) <= 0.0)
    return x[np.argmax(spent)] if spent.any() else np.nan


@pytest.mark.parametrize("part", [0.0, 1e-3, 0.3, 0.9, 1.0 - 1e-9, 1.0])
@pytest.mark.parametrize(
    "pieces",
    [
        [[1, 0, -1], [-1, -2, -1]],
        [[1, 1], [-1, -1], [-1, -1]],  # jumps, and it ends where it is spent
        [[1, 1], [-0.2, -0.2], [2, 0], [-1, -1], [-1, -1]],  # a second maximum is larger
        [[1, -2, 2], [1, -3, -3]],  # two turns in one piece
        [[-1, 1], [1, 1]],  # it falls at once
        [[1, 1], [1, 2]],  # it never falls
    ],
)
def test_an_integral_is_spent_where_brute_force_finds_it(pieces, part):
    found, expected = first_integral_fall(bernstein(*pieces), part), filled(pieces, part)
    # The distance of the points of the grid; near 1 the maximum is flat.
    assert found == pytest.approx(expected, abs=1e-3 if part > 0.99 else 3e-4, nan_ok=True)


def test_an_integral_first_falls_where_its_rate_does():
    rate = bernstein([1, 0.5, 0.2], [0.2, 0.7, -1.3], [-1, -1, 3])
    assert first_integral_fall(rate, 1.0) == first_fall(rate)


@given(
    pieces=st.lists(st.lists(st.integers(-3, 3), min_size=3, max_size=3), min_size=1, max_size=5),
    parts=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_an_integral_falls_to_a_larger_part_earlier(pieces, parts):
    low, high = (first_integral_fall(bernstein(*pieces), part) for part in sorted(parts))
    assert np.isnan(low) or high <= low + 1e-12


# --- Roots among samples ---


def sampled(function, places):
    """The first root among samples of a function, and how often it was computed for that."""
    calls = []

    def counted(x):
        calls.append(x)
        return function(x)

    values = function(places)
    last = int(np.flatnonzero(values[1:] <= 0.0)[0])
    return sampled_root(counted, places, values, last), len(calls)


@given(st.floats(0.01, 0.99), st.sampled_from([1.0, -1.0]))
def test_the_root_of_a_smooth_function_is_found_at_once(root, direction):
    places = direction * np.linspace(0.0, 1.0, 258)
    found, calls = sampled(lambda x: np.exp(-direction * x) - np.exp(-root), places)
    assert found == pytest.approx(direction * root, abs=2e-15)
    assert calls == 1


# A kink next to the root: closer than samples are, or closer than the function is computed.
@pytest.mark.parametrize("beyond", [1e-3, 1e-7, 1e-9])
def test_a_root_beside_a_kink_is_found(beyond):
    kink = 0.5
    root = kink + beyond
    found, _ = sampled(
        lambda x: np.minimum(1.0 - x, 1.0 - kink - (1.0 - kink) / beyond * (x - kink)),
        np.linspace(0.0, 1.0, 258),
    )
    assert found == pytest.approx(root, abs=2e-15)


@pytest.mark.parametrize("before", [1e-3, 1e-7, 1e-12, 0.0])
def test_the_function_is_not_computed_beyond_its_samples(before):
    def known_to_1(x):
        assert np.max(x) <= 1.0
        return np.exp(-x) - np.exp(before - 1.0)

    found, _ = sampled(known_to_1, np.linspace(0.0, 1.0, 258))
    assert found == pytest.approx(1.0 - before, abs=1e-14)


def test_a_kink_near_a_root_costs_one_more_look():
    kink = 0.5 + 1.0 / 257
    found, calls = sampled(
        lambda x: np.exp(-x) - np.exp(-0.5) - np.maximum(x - kink, 0.0), np.linspace(0.0, 1.0, 258)
    )
    assert found == pytest.approx(0.5, abs=2e-15)
    assert calls == 2


def test_a_maximum_just_before_a_root_costs_one_more_look():
    found, calls = sampled(
        lambda x: np.minimum(0.01 * x, np.exp(0.5 - x) - 1.0), np.linspace(0.0, 1.0, 258)
    )
    assert found == pytest.approx(0.5, abs=2e-15)
    assert calls == 2


def test_a_kink_that_leads_the_cubic_out_of_the_bracket_costs_three_more_looks():
    places = np.linspace(0.0, 1.0, 258)
    begin, step = places[128], places[1]
    found, calls = sampled(
        lambda x: np.minimum(152.0 - 24.0 * (x - begin) / step, 150.0 - 349.0 * (x - begin) / step),
        places,
    )
    assert found == pytest.approx(begin + 150.0 / 349.0 * step, abs=2e-15)
    assert calls <= 4


@pytest.mark.parametrize("before", [1e-6, 1e-7, 1e-8, 1e-9])
def test_a_root_just_after_a_slight_kink_is_found(before):
    more, kink = 1e-4, 0.5 - before
    found, _ = sampled(
        lambda x: 0.5 - x - more * np.maximum(x - kink, 0.0), np.linspace(0.0, 1.0, 258)
    )
    assert found == pytest.approx(kink + before / (1.0 + more), abs=2e-13)


@pytest.mark.parametrize("steepness", [10.0, 1e3, 1e5, 1e7])
def test_a_root_on_a_steep_slope_is_found(steepness):
    found, _ = sampled(
        lambda x: np.tanh(steepness * (0.3 - x)) - x + 0.3, np.linspace(0.0, 1.0, 258)
    )
    assert found == pytest.approx(0.3, abs=1e-14)


def test_a_root_at_a_jump_is_found():
    found, _ = sampled(lambda x: np.where(x < 0.3, 1.0, -1.0), np.linspace(0.0, 1.0, 258))
    assert found == pytest.approx(0.3, abs=1e-13)
