import json

import pytest

from vibrissa.grid import partition
from vibrissa.plan import PlanError, planned_blocks


def keys(*thetas):
    return [(theta, "0.85") for theta in thetas]


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
    assert list(planned_blocks(path, keys("2"), 1).values()) == [(("2", "0.85"),)]
    assert planned_blocks(path, keys("3", "2", "1"), 3) == all_blocks


def test_another_study_of_the_same_name_forgets_no_block(path):
    first = planned_blocks(path, keys("1", "2", "3"), 2)
    planned_blocks(path, keys("3", "4"), 2)
    assert first.items() <= planned_blocks(path, keys("1", "2", "3", "4"), 1).items()


def test_another_block_size_keeps_the_blocks(path):
    first = planned_blocks(path, keys("1", "2"), 2)
    assert planned_blocks(path, keys("1", "2"), 1) == first


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
    mistaken = [(str(theta), "0.85") for theta in range(1, 50)]
    planned_blocks(path, mistaken, 7, is_solved=lambda name: False)
    wanted = mistaken[::5]
    blocks = planned_blocks(path, wanted, 7, is_solved=lambda name: False)
    assert sorted(key for members in blocks.values() for key in members) == sorted(wanted)


def test_solved_blocks_are_kept_whatever_else_they_hold(tmp_path):
    path = tmp_path / "plan.json"
    first = planned_blocks(path, [("1", "0.85"), ("2", "0.85")], 7)
    again = planned_blocks(path, [("2", "0.85"), ("3", "0.85")], 1, is_solved=lambda name: True)
    assert first.items() <= again.items()
    assert len(again) == 2
