"""Runs as they are rarer: other folders, other workflows, terminals, tables of other studies."""

import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import time
import venv
import zipfile
from pathlib import Path

import pytest

from runs import ROOT, STICTION, TINY
from vibrissa.archive.crate import write_archive
from vibrissa.study.reading import read_study

SNAKEMAKE = ["-m", "snakemake", "--cores", "2"]
CAPTIONS, SUMMARY = "results/tiny/figures/captions.md", "results/tiny/summary.txt"
LONG = TINY.replace("theta: [1.5, 2]", "theta: {start: 1, stop: 4, step: 0.5}")


def snakemake(cwd, *arguments, python=sys.executable, packages=ROOT / "src"):
    environment = os.environ | {"PYTHONPATH": str(packages)}
    command = [python, *SNAKEMAKE, *arguments]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


def test_folders_may_have_spaces_and_umlauts(copied, tmp_path):
    """With an interpreter below such a folder, as `make reproduce` has in .venv."""
    root = tmp_path / "a b" / "ü"
    shutil.copytree(copied.root, root)
    venv.create(root / ".venv")
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (packages,) = root.glob(".venv/lib/*/site-packages")
    (packages / "all.pth").write_text("\n".join(paths))
    captions = "results/tiny/figures/captions.md"
    options = {"python": root / ".venv/bin/python", "packages": root / "src"}
    result = snakemake(root, captions, "--configfile", "tiny.yaml", **options)
    assert result.returncode == 0, result.stderr
    assert "Two cycles." in (root / captions).read_text()


@pytest.mark.parametrize("snakefile", ["Snakefile", "workflow/Snakefile"])
def test_a_study_runs_from_another_folder(fresh, tmp_path, snakefile):
    here = tmp_path / "here"
    here.mkdir()
    study = str(fresh.root / "tiny.yaml")
    result = snakemake(here, STICTION, "-s", str(ROOT / snakefile), "--configfile", study)
    assert result.returncode == 0, result.stderr
    assert (here / STICTION).exists() and not (fresh.root / "results").exists()


def test_another_workflow_may_contain_this_one(tmp_path):
    """As its module; YAML 1.1, by which Snakemake reads its file, takes 5e-3 for a text."""
    study = "sensor:" + TINY.replace("\n", "\n  ")
    (tmp_path / "mine.yaml").write_text(f"study: whole project\n{study}")
    (tmp_path / "Snakefile").write_text(
        f"""
configfile: "mine.yaml"
module vibrissa:
    snakefile: {str(ROOT / "Snakefile")!r}
    config: config["sensor"]
use rule * from vibrissa as sensor_*
rule mine:
    default_target: True
    input: {STICTION!r}
"""
    )
    result = snakemake(tmp_path)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / STICTION).exists()


def test_a_module_may_have_a_prefix(tmp_path):
    """And figures by scripts, and the check of tables that Snakemake has no record of."""
    own = "  own: {kind: script, script: own.py, grid: main, formats: []}\n"
    study = TINY.replace("figures:\n", f"figures:\n{own}")
    study = study.replace("scans:\n", "  more: {points: mine.csv, dx0: 0.005}\nscans:\n")
    study = "sensor:" + study.replace("\n", "\n  ")
    (tmp_path / "mine.csv").write_text("theta,mu0,eta\n1.5,0.3,0.85\n")
    (tmp_path / "mine.yaml").write_text(study)
    (tmp_path / "own.py").write_text(SCRIPT)
    (tmp_path / "Snakefile").write_text(
        f"""
configfile: "mine.yaml"
module vibrissa:
    snakefile: {str(ROOT / "Snakefile")!r}
    config: config["sensor"]
    prefix: "sub"
use rule * from vibrissa as sensor_*
rule mine:
    default_target: True
    input: "sub/results/tiny/figures/own.png", "sub/results/tiny/tables/states.parquet"
"""
    )
    result = snakemake(tmp_path)
    assert result.returncode == 0, result.stderr
    assert not (tmp_path / "results").exists()
    shutil.rmtree(tmp_path / ".snakemake")
    assert "Nothing to be done" in snakemake(tmp_path, "-n").stdout
    (tmp_path / "mine.yaml").write_text(study.replace("x1: 0.15", "x1: 0.16"))
    screen = snakemake(tmp_path, "-n").stdout
    jobs = dict(re.findall(r"^sensor_(\w+) +(\d+)$", screen, re.M))
    assert jobs == {"states": "1", "figure_own": "1"}


def test_without_its_package_the_workflow_says_how_to_get_it(copied):
    (copied.root / "none").mkdir()
    (copied.root / "none/vibrissa.py").write_text("raise ImportError('not here')")
    result = snakemake(copied.root, "-n", packages=copied.root / "none")
    screen = result.stdout + result.stderr
    assert result.returncode == 1 and "Traceback" not in screen
    assert "package is missing or incomplete (not here). Run make reproduce" in screen


def test_without_a_study_file_it_is_the_papers_study(tmp_path):
    command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "2", "-n"]
    screen = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
    assert "claims" in screen.stdout and not (tmp_path / "results").exists()


def test_a_table_of_another_study_is_never_used(done):
    """Not even where it is younger than all that it could be made of."""
    other = TINY.replace("study: tiny", "study: other").replace("[0.3, 5]", "[0.2, 5]")
    done.write("other.yaml", other)
    done.run(STICTION.replace("tiny", "other"), study="other.yaml")
    table = done.stiction()
    shutil.copy(done.root / STICTION.replace("tiny", "other"), done.root / STICTION)
    done.run()
    assert done.stiction().equals(table)


def test_a_study_file_that_was_renamed_keeps_its_results(done):
    (done.root / "tiny.yaml").rename(done.root / "mine.yaml")
    assert done.jobs(study="mine.yaml") == {"report": 1}


def test_another_run_in_the_same_folder_is_refused_and_a_killed_one_goes_on(fresh):
    fresh.write("tiny.yaml", LONG)
    command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "2"]
    process = subprocess.Popen(
        [*command, "--configfile", "tiny.yaml"], cwd=fresh.root, stderr=subprocess.DEVNULL
    )
    while not fresh.chunks():
        assert process.poll() is None
        time.sleep(0.02)
    status, screen = fresh.call()
    assert status == 1 and "another run of this study is active in " in screen
    # The process and the Snakemake that it started, which holds the lock otherwise.
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.kill()
    for child in map(int, children):
        os.killpg(child, signal.SIGKILL)
    process.communicate()
    screen = fresh.run()
    assert "14 grid points: 7 lock, 7 slip" in screen


def test_a_terminal_shows_progress(fresh):
    master, slave = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "80"}
    command = [sys.executable, "-m", "vibrissa.pipeline", "results/tiny/summary.txt"]
    command += ["--cores", "2", "--logger", "rich"]
    process = subprocess.Popen(
        [*command, "--configfile", "tiny.yaml"],
        cwd=fresh.root,
        stdout=slave,
        stderr=slave,
        env=environment,
    )
    os.close(slave)
    screen = b""
    while True:
        try:
            screen += os.read(master, 4096)
        except OSError:  # the other side is closed
            break
    assert process.wait() == 0
    assert b"100%" in screen and b"1 scan: 1 slip" in screen


def test_an_archive_makes_its_results_again(unpacked):
    def verified():
        command = [sys.executable, "workflow/verify.py"]
        result = subprocess.run(command, cwd=unpacked, capture_output=True, text=True)
        return result.returncode, result.stdout + result.stderr

    status, screen = verified()
    assert status == 0 and "Unchanged: all 9 rows" in screen, screen
    # Without its results there is nothing to compare.
    (unpacked / STICTION).unlink()
    status, screen = verified()
    assert status == 2 and "has no file tables/stiction.parquet" in screen


def test_files_of_points_and_profiles_are_part_of_the_study(fresh, tmp_path):
    """They are archived; an edit is noticed, a remark is not; tables are compared and repeated."""
    grid, scan = "  more: {points: mine.csv, dx0: 0.005}\n", "  rough: {theta: 2, eta: 0.85, "
    scan += "dx0: 0.005, surface: measured, law: energy, kinetic_ratio: 0.7, cycles: 2}\n"
    fresh.edit("states:\n", f"{scan}surfaces: {{measured: {{profile: friction.csv}}}}\nstates:\n")
    fresh.edit("scans:\n", f"{grid}scans:\n")
    fresh.write("mine.csv", "theta,mu0,eta\n2,0.3,0.85\n1.7,0.2,0.8\n")
    fresh.write("friction.csv", "x,mu0\n0,0.2\n1,0.3\n")
    fresh.run()
    for arguments, verdict in ((["--bless"], "is written"), ([], "Unchanged: all ")):
        command = [sys.executable, ROOT / "workflow/check.py", "--configfile", "tiny.yaml"]
        result = subprocess.run(
            [*command, *arguments], cwd=fresh.root, capture_output=True, text=True
        )
        assert result.returncode == 0 and verdict in result.stdout, result.stdout + result.stderr
    study = read_study(fresh.root / "tiny.yaml")
    assert study.data_files == ["friction.csv", "mine.csv"]
    results, packed = fresh.root / "results/tiny", tmp_path / "tiny.zip"
    source = fresh.root / "tiny.yaml"
    write_archive(ROOT, results, study.results, source, "0" * 40, packed, study.data_files)
    zipfile.ZipFile(packed).extractall(tmp_path / "unpacked")
    command = [sys.executable, "workflow/verify.py"]
    result = subprocess.run(command, cwd=tmp_path / "unpacked", capture_output=True, text=True)
    assert result.returncode == 0 and "Unchanged: " in result.stdout, result.stdout + result.stderr
    shutil.rmtree(fresh.root / ".snakemake")
    shown = {"figures": 1, "report": 1, "summary": 1}
    fresh.edit("1.7,0.2,0.8", "# a remark\n1.7,0.20,.8", "mine.csv")
    assert fresh.jobs() == {}
    fresh.edit("0.20,.8", "0.21,.8", "mine.csv")
    assert fresh.jobs() == shown | {"chunk": 1, "stiction": 1}
    fresh.edit("1,0.3", "1,0.4", "friction.csv")
    scans = {"scan_chunk": 1, "scans": 1, "periods": 1}
    assert fresh.jobs() == shown | scans | {"chunk": 1, "stiction": 1}


def test_a_study_may_have_scans_alone(fresh):
    scan = "{theta: [1, 2], mu0: 0.3, eta: 0.85, dx0: 0.01, cycles: 2}"
    figure = "figures: {load: {kind: sawtooth, scan: runs, theta: 2}}"
    fresh.write("scans.yaml", f"study: alone\nscans: {{runs: {scan}}}\n{figure}\n")
    assert "2 scans: 2 slip" in fresh.run(study="scans.yaml")
    assert fresh.jobs(study="scans.yaml") == {}
    tables = fresh.root / "results/alone/tables"
    assert {path.stem for path in tables.glob("*.parquet")} == {"scans", "periods"}
    for arguments, verdict in ((["--bless"], "is written"), ([], "Unchanged: all 8 rows")):
        command = [sys.executable, ROOT / "workflow/check.py", "--configfile", "scans.yaml"]
        result = subprocess.run(
            [*command, *arguments], cwd=fresh.root, capture_output=True, text=True
        )
        assert result.returncode == 0 and verdict in result.stdout, result.stdout + result.stderr


SCRIPT = """
import matplotlib.pyplot as plt


def draw(table):
    figure, axes = plt.subplots()
    axes.plot(table["theta"], table["x0_slip"], "o")
    return figure
"""


def test_a_script_of_the_user_is_an_input_of_its_figure(done):
    own = "  own: {kind: script, script: own.py, grid: main, formats: [], caption: 'At {eta}.'}\n"
    done.write("own.py", SCRIPT)
    done.edit("figures:\n", "figures:\n" + own)
    done.run(CAPTIONS, "results/tiny/figures/own.png")
    folder = done.root / "results/tiny/figures"
    assert (folder / "own.png").exists() and not (folder / "own.svg").exists()
    assert "**Own.** At 0.85.\n" in (folder / "captions.md").read_text()
    done.write("own.py", SCRIPT.replace("x0_slip", "nothing"))
    assert done.jobs() == {"figure_own": 1, "report": 1, "summary": 1}
    others = {path.name: path.stat().st_mtime_ns for path in folder.glob("t*.*")}
    # A failure stays one, takes no other figure with it, and is shown in a new report.
    for _ in range(2):
        status, screen = done.call()
        assert status != 0 and "figure own could not be drawn: own.py:7: KeyError" in screen
    assert {path.name: path.stat().st_mtime_ns for path in folder.glob("t*.*")} == others != {}
    assert not (done.root / SUMMARY).exists()
    done.write("own.py", SCRIPT)
    done.run()
    assert (done.root / SUMMARY).exists() and not list(folder.glob("*.txt"))
    # Also where Snakemake has no record, and the script is older than its figure.
    shutil.rmtree(done.root / ".snakemake")
    assert done.jobs() == {}
    done.write("own.py", f"{SCRIPT}# edited\n")
    os.utime(done.root / "own.py", (0, 0))
    assert done.jobs() == {"figure_own": 1, "report": 1, "summary": 1}


def test_points_that_fail_are_counted_and_with_strict_end_the_run(copied):
    copied.edit(
        "    for rod, curve in zip(rods, curves, strict=True):\n        shown",
        "    from vibrissa.sticking.curve import failed_curve\n"
        "    curves = [c if c.theta < 2 else failed_curve("
        "theta=c.theta, eta=c.eta, method=c.method, message='no luck') for c in curves]\n"
        "    for rod, curve in zip(rods, curves, strict=True):\n        shown",
        "src/vibrissa/computing/rods.py",
    )
    for arguments in ((), ("--keep-incomplete",)):
        status, _ = copied.call(SUMMARY, "--config", "strict=true", *arguments)
        assert status == 1 and not (copied.root / SUMMARY).exists()
    assert copied.log("summary").startswith(
        "error: the study has strict: true, but 2 grid points, 1 scan have the status 'failed'"
    )
    assert len(copied.stiction()) == 4
    copied.run(SUMMARY)
    summary = (copied.root / SUMMARY).read_text()
    assert summary.startswith("4 grid points: 2 failed, 1 lock, 1 slip\n1 scan: 1 failed\n")
