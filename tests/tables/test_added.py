"""Added points that are missing, doubled or foreign are found as a table passes."""

from dataclasses import replace
from decimal import Decimal

import pyarrow as pa
import pytest

from made_up import GRIDS, all_points, grid, point_table
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.study.codec import decode_key
from vibrissa.study.grid import Refinement, named_points
from vibrissa.tables import store
from vibrissa.tables.added import check_refined, refined_metadata, refined_summary, without_added
from vibrissa.tables.completeness import checked_points
from vibrissa.tables.schemas import STICTION

# The axis of μ0 has 0.1, 0.2, 0.3 and 0.4 in one grid, and 0.5 in the other.
REFINEMENTS = {
    "main": Refinement(column="x0_slip", tolerance=Decimal(1), closest={"mu0": Decimal("0.02")})
}
# θ, η and Δx0 of the lines that have added points.
FIRST, LAST = (0.1, 0.1, 0.1), (0.6, 0.5, 0.2)
MIDDLES = [(mu0, FIRST) for mu0 in (0.125, 0.15, 0.175)] + [(0.35, LAST), (0.325, LAST)]


def table(added, names=("main",), added_to=("main",), grids=GRIDS, leave_out=()):
    """All points of the grids, and those that were added: pairs of μ0 and a line."""
    points = all_points(grids)
    rows = [(point, names, None) for point, names in points if float(point[1]) not in leave_out]
    for mu0, (theta, eta, dx0) in added:
        rows.append(((theta, mu0, eta, dx0), list(names), list(added_to)))
    rows.sort(key=lambda row: [float(row[0][i]) for i in (2, 0, 1, 3)])
    found = point_table([(point, names) for point, names, _ in rows])
    place = STICTION.get_field_index("added_to")
    marks = pa.array([marks for *_, marks in rows], STICTION.field(place).type)
    return found.set_column(place, STICTION.field(place), marks)


def refusal(found, size=10_000, refinements=REFINEMENTS, grids=GRIDS):
    parts = [found.slice(i, size) for i in range(0, len(found), size)]
    with pytest.raises(TableError) as error:
        list(checked_points(parts, grids, refinements))
    return str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("size", [7, 100, 10_000])
def test_points_in_the_middle_of_others_pass_in_parts_of_any_size(size):
    found = table(MIDDLES)
    parts = [found.slice(i, size) for i in range(0, len(found), size)]
    assert pa.concat_tables(checked_points(parts, GRIDS, REFINEMENTS)).equals(found)


@pytest.mark.slow
@pytest.mark.parametrize("size", [13, 10_000])
@pytest.mark.parametrize(
    ("added", "problem"),
    [
        (
            [(0.16, FIRST)],
            "1 grid points are not in the study, such as (theta, mu0, eta, dx0) = (0.1, 0.16,",
        ),
        (
            [(0.15, FIRST), (0.125, FIRST), (0.1125, FIRST)],
            "1 grid points are not in the study, such as (theta, mu0, eta, dx0) = (0.1, 0.1125,",
        ),
        ([(0.45, FIRST)], "1 grid points are not in the study"),
        ([(0.05, FIRST)], "1 grid points are not in the study"),
        ([(0.15, (0.7, 0.1, 0.1))], "1 grid points are not in the study"),
        ([(0.15, (0.1, 0.6, 0.1))], "1 grid points are not in the study"),
        ([(0.15, (0.1, 0.1, 0.3))], "1 grid points are not in the study"),
        (
            [(0.125, FIRST)],
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.1, 0.15, 0.1, 0.1)",
        ),
        (
            [(0.325, LAST)],
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.6, 0.35, 0.5, 0.2)",
        ),
        (
            [(0.15, FIRST)] * 2,
            "1 grid points are doubled, such as (theta, mu0, eta, dx0) = (0.1, 0.15,",
        ),
        (
            [(0.35, LAST)] * 3,
            "1 grid points are doubled, such as (theta, mu0, eta, dx0) = (0.6, 0.35,",
        ),
        ([(0.2, FIRST)], "grid points are not in the study"),
    ],
)
def test_points_where_none_is_added_are_refused(added, problem, size):
    assert problem in refusal(table(added), size)


def test_without_a_refinement_no_point_is_added():
    assert "5 grid points are not in the study" in refusal(table(MIDDLES), refinements={})


def test_a_grid_that_is_none_of_the_studys_has_no_points():
    found = table(MIDDLES[1:2], names=("gone",), added_to=("gone",))
    assert "1 grid points are not in the study" in refusal(found)


def test_a_point_that_two_grids_share_has_one_row():
    """Of one it is on the axes, and to the other it is added."""
    grids = {"main": grid(), "other": replace(grid(theta=1, eta=1, dx0=1), mu0=(Decimal("0.15"),))}
    found = table(MIDDLES[1:2], ("main", "other"), ("main",), grids, leave_out=(0.15,))
    list(checked_points([found], grids, REFINEMENTS))
    twice = table(MIDDLES[1:2], ("main",), ("main",), grids)
    assert "1 grid points are of other grids, such as" in refusal(twice, grids=grids)
    unnamed = table(MIDDLES[1:2], ("main",), ("main",), grids, leave_out=(0.15,))
    assert "1 grid points are missing, such as" in refusal(unnamed, grids=grids)


def test_points_of_the_axes_are_missed_as_ever():
    found = table(MIDDLES).slice(1)
    assert "1 grid points are missing, such as" in refusal(found)


def test_a_point_of_one_grids_axes_that_another_gets_stays_the_ones():
    """Of the second grid, 0.5 is added to the first, whose axis would have to reach so far."""
    found = table([])
    place = STICTION.get_field_index("added_to")
    marks = [
        ["main"] if "more" in names and len(names) == 2 else None
        for names in found["grids"].to_pylist()
    ]
    marked = found.set_column(
        place, STICTION.field(place), pa.array(marks, STICTION.field(place).type)
    )
    left = without_added(marked)
    assert len(left) == len(found)
    assert left["grids"].to_pylist() == [
        ["more"] if mark else names
        for mark, names in zip(marks, found["grids"].to_pylist(), strict=True)
    ]
    assert without_added(table(MIDDLES))["grids"].equals(found["grids"])


# Values of θ are 0.1 to 0.6 and those of η 0.1 to 0.5.
CURVES = {
    "main": replace(
        REFINEMENTS["main"],
        closest={"theta": Decimal("0.02"), "eta": Decimal("0.02"), "mu0": Decimal("0.02")},
    )
}
OWN = [(mu0, dx0) for mu0 in (0.1, 0.2, 0.3, 0.4) for dx0 in (0.1, 0.2)]


def on_curves(*curves, left_out=(), more=()):
    pairs = [pair for pair in OWN if pair not in left_out]
    added = [(mu0, (theta, eta, dx0)) for theta, eta in curves for mu0, dx0 in pairs]
    return table([*added, *more])


@pytest.mark.parametrize("size", [97, 10_000])
def test_whole_curves_in_the_middle_of_others_pass(size):
    """Halved once, twice, on two lines, and with a point between the frictions of one."""
    curves = [(0.15, 0.1), (0.125, 0.1), (0.15, 0.5), (0.2, 0.35), (0.2, 0.375), (0.6, 0.15)]
    found = on_curves(*curves, more=[(0.15, (0.15, 0.1, 0.1))])
    parts = [found.slice(i, size) for i in range(0, len(found), size)]
    assert pa.concat_tables(checked_points(parts, GRIDS, CURVES)).equals(found)


@pytest.mark.parametrize(
    ("found", "problem"),
    [
        (on_curves((0.16, 0.1)), "8 grid points are not in the study"),
        (on_curves((0.65, 0.1)), "8 grid points are not in the study"),
        (on_curves((0.15, 0.15)), "8 grid points are not in the study"),
        (on_curves((0.1125, 0.1)), "8 grid points are not in the study"),
        (
            on_curves((0.125, 0.1)),
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.15, 0.1, 0.1, 0.1)",
        ),
        (
            on_curves((0.2, 0.375)),
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.2, 0.1, 0.35, 0.1)",
        ),
        (
            on_curves((0.15, 0.1), (0.125, 0.5)),
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.15, 0.1, 0.5, 0.1)",
        ),
        (
            on_curves((0.15, 0.1), left_out=[(0.3, 0.2)]),
            "1 grid points are missing, such as (theta, mu0, eta, dx0) = (0.15, 0.3, 0.1, 0.2)",
        ),
        (on_curves((0.15, 0.1), left_out=OWN[1::2]), "4 grid points are missing"),
        (on_curves((0.15, 0.1), (0.15, 0.1)), "8 grid points are doubled"),
        (on_curves((0.15, 0.1), more=[(0.125, (0.15, 0.1, 0.1))]), "1 grid points are missing"),
        (on_curves((0.15, 0.1), more=[(0.5, (0.15, 0.1, 0.1))]), "1 grid points are not in"),
        (on_curves((0.15, 0.1), more=[(0.1, (0.15, 0.1, 0.3))]), "1 grid points are not in"),
    ],
)
def test_curves_where_none_is_added_are_refused(found, problem):
    assert problem in refusal(found, refinements=CURVES)


def test_along_an_axis_that_is_not_refined_no_curve_is_added():
    assert "8 grid points are not in the study" in refusal(on_curves((0.15, 0.1)))


@pytest.mark.parametrize(
    ("theta", "eta"), [(0.1, 0.1), (0.15, 0.1)], ids=["own curve", "added curve"]
)
def test_rods_that_are_mounted_otherwise_are_foreign(theta, eta):
    found = on_curves((0.15, 0.1), more=[(0.15, (theta, eta, 0.1))])
    rows = found.to_pylist()
    tilted = [
        0.7 if (row["theta"], row["eta"], row["mu0"]) == (theta, eta, 0.15) else 0.0 for row in rows
    ]
    place = STICTION.get_field_index("clamp_angle")
    found = found.set_column(place, STICTION.field(place), pa.array(tilted))
    order = [(name, "ascending") for name in ("eta", "theta", "clamp_angle", "mu0", "dx0")]
    assert "1 grid points are not in the study" in refusal(found.sort_by(order), refinements=CURVES)


# How a block is refined, as its job is told; here any words.
REFINING = {"refinements": {"main": {"tolerance": "1"}}, "gaps": {}}
ADDED = [(Decimal(mu0), Decimal("0.1")) for mu0 in ("0.1015625", "0.15", "0.175", "0.2", "0.225")]


@pytest.fixture
def block(tmp_path):
    """Writes a block that has some of the points that were added, and an account of all."""
    own = [(Decimal("0.1"), Decimal("0.1")), (Decimal("0.1"), Decimal("0.2"))]

    marked = {pair: ["main"] for pair in ADDED}

    def write(pairs, metadata=None, key=("0.1", "0.1"), left=(), name="b"):
        points = named_points({pair: ["main"] for pair in [*own, *ADDED]}, marked)
        told = refined_metadata(REFINING, [(decode_key(key), points)], left)
        rows = point_table([((0.1, mu0, 0.1, dx0), ["main"]) for mu0, dx0 in [*own, *pairs]])
        place = STICTION.get_field_index("added_to")
        marks = pa.array([None, None] + [["main"]] * len(pairs), STICTION.field(place).type)
        told = told if metadata is None else metadata
        made = rows.set_column(place, STICTION.field(place), marks)
        store.write(
            made.replace_schema_metadata(STICTION.metadata | told), tmp_path / f"{name}.parquet"
        )
        return tmp_path / f"{name}.parquet"

    return write


def test_a_block_has_the_points_that_it_says(block):
    check_refined(block(ADDED), REFINING)


@pytest.mark.parametrize("missing", range(len(ADDED)))
def test_any_added_point_that_a_block_lost_is_named(block, missing):
    """Also one next to which nothing was added, as the last."""
    path = block([pair for pair in ADDED if pair != ADDED[missing]])
    mu0 = ADDED[missing][0]
    with pytest.raises(DamagedTableError) as error:
        check_refined(path, REFINING)
    assert str(error.value) == (
        f"{path} lacks 1 point that refine added, such as (theta, mu0, eta, dx0) = "
        f"(0.1, {mu0}, 0.1, 0.1); delete it and run again, it is made anew"
    )
    assert error.value.path == path


def test_a_point_of_which_a_block_does_not_say_that_it_was_added_is_named(block):
    path = block([*ADDED, (Decimal("0.3"), Decimal("0.1"))])
    with pytest.raises(DamagedTableError, match=r"has no account of 1 point that .* 0.3, 0.1, 0.1"):
        check_refined(path, REFINING)


def test_points_of_another_curve_are_not_those_of_a_block(block):
    """The first three are named."""
    path = block(ADDED, key=("0.2", "0.1"))
    with pytest.raises(DamagedTableError, match=r"lacks 5 points .* = \(0.2, 0.1015625, ") as error:
        check_refined(path, REFINING)
    assert str(error.value).count("(0.2, ") == 3
    path = block(ADDED, key=("0.1", "0.1", "clamp_angle=0.7"))
    with pytest.raises(DamagedTableError, match=r"lacks 5 .* \(0.1, 0.1015625, 0.1, 0.1, 0.7, 0"):
        check_refined(path, REFINING)


@pytest.mark.parametrize("metadata", [None, {}], ids=["another refine", "none"])
def test_a_block_that_was_refined_otherwise_is_made_anew(block, metadata):
    path = block(ADDED, metadata)
    with pytest.raises(DamagedTableError, match="was refined in another way than the study asks"):
        check_refined(path, {**REFINING, "gaps": {"main": {"theta": [["1"], ["2"]]}}})


def test_what_is_left_over_is_summed_up_in_a_line(block):
    """The lines of all blocks, by grid and axis, with the longest."""
    left = [("main", "mu0", Decimal("0.0015")), ("main", "mu0", Decimal("0.25"))]
    more = [("main", "mu0", Decimal("0.1")), ("a", "theta", Decimal(2))]
    paths = [block(ADDED, left=left, name="b"), block(ADDED, left=more, name="c")]
    assert refined_summary(paths) == (
        "refine added 10 points; not within the tolerance at closest: up to 2 of theta on 1 line "
        "of a, up to 0.25 of mu0 on 3 lines of main"
    )
    assert refined_summary([block(ADDED)]) == "refine added 5 points"
    nothing = refined_metadata(REFINING, [], [])
    assert refined_summary([block([], nothing)]).startswith("refine added no points: straight ")
