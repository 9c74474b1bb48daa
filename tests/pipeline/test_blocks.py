import json
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.errors import ArgumentError, PlanError
from vibrissa.pipeline.blocks import (
    block_name,
    ends_of_gaps,
    gaps_of_block,
    grids_of_blocks,
    known_blocks,
    partition,
    planned_blocks,
)
from vibrissa.study.boxes import disjoint, members, size
from vibrissa.study.codec import decode_box, decode_grid
from vibrissa.study.grid import Refinement


def box(*thetas, eta=("0.85",), **axes):
    return decode_box({"theta": thetas, "eta": eta, **axes})


def boxes(*thetas):
    return [box(*thetas)] if thetas else []


@pytest.fixture
def path(tmp_path):
    return tmp_path / "results" / "blocks" / "point-collocation.json"


def test_a_plan_is_remembered_and_extended(path):
    first = planned_blocks(path, boxes("2", "3", "4"), 2)
    longer = planned_blocks(path, boxes("1", "2", "2.5", "3", "4", "5"), 2)
    assert first == partition(boxes("2", "3", "4"), 2, {})
    assert first.items() <= longer.items()
    assert list(longer.values())[2:] == [box("1", "2.5"), box("5")]


def test_a_shorter_study_forgets_no_block(path):
    all_blocks = planned_blocks(path, boxes("1", "2", "3"), 1)
    assert list(planned_blocks(path, boxes("2"), 1).values()) == [box("2")]
    assert planned_blocks(path, boxes("1", "2", "3"), 3) == all_blocks


def test_another_study_of_the_same_name_forgets_no_block(path):
    first = planned_blocks(path, boxes("1", "2", "3"), 2)
    planned_blocks(path, boxes("3", "4"), 2)
    assert first.items() <= planned_blocks(path, boxes("1", "2", "3", "4"), 1).items()


def test_another_block_size_keeps_the_blocks(path):
    first = planned_blocks(path, boxes("1", "2"), 2)
    assert planned_blocks(path, boxes("1", "2"), 1) == first


def test_a_smaller_block_size_holds_for_blocks_that_are_not_solved(path):
    planned_blocks(path, boxes("1", "2", "3"), 3)
    blocks = planned_blocks(path, boxes("1", "2", "3"), 2, is_solved=lambda name: False)
    assert list(map(size, blocks.values())) == [2, 1]


@pytest.mark.parametrize("wanted", [("1", "2", "3"), ("2",), ()])
def test_a_plan_that_has_all_curves_is_not_written_again(path, wanted):
    planned_blocks(path, boxes("1", "2", "3"), 2)
    before = path.stat()
    planned_blocks(path, boxes(*wanted), 1)
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


def test_a_plan_can_be_made_without_being_written(path):
    blocks = planned_blocks(path, boxes("1", "2"), 1, remember=False)
    assert not path.parent.exists()
    assert planned_blocks(path, boxes("1", "2"), 1) == blocks


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b"7",
        b"null",
        b'{"a": 1}',
        b'{"a": [1]}',
        b'{"a": null}',
        b'{"a": {"theta": ["1"]}}',
        b'{"a": {"theta": ["1"], "eta": ["0.85"], "eat": ["1"]}}',
        b'{"a": {"theta": ["1:2:0.3"], "eta": ["0.85"]}}',
        b'{"a": {"theta": ["1:2"], "eta": ["0.85"]}}',
        b'{"a": {"theta": ["1:2:0"], "eta": ["0.85"]}}',
        b"\xff\xfe\x00",
    ],
)
def test_a_damaged_plan_is_refused_with_a_remedy(path, content):
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.raises(PlanError, match=f"plan of blocks is damaged; delete {path} and run again"):
        planned_blocks(path, boxes("1"), 1)
    assert path.read_bytes() == content


def test_a_plan_cut_short_anywhere_is_refused(path):
    planned_blocks(path, boxes("1", "2"), 1)
    whole = path.read_bytes()
    for length in range(len(whole.rstrip())):
        path.write_bytes(whole[:length])
        with pytest.raises(PlanError, match=f"delete {path} and run again"):
            planned_blocks(path, boxes("1"), 1)


def test_following_the_remedy_repairs_the_plan(path):
    blocks = planned_blocks(path, boxes("1", "2"), 1)
    path.write_text("{")
    path.unlink()
    assert planned_blocks(path, boxes("1", "2"), 1) == blocks


@pytest.mark.parametrize(
    "change",
    [
        lambda plan: {name: axes | {"theta": ["1"]} for name, axes in plan.items()},
        lambda plan: {name: axes | {"theta": ["2", "1"]} for name, axes in plan.items()},
        lambda plan: dict(zip(["0123456789ab"], plan.values(), strict=True)),
        lambda plan: {name: axes | {"dx0": ["0.001"]} for name, axes in plan.items()},
    ],
    ids=["curve removed", "order", "name", "step added"],
)
def test_a_plan_that_somebody_changed_is_refused_with_a_remedy(path, change):
    planned_blocks(path, boxes("1", "2"), 2)
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    with pytest.raises(PlanError, match=f"plan of blocks was changed; delete {path} and run again"):
        planned_blocks(path, boxes("1"), 1)


def test_a_plan_that_cannot_be_read_is_named(path):
    path.mkdir(parents=True)
    with pytest.raises(PlanError, match=f"cannot read the plan of blocks: .*{path}"):
        planned_blocks(path, boxes("1"), 1)


def test_a_file_in_place_of_the_folder_is_named(tmp_path):
    (tmp_path / "results").write_text("")
    with pytest.raises(PlanError, match=f"the plan of blocks: .*{tmp_path / 'results'}"):
        planned_blocks(tmp_path / "results" / "plan.json", boxes("1"), 1)


def test_a_plan_that_cannot_be_written_is_named(tmp_path):
    folder = tmp_path / "results"
    folder.symlink_to(tmp_path / "gone")
    with pytest.raises(PlanError, match=f"cannot write the plan of blocks: .*{folder}"):
        planned_blocks(folder / "plan.json", boxes("1"), 1)


def test_blocks_of_a_mistaken_grid_leave_no_traces(tmp_path):
    path = tmp_path / "plan.json"
    mistaken = list(map(str, range(1, 50)))
    planned_blocks(path, boxes(*mistaken), 7, is_solved=lambda name: False)
    wanted = boxes(*mistaken[::5])
    blocks = planned_blocks(path, wanted, 7, is_solved=lambda name: False)
    assert curves(blocks.values()) == curves(wanted)


def test_solved_blocks_are_kept_whatever_else_they_hold(tmp_path):
    path = tmp_path / "plan.json"
    first = planned_blocks(path, boxes("1", "2"), 7)
    again = planned_blocks(path, boxes("2", "3"), 1, is_solved=lambda name: True)
    assert first.items() <= again.items()
    assert len(again) == 2


def curves(boxes):
    """Curves of some boxes, each as often as it is there."""
    return sorted(curve for one in boxes for curve in map(str, members(one)))


def axes_of(*texts):
    return st.lists(st.sampled_from(texts), min_size=1, unique=True).map(sorted)


studies = st.lists(
    st.builds(
        lambda theta, eta: decode_box({"theta": theta, "eta": eta}),
        axes_of(*(f"1.{i}" for i in range(9))),
        axes_of("0.6", "0.7", "0.85"),
    ),
    max_size=3,
).map(disjoint)
sizes = st.integers(1, 8)


@given(studies, studies, sizes, sizes)
def test_a_study_that_grows_keeps_its_blocks(shorter, more, most, new_most):
    before = partition(shorter, most, {})
    assert curves(before.values()) == curves(shorter)
    longer = disjoint([*shorter, *more])
    after = partition(longer, new_most, before)
    assert before.items() <= after.items()
    assert curves(after.values()) == curves(longer)
    assert all(size(after[name]) <= new_most for name in after.keys() - before.keys())
    assert all(name == block_name(block) for name, block in after.items())


@given(studies, studies, sizes)
def test_another_study_uses_the_blocks_that_it_needs(study, other, most):
    before = partition(study, most, {})
    after = partition(other, most, before)
    needed = {n: b for n, b in before.items() if set(curves([b])) & set(curves(other))}
    assert needed.items() <= after.items()
    new = [block for name, block in after.items() if name not in needed]
    assert curves(new) == sorted(set(curves(other)) - set(curves(needed.values())))


@pytest.mark.slow
@given(studies, studies, sizes)
def test_of_blocks_that_are_not_solved_those_are_kept_that_are_needed_as_they_are(
    study, other, most
):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "plan.json"
        before = planned_blocks(path, study, most, is_solved=lambda name: False)
        after = planned_blocks(path, other, most, is_solved=lambda name: False)
        kept = {n: b for n, b in before.items() if set(curves([b])) <= set(curves(other))}
        assert kept.items() <= after.items()
        assert curves(after.values()) == curves(other)
        assert known_blocks(path) == after


def test_new_blocks_are_full_and_in_order():
    grid = box("1", "2", "3", eta=["0.6", "0.7", "0.8", "0.85", "0.9"])
    assert list(partition([grid], 7, {}).values()) == [
        grid | {"eta": grid["eta"][first : first + 2]} for first in (0, 2, 4)
    ]
    assert list(partition([grid], 2, {}).values())[:3] == [
        grid | {"eta": (eta,), "theta": thetas}
        for eta, thetas in (
            (Decimal("0.6"), grid["theta"][:2]),
            (Decimal("0.6"), grid["theta"][2:]),
            (Decimal("0.7"), grid["theta"][:2]),
        )
    ]


def test_block_names_never_change():
    assert block_name(box("1", "1.1")) == "492f9e4606e5"
    assert block_name(box("1:3:0.1", dx0=["0.001"])) == "640db4174f5c"


def test_a_plan_of_ten_million_curves_is_small(path):
    grid = decode_box({"theta": ["1:4.999:0.001"], "eta": ["0.5:0.7499:0.0001"]})
    blocks = planned_blocks(path, [grid], 4000)
    assert sum(map(size, blocks.values())) == 10_000_000 and len(blocks) == 2500
    assert path.stat().st_size < 300_000
    assert known_blocks(path) == blocks == planned_blocks(path, [grid], 4000)


@pytest.mark.parametrize("size", [0, -1])
def test_a_block_size_below_one_is_refused(size):
    with pytest.raises(ArgumentError, match=f"at least one curve, got block_size {size}"):
        partition(boxes("1"), size, {})


def make_grid(theta=("1",), mu0=("0.3",), eta=("0.85",), dx0=("0.001",)):
    return decode_grid({"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0})


BLOCK = box("1", "2")
STEP_BLOCK = box("1", "2", dx0=["0.001"])
GRID = make_grid(theta=("1", "2"), mu0=("0.2", "0.3"))


@pytest.mark.parametrize("block", [BLOCK, STEP_BLOCK])
@pytest.mark.parametrize(
    "longer",
    [
        make_grid(theta=("0.5", "1", "1.5", "2", "7"), mu0=("0.2", "0.3")),
        make_grid(theta=("1", "2"), mu0=("0.2", "0.3"), eta=("0.5", "0.85", "0.9")),
    ],
    ids=["theta", "eta"],
)
def test_a_block_does_not_see_axis_values_of_other_blocks(block, longer):
    elsewhere = make_grid(theta=("3",))
    assert grids_of_blocks({"g": GRID})(block) == grids_of_blocks(
        {"g": longer, "elsewhere": elsewhere}
    )(block)


@pytest.mark.parametrize(
    ("block", "changed", "seen"),
    [
        (BLOCK, make_grid(theta=("1", "2"), mu0=("0.2", "0.3", "0.4")), True),
        (STEP_BLOCK, make_grid(theta=("1", "2"), mu0=("0.2", "0.3", "0.4")), True),
        (BLOCK, make_grid(("1", "2"), ("0.2", "0.3"), dx0=("0.001", "0.002")), True),
        (STEP_BLOCK, make_grid(("1", "2"), ("0.2", "0.3"), dx0=("0.001", "0.002")), False),
        (BLOCK, make_grid(("1",), ("0.2", "0.3")), True),
    ],
)
def test_a_block_sees_the_points_on_its_curves(block, changed, seen):
    before = grids_of_blocks({"g": GRID})(block)
    assert (grids_of_blocks({"g": changed})(block) != before) == seen


@pytest.mark.parametrize("most", [1, 2, 3, 5, 12])
def test_each_gap_begins_in_one_block_and_its_end_is_found(most):
    axes = {"theta": ["1", "2", "4", "8"], "eta": ["0.7", "0.8", "0.9"], "mu0": ["0.3"]}
    grid = decode_grid({**axes, "dx0": ["0.001"]})
    grids = {"main": grid, "plain": grid, "mu0": grid}
    closest = {"theta": Decimal("0.1"), "eta": Decimal("0.01")}
    refinements = {
        "main": Refinement(column="x0_slip", tolerance=Decimal(1), closest=closest),
        "mu0": Refinement(column="x0_slip", tolerance=Decimal(1), closest={"mu0": Decimal(1)}),
    }
    found = []
    for block in partition([grid.curves(by_step=False)], most, {}).values():
        gaps = gaps_of_block(block, grids, refinements)
        assert gaps.keys() <= {"main"}
        ends = set()
        for axis, some in gaps.get("main", {}).items():
            across = "eta" if axis == "theta" else "theta"
            for gap in some:
                found += [(axis, gap, at) for at in block[across]]
                ends |= {(axis, gap[1], at) for at in block[across]}
        boxes = ends_of_gaps(block, grids, gaps)
        assert all(one["dx0"] == (None,) for one in boxes)
        told = {(key[1], key[0]) for one in boxes for key in members(one)}
        assert told == {(v, at) if axis == "theta" else (at, v) for axis, v, at in ends}
    along = [("theta", gap, at) for gap in pairwise(grid.theta) for at in grid.eta]
    along += [("eta", gap, at) for gap in pairwise(grid.eta) for at in grid.theta]
    assert sorted(found) == sorted(along)
