from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.decimals import exact, spell
from vibrissa.errors import ArgumentError
from vibrissa.pipeline.blocks import grids_of_blocks, partition
from vibrissa.study import grid
from vibrissa.study.boxes import disjoint
from vibrissa.study.codec import decode_grid, encode_grid, encode_key
from vibrissa.study.grid import Grid


def make_grid(theta=("1",), mu0=("0.3",), eta=("0.85",), dx0=("0.001",)):
    return decode_grid({"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0})


def axes_of(*texts):
    return st.sets(st.sampled_from(texts), min_size=1).map(
        lambda chosen: tuple(sorted(map(Decimal, chosen)))
    )


grids = st.builds(
    Grid,
    theta=axes_of("1", "1.5", "2", "10"),
    mu0=axes_of("0.2", "0.3", "0.4"),
    eta=axes_of("0.6", "0.85"),
    dx0=axes_of("0.0005", "0.001", "0.01"),
)
grids_by_name = st.dictionaries(st.sampled_from("abc"), grids, min_size=1)


def steps(start, stop, step):
    return grid.equal_steps(*map(exact, (start, stop, step)))


def test_a_range_includes_its_stop_in_exact_decimals():
    assert [spell(v) for v in steps(1, 3, 0.1)] == [f"{i / 10:g}" for i in range(10, 31)]


@given(st.integers(0, 10**6), st.integers(1, 10**4), st.integers(0, 50), st.integers(0, 6))
def test_a_range_is_exact(start, step, count, places):
    start, step = (float(f"{n}e-{places}") for n in (start, step))
    first, width = (Fraction(str(v)) for v in (start, step))
    values = steps(start, float(first + count * width), step)
    assert [Fraction(v) for v in values] == [first + i * width for i in range(count + 1)]


@pytest.mark.parametrize(
    ("start", "stop", "step"), [("1", "2", "0.3"), ("1", "1.05", "0.1"), ("3", "1", "0.5")]
)
def test_a_stop_that_is_not_hit_is_refused(start, stop, step):
    message = f"^stop {stop} must be start {start} plus a whole number of steps of {step}$"
    with pytest.raises(ArgumentError, match=message):
        steps(start, stop, step)


@pytest.mark.parametrize("stop", [6, 7, 1e30])
def test_an_axis_longer_than_anybody_can_mean_is_refused(monkeypatch, stop):
    monkeypatch.setattr(grid, "LONGEST_AXIS", 5)
    assert steps(1, 5, 1) == (1, 2, 3, 4, 5)
    with pytest.raises(ArgumentError, match="an axis has at most 5 values"):
        steps(1, stop, 1)


def test_curve_keys_are_unique_and_ordered_by_number():
    one = make_grid(theta=("2", "9", "10"), eta=("0.6", "0.85"), dx0=("0.001", "0.01"))
    other = make_grid(theta=("9",), eta=("0.7",))
    boxes = [some.curves(by_step=False) for some in (one, other, one)]
    assert list(map(encode_key, grid.curve_keys(boxes))) == [
        *[[theta, "0.6"] for theta in ("2", "9", "10")],
        ["9", "0.7"],
        *[[theta, "0.85"] for theta in ("2", "9", "10")],
    ]


def test_curve_keys_have_the_step_where_the_solver_walks_along_it():
    one = make_grid(theta=("1", "2"), dx0=("0.001", "0.01"))
    assert list(map(encode_key, grid.curve_keys([one.curves(by_step=True)]))) == [
        ["1", "0.85", "0.001"],
        ["1", "0.85", "0.01"],
        ["2", "0.85", "0.001"],
        ["2", "0.85", "0.01"],
    ]


sizes = st.integers(1, 8)


def named_points(curves):
    """Grid points of some curves with the names of their grids."""
    return {
        (key, mu0, dx0): names
        for key, points in curves
        for mu0, dx0, names in zip(points.mu0, points.dx0, points.grids, strict=True)
    }


@given(grids_by_name, st.booleans(), sizes)
def test_points_of_all_blocks_are_the_points_of_the_study(named, by_step, size):
    curves = disjoint(some.curves(by_step) for some in named.values())
    read = {}
    for box in partition(curves, size, {}).values():
        block = list(grid.keys_of(box))
        part = {
            name: decode_grid(encode_grid(axes))
            for name, axes in grids_of_blocks(named)(box).items()
        }
        points = named_points(grid.points_on_curves(block, part))
        assert points == named_points(grid.points_on_curves(block, named))
        for key, mu0, dx0 in points:
            assert grid.Point(key.theta, mu0, key.eta, dx0).curve_key(by_step) == key
        points = {(key._replace(dx0=None), mu0, dx0): v for (key, mu0, dx0), v in points.items()}
        assert not points.keys() & read.keys()
        read |= points
    found = named_points(grid.study_points(named))
    in_order = [(key.eta, key.theta, mu0, dx0) for key, mu0, dx0 in found]
    assert in_order == sorted(in_order)
    assert read == found


def test_a_point_of_several_grids_stands_once_with_all_names():
    named = {"b": make_grid(mu0=("0.3", "0.4")), "a": make_grid()}
    assert list(named_points(grid.study_points(named)).values()) == [["a", "b"], ["b"]]
