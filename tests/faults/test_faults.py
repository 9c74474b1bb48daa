"""Faults at random times, and the same command again: the values are those of an undisturbed run.

Run by `python -m validation faults` alone, as it takes minutes.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from vibrissa.tables import schemas, store

ROOT = Path(__file__).parents[2]
STUDY = """study: faults
chunk: {theta: 1}
grids: {g: {theta: {start: 1, stop: 3, step: 0.5}, mu0: [0.3, 5], eta: [0.85], dx0: [0.005]}}
surfaces: {rough: {mean: 0.3, deviation: 0.05, correlation: 0.05, seed: [1, 2]}}
scans:
  s: {theta: [1, 3], surface: rough, eta: [0.85], dx0: [0.005], law: [free, energy],
      kinetic_ratio: 0.7, cycles: 2}
"""
COMMAND = [sys.executable, "-m", "vibrissa.pipeline", "--configfile", "study.yaml", "--cores", "2"]
# Each push runs one of each: VIBRISSA_TRIES=1.
TRIES = range(int(os.environ.get("VIBRISSA_TRIES", "10")))
KILLED = (0.2, 6.0)  # seconds in which a run does most of its work


def start(folder, command=COMMAND):
    folder.mkdir(exist_ok=True)
    (folder / "study.yaml").write_text(STUDY)
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def finish(folder):
    process = start(folder)
    screen, _ = process.communicate(timeout=300)
    assert "Traceback" not in screen
    return process.returncode, screen


def tables(folder):
    paths = sorted(folder.glob("results/faults/tables/*.parquet"))
    assert [path.stem for path in paths] == ["periods", "scans", "stiction"]
    return {path.stem: store.read(path, schemas.TABLES[path.stem]) for path in paths}


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    status, screen = finish(folder)
    assert status == 0, screen
    return folder


def assert_healed(folder, undisturbed, runs=1):
    """The same command comes to its end, with the same values, and leaves nothing behind."""
    for _ in range(runs):
        status, screen = finish(folder)
    assert status == 0, screen
    mine, theirs = tables(folder), tables(undisturbed)
    for name in theirs:
        assert mine[name].equals(theirs[name]), name
    files = {path.relative_to(folder) for path in (folder / "results").rglob("*")}
    expected = {path.relative_to(undisturbed) for path in (undisturbed / "results").rglob("*")}
    assert files == expected
    assert "Nothing to be done" in finish(folder)[1]


@pytest.mark.parametrize("seed", TRIES)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_signal_at_a_random_time(tmp_path, undisturbed, number, seed):
    """SIGKILL ends the run, its Snakemake and all jobs at once, as a power cut does."""
    process = start(tmp_path)
    time.sleep(random.Random(seed).uniform(*KILLED))
    family = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    for one in family if number == signal.SIGKILL else family[:1]:
        if one.is_running():
            one.send_signal(number)
    screen, _ = process.communicate(timeout=120)
    assert "Traceback" not in screen and "Exception ignored" not in screen
    if number != signal.SIGKILL and process.returncode:
        assert "Stopped. Finished results are kept" in screen.splitlines()[-1]
        assert "Error in rule" not in screen
    assert_healed(tmp_path, undisturbed)


@pytest.mark.parametrize("seed", TRIES)
def test_one_job_is_killed(tmp_path, undisturbed, seed):
    process = start(tmp_path)
    time.sleep(random.Random(seed).uniform(*KILLED))
    children = psutil.Process(process.pid).children(recursive=True)
    jobs = [one for one in children if any(".snakemake/scripts" in x for x in one.cmdline())]
    for one in jobs[-1:]:
        one.kill()
    # The other jobs go on, which takes as long as in `finish`.
    screen, _ = process.communicate(timeout=300)
    assert "Traceback" not in screen
    assert_healed(tmp_path, undisturbed)


@pytest.mark.parametrize("seed", TRIES)
def test_a_file_is_damaged(tmp_path, undisturbed, seed):
    """A byte, or the end, of a chunk or a table; the file keeps its time."""
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    chance = random.Random(seed)
    path = chance.choice(sorted((tmp_path / "results/faults").glob("*/**/*.parquet")))
    times, data = path.stat(), bytearray(path.read_bytes())
    if seed % 2:
        data = data[: chance.randrange(len(data))]
    else:
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    # A chunk is read only where the table of all chunks must be made again.
    kind, *below = path.relative_to(tmp_path / "results/faults").parts
    if kind != "tables":
        table = "stiction" if kind == "chunks" else below[0]
        (tmp_path / f"results/faults/tables/{table}.parquet").unlink()
    status, screen = finish(tmp_path)
    assert status == 0, screen
    assert f"{path.relative_to(tmp_path)} " in screen and ": it is made again" in screen
    assert_healed(tmp_path, undisturbed)


@pytest.mark.parametrize("seed", TRIES)
def test_the_disk_is_full(tmp_path, undisturbed, seed):
    disk = tmp_path / "disk"
    disk.mkdir()
    size = random.Random(seed).randrange(64, 768)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}k", "none", str(disk)]
    if subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("no right to mount a small disk")
    try:
        # Snakemake shows a traceback where it finds no room for its own files.
        process = start(disk)
        screen, _ = process.communicate(timeout=300)
        assert process.returncode
        assert "No space left on device" in screen, screen
        subprocess.run(["mount", "-o", "remount,size=64m", str(disk)], check=True)
        assert_healed(disk, undisturbed)
    finally:
        subprocess.run(["umount", str(disk)], check=True)
