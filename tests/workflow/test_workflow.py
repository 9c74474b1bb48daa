"""The workflow: what a finished study holds, what a change makes anew, and what is refused."""

import os
import re
import shutil
import subprocess
import sys
from itertools import product

import numpy as np
import pytest
import yaml

import vibrissa
from runs import STICTION, TINY
from vibrissa.tables import schemas, store

pytestmark = pytest.mark.slow

# What is made anew where all tables stay.
SHOWN = {"figures": 1, "report": 1, "summary": 1}
SCANNED = {"scan_chunk": 1, "scans": 1, "periods": 1}
SOLVED = SHOWN | SCANNED | {"chunk": 2, "stiction": 1, "states": 1}


def test_the_tables_hold_the_study(finished):
    rows = finished.stiction().to_pylist()
    assert [(r["grid"], r["theta"], r["mu0"], r["dx0"], r["status"]) for r in rows] == [
        ("main", theta, mu0, 0.005, status)
        for theta, (mu0, status) in product((1.5, 2), ((0.3, "slip"), (5, "lock")))
    ]
    folder = finished.root / "results/tiny/tables"
    scans = store.read(folder / "scans.parquet", schemas.SCANS).to_pylist()
    (last,) = (r["n_steps"] for r in rows if (r["theta"], r["status"]) == (2, "slip"))
    assert [r["step"] for r in scans] == [*range(last + 2), *range(1, last + 2)]
    states = store.read(folder / "states.parquet", schemas.STATES).to_pylist()
    assert [(r["state"], r["status"], r["penetrates"]) for r in states] == [
        ("inside", "solved", True)
    ]
    assert sorted(finished.chunks()) == ["theta1.5_eta0.85", "theta2_eta0.85"]
    parts = {"stiction": {"grids"}, "scans": {"scans", "with_shapes"}}
    for name, sections in (parts | {"periods": {"scans"}, "states": {"states"}}).items():
        told = store.metadata(folder / f"{name}.parquet")
        assert yaml.safe_load(told[store.STUDY]).keys() == {"study"} | sections
        assert told[store.PROGRAM] == vibrissa.__version__


def test_what_people_read_is_made(finished):
    results = finished.root / "results/tiny"
    for name, suffix in product(("taper", "scan", "state"), ("svg", "pdf", "png")):
        assert (results / f"figures/{name}.{suffix}").stat().st_size > 1000
    assert "**Scan.** Two cycles.\n" in (results / "figures/captions.md").read_text()
    text = (results / "report.html").read_text()
    assert text.count("<img ") == 3 and "Two cycles." in text and "chunk: {theta: 1}" in text
    assert str(finished.root) not in text
    counts = "4 grid points: 2 lock, 2 slip\n1 scan: 1 slip\n1 state: 1 solved\n"
    assert (results / "summary.txt").read_text() == counts
    log = next((results / "logs/chunks/main").glob("*theta2*")).read_text()
    assert log.startswith("eta 0.85 theta 2.0: solved, residual ")
    screen = (finished.root / "screen.txt").read_text()
    assert " steps (100%) done" in screen
    assert f"{counts}Report: results/tiny/report.html\n" in screen


# What is written in the study file, and which jobs it makes, beside those that show the tables.
CHANGES = {
    "a comment": ("study: tiny", "study: tiny # mine", {"report": 1}),
    "a caption": ("Two cycles.", "Cycles.", SHOWN),
    "mu0": ("[0.3, 5]", "[0.3, 0.4, 5]", SHOWN | {"chunk": 2, "stiction": 1}),
    "a larger theta": ("[1.5, 2]", "[1.5, 2, 2.5]", SHOWN | {"chunk": 1, "stiction": 1}),
    "contact": ("study: tiny", "study: tiny\ncontact: line", SOLVED),
}


@pytest.mark.parametrize("name", CHANGES)
def test_only_what_a_change_touches_is_made_anew(done, name):
    old, new, jobs = CHANGES[name]
    done.edit(old, new)
    assert done.jobs() == jobs


@pytest.mark.parametrize(
    ("name", "text", "jobs"),
    [
        ("vibrissa/figures/style.py", "\n", SHOWN),
        ("vibrissa/sticking/curve.py", "\n", SOLVED),
        # What pandas tells of itself.
        ("pandas-99.dist-info/METADATA", "Name: pandas\nVersion: 99\n", SHOWN),
    ],
)
def test_a_change_of_the_program_makes_anew_what_it_may_change(edited, name, text, jobs):
    path = edited.root / "src" / name
    path.parent.mkdir(exist_ok=True)
    with path.open("a") as file:
        file.write(text)
    assert edited.jobs() == jobs


def test_results_from_elsewhere_are_used_if_this_code_makes_them_of_this_study(edited):
    """As in a clone that got them without the folder .snakemake."""
    shutil.rmtree(edited.root / ".snakemake")
    assert edited.jobs() == {}
    edited.edit("cycles: 2", "cycles: 3")
    edited.edit("Two cycles.", "Cycles.")
    assert edited.jobs() == SHOWN | SCANNED
    # Only what is asked for is made again.
    edited.edit("step * numerator", "2 * step * numerator", "src/vibrissa/numerics/steps.py")
    assert set(edited.jobs("results/tiny/tables/states.parquet")) == {"states"}


def test_an_upgrade_is_noticed_with_records_in_a_database(edited):
    (edited.root / "src/numpy-99.dist-info").mkdir()
    edited.write("src/numpy-99.dist-info/METADATA", "Name: numpy\nVersion: 99\n")
    screen = edited.dry_run("--persistence-backend", "db")
    assert "tables/scans.parquet was made by other code: numpy " in screen
    assert f"numpy {np.__version__} (now numpy 99): it is made again" in screen
    assert edited.jobs_on(screen) == SOLVED


def test_only_the_content_of_the_code_counts(edited):
    for path in edited.root.glob("workflow/scripts/*.py"):
        path.touch()
    assert edited.jobs() == {}
    with (edited.root / "workflow/scripts/chunk.py").open("a") as file:
        file.write("\n")
    assert edited.jobs() == SOLVED


def check(folder, *arguments):
    command = [sys.executable, folder.home / "workflow/check.py", "--configfile", "tiny.yaml"]
    result = subprocess.run(
        [*command, *arguments],
        cwd=folder.root,
        env=os.environ | {"PYTHONPATH": str(folder.home / "src")},
        capture_output=True,
        text=True,
    )
    return result.returncode, result.stdout + result.stderr


def test_tables_of_other_code_are_not_certified(edited):
    shutil.rmtree(edited.root / ".snakemake")
    assert check(edited, "--bless")[0] == 0
    edited.edit("step * numerator", "2 * step * numerator", "src/vibrissa/numerics/steps.py")
    for arguments in ((), ("--bless",)):
        status, screen = check(edited, *arguments)
        assert status == 2 and "stiction.parquet was made by other code: code" in screen
        assert "run make study STUDY=tiny.yaml first" in screen


def flipped(path):
    """Flip a bit; the file keeps its time."""
    times, data = path.stat(), bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_a_damaged_table_of_a_finished_study_is_found_and_made_again(done):
    path = done.root / "results/tiny/tables/scans.parquet"
    whole = path.read_bytes()
    flipped(path)
    status, screen = check(done)
    assert status == 2 and "scans.parquet does not have its checksum; run make study" in screen
    assert "scans.parquet does not have its checksum: it is made again" in done.run(
        "results/tiny/tables/scans.parquet"
    )
    assert path.read_bytes() == whole


def test_damaged_chunks_are_named_and_made_again(done):
    """The chunks keep their times, so that Snakemake does not notice."""
    table = done.stiction()
    paths = list(done.root.glob("results/tiny/chunks/main/*.parquet"))
    for path in paths:
        flipped(path)
    (done.root / STICTION).unlink()
    screen = done.run(STICTION)
    for path in paths:
        # The bit may be in the data, or in what describes them.
        why = r"(does not have its checksum|cannot be read \(.*\)): it is made again"
        assert re.search(f"{re.escape(str(path.relative_to(done.root)))} {why}", screen)
    assert done.stiction().equals(table)


def test_a_copy_of_a_study_file_does_not_write_over_the_results_of_the_first(done):
    done.write("copy.yaml", TINY.replace("[0.3, 5]", "[0.2, 5]"))
    status, screen = done.dry_call(study="copy.yaml")
    assert status != 0
    assert "copy.yaml: study: 'tiny' is used by tiny.yaml" in screen
    assert "change the value of the key 'study' in copy.yaml" in screen
    status, screen = done.dry_call(study="copy.yaml tiny.yaml")
    assert status == 1 and "with --configfile, not copy.yaml and tiny.yaml" in screen
