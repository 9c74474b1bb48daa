"""Intervals are halved where a straight line does not tell what is between, and nowhere else."""

import math
from decimal import Decimal
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.numerics.halving import Reading, Verdict, halve, verdict

UNIT = (Decimal(0), Decimal(1))


def of(function, kind=lambda x: ""):
    """What is read of a function, and the places at which it was asked for."""
    asked = []

    def read(places):
        asked.append(list(places))
        return [Reading((function(float(x)),), kind(float(x))) for x in places]

    return read, asked


def halved(function, tolerance, closest, places=UNIT, kind=lambda x: ""):
    return halve(list(pairwise(places)), of(function, kind)[0], tolerance, Decimal(closest))


def test_a_line_needs_no_more_points():
    found = halved(lambda x: 3 * x - 1, 1e-12, "0.001")
    assert (found.added, found.switches, found.unmet) == ((), (), ())


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_a_parabola_is_halved_everywhere_until_a_quarter_of_the_squared_width(levels):
    """The line between the ends of x² is off by (width/2)² in the middle."""
    width = 0.5**levels
    found = halved(lambda x: x * x, (width / 2) ** 2, "0.001")
    assert list(map(float, found.added)) == [i * width for i in range(1, 2**levels)]
    less = halved(lambda x: x * x, (width / 2) ** 2 * 0.999, "0.001")
    assert len(less.added) == 2 ** (levels + 1) - 1


def test_an_inflection_in_the_middle_hides_nothing():
    """The line through the ends meets x³ in the middle; a quarter on, it is off by 3/64."""
    cubic = (lambda x: (x - 0.5) ** 3, "0.3")
    assert halved(cubic[0], 0.046, cubic[1]).added == (Decimal("0.5"),)
    assert halved(cubic[0], 0.047, cubic[1]).added == ()


def test_what_is_left_is_told_in_its_order_not_in_that_in_which_it_was_found():
    """The long interval is halved three times before it is as narrow as the short one."""
    places = (Decimal(0), Decimal(8), Decimal(9))
    found = halved(lambda x: 0.0, 1.0, "1", places, kind=lambda x: (x > 2.5, x > 8.5))
    assert [tuple(map(int, ends)) for ends in found.switches] == [(2, 3), (8, 9)]
    steps = (lambda x: float(x > 2.5) + float(x > 8.5), 0.1, "1", places)
    assert [tuple(map(int, ends)) for ends in halved(*steps).unmet] == [(2, 3), (8, 9)]


def test_a_jump_of_kind_is_closed_in():
    found = halved(lambda x: 0.0, 1.0, "0.01", kind=lambda x: x > 1 / 3)
    ((start, stop),) = found.switches
    assert float(start) < 1 / 3 < float(stop)
    assert Decimal("0.01") <= stop - start < Decimal("0.02")
    # One point for each halving of the interval that has the jump.
    assert len(found.added) == 6
    assert found.unmet == ()


def test_an_island_of_another_kind_is_found_at_a_quarter():
    found = halved(lambda x: 0.0, 1.0, "0.1", kind=lambda x: 0.7 < x < 0.8)
    assert [float(stop) for _, stop in found.switches] == [0.75, 0.875]
    assert found.unmet == ()


def test_what_is_too_narrow_is_told():
    found = halved(math.sqrt, 0.01, "0.1")
    assert list(map(float, found.added)) == [0.125, 0.25, 0.5, 0.75]
    assert [tuple(map(float, ends)) for ends in found.unmet] == [(0.0, 0.125)]
    found = halved(lambda x: 0.0, 1.0, "0.6", kind=lambda x: 0.4 < x < 0.6)
    assert (found.added, found.unmet) == ((), (UNIT,))


def test_a_half_is_never_narrower_than_the_closest():
    assert halved(math.sqrt, 1e-9, "0.5").added == (Decimal("0.5"),)
    assert halved(math.sqrt, 1e-9, "0.501").added == ()


def test_points_without_a_value_have_nothing_to_be_met():
    assert halved(lambda x: math.nan, 1e-9, "0.01").added == ()


def test_each_generation_is_asked_for_once_and_no_place_twice():
    read, asked = of(lambda x: x * x)
    halve([UNIT], read, 1 / 64, Decimal("0.001"))
    assert [len(places) for places in asked] == [2, 3, 4, 8]
    assert [places == sorted(places) for places in asked] == [True] * 4
    assert len({x for places in asked for x in places}) == 17


def test_a_single_point_has_no_interval():
    found = halved(lambda x: x, 1.0, "0.1", places=(Decimal(1),))
    assert (found.added, found.switches, found.unmet) == ((), (), ())


@pytest.mark.parametrize(
    ("values", "kinds", "expected"),
    [
        ((0, 1, 2, 3, 4), "aaaaa", Verdict.MET),
        ((0, 1.5, 2, 3, 4), "aaaaa", Verdict.MET),
        ((0, 1.6, 2, 3, 4), "aaaaa", Verdict.UNMET),
        ((0, 1, 1.4, 3, 4), "aaaaa", Verdict.UNMET),
        ((0, 1, 2, 3.6, 4), "aaaaa", Verdict.UNMET),
        ((0, 1, 2, 3, 4), "aabaa", Verdict.UNMET),
        ((0, 1, 2, 3, 4), "aaabb", Verdict.SWITCH),
    ],
)
def test_verdicts(values, kinds, expected):
    readings = [Reading((value,), kind) for value, kind in zip(values, kinds, strict=True)]
    assert verdict(readings, 0.5) is expected


def test_of_several_values_each_is_to_be_met():
    straight, bent = (0, 1, 2, 3, 4), (0, 1, 2, 3.6, 4)
    for values, expected in (
        ((straight, straight), Verdict.MET),
        ((straight, bent), Verdict.UNMET),
        ((bent, straight), Verdict.UNMET),
    ):
        readings = [Reading(pair, "") for pair in zip(*values, strict=True)]
        assert verdict(readings, 0.5) is expected


def test_intervals_may_lie_apart():
    apart = [(Decimal(0), Decimal(1)), (Decimal(2), Decimal(3))]
    read, _ = of(lambda x: x * x)
    assert halve(apart, read, 0.2, Decimal("0.1")).added == (Decimal("0.5"), Decimal("2.5"))


@given(
    st.lists(st.integers(0, 40), min_size=2, max_size=6, unique=True),
    st.floats(1e-3, 1.0),
    st.integers(1, 60),
    st.floats(0.3, 20.0),
    st.integers(0, 40),
)
def test_in_the_end_every_interval_is_met_or_narrow(places, tolerance, closest, rate, jump):
    """Looked at anew, with another evaluation at the quarters."""
    axis = [Decimal(place) / 10 for place in sorted(places)]
    least = Decimal(closest) / 100

    def value(x):
        return math.sin(rate * x)

    found = halved(value, tolerance, least, axis, lambda x: 10 * x > jump)
    told = set(found.switches) | set(found.unmet)
    whole = sorted([*axis, *found.added])
    assert len(whole) == len(set(whole))
    for start, stop in pairwise(whole):
        if (start, stop) in told:
            assert stop - start < 2 * least
            continue
        ends = value(float(start)), value(float(stop))
        assert (10 * float(start) > jump) == (10 * float(stop) > jump)
        for part in (0.25, 0.5, 0.75):
            line = ends[0] + part * (ends[1] - ends[0])
            off = value(float(start) + part * float(stop - start)) - line
            assert abs(off) <= tolerance + 1e-12
    for start, stop in pairwise(whole):
        assert stop - start >= least or (start in axis and stop in axis)
