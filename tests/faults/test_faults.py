"""Faults, and the same command again: the study must be finished as if nothing had happened.

Run by `make test-faults` alone, as it takes minutes. The first line of a test's docstring is its
row in docs/faults.md.
"""

import contextlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pyarrow.parquet as pq
import pytest
import yaml

from vibrissa.pipeline.repair import FOLDERS
from vibrissa.tables import schemas, store

ROOT = Path(__file__).parents[2]
AXES = {"theta": [1.5, 2, 3], "mu0": [0.3, 5], "eta": [0.85], "dx0": [0.005]}
SCAN = {"theta": [2], "mu0": [0.3], "eta": [0.85], "dx0": [0.005], "cycles": 1}
STUDY = {
    "study": "faults",
    "block_size": 1,
    "grids": {"main": AXES},
    "scans": {"runs": SCAN},
}
# Reads every block again, as they are not written.
GROWN = STUDY | {"grids": {"main": AXES | {"mu0": [0.2, 0.3, 5]}}}
RUN = [sys.executable, "workflow/run.py", "--configfile", "study.yaml", "--cores", "2"]


class Project:
    """A copy of the project, in which the study is run."""

    def __init__(self, root, study=STUDY):
        self.root = root
        self.results = root / "results/faults"
        skip = shutil.ignore_patterns("__pycache__")
        for name in ("src", "workflow"):
            shutil.copytree(ROOT / name, root / name, ignore=skip)
        for name in ("Snakefile", "config.yaml"):
            shutil.copy(ROOT / name, root)
        self.write(study)

    def write(self, study):
        (self.root / "study.yaml").write_text(yaml.safe_dump(study))

    def start(self, command=RUN):
        environment = os.environ | {
            "PYTHONPATH": str(self.root / "src"),
            "XDG_CACHE_HOME": str(self.root / ".cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return subprocess.Popen(
            command,
            cwd=self.root,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def run(self, command=RUN):
        """Run the study; return the status and what was on the screen."""
        process = self.start(command)
        said = process.communicate(timeout=300)[1]
        assert_plain(said)
        return process.returncode, said

    def finish(self):
        """Run the study, which must come to its end; return what was on the screen."""
        status, said = self.run()
        assert status == 0, said
        return said

    def refuse(self, record_property, pattern):
        """Run the study, which must fail and say why and what to do."""
        status, said = self.run()
        assert status > 0, said
        (line, *_) = [line.strip() for line in said.splitlines() if re.search(pattern, line)] or [
            ""
        ]
        assert line, said
        record_property("said", line.replace(f"{self.root}/", "").replace(str(self.root), "…"))

    def files(self, pattern):
        found = sorted(self.results.glob(pattern))
        assert found
        return found


def assert_plain(said):
    """What is on the screen is meant for its reader."""
    assert "Traceback" not in said and 'File "' not in said, said


def assert_same(project, other, again=True, said=""):
    """All is there, whole, and equal to an undisturbed run's; nothing is left to do."""
    mine, theirs = (sorted(p.results.glob("tables/*.parquet")) for p in (project, other))
    assert [path.name for path in mine] == [path.name for path in theirs]
    for one, two in zip(mine, theirs, strict=True):
        schema = schemas.TABLES[one.stem]
        table = store.read(one, schema)
        assert table.equals(store.read(two, schema), check_metadata=True), one
        assert one.read_bytes() == two.read_bytes(), one
    for path in project.results.rglob("*.parquet"):
        store.check_file(path)
    here, there = (
        {str(path.relative_to(p.results)) for path in p.results.rglob("*") if path.is_file()}
        for p in (project, other)
    )
    assert here <= there  # no temporary file among them
    # A removed block is made anew where it is needed, and else not.
    for name in there - here:
        assert "blocks/" in name and f"{name} is damaged" in said
    for name in ("locks", "incomplete"):
        assert not list((project.root / ".snakemake" / name).rglob("*.lock"))
        assert not [
            path for path in (project.root / ".snakemake" / name).rglob("*") if path.is_file()
        ]
    if again:
        assert "Nothing to do" in project.finish()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The study after a run without a fault; not to be changed."""
    project = Project(tmp_path_factory.mktemp("undisturbed") / "project")
    start = time.monotonic()
    project.finish()
    project.seconds = time.monotonic() - start
    return project


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """The same of the grown study."""
    project = Project(tmp_path_factory.mktemp("grown") / "project", GROWN)
    project.finish()
    return project


@pytest.fixture
def fresh(tmp_path):
    return Project(tmp_path / "project")


def copy_of(undisturbed, root):
    project = Project(root)
    for name in ("results", ".snakemake"):
        shutil.copytree(undisturbed.root / name, root / name)
    return project


@pytest.fixture
def done(undisturbed, tmp_path):
    """A finished study of one's own."""
    return copy_of(undisturbed, tmp_path / "project")


# Killed

KILLED = "The last run was killed; its finished results are kept and it is continued."
ENDED = "Snakemake was ended by signal 9"
FORKS = "from multiprocessing.forkserver import main"
# So often a job may have ended just before it was killed.
ATTEMPTS = 5


def descendants(process):
    with contextlib.suppress(psutil.NoSuchProcess):
        return psutil.Process(process.pid).children(recursive=True)
    return []


def pick(process, victim, generator):
    """The process to be killed, or None if there is no such process now."""
    found = []
    for candidate in descendants(process):
        with contextlib.suppress(psutil.Error):
            command, parent = candidate.cmdline(), candidate.parent()
            # A job is a fork of the process that has imported everything.
            forked = parent is not None and FORKS in " ".join(parent.cmdline())
            if forked if victim == "job" else command[1:3] == ["-m", "vibrissa.pipeline"]:
                found.append(candidate)
    # Snakemake starts a Snakemake for some jobs; it is the first.
    return found and (generator.choice(found) if victim == "job" else found[0])


def kill(process, victim, moment, generator):
    """Kill something at a moment; return all processes that there were, or None if it was over."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(moment)
    while process.poll() is None:
        there = descendants(process)
        if victim == "group":
            os.killpg(process.pid, signal.SIGKILL)
            return there
        target = process if victim == "wrapper" else pick(process, victim, generator)
        if target:
            with contextlib.suppress(psutil.NoSuchProcess):
                target.kill()
                return there
        time.sleep(0.01)
    return None


def killed(victim, seed, undisturbed, project, record_property):
    generator = random.Random(f"{victim} {seed}")
    moment = generator.uniform(0.02, 0.95) * undisturbed.seconds
    for _ in range(ATTEMPTS):
        process = project.start()
        there = kill(process, victim, moment, generator)
        said = process.communicate(timeout=300)[1] if victim in ("snakemake", "job") else ""
        if there is not None and not (victim == "job" and process.returncode == 0):
            break
        # The machine was faster than before: from the beginning.
        process.communicate()
        shutil.rmtree(project.root / "results")
        shutil.rmtree(project.root / ".snakemake")
        moment *= 0.7
    else:
        pytest.fail(f"nothing was killed in {ATTEMPTS} runs")
    if victim == "wrapper":
        # Snakemake goes on by itself, and nobody may disturb it.
        _, said = project.run()
        assert re.search("Another run .* is active|Nothing to do|was killed|steps", said), said
        psutil.wait_procs(there, timeout=300)
    elif victim != "group":
        assert_plain(said)
        (line, *_) = [line for line in said.splitlines() if re.match(f"FAILED|{ENDED}", line)]
        record_property("said", re.sub("[0-9a-f]{12}", "…", line))
    said = project.finish()
    # Snakemake that goes on by itself may have been waited for, or have finished by then.
    if victim in ("snakemake", "group"):
        assert said.startswith(f"{KILLED}\n"), said
    if victim in ("wrapper", "group"):
        record_property("said", KILLED)
    # Jobs of the killed run may outlive it.
    psutil.wait_procs(there, timeout=300)
    assert_same(project, undisturbed)


@pytest.mark.parametrize("seed", range(5))
def test_wrapper(undisturbed, fresh, seed, record_property):
    """SIGKILL of `make study`, but not of the Snakemake that it started."""
    killed("wrapper", seed, undisturbed, fresh, record_property)


@pytest.mark.parametrize("seed", range(5))
def test_snakemake(undisturbed, fresh, seed, record_property):
    """SIGKILL of Snakemake, its jobs going on."""
    killed("snakemake", seed, undisturbed, fresh, record_property)


@pytest.mark.parametrize("seed", range(5))
def test_job(undisturbed, fresh, seed, record_property):
    """SIGKILL of one job."""
    killed("job", seed, undisturbed, fresh, record_property)


@pytest.mark.parametrize("seed", range(5))
def test_group(undisturbed, fresh, seed, record_property):
    """SIGKILL of everything at once."""
    killed("group", seed, undisturbed, fresh, record_property)


# Damaged


def halve(path, generator, undisturbed):
    path.write_bytes(path.read_bytes()[: generator.randrange(1, path.stat().st_size)])


def empty(path, generator, undisturbed):
    path.write_bytes(b"")


def flip(path, generator, undisturbed):
    data = bytearray(path.read_bytes())
    data[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
    path.write_bytes(data)


def age(path, generator, undisturbed):
    table = pq.read_table(path)
    older = table.replace_schema_metadata({**table.schema.metadata, b"vibrissa.schema": b"1"})
    store.write(older, path)


def swap(path, generator, undisturbed):
    others = [
        other for other in path.parent.glob(f"*.{path.name.split('.', 1)[1]}") if other != path
    ]
    shutil.copyfile(generator.choice(others), path)


KINDS = ("blocks/*/*.curves.parquet", "blocks/*/*.points.parquet", "blocks/*/*.scan.parquet")
TABLES = "tables/*.parquet"


def damaged(change, kind, seed, project, undisturbed, grown, record_property, study=GROWN):
    """Damage one file, and have it read: as it is newer, or as the study grows."""
    generator = random.Random(f"{change} {kind} {seed}")
    path = generator.choice(project.files(kind))
    times = path.stat()
    change(path, generator, undisturbed)
    unnoticed = seed % 2 and "scan" not in kind
    if unnoticed:
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        project.write(GROWN)
    said = project.finish()
    name = str(path.relative_to(project.root))
    lines = [line for line in said.splitlines() if line.startswith(f"{name} is damaged")]
    # Points that are made anew before anybody read them need no word.
    assert lines or (unnoticed and "points" in kind), said
    if lines:
        record_property("said", lines[0].replace(path.name, f"….{path.name.split('.', 1)[1]}"))
    assert_same(project, grown if unnoticed else undisturbed, said=said)


@pytest.mark.parametrize(
    ("change", "kind"),
    [*((halve, kind) for kind in (*KINDS, TABLES)), (empty, KINDS[0]), (empty, TABLES)],
)
def test_cut_short(undisturbed, grown, done, change, kind, record_property):
    """A block or a table cut short or empty."""
    damaged(change, kind, 0, done, undisturbed, grown, record_property)


@pytest.mark.parametrize(
    ("kind", "seed"), [(KINDS[0], 0), (KINDS[0], 1), (KINDS[1], 0), (KINDS[2], 0), (TABLES, 0)]
)
def test_flipped(undisturbed, grown, done, kind, seed, record_property):
    """A block or a table with one flipped bit."""
    damaged(flip, kind, seed, done, undisturbed, grown, record_property)


@pytest.mark.parametrize(("kind", "seed"), [(KINDS[0], 1), (KINDS[1], 0)])
def test_aged(undisturbed, grown, done, kind, seed, record_property):
    """A block of another version of the tables."""
    damaged(age, kind, seed, done, undisturbed, grown, record_property)


@pytest.mark.parametrize(("kind", "seed"), [(KINDS[0], 0), (KINDS[1], 0)])
def test_swapped(undisturbed, grown, done, kind, seed, record_property):
    """A block under the name of another."""
    damaged(swap, kind, seed, done, undisturbed, grown, record_property)


@pytest.fixture(scope="module")
def another(tmp_path_factory):
    """Another study with blocks of the same names, which are about other friction and a line."""
    study = STUDY | {"study": "another", "contact": "line", "scans": {"runs": SCAN | {"cycles": 2}}}
    project = Project(tmp_path_factory.mktemp("another") / "project", study)
    project.finish()
    return project.root / "results/another"


@pytest.mark.parametrize("kind", KINDS)
def test_of_another_study(undisturbed, grown, done, another, kind, record_property):
    """A block of another study with the same curves."""

    def replace(path, generator, undisturbed):
        (other,) = another.glob(f"blocks/*/{path.name}")
        shutil.copyfile(other, path)

    damaged(replace, kind, 0, done, undisturbed, grown, record_property)


def test_many_damaged(undisturbed, done, record_property):
    """All blocks of curves with one flipped bit each."""
    generator = random.Random(0)
    blocks = done.files(KINDS[0])
    for path in blocks:
        flip(path, generator, undisturbed)
    said = done.finish()
    assert said.count("Running again.") == 1
    assert said.count("is damaged") == len(blocks)
    record_property("said", "Running again.")
    assert_same(done, undisturbed, said=said)


# Disks


@contextlib.contextmanager
def mounted(folder, size):
    """A small disk under a folder, whose contents are copied to it."""
    keep = folder.with_name(f"{folder.name}-kept")
    folder.rename(keep)
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", folder], check=True)
    try:
        shutil.copytree(keep, folder, dirs_exist_ok=True)
        yield
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


def remount(folder, option):
    subprocess.run(["mount", "-o", f"remount,{option}", folder], check=True)


def can_mount():
    return (
        os.geteuid() == 0
        and not subprocess.run(
            ["unshare", "-m", "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True
        ).returncode
    )


NEEDS_MOUNT = pytest.mark.skipif(not can_mount(), reason="needs the right to mount a file system")


@NEEDS_MOUNT
@pytest.mark.parametrize("size", [4, 120, 200])
def test_full_results(undisturbed, fresh, size, record_property):
    """A full disk under the results, then space."""
    (fresh.root / "results").mkdir()
    with mounted(fresh.root / "results", size):
        fresh.refuse(record_property, "^The disk of .* is full; make space")
        remount(fresh.root / "results", "size=64m")
        fresh.finish()
        assert_same(fresh, undisturbed)


@NEEDS_MOUNT
@pytest.mark.parametrize("room", [0, 8, 150])
def test_full_project(undisturbed, fresh, room, record_property):
    """A full disk under everything, then space."""
    with mounted(fresh.root, 64 * 1024):
        disk = shutil.disk_usage(fresh.root)
        filler = fresh.root / "filler"
        filler.write_bytes(bytes(disk.free - 1024 * room))
        fresh.refuse(record_property, "^The disk of .* is full; make space")
        filler.unlink()
        fresh.finish()
        assert_same(fresh, undisturbed)


@NEEDS_MOUNT
@pytest.mark.parametrize(
    ("state", "where"), [("fresh", "results"), ("done", "results"), ("done", "")]
)
def test_read_only(undisturbed, grown, tmp_path, where, state, record_property):
    """Results, or everything, on a read-only disk, then writable."""
    root = tmp_path / "project"
    project = Project(root) if state == "fresh" else copy_of(undisturbed, root)
    project.write(GROWN)
    (root / "results").mkdir(exist_ok=True)
    with mounted(root / where, 64 * 1024):
        remount(root / where, "ro")
        project.refuse(record_property, "cannot be written to; allow it")
        remount(root / where, "rw")
        project.finish()
        assert_same(project, grown)


@NEEDS_MOUNT
def test_read_only_but_finished(undisturbed, done, record_property):
    """Finished results on a read-only disk: nothing is to be written."""
    with mounted(done.root / "results", 64 * 1024):
        remount(done.root / "results", "ro")
        assert_same(done, undisturbed)
        record_property("said", "Nothing to do: all results are up to date.")


@pytest.mark.parametrize("name", ["", *FOLDERS])
def test_file_for_folder(undisturbed, done, name, record_property):
    """A file where the study or one of its folders should be, then moved away."""
    path = done.results / name
    if path.exists():
        shutil.move(path, done.root / "kept")
    path.write_text("mine")
    done.refuse(record_property, "is a file where a folder is needed; move it away")
    assert path.read_text() == "mine"
    path.unlink()
    if (done.root / "kept").exists():
        shutil.move(done.root / "kept", path)
    assert_same(done, undisturbed)


# Power


def cut_power(project, undisturbed, seed):
    """Leave what a power cut may leave: locks, marks of unfinished jobs, and files without data."""
    generator = random.Random(seed)
    internal = project.root / ".snakemake"
    (internal / "run.lock").write_text("running\n")
    (internal / "locks").mkdir(exist_ok=True)
    (internal / "locks/0.input.lock").write_text("src/vibrissa/pipeline/jobs.py\n")
    (internal / "locks/0.output.lock").write_text("results/faults/tables/stiction.parquet\n")
    for record in generator.sample(sorted((internal / "metadata").iterdir()), 4):
        (internal / "incomplete" / record.name).write_text('{"external_jobid": null}')
        if seed % 2:
            record.write_bytes(record.read_bytes()[: generator.randrange(40)])
    for path in generator.sample(project.files("*/*/*.parquet") + project.files("*/*.parquet"), 3):
        if seed % 2:
            path.write_bytes(bytes(path.stat().st_size))
        path.with_name(f".{path.stem}-a1b2c3d4.tmp{path.suffix}").write_bytes(b"PAR1")


@pytest.mark.parametrize("seed", range(3))
def test_power_cut(undisturbed, done, seed, record_property):
    """A power cut: stale locks and marks, left-over temporary files, files and records of zeros."""
    cut_power(done, undisturbed, seed)
    said = done.finish()
    record_property("said", said.splitlines()[0])
    assert "was killed" in said
    assert_same(done, undisturbed, said=said)


def test_stale_lock_of_snakemake(undisturbed, done, record_property):
    """The lock of a Snakemake that was started by hand and killed, then removed as told."""
    cut_power(done, undisturbed, 0)
    (done.root / ".snakemake/run.lock").write_text("")
    done.refuse(record_property, r"rm -r \.snakemake/locks")
    shutil.rmtree(done.root / ".snakemake/locks")
    done.finish()
    assert_same(done, undisturbed)


# Company


@pytest.mark.parametrize("delay", [0, 1])
def test_two_at_once(undisturbed, fresh, delay, record_property):
    """Two runs started at once, or one soon after the other."""
    one = fresh.start()
    time.sleep(delay)
    two = fresh.start()
    said = {process.communicate(timeout=300)[1]: process.returncode for process in (one, two)}
    (refused,) = [text for text, status in said.items() if status]
    assert re.fullmatch("Another run of this workflow is active in this folder; .*\n", refused)
    assert sorted(said.values()) == [0, 1]
    record_property("said", refused.strip())
    assert_same(fresh, undisturbed, again=False)


def test_beside_a_writer(undisturbed, done):
    """A temporary file that somebody is writing still: it is left alone."""
    code = (
        "import sys; from pathlib import Path; from vibrissa.files import write_atomically\n"
        "with write_atomically(Path('results/faults/tables/more.txt')) as path:\n"
        "    print(path, file=sys.stderr, flush=True); path.write_text(input())"
    )
    writer = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=done.root,
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with writer:
        writer.stderr.readline()
        assert "Nothing to do" in done.finish()
        writer.communicate("more\n")
    path = done.results / "tables/more.txt"
    assert path.read_text() == "more"
    path.unlink()
    assert_same(done, undisturbed, again=False)


def test_dry_run(undisturbed, fresh):
    """A dry run: it leaves nothing behind."""
    status, _ = fresh.run([*RUN, "-n"])
    assert status == 0
    assert not (fresh.root / "results").exists()
    fresh.finish()
    assert_same(fresh, undisturbed, again=False)
