import json
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.errors import ArgumentError, PlanError
from vibrissa.pipeline.blocks import block_name, grids_of_block, partition, planned_blocks
from vibrissa.study.codec import decode_grid, decode_key


def keys(*thetas):
    return [decode_key([theta, "0.85"]) for theta in thetas]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "results" / "blocks" / "point-collocation.json"


def test_a_plan_is_remembered_and_extended(path):
    first = planned_blocks(path, keys("2", "3", "4"), 2)
    longer = planned_blocks(path, keys("1", "2", "2.5", "3", "4", "5"), 2)
    assert first == partition(keys("2", "3", "4"), 2, {})
    assert first.items() <= longer.items()
    assert list(longer.values())[2:] == [tuple(keys("1", "2.5")), tuple(keys("5"))]


def test_a_shorter_study_forgets_no_block(path):
    all_blocks = planned_blocks(path, keys("1", "2", "3"), 1)
    assert list(planned_blocks(path, keys("2"), 1).values()) == [tuple(keys("2"))]
    assert planned_blocks(path, keys("3", "2", "1"), 3) == all_blocks


def test_another_study_of_the_same_name_forgets_no_block(path):
    first = planned_blocks(path, keys("1", "2", "3"), 2)
    planned_blocks(path, keys("3", "4"), 2)
    assert first.items() <= planned_blocks(path, keys("1", "2", "3", "4"), 1).items()


def test_another_block_size_keeps_the_blocks(path):
    first = planned_blocks(path, keys("1", "2"), 2)
    assert planned_blocks(path, keys("1", "2"), 1) == first


def test_a_smaller_block_size_holds_for_blocks_that_are_not_solved(path):
    planned_blocks(path, keys("1", "2", "3"), 3)
    blocks = planned_blocks(path, keys("1", "2", "3"), 2, is_solved=lambda name: False)
    assert [len(members) for members in blocks.values()] == [2, 1]


@pytest.mark.parametrize("wanted", [("1", "2", "3"), ("2",), ()])
def test_a_plan_that_has_all_curves_is_not_written_again(path, wanted):
    planned_blocks(path, keys("1", "2", "3"), 2)
    before = path.stat()
    planned_blocks(path, keys(*wanted), 1)
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


def test_a_plan_can_be_made_without_being_written(path):
    blocks = planned_blocks(path, keys("1", "2"), 1, remember=False)
    assert not path.parent.exists()
    assert planned_blocks(path, keys("1", "2"), 1) == blocks


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
        b"\xff\xfe\x00",
    ],
)
def test_a_damaged_plan_is_refused_with_a_remedy(path, content):
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.raises(PlanError, match=f"plan of blocks is damaged; delete {path} and run again"):
        planned_blocks(path, keys("1"), 1)
    assert path.read_bytes() == content


def test_a_plan_cut_short_anywhere_is_refused(path):
    planned_blocks(path, keys("1", "2"), 1)
    whole = path.read_bytes()
    for length in range(len(whole.rstrip())):
        path.write_bytes(whole[:length])
        with pytest.raises(PlanError, match=f"delete {path} and run again"):
            planned_blocks(path, keys("1"), 1)


def test_following_the_remedy_repairs_the_plan(path):
    blocks = planned_blocks(path, keys("1", "2"), 1)
    path.write_text("{")
    path.unlink()
    assert planned_blocks(path, keys("1", "2"), 1) == blocks


@pytest.mark.parametrize(
    "change",
    [
        lambda plan: {name: members[:1] for name, members in plan.items()},
        lambda plan: {name: members[::-1] for name, members in plan.items()},
        lambda plan: dict(zip(["0123456789ab"], plan.values(), strict=True)),
        lambda plan: {name: [[*key, "0.001"] for key in members] for name, members in plan.items()},
    ],
    ids=["curve removed", "order", "name", "step added"],
)
def test_a_plan_that_somebody_changed_is_refused_with_a_remedy(path, change):
    planned_blocks(path, keys("1", "2"), 2)
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    with pytest.raises(PlanError, match=f"plan of blocks was changed; delete {path} and run again"):
        planned_blocks(path, keys("1"), 1)


def test_a_plan_that_cannot_be_read_is_named(path):
    path.mkdir(parents=True)
    with pytest.raises(PlanError, match=f"cannot read the plan of blocks: .*{path}"):
        planned_blocks(path, keys("1"), 1)


def test_a_file_in_place_of_the_folder_is_named(tmp_path):
    (tmp_path / "results").write_text("")
    with pytest.raises(PlanError, match=f"the plan of blocks: .*{tmp_path / 'results'}"):
        planned_blocks(tmp_path / "results" / "plan.json", keys("1"), 1)


def test_a_plan_that_cannot_be_written_is_named(tmp_path):
    folder = tmp_path / "results"
    folder.symlink_to(tmp_path / "gone")
    with pytest.raises(PlanError, match=f"cannot write the plan of blocks: .*{folder}"):
        planned_blocks(folder / "plan.json", keys("1"), 1)


def test_blocks_of_a_mistaken_grid_leave_no_traces(tmp_path):
    path = tmp_path / "plan.json"
    mistaken = keys(*map(str, range(1, 50)))
    planned_blocks(path, mistaken, 7, is_solved=lambda name: False)
    wanted = mistaken[::5]
    blocks = planned_blocks(path, wanted, 7, is_solved=lambda name: False)
    assert sorted(key for members in blocks.values() for key in members) == sorted(wanted)


def test_solved_blocks_are_kept_whatever_else_they_hold(tmp_path):
    path = tmp_path / "plan.json"
    first = planned_blocks(path, keys("1", "2"), 7)
    again = planned_blocks(path, keys("2", "3"), 1, is_solved=lambda name: True)
    assert first.items() <= again.items()
    assert len(again) == 2


key_sets = st.sets(
    st.tuples(st.integers(1, 40).map(str), st.sampled_from(["0.6", "0.85"])).map(decode_key)
)
sizes = st.integers(1, 8)


@given(key_sets, st.data(), sizes, sizes)
def test_a_longer_study_keeps_its_blocks(longer, data, size, new_size):
    shorter = [key for key in sorted(longer) if data.draw(st.booleans())]
    before = partition(shorter, size, {})
    after = partition(sorted(longer), new_size, before)
    assert before.items() <= after.items()
    assert sorted(key for members in after.values() for key in members) == sorted(longer)
    assert all(len(after[name]) <= new_size for name in after.keys() - before.keys())
    assert all(name == block_name(members) for name, members in after.items())


@given(key_sets, st.data(), sizes)
def test_a_shorter_study_uses_the_blocks_that_it_needs(longer, data, size):
    before = partition(sorted(longer), size, {})
    needed = {key for key in longer if data.draw(st.booleans())}
    after = partition(sorted(needed), size, before)
    assert after == {name: m for name, m in before.items() if needed.intersection(m)}


def test_new_blocks_are_full_and_in_order():
    members = keys("0", "1", "2", "3", "4")
    assert list(partition(members, 2, {}).values()) == [
        tuple(members[:2]),
        tuple(members[2:4]),
        tuple(members[4:]),
    ]


def test_block_names_never_change():
    assert block_name(keys("1", "1.1")) == "617844beb85e"
    assert block_name([decode_key(["1", "0.85", "0.001"])]) == "97671af1c25f"


def test_a_plan_that_was_written_before_keys_were_decimals_still_holds(path):
    path.parent.mkdir(parents=True)
    written = '{\n"617844beb85e": [["1", "0.85"], ["1.1", "0.85"]]\n}\n'
    path.write_text(written)
    assert list(planned_blocks(path, keys("1.1", "1"), 1)) == ["617844beb85e"]
    planned_blocks(path, keys("1", "2"), 1)
    assert path.read_text().startswith(written.removesuffix("\n}\n"))


@pytest.mark.parametrize("size", [0, -1])
def test_a_block_size_below_one_is_refused(size):
    with pytest.raises(ArgumentError, match=f"at least one curve, got block_size {size}"):
        partition(keys("1"), size, {})


def make_grid(theta=("1",), mu0=("0.3",), eta=("0.85",), dx0=("0.001",)):
    return decode_grid({"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0})


BLOCK = keys("1", "2")
STEP_BLOCK = [key._replace(dx0=Decimal("0.001")) for key in BLOCK]
GRID = make_grid(theta=("1", "2"), mu0=("0.2", "0.3"))


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
    assert grids_of_block(members, {"g": GRID}) == grids_of_block(
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
def test_a_block_sees_the_points_on_its_curves(members, changed, seen):
    before = grids_of_block(members, {"g": GRID})
    assert (grids_of_block(members, {"g": changed}) != before) == seen
