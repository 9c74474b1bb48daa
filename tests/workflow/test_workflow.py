"""The workflow end to end: real Snakemake runs in temporary copies of the project."""

import compileall
import fcntl
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import venv
from itertools import product
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from vibrissa import solve_curve
from vibrissa.figures import style
from vibrissa.figures.draw import draw
from vibrissa.study.parsing import parse_study
from vibrissa.tables import added, schemas, store
from vibrissa.tables.completeness import checked_points
from vibrissa.tables.parquet import digests

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
# In the order of the rule: what is saved first fixes the layout for all.
ENDINGS = ("svg", "pdf", "png")
SNAKEMAKE = [
    *(sys.executable, "-m", "snakemake", "--cores", "2", "--scheduler", "greedy"),
    *("--workflow-profile", "workflow/profiles/default"),
]
RUN = [sys.executable, "workflow/run.py", "--cores", "2"]

TINY = """
study: tiny
block_size: 1
grids:
  main: {theta: [1.5, 2], mu0: [0.3, 5], eta: [0.85], dx0: [0.005]}
scans:
  runs: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.005], cycles: 2}
states:
  inside: {theta: 1, eta: 0.55, x1: 0.15}
figures:
  taper: {kind: taper, grid: main}
  friction: {kind: friction, grid: main, theta: 2}
  scan: {kind: scan, scan: runs, theta: 2, mu0: 0.3, caption: Two cycles.}
  period: {kind: period, scan: runs, theta: 2, mu0: 0.3}
  state: {kind: state, state: inside}
"""
TABLES = [f"results/tiny/tables/{name}.parquet" for name in ("stiction", "scans", "states")]
STICTION = TABLES[0]
LONGER_THETA = ("[1.5, 2]", "[1.5, 1.75, 2]")
LONGER_MU0 = ("[0.3, 5]", "[0.2, 0.3, 0.4, 5]")


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

    def call(self, command, *arguments, study="tiny.yaml", cwd=None, packages="src"):
        environment = os.environ | {"PYTHONPATH": str(self.root / packages)}
        study = ["--configfile", study] if study else []
        command = [*command, *arguments, *study]
        return subprocess.run(
            command, cwd=cwd or self.root, env=environment, capture_output=True, text=True
        )

    def run(self, *arguments, study="tiny.yaml", command=RUN):
        """As users run it; with Snakemake alone each job starts a Python of its own."""
        result = self.call(command, *arguments, study=study)
        assert result.returncode == 0, result.stderr
        return result

    def jobs(self, *arguments, study="tiny.yaml"):
        """What a run would do: number of jobs by rule."""
        report = self.run("-n", *arguments, study=study, command=SNAKEMAKE)
        return {
            rule: int(count)
            for rule, count in re.findall(r"^(\w+) +(\d+)$", report.stdout + report.stderr, re.M)
            if rule not in ("all", "total")
        }

    def path(self, pattern):
        (found,) = self.root.glob(pattern)
        return found

    def blocks(self, kind):
        """Time of the last change of each block file by its name."""
        found = self.root.glob(f"results/*/blocks/*/*.{kind}.parquet")
        return {path.name: path.stat().st_mtime_ns for path in found}

    def stiction(self, study="tiny"):
        return store.read(self.root / f"results/{study}/tables/stiction.parquet", schemas.STICTION)


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
    compileall.compile_dir(root, quiet=1)  # once, and not by each process of each copy
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
            shutil.copytree(pristine.root, new.root)
            new.run()
            new.root.rename(copy.root)
    return copy


@pytest.fixture
def fresh(pristine, tmp_path):
    """A copy in which nothing was run yet."""
    shutil.copytree(pristine.root, tmp_path / "project")
    return Copy(tmp_path / "project")


@pytest.fixture
def done(finished, tmp_path):
    """A copy of its own for a test that goes on from the finished study."""
    shutil.copytree(finished.root, tmp_path / "project")
    return Copy(tmp_path / "project")


def parsed(text):
    return parse_study(yaml.safe_load(text))


def test_the_tables_hold_the_study(finished):
    table = finished.stiction()
    list(checked_points([table], parsed(TINY).point_grids))
    rows = table.to_pylist()
    assert [(r["theta"], r["mu0"], r["status"]) for r in rows] == [
        (theta, mu0, status)
        for theta, (mu0, status) in product((1.5, 2), ((0.3, "slip"), (5, "lock")))
    ]
    folder = finished.root / "results/tiny/tables"
    scans = store.read(folder / "scans.parquet", schemas.SCANS).to_pylist()
    (last,) = (r["n_steps"] for r in rows if (r["theta"], r["status"]) == (2, "slip"))
    assert [r["status"] for r in scans] == ["slip"] * (2 * (last + 1) + 1)
    assert [r["step"] for r in scans] == [*range(last + 2), *range(1, last + 2)]
    states = store.read(folder / "states.parquet", schemas.STATES).to_pylist()
    assert [(r["state"], r["status"], r["penetrates"]) for r in states] == [
        ("inside", "solved", True)
    ]


REFINED = """
study: tiny
block_size: 1
grids:
  main:
    theta: [1.5, 2]
    mu0: [0.3, 0.4, 0.6]
    eta: [0.85]
    dx0: [0.005]
    refine: {tolerance: 0.01, closest: {mu0: 0.02}}
figures:
  friction: {kind: friction, grid: main, theta: 2}
"""


def test_added_points_do_not_depend_on_blocks_and_no_curve_is_solved_for_them(fresh):
    fresh.write("tiny.yaml", REFINED)
    fresh.run(STICTION)
    study, alone = parsed(REFINED), fresh.stiction()
    list(checked_points([alone], study.point_grids, study.refinements.keys()))
    assert 0 < alone["added_to"].null_count < len(alone)
    (_, log) = sorted(fresh.root.glob("results/tiny/logs/points/*.log"))
    assert "of mu0 added to main; 1 change of kind closed in" in log.read_text()

    path = max(fresh.root.glob("results/tiny/blocks/*/*.points.parquet"))
    block = store.read(path, schemas.STICTION)
    told = schemas.STICTION.metadata | {added.ACCOUNT: block.schema.metadata[added.ACCOUNT]}
    (*_, last) = np.flatnonzero(block["added_to"].is_valid())
    less = block.take([i for i in range(len(block)) if i != last])
    store.write(less.replace_schema_metadata(told), path)
    screen = fresh.run(STICTION).stderr
    assert fresh.stiction().equals(alone)
    count = len(alone) - alone["added_to"].null_count
    assert f"refine added {count} points (for each line: results/tiny/logs/points)" in screen

    fresh.edit("tiny.yaml", "tolerance: 0.01", "tolerance: 0.001")
    assert fresh.jobs(STICTION) == {"points": 2, "stiction": 1}

    together = REFINED.replace("study: tiny", "study: together").replace("size: 1", "size: 2")
    fresh.write("together.yaml", together)
    fresh.run(STICTION.replace("tiny", "together"), study="together.yaml")
    other = fresh.stiction("together")
    for name in ("theta", "mu0", "grids", "added_to", "status", "n_steps"):
        assert other[name].equals(alone[name])


WITH_CURVES = """
study: tiny
block_size: 1
grids:
  main:
    theta: [1, 3]
    mu0: [0.3, 0.45]
    eta: [0.8, 0.9]
    dx0: [0.005]
    refine: {tolerance: 0.003, closest: {theta: 0.2, eta: 0.02, mu0: 0.05}}
"""


def test_added_curves_do_not_depend_on_blocks(fresh):
    """Each gap is looked at by one job, wherever its ends were solved."""
    fresh.write("tiny.yaml", WITH_CURVES)
    fresh.run(STICTION)
    study, apart = parsed(WITH_CURVES), fresh.stiction()
    list(checked_points([apart], study.point_grids, study.refinements.keys()))
    thetas, etas = (set(apart[name].to_pylist()) for name in ("theta", "eta"))
    assert len(thetas) > 2 and len(etas) > 2
    together = WITH_CURVES.replace("study: tiny", "study: together").replace("size: 1", "size: 4")
    fresh.write("together.yaml", together)
    screen = fresh.run(STICTION.replace("tiny", "together"), study="together.yaml").stderr
    logs = [path.read_text() for path in fresh.root.glob("results/together/logs/points/*.log")]
    left = re.findall(r"of mu0 added to main;.* not within the tolerance at closest", "".join(logs))
    assert len(left) > 1 and f" of mu0 on {len(left)} lines of main (for each line: " in screen
    one = fresh.stiction("together")
    for name in ("theta", "eta", "mu0", "grids", "added_to", "status", "n_steps"):
        assert one[name].equals(apart[name]), name


@pytest.mark.parametrize(("study", "groups"), [(REFINED, 2), (WITH_CURVES, 0)])
def test_blocks_are_jobs_of_a_cluster_each_by_itself(pristine, tmp_path, study, groups):
    """None at all where points of a block need curves of others: they would be one job."""
    (tmp_path / "tiny.yaml").write_text(study)
    said = pristine.call([*SNAKEMAKE, "-n", "-s", pristine.root / "Snakefile"], cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    assert said.stdout.count("Group job block") == groups, said.stderr


def test_only_the_given_study_is_run_and_written_down(finished):
    assert [path.name for path in (finished.root / "results").iterdir()] == ["tiny"]
    for name in ("stiction", "scans", "states"):
        path = finished.root / f"results/tiny/tables/{name}.parquet"
        metadata = store.read(path, schemas.TABLES[name]).schema.metadata
        section = {"stiction": "grids"}.get(name, name)
        answered = yaml.safe_load(metadata[b"vibrissa.study"])
        whole = yaml.safe_load(TINY)
        assert answered == {key: whole[key] for key in answered}
        assert {"study", section} <= answered.keys() <= {"study", "contact", "method", section}
        assert metadata[b"vibrissa.version"].startswith(b"copy of ")


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("taper", "stiction"),
        ("friction", "stiction"),
        ("scan", "scans"),
        ("period", "scans"),
        ("state", "states"),
    ],
)
def test_the_figures_are_drawn_from_the_tables_alone(finished, tmp_path, name, table):
    results = finished.root / "results/tiny"
    rows = store.read(results / f"tables/{table}.parquet", schemas.TABLES[table])
    selection = yaml.safe_load(TINY)["figures"][name]
    kind = selection.pop("kind")
    selection.pop("caption", "")
    paths = [tmp_path / f"{name}.{ending}" for ending in ENDINGS]
    style.save(draw(kind, rows, selection), paths)
    for path in paths:
        assert path.read_bytes() == (results / "figures" / path.name).read_bytes()


def test_the_captions_are_written(finished):
    text = finished.path("results/tiny/figures/captions.md").read_text()
    assert "**scan.** Two cycles.\n" in text
    assert text.count("**") == 10


def test_the_report_has_what_was_found_and_what_was_run(finished):
    text = finished.path("results/tiny/report.html").read_text()
    assert text.count("<img ") == 5 and "Two cycles." in text
    assert "block_size: 1" in text and "tiny.yaml" in text
    assert str(finished.root) not in text
    (curves,) = re.findall(r"<td>curves</td><td>(\d+)</td>", text)
    assert int(curves) == 2


@pytest.mark.parametrize("name", ["explorer/view/stage.js", "report/page.css", "report/page.html"])
def test_editing_the_page_redraws_the_page_alone(done, name):
    path = done.root / "src/vibrissa" / name
    path.write_text(path.read_text() + "\n")
    assert done.jobs() == REPORT


def test_a_comment_in_the_study_file_redraws_the_page_that_shows_it(done):
    done.write("tiny.yaml", f"# A comment\n{TINY}")
    assert done.jobs() == REPORT
    done.run()
    assert "# A comment" in done.path("results/tiny/report.html").read_text()


def test_the_page_says_what_the_command_line_changed(fresh):
    text = "study: one\ngrids: {g: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.005]}}\n"
    fresh.write("one.yaml", text)
    fresh.run("--config", "contact=line", study="one.yaml")
    page = fresh.path("results/one/report.html").read_text()
    assert "changes on the command line" in page and "contact: line" in page
    assert '"contact":"line"' in page  # in what the explorer is to solve
    for nothing in ("<img ", "<canvas", 'id="claims"'):
        assert nothing not in page


def test_the_logs_say_what_was_computed(finished):
    log = finished.path("results/tiny/logs/stiction.log").read_text()
    assert log == "2 lock, 2 slip\n"
    curves = [p.read_text() for p in finished.root.glob("results/tiny/logs/curves/*.log")]
    assert sorted(text.split()[:3] for text in curves) == [
        ["1.5", "0.85", "solved"],
        ["2", "0.85", "solved"],
    ]


def test_a_second_run_does_nothing(done):
    assert "Nothing to be done" in done.run(command=SNAKEMAKE).stderr


def test_without_a_study_file_it_is_the_papers_study(fresh):
    jobs = fresh.jobs(study=None)
    paper = yaml.safe_load((ROOT / "config.yaml").read_text())
    assert jobs["figure"] == len(paper["figures"])
    assert jobs["claims"] == 1
    captions = f"results/{paper['study']}/figures/captions.md"
    fresh.run(captions, study=None)
    assert [path.name for path in (fresh.root / "results").iterdir()] == [paper["study"]]


def test_a_longer_theta_axis_computes_only_what_is_new(done):
    before = {kind: done.blocks(kind) for kind in ("curves", "points")}
    rows = done.stiction().to_pylist()
    done.edit("tiny.yaml", *LONGER_THETA)
    done.run(STICTION)
    for kind, blocks in before.items():
        after = done.blocks(kind)
        assert len(blocks) == 2 and len(after) == 3
        assert blocks.items() <= after.items()
    longer = done.stiction().to_pylist()
    assert sorted({r["theta"] for r in longer}) == [1.5, 1.75, 2]
    assert len(longer) == 6
    assert [row for row in longer if row["theta"] in (1.5, 2)] == rows


def test_a_longer_friction_axis_solves_nothing(done):
    before = done.blocks("curves")
    done.edit("tiny.yaml", *LONGER_MU0)
    assert done.jobs(STICTION) == {"points": 2, "stiction": 1}
    done.run(STICTION)
    assert done.blocks("curves") == before
    assert [r["mu0"] for r in done.stiction().to_pylist()] == 2 * [0.2, 0.3, 0.4, 5]


def test_results_that_were_made_elsewhere_are_not_taken_for_those_of_another_study_file(done):
    shutil.rmtree(done.root / ".snakemake")
    curves, points = done.blocks("curves"), done.blocks("points")
    done.edit("tiny.yaml", *LONGER_MU0)
    screen = done.run(STICTION).stderr
    assert "was made: all but the curves is made anew, to be of the study file as it is" in screen
    assert done.stiction()["mu0"].to_pylist() == [0.2, 0.3, 0.4, 5] * 2
    assert done.blocks("curves") == curves and not points.items() & done.blocks("points").items()
    # Of the scans there is no record yet, and there is once all was made.
    assert "Nothing here says how results/tiny/tables/sca" in done.run(STICTION).stderr
    done.run()
    assert "Nothing here says" not in done.run(STICTION).stderr


def test_results_that_were_made_elsewhere_are_used_as_the_documentation_says(done):
    shutil.rmtree(done.root / ".snakemake")
    # The clone is younger: without --touch all would be solved anew.
    for path in done.root.glob("results/**/*"):
        os.utime(path, (0, 0))
    done.run("--touch", command=SNAKEMAKE)
    assert done.jobs() == {}
    assert "Nothing here says" not in done.run("-n").stderr
    done.edit("tiny.yaml", *LONGER_MU0)
    assert done.jobs(STICTION) == {"points": 2, "stiction": 1}


ALL_FIGURES = {"figure": 5}
COLLECTED = {"stiction": 1, "scans": 1}
REPORT = {"report": 1}
SOLVED = {"curves": 2, "points": 2, "scan": 1, "states": 1}
EVERYTHING = SOLVED | COLLECTED | ALL_FIGURES | REPORT


@pytest.mark.parametrize(
    ("module", "jobs"),
    [
        ("mechanics/equations", EVERYTHING),
        ("sticking/stiction", {"points": 2, "stiction": 1, "states": 1, "figure": 3} | REPORT),
        ("sticking/cycles", {"scan": 1, "scans": 1, "figure": 2} | REPORT),
        ("figures/draw", ALL_FIGURES | REPORT),
        ("sticking/solving/shooting", {"states": 1, "figure": 1} | REPORT),
        ("report/motion", REPORT),
        ("study/model", {}),
    ],
)
def test_editing_a_module_reruns_what_depends_on_it(done, module, jobs):
    with (done.root / f"src/vibrissa/{module}.py").open("a") as file:
        file.write("# edited\n")
    assert done.jobs() == jobs


TOO_SMALL = (
    *("theta: [1.5, 2]", "theta: [0.5, 2]"),
    "grids.main.theta[0]: 0.5 is not allowed; allowed:",
)


@pytest.mark.parametrize(
    ("command", "old", "new", "message"),
    [
        (SNAKEMAKE, *TOO_SMALL),
        (RUN, *TOO_SMALL),
        (
            RUN,
            "theta: [1.5, 2]",
            "theta: [1], theta: [2]",
            "'theta' stands twice, in lines 5 and 5",
        ),
        (
            RUN,
            "grid: main}",
            "grid: other}",
            "figures.taper.grid: 'other' is not the name of a grid",
        ),
    ],
)
def test_a_bad_study_stops_with_one_message(fresh, command, old, new, message):
    fresh.edit("tiny.yaml", old, new)
    result = fresh.call(command)
    assert result.returncode != 0
    assert result.stderr.count(message) == 1
    assert "Traceback" not in result.stderr
    assert not (fresh.root / "results").exists()
    if command is RUN:
        assert message in result.stderr.splitlines()[-1]


def test_both_methods_find_the_same(done):
    old = "theta: [1.5, 2], mu0: [0.3, 5], eta: [0.85]"
    done.edit("tiny.yaml", old, "theta: [2], mu0: [0.1], eta: [0.98]")
    done.run(STICTION, "--config", "method=shooting")
    (shooting,) = done.stiction().to_pylist()
    assert shooting["x0_slip"] == pytest.approx(float(solve_curve(2, 0.98).onset(0.1)), abs=1e-8)
    assert {p.parent.name for p in done.root.glob("results/tiny/blocks/*/*.curves.parquet")} == {
        "point-collocation",
        "point-shooting",
    }


def test_a_study_goes_on_where_a_curve_cannot_be_solved(fresh):
    """Rods that are 1000 times thicker at their base, at the bottom of their reach."""
    text = TINY.replace("[1.5, 2]", "[1000, 2000]").replace("[0.85]", "[0.01]")
    fresh.write("tiny.yaml", re.sub(r"theta: (\[?)2\b", r"theta: \g<1>1000", text))
    result = fresh.call(RUN)
    assert result.returncode == 0, result.stderr
    assert {row["status"] for row in fresh.stiction().to_pylist()} == {"failed"}
    log = fresh.path("results/tiny/logs/stiction.log").read_text()
    assert log == "4 failed\n"
    assert "1000 0.01 failed" in "".join(
        path.read_text() for path in fresh.root.glob("results/tiny/logs/curves/*.log")
    )
    assert len(list(fresh.root.glob("results/tiny/figures/*.svg"))) == 5


@pytest.mark.parametrize(("kind", "rule"), [("points", "stiction"), ("curves", "points")])
def test_a_damaged_block_is_named_last_and_running_again_repairs_the_study(done, kind, rule):
    """The block keeps its time, so that Snakemake does not notice until it is read again."""
    path = sorted(done.root.glob(f"results/tiny/blocks/*/*.{kind}.parquet"))[0]
    times = path.stat()
    data = bytearray(path.read_bytes())
    data[100] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    (done.root / STICTION).unlink()
    if rule == "points":
        for made in done.blocks("points"):
            done.path(f"results/*/blocks/*/{made}").unlink()

    result = done.call(SNAKEMAKE, STICTION)
    name = str(path.relative_to(done.root))
    assert result.returncode != 0
    assert f"rule {rule}:" in result.stderr
    logs = "".join(path.read_text() for path in done.root.glob(f"results/tiny/logs/{rule}*/*.log"))
    logs += "".join(path.read_text() for path in done.root.glob(f"results/tiny/logs/{rule}.log"))
    (reason,) = [line for line in logs.splitlines() if line.startswith("error: ")]
    assert reason.startswith(f"error: {name} cannot be read")
    assert reason.endswith("delete it and run again, it is made anew")

    result = done.call(RUN, STICTION)
    assert result.returncode == 0, result.stderr
    assert result.stderr.count(f"{name} is damaged or does not belong there: removed") == 1
    list(checked_points([done.stiction()], parsed(TINY).point_grids))
    store.check_file(path)


def test_of_a_cluster_job_the_rule_that_failed_and_its_reason_are_named_last(fresh):
    """With a scheduler that runs each job at once."""
    fresh.edit("workflow/scripts/points.py", "    grids = {", "    grids = nothing_here or {")
    cluster = ("--executor", "cluster-generic", "--cluster-generic-submit-cmd", "sh", "--jobs", "1")
    groups = ("--groups", "curves=block", "points=block", "--seconds-between-status-checks", "1")
    result = fresh.call(RUN, STICTION, *cluster, *groups)
    assert result.returncode == 1
    title, *_, reason, log = result.stderr.splitlines()[-7:]
    assert title.startswith("FAILED: rule points, making results/tiny/blocks/")
    assert reason == "    NameError: name 'nothing_here' is not defined"
    assert "results/tiny/logs/points/" in log


def test_a_table_that_is_damaged_again_is_not_made_for_ever(done):
    """As when the disk is broken."""
    digests = "src/vibrissa/tables/parquet/digests.py"
    done.edit(digests, "file.write(digest)", "file.write(digest[::-1])")
    result = done.call(RUN, STICTION)
    assert result.returncode != 0
    assert result.stderr.count("Running again.") == 1
    title, reason, log = result.stderr.splitlines()[-3:]
    assert title.startswith("FAILED: rule points, making results/tiny/blocks/point-collocation/")
    assert re.match("    error: results/tiny/blocks/.* cannot be read .* run again, it is", reason)
    assert reason.strip() in (done.root / log.removeprefix("  log: ")).read_text()


def test_a_damaged_table_is_made_anew(done):
    path = done.root / STICTION
    before = path.read_bytes()
    path.write_bytes(before[:-100])
    result = done.call(RUN, STICTION)
    assert result.returncode == 0, result.stderr
    assert result.stderr.startswith(f"{STICTION} is damaged or does not belong there: removed")
    assert path.read_bytes() == before


def test_a_killed_run_goes_on(finished, fresh):
    """At one moment; tests/faults has more of them, and other faults."""
    environment = os.environ | {"PYTHONPATH": str(fresh.root / "src")}
    process = subprocess.Popen(
        [*RUN, "--configfile", "tiny.yaml"],
        cwd=fresh.root,
        env=environment,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    while not list(fresh.root.glob("results/tiny/blocks/*/*.curves.parquet")):
        assert process.poll() is None
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    result = fresh.call(RUN, *TABLES)
    assert result.returncode == 0, result.stderr
    assert result.stderr.startswith("The last run was killed; its finished results are kept")
    for path in TABLES:
        assert (fresh.root / path).read_bytes() == (finished.root / path).read_bytes()


def test_a_long_table_is_collected_in_threads(fresh, finished):
    fresh.edit("src/vibrissa/study/costs.py", "LONG_TABLE = 20_000_000", "LONG_TABLE = 3")
    fresh.edit("src/vibrissa/tables/store.py", "LEAST_ROW_GROUP = 2**14", "LEAST_ROW_GROUP = 2")
    threads = "    threads = snakemake.threads\n"
    fresh.edit("workflow/scripts/stiction.py", threads, threads + "    print(threads, 'threads')\n")
    assert fresh.call(RUN, STICTION).returncode == 0
    log = (fresh.root / "results/tiny/logs/stiction.log").read_text()
    assert log.startswith("2 threads\n")
    assert digests.DIGEST_OF_PARTS in pq.read_metadata(fresh.root / STICTION).metadata
    assert fresh.stiction().equals(finished.stiction())


def test_a_dry_run_plans_nothing(fresh):
    assert fresh.jobs()["curves"] == 2
    assert not (fresh.root / "results").exists()


ASKING = "jobs.logged(snakemake.log[0]):\n"


def test_jobs_run_in_workers_that_import_nothing_anew(fresh):
    """And without `run.py` in a Python of their own."""
    fresh.edit("workflow/scripts/captions.py", ASKING, f"{ASKING}    import sys\n")
    asked = '    print("matplotlib" in sys.modules, __name__)\n'
    fresh.edit("workflow/scripts/captions.py", "    import sys\n", f"    import sys\n{asked}")
    log = fresh.root / "results/tiny/logs/captions.log"
    assert fresh.call(RUN, CAPTIONS).returncode == 0
    assert log.read_text() == "True __main__\n"
    fresh.run(CAPTIONS, "--forcerun", CAPTIONS, command=SNAKEMAKE)
    assert log.read_text() == "False __main__\n"


def test_a_worker_that_is_killed_says_so_and_the_other_figures_are_kept(done):
    done.edit(
        "workflow/scripts/figure.py",
        ASKING,
        f"{ASKING}    import os\n    if 'taper' in snakemake.output[0]: os.kill(os.getpid(), 9)\n",
    )
    shutil.rmtree(done.root / "results/tiny/figures")
    result = done.call(RUN, "--keep-going")
    assert result.returncode == 1
    title, why, log = result.stderr.splitlines()[-3:]
    assert title.startswith("FAILED: rule figure, making results/tiny/figures/taper.svg")
    assert why == "    (ended by SIGKILL)" and "logs/figure/taper.log" in log
    drawn = {path.stem for path in done.root.glob("results/tiny/figures/*.svg")}
    assert drawn == {"friction", "scan", "period", "state"}


def test_a_figures_folder_that_is_a_file_is_named_last(fresh):
    fresh.edit("tiny.yaml", TINY[TINY.index("scans:") : TINY.index("figures:")], "")
    for name in ("scan", "period", "state", "friction"):
        text = (fresh.root / "tiny.yaml").read_text()
        fresh.write("tiny.yaml", re.sub(rf"\n  {name}: .*", "", text))
    folder = fresh.root / "results/tiny/figures"
    folder.parent.mkdir(parents=True)
    folder.write_text("")
    result = fresh.call(RUN)
    assert result.returncode != 0
    assert result.stderr.startswith("results/tiny/figures is a file where a folder is needed; move")
    assert len(result.stderr.splitlines()) == 1


def test_a_damaged_plan_stops_with_its_remedy(done):
    plan = done.path("results/tiny/blocks/*.json")
    whole = plan.read_bytes()
    plan.write_bytes(whole[:-10])
    result = done.call(RUN)
    name = plan.relative_to(done.root)
    assert result.returncode != 0
    assert f"the plan of blocks is damaged; delete {name}" in result.stderr.splitlines()[-1]
    plan.unlink()
    assert done.jobs() == {}
    assert not plan.exists()
    assert "Nothing to be done" in done.run(command=SNAKEMAKE).stderr
    assert plan.read_bytes() == whole


def test_editing_a_caption_touches_captions_and_plots_alone(done):
    done.edit("tiny.yaml", "Two cycles.", "Two cycles of stick and slip.")
    assert set(done.jobs()) <= {"figure", "captions", "report", "all"}


def test_a_rod_may_lie_down_along_the_surface(fresh):
    fresh.write("tiny.yaml", TINY.replace("study: tiny", "study: tiny\ncontact: line"))
    fresh.edit("tiny.yaml", "[1.5, 2]", "[2, 5]")
    assert fresh.call(RUN, STICTION, "results/tiny/tables/states.parquet").returncode == 0
    slips = fresh.stiction().to_pandas().query("status == 'slip'").set_index("theta")
    assert slips["contact"].to_dict() == {2.0: "point", 5.0: "line"}
    assert slips.loc[5.0, "s_c_slip"] < 1.0 == slips.loc[2.0, "s_c_slip"]
    assert not slips["penetrates"].any()
    states = store.read(fresh.root / "results/tiny/tables/states.parquet", schemas.STATES)
    (state,) = states.to_pylist()
    assert state["contact"] == "line" and not state["penetrates"] and state["stability"] > 0


def test_check_is_a_target(done):
    def check():
        result = done.call(SNAKEMAKE, "check")
        return result.returncode, result.stdout + result.stderr

    blessed = done.call([sys.executable, "workflow/check.py", "--bless"])
    assert "tests/regression/tiny is written: review it with git diff" in blessed.stdout
    status, text = check()
    assert not status and "Nothing moved: results/tiny has" in text
    done.edit("tests/regression/tiny/states.csv", ",solved,", ",failed,")
    status, text = check()
    assert status and "states.status: 1 of 1 rows moved; at state inside (failed -> solved)" in text
    log = done.path("results/tiny/logs/check.log").read_text()
    assert log.splitlines()[-1] == "1 differences between results/tiny and tests/regression/tiny"


def test_folders_may_have_spaces_and_umlauts(pristine, tmp_path):
    """With an interpreter below such a folder, as `make reproduce` has in .venv."""
    copy = Copy(tmp_path / "a b" / "ü")
    shutil.copytree(pristine.root, copy.root)
    venv.create(copy.root / ".venv")
    python = copy.root / ".venv/bin/python"
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (packages,) = copy.root.glob(".venv/lib/*/site-packages")
    (packages / "all.pth").write_text("\n".join(paths))
    result = copy.call([str(python), *RUN[1:], "results/tiny/figures/captions.md"])
    assert result.returncode == 0, result.stderr
    assert "Two cycles." in copy.path("results/tiny/figures/captions.md").read_text()


def test_check_refuses_tables_that_are_older_than_the_code(done):
    def check(*arguments):
        result = done.call([sys.executable, "workflow/check.py"], *arguments)
        return result.returncode, (result.stdout + result.stderr).splitlines()[-1]

    done.edit("src/vibrissa/sticking/cycles.py", '"""Stick', '"""A stick')
    assert check() == (
        2,
        "error: the tables in results/tiny are older than the code or the study file (to be run: "
        "scan, scans); run make study STUDY=tiny.yaml first",
    )
    assert check("--results", "results/tiny", "--bless")[0] == 0


CAPTIONS = "results/tiny/figures/captions.md"


@pytest.mark.parametrize(
    "command",
    [
        ["{root}/workflow/run.py", CAPTIONS],
        ["-m", "snakemake", CAPTIONS, "-s", "{root}/workflow/Snakefile", "--cores", "1"],
    ],
    ids=["run.py", "snakemake"],
)
def test_a_study_runs_from_another_folder(fresh, tmp_path, command):
    here = tmp_path / "here"
    here.mkdir()
    command = [sys.executable, *(word.format(root=fresh.root) for word in command)]
    result = fresh.call(command, study=str(fresh.root / "tiny.yaml"), cwd=here)
    assert result.returncode == 0, result.stderr
    assert (here / CAPTIONS).exists() and not (fresh.root / "results").exists()


def test_a_study_runs_into_another_folder(fresh):
    """Bare, with the profile that is found beside the Snakefile: all cores."""
    fresh.call([sys.executable, "-m", "snakemake", CAPTIONS, "--directory", "scratch"])
    assert (fresh.root / "scratch" / CAPTIONS).exists()
    assert not (fresh.root / "results").exists()


def test_another_workflow_may_contain_this_one(fresh, tmp_path):
    """As its module; `check` says that there are no reference tables yet."""
    here = tmp_path / "here"
    here.mkdir()
    (here / "mine.yaml").write_text(yaml.safe_dump({"sensor": yaml.safe_load(TINY)}))
    (here / "Snakefile").write_text(
        f"""
configfile: "mine.yaml"
module vibrissa:
    snakefile: {str(fresh.root / "Snakefile")!r}
    config: config["sensor"]
use rule * from vibrissa as sensor_*
rule mine:
    default_target: True
    input: {CAPTIONS!r}
"""
    )
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "1"]
    result = fresh.call(snakemake, study=None, cwd=here)
    assert result.returncode == 0, result.stderr
    assert (here / CAPTIONS).exists()
    result = fresh.call(snakemake, "-n", "-p", "sensor_check", study=None, cwd=here)
    (line,) = (line for line in result.stdout.splitlines() if "--reference" in line)
    words = shlex.split(line)
    assert words[words.index("--results") - 1] == str(fresh.root / "workflow/check.py")
    assert words[words.index("--reference") + 1] == "tests/regression/tiny"


def test_without_its_package_the_workflow_says_how_to_get_it(fresh):
    (fresh.root / "none").mkdir()
    (fresh.root / "none/vibrissa.py").write_text("raise ImportError('not here')")
    result = fresh.call([sys.executable, "-m", "snakemake", "-n"], packages="none")
    assert result.returncode == 1 and "Traceback" not in result.stderr
    _, line = result.stdout.split("package is missing or incomplete ")
    assert line.startswith(f"(not here). Run make reproduce in {fresh.root}, or install it for ")
    assert f": pip install '{fresh.root}[workflow]'\n" in line
