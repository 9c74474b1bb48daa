"""The workflow end to end: real Snakemake runs in temporary copies of the project."""

import fcntl
import os
import re
import shutil
import subprocess
import sys
import venv
from itertools import product
from pathlib import Path

import pytest
import yaml

from vibrissa.tables import schemas, store

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
SNAKEMAKE = [sys.executable, "-m", "snakemake", "--cores", "2"]

TINY = """
study: tiny
chunk: {theta: 1}
grids:
  main: {theta: [1.5, 2], mu0: [0.3, 5], eta: [0.85], dx0: [5e-3]}
scans:
  runs: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.005], cycles: 2}
states:
  inside: {theta: 1, eta: 0.55, x1: 0.15}
figures:
  taper: {kind: taper, grid: main}
  scan: {kind: scan, scan: runs, caption: Two cycles.}
  state: {kind: state, state: inside}
  own: {kind: script, script: own.py, grid: main, formats: [], caption: "At eta = {eta}."}
"""
OWN = """
import matplotlib.pyplot as plt


def draw(table):
    figure, axes = plt.subplots()
    axes.plot(table["theta"], table["x0_slip"], "o")
    return figure
"""
STICTION = "results/tiny/tables/stiction.parquet"
CAPTIONS = "results/tiny/figures/captions.md"
# What is made anew where all tables stay.
SHOWN = {"figures": 1, "report": 1, "summary": 1}


class Copy:
    """A copy of the project with a study file, whose code is what runs."""

    def __init__(self, root):
        self.root = root

    def write(self, name, text):
        (self.root / name).write_text(text)

    def edit(self, name, old, new):
        text = (self.root / name).read_text()
        assert text.count(old) == 1
        self.write(name, text.replace(old, new))

    def call(self, *arguments, study="tiny.yaml", cwd=None, packages="src", command=SNAKEMAKE):
        environment = os.environ | {"PYTHONPATH": str(self.root / packages)}
        study = ["--configfile", study] if study else []
        command = [*command, *arguments, *study]
        return subprocess.run(
            command, cwd=cwd or self.root, env=environment, capture_output=True, text=True
        )

    def run(self, *arguments, **options):
        result = self.call(*arguments, **options)
        assert result.returncode == 0, result.stdout + result.stderr
        return result.stdout + result.stderr

    def jobs(self, *arguments, study="tiny.yaml"):
        """What a run would do: number of jobs by rule."""
        screen = self.run("-n", *arguments, study=study)
        found = {rule: int(n) for rule, n in re.findall(r"^(\w+) +(\d+)$", screen, re.M)}
        return {rule: n for rule, n in found.items() if rule not in ("all", "total")}

    def chunks(self):
        """Time of the last change of the file of each chunk, by its name."""
        found = self.root.glob("results/*/chunks/*/*.parquet")
        return {path.stem: path.stat().st_mtime_ns for path in found}

    def stiction(self, study="tiny"):
        path = self.root / f"results/{study}/tables/stiction.parquet"
        return store.read(path, schemas.STICTION)


@pytest.fixture(scope="module")
def pristine(tmp_path_factory):
    root = tmp_path_factory.mktemp("pristine") / "project"
    root.mkdir()
    for name in ("src", "workflow"):
        shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("Snakefile", "config.yaml"):
        shutil.copy(ROOT / name, root)
    (root / "profiles").symlink_to("workflow/profiles")
    copy = Copy(root)
    copy.edit("src/vibrissa/__init__.py", '__version__ = "', '__version__ = "copy of ')
    copy.write("tiny.yaml", TINY)
    copy.write("own.py", OWN)
    return copy


@pytest.fixture(scope="module")
def finished(pristine, tmp_path_factory):
    """A copy in which the tiny study was run; not to be changed, as parallel workers share it."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    copy = Copy(folder / "finished")
    with (folder / "finished.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not copy.root.exists():
            new = Copy(tmp_path_factory.mktemp("new") / "project")
            shutil.copytree(pristine.root, new.root, symlinks=True)
            new.run()
            new.root.rename(copy.root)
    return copy


@pytest.fixture
def fresh(pristine, tmp_path):
    """A copy in which nothing was run yet."""
    shutil.copytree(pristine.root, tmp_path / "project", symlinks=True)
    return Copy(tmp_path / "project")


@pytest.fixture
def done(finished, tmp_path):
    """A copy of its own for a test that goes on from the finished study."""
    shutil.copytree(finished.root, tmp_path / "project", symlinks=True)
    return Copy(tmp_path / "project")


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


def test_each_table_names_its_part_of_the_study_file_and_the_program(finished):
    for name, section in (("stiction", "grids"), ("scans", "scans"), ("states", "states")):
        told = store.metadata(finished.root / f"results/tiny/tables/{name}.parquet")
        assert yaml.safe_load(told[store.STUDY]).keys() == {"study", section}
        assert told[store.PROGRAM].startswith("copy of ")


def test_what_people_read_is_made(finished):
    results = finished.root / "results/tiny"
    for name, suffix in product(("taper", "scan", "state"), ("svg", "pdf", "png")):
        assert (results / f"figures/{name}.{suffix}").stat().st_size > 1000
    assert not (results / "figures/own.svg").exists()
    captions = (finished.root / CAPTIONS).read_text()
    assert "**Scan.** Two cycles.\n" in captions and "**Own.** At eta = 0.85.\n" in captions
    text = (results / "report.html").read_text()
    assert text.count("<img ") == 4 and "Two cycles." in text and "chunk: {theta: 1}" in text
    assert str(finished.root) not in text
    assert (results / "summary.txt").read_text().splitlines()[0] == "4 grid points: 2 lock, 2 slip"
    log = next((results / "logs/chunks/main").glob("*theta2*")).read_text()
    assert log.startswith("eta 0.85 theta 2.0: solved, residual ")


def test_a_second_run_does_nothing(done):
    assert "Nothing to be done" in done.run()


def test_without_a_study_file_it_is_the_papers_study(fresh):
    jobs = fresh.jobs(study=None)
    assert jobs["chunk"] == 2 and jobs["claims"] == jobs["figures"] == 1
    assert not (fresh.root / "results").exists()  # a plan writes nothing


# What is written in the study file, and which jobs it makes, beside those that show the tables.
CHANGES = {
    "a comment": (("study: tiny", "study: tiny # mine"), {}, {"report"}),
    "a caption": (("Two cycles.", "Cycles."), {}, {"report", "figures"}),
    "a spelling": (("[5e-3]", "[0.005]"), {}, {"report"}),
    "theta": (("[1.5, 2]", "[1.5, 2, 2.5]"), {"chunk": 1, "stiction": 1}, set(SHOWN)),
    "mu0": (("[0.3, 5]", "[0.3, 0.4, 5]"), {"chunk": 2, "stiction": 1}, set(SHOWN)),
    "cycles": (("cycles: 2", "cycles: 3"), {"scans": 1}, set(SHOWN)),
    "contact": (
        ("study: tiny", "study: tiny\ncontact: line"),
        {"chunk": 2, "stiction": 1, "scans": 1, "states": 1},
        set(SHOWN),
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_only_what_a_change_touches_is_made_anew(done, name):
    change, jobs, more = CHANGES[name]
    done.edit("tiny.yaml", *change)
    assert done.jobs() == jobs | dict.fromkeys(more, 1)


def test_a_changed_script_draws_anew_and_one_that_fails_ends_the_run_with_its_line(done):
    done.write("own.py", OWN.replace("x0_slip", "nothing"))
    assert done.jobs() == {"figures": 1, "report": 1}
    result = done.call()
    assert result.returncode != 0
    assert (
        "own.py:7: KeyError: 'nothing'" in (done.root / "results/tiny/logs/figures.log").read_text()
    )


def test_values_appended_to_an_axis_leave_the_other_chunks(done):
    before, rows = done.chunks(), done.stiction().to_pylist()
    done.edit("tiny.yaml", "[1.5, 2]", "[1.5, 2, 2.5]")
    done.run(STICTION)
    assert before.items() < done.chunks().items() and len(done.chunks()) == 3
    assert done.stiction().to_pylist()[:4] == rows


@pytest.mark.parametrize(
    ("name", "jobs"),
    [
        ("report/page.css", SHOWN),
        ("figures/style.py", SHOWN),
        (
            "sticking/cycles.py",
            SHOWN | {"chunk": 2, "stiction": 1, "scans": 1, "states": 1},
        ),
    ],
)
def test_a_change_of_the_program_makes_anew_what_it_may_change(done, name, jobs):
    path = done.root / "src/vibrissa" / name
    path.write_text(path.read_text() + "\n")
    assert done.jobs() == jobs


def test_results_from_another_machine_are_used_as_they_are(done):
    """Without Snakemake's records, and with other times."""
    shutil.rmtree(done.root / ".snakemake")
    for path in (done.root / "results").rglob("*"):
        path.touch()
    done.run("--touch")
    assert "Nothing to be done" in done.run()


def test_a_damaged_chunk_is_named_and_removed_and_the_same_command_makes_it_anew(done):
    """The chunk keeps its time, so that Snakemake does not notice until it is read again."""
    table = done.stiction()
    path = next(done.root.glob("results/tiny/chunks/main/theta2*.parquet"))
    times = path.stat()
    data = bytearray(path.read_bytes())
    data[100] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    (done.root / STICTION).unlink()
    assert done.call(STICTION).returncode != 0
    log = (done.root / "results/tiny/logs/stiction.log").read_text()
    name = path.relative_to(done.root)
    assert log.startswith(f"error: {name} cannot be read") and f"{name} is removed" in log
    done.run(STICTION)
    assert done.stiction().equals(table)


def test_a_table_of_another_study_is_never_used(done):
    """Not even where it is younger than all that it could be made of."""
    other = TINY.replace("study: tiny", "study: other").replace("[0.3, 5]", "[0.2, 5]")
    done.write("other.yaml", other)
    done.run(STICTION.replace("tiny", "other"), study="other.yaml")
    table = done.stiction()
    shutil.copy(done.root / STICTION.replace("tiny", "other"), done.root / STICTION)
    result = done.call()
    assert result.returncode != 0
    log = (done.root / "results/tiny/logs/summary.log").read_text()
    assert f"{STICTION} does not answer this study file (it has 'study: other')" in log
    done.run()
    assert done.stiction().equals(table)


def test_a_copy_of_a_study_file_does_not_write_over_the_results_of_the_first(done):
    done.write("copy.yaml", TINY.replace("[0.3, 5]", "[0.2, 5]"))
    result = done.call("-n", study="copy.yaml")
    assert result.returncode != 0
    assert "copy.yaml: study: 'tiny' is the study of tiny.yaml" in result.stderr
    assert "give the key study another value in copy.yaml" in result.stderr
    # A file that was renamed keeps its results.
    (done.root / "tiny.yaml").rename(done.root / "mine.yaml")
    assert done.jobs(study="mine.yaml") == {"report": 1}


def test_points_that_fail_are_counted_and_with_strict_end_the_run(fresh):
    fresh.edit(
        "src/vibrissa/tables/rods.py",
        "    for rod, curve in zip(rods, curves, strict=True):\n        shown",
        "    from vibrissa.sticking.curve import failed_curve\n"
        "    curves = [c if c.theta < 2 else failed_curve("
        "theta=c.theta, eta=c.eta, method=c.method, message='no luck') for c in curves]\n"
        "    for rod, curve in zip(rods, curves, strict=True):\n        shown",
    )
    fresh.run()
    summary = (fresh.root / "results/tiny/summary.txt").read_text()
    assert summary.startswith("4 grid points: 2 failed, 1 lock, 1 slip\n1 scans: 1 failed\n")
    result = fresh.call("--config", "strict=true")
    assert result.returncode != 0
    log = (fresh.root / "results/tiny/logs/summary.log").read_text()
    assert log.startswith("error: strict: 2 grid points, 1 scans have the status failed")
    assert len(fresh.stiction()) == 4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[1.5, 2]", "[0.5, 2]", "tiny.yaml:5: grids.main.theta[0]: 0.5 is not allowed"),
        ("study: tiny", "studie: tiny", "missing 'study'"),
        ("figures:", "figure:", "'figure' is not a valid key; allowed: "),
    ],
)
def test_a_mistake_stops_before_any_work(fresh, old, new, words):
    fresh.edit("tiny.yaml", old, new)
    result = fresh.call()
    assert result.returncode != 0 and "Traceback" not in result.stderr
    assert words in result.stderr
    assert not (fresh.root / "results").exists()


def test_a_job_that_fails_names_its_log(fresh):
    fresh.edit("workflow/scripts/states.py", "    states = {}", "    states = nothing_here")
    result = fresh.call("results/tiny/tables/states.parquet")
    assert result.returncode != 0 and "rule states:" in result.stderr, result.stderr
    assert "nothing_here" in (fresh.root / "results/tiny/logs/states.log").read_text()


def test_a_rod_may_lie_down_along_the_surface(fresh):
    fresh.edit("tiny.yaml", "study: tiny", "study: tiny\ncontact: line")
    fresh.edit("tiny.yaml", "[1.5, 2]", "[2, 5]")
    fresh.run(STICTION)
    slips = fresh.stiction().to_pandas().query("status == 'slip'").set_index("theta")
    assert slips["contact"].to_dict() == {2.0: "point", 5.0: "line"}
    assert slips.loc[5.0, "s_c_slip"] < 1.0 == slips.loc[2.0, "s_c_slip"]
    assert not slips["penetrates"].any()


def test_folders_may_have_spaces_and_umlauts(pristine, tmp_path):
    """With an interpreter below such a folder, as `make reproduce` has in .venv."""
    copy = Copy(tmp_path / "a b" / "ü")
    shutil.copytree(pristine.root, copy.root, symlinks=True)
    venv.create(copy.root / ".venv")
    python = copy.root / ".venv/bin/python"
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (packages,) = copy.root.glob(".venv/lib/*/site-packages")
    (packages / "all.pth").write_text("\n".join(paths))
    copy.run(CAPTIONS, command=[str(python), *SNAKEMAKE[1:]])
    assert "Two cycles." in (copy.root / CAPTIONS).read_text()


@pytest.mark.parametrize("snakefile", ["Snakefile", "workflow/Snakefile"])
def test_a_study_runs_from_another_folder(fresh, tmp_path, snakefile):
    here = tmp_path / "here"
    here.mkdir()
    study = str(fresh.root / "tiny.yaml")
    fresh.run(STICTION, "-s", str(fresh.root / snakefile), study=study, cwd=here)
    assert (here / STICTION).exists() and not (fresh.root / "results").exists()


def test_another_workflow_may_contain_this_one(fresh, tmp_path):
    """As its module; YAML 1.1, by which Snakemake reads its file, takes 5e-3 for a text."""
    here = tmp_path / "here"
    here.mkdir()
    (here / "mine.yaml").write_text("sensor:" + TINY.replace("\n", "\n  "))
    (here / "own.py").write_text(OWN)
    (here / "Snakefile").write_text(
        f"""
configfile: "mine.yaml"
module vibrissa:
    snakefile: {str(fresh.root / "Snakefile")!r}
    config: config["sensor"]
use rule * from vibrissa as sensor_*
rule mine:
    default_target: True
    input: {STICTION!r}
"""
    )
    fresh.run(study=None, cwd=here)
    assert (here / STICTION).exists()


def test_without_its_package_the_workflow_says_how_to_get_it(fresh):
    (fresh.root / "none").mkdir()
    (fresh.root / "none/vibrissa.py").write_text("raise ImportError('not here')")
    result = fresh.call("-n", packages="none")
    assert result.returncode == 1 and "Traceback" not in result.stderr
    assert "package is missing or incomplete (not here). Run make reproduce" in (
        result.stdout + result.stderr
    )
