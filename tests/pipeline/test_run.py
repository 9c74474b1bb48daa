"""What a person sees of a run: mistakes before it, signals while it lasts, and logs of jobs."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from runs import TINY
from vibrissa.errors import DamagedTableError, VibrissaError
from vibrissa.pipeline import jobs, ownership, places
from vibrissa.pipeline.suitable import unsuitable


@pytest.mark.slow
def test_all_mistakes_of_a_study_file_are_shown_before_any_work(fresh):
    fresh.write("tiny.yaml", TINY.replace("[1.5, 2]", "[0.5]").replace("kind: taper", "kind: pie"))
    status, screen = fresh.call("--config", "contact=tip")
    assert status == 1 and "Traceback" not in screen
    told = [line.split(": ")[0] for line in screen.splitlines()]
    assert told[-3:] == ["--config", "tiny.yaml:5", "tiny.yaml:11"]
    assert not (fresh.root / "results").exists()


@pytest.mark.nightly
@pytest.mark.slow
def test_a_run_that_is_stopped_says_so(fresh):
    """And goes on later; `python -m validation faults` stops runs at random times."""
    process = subprocess.Popen(
        [sys.executable, "-m", "vibrissa.pipeline", "--configfile", "tiny.yaml", "--cores", "1"],
        cwd=fresh.root,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    while not fresh.chunks():
        assert process.poll() is None, process.stdout.read()
        time.sleep(0.02)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        process.send_signal(number)
        time.sleep(0.1)
    screen, _ = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGINT and "Traceback" not in screen
    told = "Stopped. Finished results are kept: run the same command to resume."
    *before, kept, last = screen.splitlines()
    assert last == told
    assert kept.startswith("results/tiny has ") and kept.endswith(" of 4 tables.")
    # The jobs that were ended are no failures.
    assert not [line for line in before if "Error" in line or "rror:" in line]


def test_where_nothing_can_run_one_line_says_what_to_type(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert not unsuitable([])
    slurm = ["--workflow-profile", str(places.HOME / "workflow/profiles/slurm")]
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "no SLURM on this machine (no command sbatch)" in unsuitable(slurm)
    assert not unsuitable([*slurm, "-n"])
    Path("my.yaml").write_bytes("study: a\n".encode("utf-16"))
    assert unsuitable(["--configfile", "my.yaml"]).startswith("my.yaml:1: not a text in UTF-8")
    config = str(places.HOME / "config.yaml")
    wrong = unsuitable(["--cores", "1", "--configfile", config, "results/x.parquet", "-n"])
    assert wrong.startswith("error: there is no study file results/x.parquet. ")
    assert not unsuitable(["results/x.parquet", "--configfile", config, "-n"])
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert "--directory FOLDER" in unsuitable([])
    assert not unsuitable(["--directory", "elsewhere"])


def test_a_log_has_the_reason_and_damaged_tables_are_removed(tmp_path):
    log, table = tmp_path / "job.log", tmp_path / "chunk.parquet"
    table.write_text("damaged")
    streams = sys.stdout, sys.stderr
    for error, words in (
        (VibrissaError("no luck"), "error: no luck\n"),
        (OSError(28, "No space left on device"), "error: [Errno 28] No space left on device\n"),
        (DamagedTableError(table, "is bad"), f"again: it is made again\n{table} is removed; run"),
    ):
        with pytest.raises(SystemExit), jobs.logged(log):
            raise error
        sys.stdout, sys.stderr = streams
        assert words in log.read_text()
    assert not table.exists()
    with pytest.raises(ZeroDivisionError), jobs.logged(log):
        _ = 1 / 0
    sys.stdout, sys.stderr = streams


@pytest.mark.parametrize("log", ["/dev/full", "no folder/job.log"])
def test_the_reason_goes_to_the_screen_where_the_log_cannot_be_written(log, capfd):
    streams = sys.stdout, sys.stderr
    with pytest.raises(SystemExit), jobs.logged(log):
        raise OSError(28, "No space left on device")
    sys.stdout, sys.stderr = streams
    said, errors = capfd.readouterr()
    assert (said + errors).startswith("error: [Errno ") and "Traceback" not in said + errors


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_the_program_loads_stops_it_with_one_sentence(number, tmp_path):
    code = f"""
import os, runpy, sys
class Signalling:
    def find_spec(name, path=None, target=None):
        if name == "vibrissa.pipeline.suitable":
            os.kill(os.getpid(), {int(number)})
sys.meta_path.insert(0, Signalling)
sys.argv = ["vibrissa.pipeline", "-n"]
runpy.run_module("vibrissa.pipeline", run_name="__main__")
"""
    ended = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert ended.returncode == 130
    assert ended.stderr.splitlines()[-1].startswith("Stopped. Finished results are kept")
    assert "Traceback" not in ended.stdout + ended.stderr


def test_results_belong_to_one_study_file_and_to_one_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, copy, results = Path("first.yaml"), Path("copy.yaml"), Path("results/a")
    for path in (first, copy):
        path.write_text("study: a\n")
    ownership.check(results, first)
    ownership.claim(results, first.absolute())
    assert Path("results/a/study_file.txt").read_text() == "first.yaml\n"
    ownership.check(results, first.absolute())
    with pytest.raises(VibrissaError, match="change the value of the key 'study' in copy"):
        ownership.check(results, copy)
    for unreadable in (b"\xff", b"long" * 99):
        Path("results/a/study_file.txt").write_bytes(unreadable)
        with pytest.raises(VibrissaError, match=r"file in results/a/study_file.txt \(.*; change"):
            ownership.check(results, copy)
    Path("results/a/study_file.txt").write_text("first.yaml\n")
    first.write_text("study: b\n")
    ownership.check(results, copy)
    with pytest.raises(VibrissaError, match=r"another run of this study is active in .*/a:"):
        ownership.claim(results, copy)
    ownership._held.pop().close()
    Path("results/a/.x-1.tmp.parquet").touch()
    ownership.claim(results, copy)
    assert [path.name for path in results.iterdir()] == ["study_file.txt"]
    assert Path("results/a/study_file.txt").read_text() == "copy.yaml\n"
    ownership._held.pop().close()
    monkeypatch.setattr(ownership.fcntl, "flock", Mock(side_effect=OSError(38, "no")))
    with pytest.raises(VibrissaError, match=r"results/a cannot be locked \(.*: use another file"):
        ownership.claim(results, copy)
