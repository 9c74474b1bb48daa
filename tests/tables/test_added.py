"""Added points that are missing, doubled, foreign or misnamed are found, in a block or several."""

from dataclasses import replace
from decimal import Decimal

import pyarrow as pa
import pytest

from made_up import GRIDS, all_points, grid, point_table
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.study.codec import decode_key
from vibrissa.study.grid import named_points
from vibrissa.tables import store
from vibrissa.tables.added import refined_metadata, refined_summary
from vibrissa.tables.completeness import check_refined, checked_points
from vibrissa.tables.schemas import STICTION

# θ, η and Δx0 of the lines that have added points; the third is of a curve that was added.
FIRST, LAST, BETWEEN = (0.1, 0.1, 0.1), (0.6, 0.5, 0.2), (0.15, 0.1, 0.1)
MIDDLES = [(mu0, FIRST) for mu0 in (0.125, 0.15, 0.175)] + [(0.35, LAST), (0.325, LAST)]


def marked(rows):
    """A table of points, each with the names of its grids and of those that it was added to."""
    found = point_table([(point, names) for point, names, _ in rows])
    place = STICTION.get_field_index("added_to")
    marks = pa.array([added_to for *_, added_to in rows], STICTION.field(place).type)
    return found.set_column(place, STICTION.field(place), marks)


def table(added, names=("main",), added_to=("main",), grids=GRIDS, leave_out=()):
    """All points of the grids, and those that were added: pairs of μ0 and a line."""
    points = all_points(grids)
    rows = [(point, names, None) for point, names in points if float(point[1]) not in leave_out]
    for mu0, (theta, eta, dx0) in added:
        rows.append(((theta, mu0, eta, dx0), list(names), list(added_to)))
    rows.sort(key=lambda row: [float(row[0][i]) for i in (2, 0, 1, 3)])
    return marked(rows)


def refusal(found, size=10_000, refined=frozenset({"main"}), grids=GRIDS):
    parts = [found.slice(i, size) for i in range(0, len(found), size)]
    with pytest.raises(TableError) as error:
        list(checked_points(parts, grids, refined))
    return str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("size", [7, 100, 10_000])
def test_added_points_and_curves_pass_in_parts_of_any_size(size):
    found = table([*MIDDLES, (0.1, BETWEEN), (0.4, BETWEEN)])
    parts = [found.slice(i, size) for i in range(0, len(found), size)]
    assert pa.concat_tables(checked_points(parts, GRIDS, {"main"})).equals(found)


@pytest.mark.parametrize("size", [1, 13, 10_000])
@pytest.mark.parametrize(
    ("added", "count", "example"),
    [
        ([(0.15, FIRST)] * 2, "1 grid point", "(0.1, 0.15, 0.1, 0.1)"),
        ([(0.35, LAST)] * 3, "1 grid point", "(0.6, 0.35, 0.5, 0.2)"),
        ([(0.1, BETWEEN), (0.4, BETWEEN)] * 2, "2 grid points", "(0.15, 0.1, 0.1, 0.1)"),
        # A point of the axes
        ([(0.2, FIRST)], "1 grid point", "(0.1, 0.2, 0.1, 0.1)"),
    ],
)
def test_no_point_stands_twice_also_in_two_blocks(added, count, example, size):
    said = refusal(table(added), size)
    place = "(theta, mu0, eta, dx0)"
    assert said.startswith(f"stiction has {count} more than once, such as {place} = {example}")


def test_without_refine_no_point_is_added():
    assert "stiction has 5 grid points too many" in refusal(table(MIDDLES), refined=frozenset())


def test_a_grid_that_is_none_of_the_studys_has_no_points():
    found = table(MIDDLES[1:2], names=("gone",), added_to=("gone",))
    assert "stiction has 1 grid point too many" in refusal(found)


def test_a_point_that_two_grids_share_has_one_row():
    """Of one it is on the axes, and to the other it is added."""
    grids = {"main": grid(), "other": replace(grid(theta=1, eta=1, dx0=1), mu0=(Decimal("0.15"),))}
    shared = table(MIDDLES[1:2], ("main", "other"), ("main",), grids, leave_out=(0.15,))
    list(checked_points([shared], grids, {"main"}))
    twice = table(MIDDLES[1:2], ("main",), ("main",), grids)
    assert "stiction has 1 grid point more than once, such as" in refusal(twice, grids=grids)
    unnamed = table(MIDDLES[1:2], ("main",), ("main",), grids, leave_out=(0.15,))
    assert "stiction lacks 1 grid point, such as" in refusal(unnamed, grids=grids)
    other = table(MIDDLES[1:2], ("main", "more", "other"), ("main",), grids, leave_out=(0.15,))
    assert "stiction has 1 grid point with the names of other" in refusal(other, grids=grids)


def test_points_of_the_axes_are_missed_as_ever():
    assert "stiction lacks 1 grid point, such as" in refusal(table(MIDDLES).slice(1))


def test_points_of_the_axes_were_not_added():
    """Whether refine adds points to their grid or not."""
    rows = [(point, names, None) for point, names in all_points()]
    rows[-1] = (*rows[-1][:2], ["main"])
    assert "stiction lacks 1 grid point, such as" in refusal(marked(rows))
    said = refusal(marked(rows), refined=frozenset())
    assert "stiction has 1 grid point with the names of other grids, such as" in said


# How a block is refined, as its job is told; here any words.
REFINING = {"refinements": {"main": {"tolerance": "1"}}, "gaps": {}}
NOT_REFINING = {"refinements": {}, "gaps": {}}
OWN = [((0.1, 0.1, 0.1, dx0), ["main"], None) for dx0 in (0.1, 0.2)]
# On a curve of a grid, one of them for two grids; and all points of a curve that was added.
ADDED = [
    *(((0.1, mu0, 0.1, 0.1), ["main"], ["main"]) for mu0 in (0.1015625, 0.15, 0.175)),
    ((0.1, 0.2, 0.1, 0.1), ["main", "other"], ["main"]),
    ((0.1, 0.225, 0.1, 0.1), ["main"], ["main"]),
    *(((0.15, mu0, 0.1, dx0), ["main"], ["main"]) for mu0 in (0.1, 0.2) for dx0 in (0.1, 0.2)),
]


def account(rows, *mounting, left=()):
    """What a block says that has some rows, in exact values."""
    curves = {}
    for (theta, mu0, eta, dx0), names, added_to in rows:
        key = decode_key([str(theta), str(eta), *mounting])
        curves.setdefault(key, {})[Decimal(str(mu0)), Decimal(str(dx0))] = names, added_to
    points = [
        (
            key,
            named_points(
                {pair: names for pair, (names, _) in pairs.items()},
                {pair: added_to for pair, (_, added_to) in pairs.items()},
            ),
        )
        for key, pairs in curves.items()
    ]
    return refined_metadata(REFINING, points, left)


@pytest.fixture
def block(tmp_path):
    """Writes a block that has some rows beside those of the axes, and an account of all."""

    def write(rows, metadata=None, name="b"):
        metadata = account([*OWN, *ADDED]) if metadata is None else metadata
        path = tmp_path / f"{name}.parquet"
        made = marked([*OWN, *rows])
        store.write(made.replace_schema_metadata(STICTION.metadata | metadata), path)
        return path

    return write


def complaint(path, refining=REFINING):
    with pytest.raises(DamagedTableError) as error:
        check_refined(path, refining)
    assert error.value.path == path
    said = str(error.value)
    assert said.endswith("; delete it and run again, it is made anew")
    return said.removeprefix(f"{path} ")


def test_a_block_has_the_points_that_it_says(block):
    check_refined(block(ADDED), REFINING)
    check_refined(block(ADDED[::-1]), REFINING)
    check_refined(block([], {}), NOT_REFINING)


@pytest.mark.parametrize("lost", range(len(ADDED)))
def test_any_added_point_that_a_block_lost_is_named(block, lost):
    """Also one next to which nothing was added, as 0.1015625."""
    theta, mu0, eta, dx0 = ADDED[lost][0]
    assert complaint(block(ADDED[:lost] + ADDED[lost + 1 :])).startswith(
        "lacks 1 added point, such as (theta, mu0, eta, dx0) = "
        f"({theta}, {mu0}, {eta}, {dx0}); delete"
    )


def test_a_curve_that_a_block_lost_is_named(block):
    """By its first three points."""
    assert complaint(block(ADDED[:5])).startswith(
        "lacks 4 added points, such as (theta, mu0, eta, dx0) = "
        "(0.15, 0.1, 0.1, 0.1), (0.15, 0.1, 0.1, 0.2), (0.15, 0.2, 0.1, 0.1); delete"
    )


@pytest.mark.parametrize(
    "point",
    [(0.1, 0.3, 0.1, 0.1), (0.1, 0.15, 0.1, 0.2), (0.125, 0.1, 0.1, 0.1), (0.1, 0.15, 0.2, 0.1)],
)
def test_a_point_of_which_a_block_does_not_say_that_it_was_added_is_named(block, point):
    said = complaint(block([*ADDED, (point, ["main"], ["main"])]))
    assert said.startswith("has 1 added point too many, such as")
    assert f" = {point};" in said


def test_an_added_point_that_a_block_has_twice_is_named(block):
    said = complaint(block([*ADDED, ADDED[4], ADDED[4]]))
    assert said.startswith("has 1 added point more than once, such as")
    assert " = (0.1, 0.225, 0.1, 0.1);" in said


@pytest.mark.parametrize(
    ("names", "added_to"),
    [
        (["main"], ["main"]),
        (["main", "other"], ["main", "other"]),
        (["main", "other"], ["other"]),
        (["other"], ["main"]),
    ],
)
def test_an_added_point_that_names_other_grids_is_named(block, names, added_to):
    rows = [
        (point, names, added_to) if point[1] == 0.2 else (point, *rest)
        for point, *rest in ADDED[:5]
    ]
    said = complaint(block([*rows, *ADDED[5:]]))
    assert said.startswith("has 1 added point with the names of other grids, such as")
    assert " = (0.1, 0.2, 0.1, 0.1);" in said


def test_points_of_another_rod_are_not_those_of_a_block(block):
    """It is mounted in another way."""
    said = complaint(block(ADDED, account(ADDED, "clamp_angle=0.7")))
    assert said.startswith("lacks 9 added points, such as (theta, mu0, eta, dx0, clamp_angle, ")
    assert "(0.1, 0.1015625, 0.1, 0.1, 0.7, 0" in said


@pytest.mark.parametrize("metadata", [None, {}], ids=["another refine", "none"])
def test_a_block_that_was_refined_otherwise_is_made_anew(block, metadata):
    said = complaint(
        block(ADDED, metadata), {**REFINING, "gaps": {"main": {"theta": [["1"], ["2"]]}}}
    )
    assert said.startswith("was refined in another way than the study asks for;")


def test_a_block_that_is_not_refined_has_no_added_points(block):
    assert complaint(block(ADDED[:1], {}), NOT_REFINING).startswith("has 1 added point too many")
    assert complaint(block(ADDED), NOT_REFINING).startswith("was refined in another way")


def test_what_is_left_over_is_summed_up_in_a_line(block):
    """The lines of all blocks, by grid and axis, with the longest."""
    left = [("main", "mu0", Decimal("0.0015")), ("main", "mu0", Decimal("0.25"))]
    more = [("main", "mu0", Decimal("0.1")), ("a", "theta", Decimal(2))]
    said = {name: account(ADDED, left=lines) for name, lines in (("b", left), ("c", more))}
    paths = [block(ADDED, metadata, name) for name, metadata in said.items()]
    assert refined_summary([*paths, block([], {}, "d")]) == (
        "refine added 18 points; not within the tolerance at closest: up to 2 of theta on 1 line "
        "of a, up to 0.25 of mu0 on 3 lines of main"
    )
    assert refined_summary([block(ADDED)]) == "refine added 9 points"
    assert refined_summary([block([], account(OWN))]).startswith(
        "refine added no points: straight "
    )
