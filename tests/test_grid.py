from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa import grid
from vibrissa.grid import AXES, Grid


def make_grid(theta=("1",), mu0=("0.3",), eta=("0.85",), dx0=("0.001",)):
    return Grid(*(tuple(map(Decimal, values)) for values in (theta, mu0, eta, dx0)))


def axes_of(*texts):
    return st.sets(st.sampled_from(texts), min_size=1).map(
        lambda chosen: tuple(sorted(map(Decimal, chosen)))
    )


grids = st.builds(
    Grid,
    axes_of("1", "1.5", "2", "10"),
    axes_of("0.2", "0.3", "0.4"),
    axes_of("0.6", "0.85"),
    axes_of("0.0005", "0.001", "0.01"),
)
grids_by_name = st.dictionaries(st.sampled_from("abc"), grids, min_size=1)


def test_a_list_is_sorted_and_each_value_stands_once():
    assert grid.axis([2, 1.5, 1, 1.0, 2.0, 1.50]) == (1, Decimal("1.5"), 2)


def test_a_range_includes_its_stop_in_exact_decimals():
    values = grid.axis({"start": 1, "stop": 3, "step": 0.1})
    assert [grid.spell(v) for v in values] == [f"{i / 10:g}" for i in range(10, 31)]


@given(st.integers(0, 10**6), st.integers(1, 10**4), st.integers(0, 50), st.integers(0, 6))
def test_a_range_is_exact(start, step, count, places):
    start, step = (float(f"{n}e-{places}") for n in (start, step))
    first, width = (Fraction(str(v)) for v in (start, step))
    stop = float(first + count * width)
    values = grid.axis({"start": start, "stop": stop, "step": step})
    assert [Fraction(v) for v in values] == [first + i * width for i in range(count + 1)]


def test_a_value_is_the_same_in_a_list_and_in_a_range():
    assert grid.axis({"start": 0.1, "stop": 0.5, "step": 0.2}) == grid.axis([0.1, 0.3, 0.5])


@pytest.mark.parametrize(
    ("start", "stop", "step"), [("1", "2", "0.3"), ("1", "1.05", "0.1"), ("3", "1", "0.5")]
)
def test_a_stop_that_is_not_hit_is_refused(start, stop, step):
    message = f"^stop {stop} must be start {start} plus a whole number of steps of {step}$"
    with pytest.raises(ValueError, match=message):
        grid.axis({"start": float(start), "stop": float(stop), "step": float(step)})


@pytest.mark.parametrize("stop", [6, 7, 1e30])
def test_an_axis_longer_than_anybody_can_mean_is_refused(monkeypatch, stop):
    monkeypatch.setattr(grid, "LONGEST_AXIS", 5)
    assert grid.axis({"start": 1, "stop": 5, "step": 1}) == (1, 2, 3, 4, 5)
    with pytest.raises(ValueError, match="an axis has at most 5 values"):
        grid.axis({"start": 1, "stop": stop, "step": 1})


@pytest.mark.parametrize(
    "values", [[1, float("nan")], {"start": 1, "stop": float("inf"), "step": 1}]
)
def test_an_axis_has_finite_values(values):
    with pytest.raises(ValueError, match="finite"):
        grid.axis(values)


def test_curve_keys_are_unique_and_ordered_by_number():
    one = make_grid(theta=("2", "9", "10"), eta=("0.6", "0.85"), dx0=("0.001", "0.01"))
    other = make_grid(theta=("9",), eta=("0.7",))
    assert grid.curve_keys([one, other, one], by_step=False) == [
        *[(theta, "0.6") for theta in ("2", "9", "10")],
        ("9", "0.7"),
        *[(theta, "0.85") for theta in ("2", "9", "10")],
    ]


def test_curve_keys_have_the_step_where_the_solver_walks_along_it():
    one = make_grid(theta=("1", "2"), dx0=("0.001", "0.01"))
    assert grid.curve_keys([one], by_step=True) == [
        ("1", "0.85", "0.001"),
        ("1", "0.85", "0.01"),
        ("2", "0.85", "0.001"),
        ("2", "0.85", "0.01"),
    ]


def test_keys_do_not_depend_on_how_a_value_is_written():
    written = [{"theta": [theta], "eta": [0.5]} for theta in (1, 1.0)]
    made = [Grid(grid.axis(w["theta"]), (), grid.axis(w["eta"]), ()) for w in written]
    assert grid.curve_keys(made, by_step=False) == [("1", "0.5")]


keys = st.sets(st.tuples(st.integers(1, 40).map(str), st.sampled_from(["0.6", "0.85"])))
sizes = st.integers(1, 8)


@given(keys, st.data(), sizes, sizes)
def test_a_longer_study_keeps_its_blocks(longer, data, size, new_size):
    shorter = [key for key in sorted(longer) if data.draw(st.booleans())]
    before = grid.partition(shorter, size, {})
    after = grid.partition(sorted(longer), new_size, before)
    assert before.items() <= after.items()
    assert sorted(key for members in after.values() for key in members) == sorted(longer)
    assert all(len(after[name]) <= new_size for name in after.keys() - before.keys())
    assert all(name == grid.block_name(members) for name, members in after.items())


@given(keys, st.data(), sizes)
def test_a_shorter_study_uses_the_blocks_that_it_needs(longer, data, size):
    before = grid.partition(sorted(longer), size, {})
    needed = {key for key in longer if data.draw(st.booleans())}
    after = grid.partition(sorted(needed), size, before)
    assert after == {name: m for name, m in before.items() if needed.intersection(m)}


def test_new_blocks_are_full_and_in_order():
    members = [(str(i), "0.85") for i in range(5)]
    assert list(grid.partition(members, 2, {}).values()) == [
        tuple(members[:2]),
        tuple(members[2:4]),
        tuple(members[4:]),
    ]


def test_block_names_never_change():
    assert grid.block_name([("1", "0.85"), ("1.1", "0.85")]) == "617844beb85e"
    assert grid.block_name([("1", "0.85", "0.001")]) == "97671af1c25f"


@pytest.mark.parametrize("size", [0, -1])
def test_a_block_size_below_one_is_refused(size):
    with pytest.raises(ValueError, match=f"at least one curve, got block_size {size}"):
        grid.partition([("1", "0.85")], size, {})


BLOCK = [("1", "0.85"), ("2", "0.85")]
STEP_BLOCK = [("1", "0.85", "0.001"), ("2", "0.85", "0.001")]
READ = make_grid(theta=("1", "2"), mu0=("0.2", "0.3"))


@pytest.mark.parametrize("members", [BLOCK, STEP_BLOCK])
@pytest.mark.parametrize(
    "longer",
    [
        make_grid(theta=("0.5", "1", "1.5", "2", "7"), mu0=("0.2", "0.3")),
        make_grid(theta=("1", "2"), mu0=("0.2", "0.3"), eta=("0.5", "0.85", "0.9")),
    ],
    ids=["theta", "eta"],
)
def test_a_block_does_not_see_axis_values_of_other_blocks(members, longer):
    elsewhere = make_grid(theta=("3",))
    assert grid.block_readings(members, {"g": READ}) == grid.block_readings(
        members, {"g": longer, "elsewhere": elsewhere}
    )


@pytest.mark.parametrize(
    ("members", "changed", "seen"),
    [
        (BLOCK, make_grid(theta=("1", "2"), mu0=("0.2", "0.3", "0.4")), True),
        (STEP_BLOCK, make_grid(theta=("1", "2"), mu0=("0.2", "0.3", "0.4")), True),
        (BLOCK, make_grid(("1", "2"), ("0.2", "0.3"), dx0=("0.001", "0.002")), True),
        (STEP_BLOCK, make_grid(("1", "2"), ("0.2", "0.3"), dx0=("0.001", "0.002")), False),
        (BLOCK, make_grid(("1",), ("0.2", "0.3")), True),
    ],
)
def test_a_block_sees_what_is_read_off_it(members, changed, seen):
    before = grid.block_readings(members, {"g": READ})
    assert (grid.block_readings(members, {"g": changed}) != before) == seen


def test_readings_are_plain_values():
    assert grid.block_readings(BLOCK[:1], {"g": READ}) == {
        "g": {"theta": ["1"], "mu0": ["0.2", "0.3"], "eta": ["0.85"], "dx0": ["0.001"]}
    }


def study_points(named):
    """All points of a study with the names of their grids."""
    return {
        grid.Point(theta, mu0, eta, dx0): names
        for theta, eta, pairs in grid.study_points(named)
        for mu0, dx0, names in zip(pairs.mu0, pairs.dx0, pairs.grids, strict=True)
    }


def points_of_curves(keys, named):
    """Points that are read off curves with the names of their grids."""
    return {
        key: {
            grid.Point(Decimal(key[0]), mu0, Decimal(key[1]), dx0): names
            for mu0, dx0, names in zip(pairs.mu0, pairs.dx0, pairs.grids, strict=True)
        }
        for key, pairs in grid.readings(keys, named)
    }


@given(grids_by_name, st.booleans(), sizes)
def test_points_of_all_blocks_are_the_points_of_the_study(named, by_step, size):
    members = grid.curve_keys(named.values(), by_step)
    read = {}
    for block in grid.partition(members, size, {}).values():
        part = {
            name: grid.from_spelled(axes)
            for name, axes in grid.block_readings(block, named).items()
        }
        assert points_of_curves(block, part) == points_of_curves(block, named)
        for key, points in points_of_curves(block, part).items():
            assert list(points) == sorted(points)
            assert all(grid.curve_key(point, by_step) == key for point in points)
            assert not points.keys() & read.keys()
            read |= points
    in_order = [(p.eta, p.theta, p.mu0, p.dx0) for p in study_points(named)]
    assert in_order == sorted(in_order)
    assert read == study_points(named)


def test_a_point_of_several_grids_stands_once_with_all_names():
    named = {"b": make_grid(mu0=("0.3", "0.4")), "a": make_grid()}
    points = study_points(named)
    assert list(points.values()) == [["a", "b"], ["b"]]


@given(grids)
def test_the_plain_form_of_a_grid_reads_back(one):
    plain = grid.spelled(one)
    assert list(plain) == list(AXES)
    assert grid.from_spelled(plain) == one
