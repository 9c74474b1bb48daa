import json
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.decimals import exact, order_of, polynomial
from vibrissa.study.codec import (
    decode_axis,
    decode_box,
    decode_columns,
    decode_grid,
    decode_key,
    encode_axis,
    encode_box,
    encode_columns,
    encode_grid,
    encode_key,
)
from vibrissa.study.grid import MOUNTING_AXES, CurveKey, Grid

decimals = st.decimals(-1000, 1000, places=9).map(exact)
polynomials = st.lists(decimals, min_size=1, max_size=4).map(polynomial)
mounting = {name: decimals for name in MOUNTING_AXES} | {"curvature": decimals | polynomials}
keys = st.builds(CurveKey, theta=decimals, eta=decimals, dx0=st.none() | decimals, **mounting)
axes = st.lists(decimals, min_size=1, unique=True).map(lambda values: tuple(sorted(values)))


@given(keys)
def test_a_key_comes_back_from_its_plain_form(key):
    assert decode_key(json.loads(json.dumps(encode_key(key)))) == key


@pytest.mark.slow
@given(st.lists(keys))
def test_keys_come_back_from_columns(written):
    columns = encode_columns(written)
    assert list(columns) == ["theta", "eta", "dx0", *MOUNTING_AXES]
    rows = zip(*columns.values(), strict=True)
    assert [decode_columns(dict(zip(columns, row, strict=True))) for row in rows] == written


curvatures = st.lists(polynomials, min_size=1, unique=True).map(
    lambda values: tuple(sorted(values, key=order_of))
)


@pytest.mark.slow
@given(st.builds(Grid, theta=axes, mu0=axes, eta=axes, dx0=axes, curvature=curvatures))
def test_a_grid_comes_back_from_its_plain_form(grid):
    assert decode_grid(json.loads(json.dumps(encode_grid(grid)))) == grid


def test_the_plain_form_has_no_exponents():
    key = CurveKey(Decimal("10"), Decimal("0.85"), Decimal("1E-7"))
    assert encode_key(key) == ["10", "0.85", "0.0000001"]
    assert encode_key(key._replace(dx0=None)) == ["10", "0.85"]
    grid = Grid(theta=(key.theta,), mu0=(Decimal("0.3"),), eta=(key.eta,), dx0=(key.dx0,))
    assert encode_grid(grid) == {
        "theta": ["10"],
        "mu0": ["0.3"],
        "eta": ["0.85"],
        "dx0": ["0.0000001"],
    }


def test_a_mounting_is_named_and_the_ideal_one_is_not():
    key = CurveKey(Decimal("2"), Decimal("0.85"), clamp_angle=Decimal("-0.02"))
    assert encode_key(key) == ["2", "0.85", "clamp_angle=-0.02"]
    assert encode_key(key._replace(clamp_angle=Decimal(0))) == ["2", "0.85"]
    with pytest.raises(TypeError, match="angle"):
        decode_key(["2", "0.85", "angle=0.1"])


def test_a_polynomial_is_spelled_with_commas():
    key = decode_key(["2", "0.85", "curvature=-0.050,0,0.10,0"])
    assert key.curvature == (Decimal("-0.05"), Decimal(0), Decimal("0.1"))
    assert encode_key(key) == ["2", "0.85", "curvature=-0.05, 0, 0.1"]
    assert decode_key(["2", "0.85", "curvature=0.1, 0"]).curvature == Decimal("0.1")
    with pytest.raises(ValueError, match="number"):
        decode_key(["2", "0.85", "curvature=0.1, x"])


def test_equal_keys_have_one_form():
    assert decode_key(["1.50", "0.850"]) == decode_key(["1.5", "0.85"])
    assert encode_key(decode_key(["1.50", "0.850"])) == ["1.5", "0.85"]


@pytest.mark.parametrize("texts", [["1"], ["1", "2", "3", "4"], [None, "1"], 1, [[], []]])
def test_what_is_no_key_is_refused(texts):
    with pytest.raises((TypeError, ValueError)):
        decode_key(texts)


@pytest.mark.parametrize("text", ["", "x", "nan", "inf"])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(ValueError, match="number"):
        decode_key([text, "0.85"])


steps = st.tuples(decimals, st.integers(1, 500), st.integers(1, 9)).map(
    lambda drawn: tuple(exact(drawn[0] + i * exact(drawn[1]) / 1000) for i in range(drawn[2]))
)
values = st.lists(steps, min_size=1, max_size=4).map(
    lambda parts: tuple(dict.fromkeys(sum(parts, ())))
)


@given(values)
def test_an_axis_comes_back_from_its_plain_form(axis):
    assert decode_axis(json.loads(json.dumps(encode_axis(axis)))) == axis


def test_equal_steps_are_spelled_as_a_range():
    axis = decode_axis(["0.5", "1:3:0.1", "4", "5.5"])
    assert len(axis) == 24 and axis[1:3] == (1, Decimal("1.1"))
    assert encode_axis(axis) == ["0.5", "1:3:0.1", "4", "5.5"]
    assert encode_axis(axis[1:4]) == ["1", "1.1", "1.2"]
    assert encode_axis(tuple(map(Decimal, range(4)))) == ["0:3:1"]


def test_equal_steps_end_at_a_polynomial():
    numbers = tuple(map(Decimal, range(4)))
    axis = (*numbers, (Decimal(4), Decimal(1)))
    assert encode_axis(axis) == ["0:3:1", "4, 1"] and decode_axis(["0:3:1", "4, 1"]) == axis
    around = (*axis, *(number + 4 for number in numbers))
    assert (
        encode_axis(around) == ["0:3:1", "4, 1", "4:7:1"]
        and decode_axis(encode_axis(around)) == around
    )


def test_a_box_says_nothing_of_axes_that_it_does_not_have():
    box = decode_box({"theta": ["1", "2"], "eta": ["0.85"]})
    assert box["dx0"] == (None,) and box["curvature"] == (0,)
    assert encode_box(box) == {"eta": ["0.85"], "theta": ["1", "2"]}
    assert encode_box(box | {"dx0": (Decimal("0.001"),)})["dx0"] == ["0.001"]


@pytest.mark.parametrize(
    "axes",
    [
        {"theta": ["1"]},
        {"eta": ["1"]},
        {"theta": ["1"], "eta": ["1"], "mu0": ["1"]},
        {"theta": ["1:2"], "eta": ["1"]},
        {"theta": ["1:2:0.3"], "eta": ["1"]},
        {"theta": ["1:2:0"], "eta": ["1"]},
    ],
)
def test_what_is_no_box_is_refused(axes):
    with pytest.raises((KeyError, ValueError, ArithmeticError)):
        decode_box(axes)
