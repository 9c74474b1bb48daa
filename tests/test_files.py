import os
import stat

import pytest

from vibrissa.files import write_atomically


@pytest.mark.parametrize("old", [None, "old"])
def test_the_file_is_there_only_when_it_is_whole(tmp_path, old):
    path = tmp_path / "table.txt"
    if old:
        path.write_text(old)
    with write_atomically(path) as temporary:
        temporary.write_text("new")
        assert temporary.parent == path.parent
        assert temporary.suffix == path.suffix
        assert path.exists() == (old is not None)
        assert not old or path.read_text() == old
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_is_on_the_disk_before_it_is_moved_and_the_folder_after(tmp_path, monkeypatch):
    """Otherwise a loss of power could leave an empty file under the right name."""
    path, synced = tmp_path / "table.txt", []
    # Whether it was the file or the folder, and whether the file had its name.
    monkeypatch.setattr(
        os, "fsync", lambda handle: synced.append((os.fstat(handle).st_ino, path.exists()))
    )
    with write_atomically(path) as temporary:
        temporary.write_text("new")
    assert synced == [(path.stat().st_ino, False), (tmp_path.stat().st_ino, True)]


@pytest.mark.parametrize("old", [None, "old"])
@pytest.mark.parametrize("error", [ValueError, OSError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_everything_as_it_was(tmp_path, error, old):
    path = tmp_path / "table.txt"
    if old:
        path.write_text(old)
    with pytest.raises(error), write_atomically(path) as temporary:
        temporary.write_text("half")
        raise error
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == ({path.name: old} if old else {})


@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o027, 0o640), (0o077, 0o600)])
def test_the_result_has_the_rights_of_any_new_file(tmp_path, umask, mode):
    path = tmp_path / "table.txt"
    before = os.umask(umask)
    try:
        with write_atomically(path) as temporary:
            temporary.write_text("new")
        after = os.umask(umask)
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == mode
    assert after == umask


def test_a_missing_folder_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError), write_atomically(tmp_path / "no" / "table.txt"):
        pass


def test_an_error_comes_through_where_the_temporary_file_is_gone_already(tmp_path):
    with (
        pytest.raises(ValueError, match="my own"),
        write_atomically(tmp_path / "table.txt") as temporary,
    ):
        temporary.unlink()
        raise ValueError("my own")
    assert not list(tmp_path.iterdir())
