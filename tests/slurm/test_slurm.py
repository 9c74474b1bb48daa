"""The profiles for clusters, run on a real SLURM: `python -m validation slurm` installs one.

Jobs and daemons are found by what they inherit from `up.sh`, so that `down.sh` ends all of them.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
import pytest
import yaml

from vibrissa.tables import schemas, store

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
STUDY = yaml.safe_load((HERE / "study.yaml").read_text())
# Two chunks, for what is about the jobs and not about the numbers.
AXES = {"theta": [1.5, 2, 2.5], "mu0": [0.3, 5], "eta": [0.8, 0.85], "dx0": [0.001]}
SMALL = {"study": "small", "chunk": {"eta": 1}, "grids": {"main": AXES}}
# The plugin waits 40 s before it looks after its first jobs.
SOON = ("--slurm-init-seconds-before-status-checks", "5")


class Project:
    """A copy of the project, in which a study is run."""

    def __init__(self, root, study, cluster=""):
        self.root = root
        self.study = study
        self.screen = root / "screen.txt"
        skip = shutil.ignore_patterns("__pycache__")
        for name in ("src", "workflow"):
            shutil.copytree(ROOT / name, root / name, ignore=skip)
        for name in ("Snakefile", "config.yaml"):
            shutil.copy(ROOT / name, root)
        (root / "study.yaml").write_text(yaml.safe_dump(study))
        self.environment = os.environ | {
            "PYTHONPATH": str(root / "src"),
            "XDG_CACHE_HOME": str(root / ".cache"),
            "VIBRISSA_SLURM": str(cluster),
        }

    @contextlib.contextmanager
    def running(self, profile, *arguments, status=0):
        """Run the study while the caller does something with it; it must end with the status."""
        command = [sys.executable, "-m", "vibrissa.pipeline", "--configfile", "study.yaml"]
        command += ["--workflow-profile", f"workflow/profiles/{profile}", *arguments]
        process = subprocess.Popen(
            command,
            cwd=self.root,
            env=self.environment,
            stdout=self.screen.open("w"),
            stderr=subprocess.STDOUT,
        )
        try:
            yield process
            process.wait(timeout=240)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
        assert process.returncode == status, f"{self.said}\n{self.log()}"

    @property
    def said(self):
        """What the last run wrote to the screen."""
        return self.screen.read_text()

    def run(self, profile, *arguments, status=0):
        """Run the study; return what was on the screen."""
        with self.running(profile, *arguments, status=status):
            pass
        return self.said

    def log(self):
        """What the last Snakemake run wrote."""
        return max((self.root / ".snakemake/log").glob("*.log")).read_text()

    def tables(self):
        """Names and paths of the study's tables."""
        folder = self.root / "results" / self.study["study"] / "tables"
        return {path.stem: path for path in sorted(folder.glob("*.parquet"))}

    def table(self, name):
        return store.read(self.tables()[name], schemas.TABLES[name])


def slurm(command):
    """Lines that one of SLURM's commands prints."""
    return subprocess.run(
        command.split(), capture_output=True, text=True, check=True
    ).stdout.splitlines()


def wait_for(condition, what, seconds=60):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, f"no {what} within {seconds} s"
        time.sleep(0.2)
    return found


@pytest.fixture(scope="module")
def cluster():
    """Folder of a cluster of two nodes, n1 and n2."""
    folder = Path(tempfile.mkdtemp(prefix="vibrissa-slurm-", dir="/tmp"))
    up = subprocess.run([HERE / "up.sh", folder], capture_output=True, text=True)
    said = (up.stdout + up.stderr).strip()
    if up.returncode == 77:
        folder.rmdir()
        pytest.skip(said.splitlines()[-1])
    assert up.returncode == 0, said
    try:
        yield folder
    finally:
        down = subprocess.run([HERE / "down.sh", folder], capture_output=True, text=True)
        assert down.returncode == 0, down.stderr
    shutil.rmtree(folder)


@pytest.fixture
def hold(cluster):
    """Make jobs wait when they have started, until the file is removed."""
    path = cluster / "hold"
    path.touch()
    yield path
    path.unlink(missing_ok=True)


def local(study, folder):
    """The project after a run of a study on this machine."""
    project = Project(folder / "project", study)
    project.run("default")
    return project


@pytest.fixture
def project(cluster, tmp_path):
    """The small study, which has not been run."""
    return Project(tmp_path / "project", SMALL, cluster)


@pytest.fixture(scope="module")
def small(cluster, tmp_path_factory):
    return local(SMALL, tmp_path_factory.mktemp("small"))


def assert_same_tables(project, other):
    """The files are the same byte for byte: values, nulls, order, schema and metadata."""
    assert project.tables().keys() == other.tables().keys() != set()
    for name, path in project.tables().items():
        one, two = project.table(name), other.table(name)
        differ = [column for column in one.column_names if not one[column].equals(two[column])]
        assert path.read_bytes() == other.tables()[name].read_bytes(), (name, differ)


def test_the_tables_are_the_same_as_without_a_cluster(cluster, hold, tmp_path):
    start = time.monotonic()
    here = local(STUDY, tmp_path / "here")
    seconds = [time.monotonic() - start]
    project = Project(tmp_path / "there", STUDY, cluster)
    with project.running("slurm", *SOON):
        wait_for(lambda: len(running_on("n1,n2")) == 4, "full cluster")
        hold.unlink()
    seconds.append(time.monotonic() - start - seconds[0])

    points = project.table("stiction")
    assert len(points) >= 20_000
    assert project.tables().keys() == {"stiction", "scans", "periods", "states"}
    assert_same_tables(project, here)

    jobs = all_jobs()
    assert {state for state, _ in jobs} == {"COMPLETED"}
    assert {node for _, node in jobs} == {"n1", "n2"}
    chunks = list(project.root.glob("results/*/chunks/*/*.parquet"))
    chunks += project.root.glob("results/*/scan_chunks/scans/*/*.parquet")
    assert len(jobs) == len(chunks) + 1 >= 7  # one for each chunk, and the states
    print(
        f"\n{len(points)} points, bit for bit the same: {seconds[0]:.0f} s on this machine, "
        f"{seconds[1]:.0f} s as {len(jobs)} jobs of SLURM"
    )
    assert "(100%) done" in project.said
    assert "Nothing to be done" in project.run("slurm", *SOON)


def all_jobs():
    """State and node of each job of a study, also of those that have ended."""
    lines = [line.split("|") for line in slurm("squeue --states=all -h -o %j|%T|%N")]
    return [(state, node) for name, state, node in lines if name.startswith("vibrissa_")]


def running_on(node):
    return slurm(f"squeue -h --states=RUNNING --nodelist={node} -o %i")


def processes_on(node, cluster):
    """Processes of jobs on a node."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            environment = process.environ()
            if environment.get("VIBRISSA_SLURM") == str(cluster):
                if environment.get("SLURMD_NODENAME") == node:
                    found.append(process)
    return found


def lose(node, cluster):
    """Kill the daemon of a node and all that runs on it, as if somebody had pulled its plug."""
    os.kill(int((cluster / node / "slurmd.pid").read_text()), signal.SIGKILL)
    sessions = {os.getsid(process.pid) for process in processes_on(node, cluster)}
    for process in psutil.process_iter():
        # SLURM's own part of a job has overwritten its environment, but shares the session.
        with contextlib.suppress(psutil.Error, ProcessLookupError):
            if os.getsid(process.pid) in sessions:
                process.kill()
    # SLURM by itself notices after half a minute.
    slurm(f"scontrol update nodename={node} state=down reason=lost")


def test_a_node_lost_in_the_middle_of_a_job_changes_nothing(cluster, small, project, hold):
    with project.running("slurm", *SOON):
        lost = wait_for(lambda: running_on("n1"), "job on n1")
        wait_for(lambda: processes_on("n1", cluster), "process on n1")
        lose("n1", cluster)
        hold.unlink()
    # SLURM itself started the jobs again, and Snakemake did not have to.
    for job in lost:
        assert " Restarts=1 " in slurm(f"scontrol show job -o {job}")[0]
    assert "Trying to restart" not in project.log()
    assert_same_tables(project, small)


def test_another_scheduler_and_a_job_cancelled_by_hand(cluster, small, project, hold):
    """SLURM, as any scheduler. Snakemake by itself would wait for the job for ever."""
    with project.running("cluster-generic", "--seconds-between-status-checks", "3"):
        cancelled, *_ = wait_for(lambda: running_on("n1,n2"), "job")
        slurm(f"scancel {cancelled}")
        # A job that has just started may not hear SIGTERM; let go, it would be done before SIGKILL.
        wait_for(lambda: cancelled not in slurm("squeue -h -o %i"), "end of the job")
        hold.unlink()
    assert project.log().count("Trying to restart") == 1
    assert_same_tables(project, small)


REFUSALS = {
    "a wrong partition": (["--default-resources", "slurm_partition=nowhere"], "nvalid partition"),
    "a wrong account": (
        ["--default-resources", "slurm_account=nobody"],
        "The given account nobody appears to be invalid",
    ),
    "more memory than a node has": (
        ["--set-resources", "chunk:mem_mb=100000000"],
        "Requested node configuration is not available",
    ),
}


@pytest.mark.parametrize("arguments, words", REFUSALS.values(), ids=REFUSALS)
def test_a_refusal_ends_the_run_with_slurms_words(cluster, project, arguments, words):
    assert words in project.run("slurm", *arguments, "--retries", "0", status=1)


def test_sigterm_ends_the_run_and_takes_its_jobs_out_of_the_queue(cluster, project):
    """SLURM takes the jobs and does not start them."""
    closed = ("--default-resources", "slurm_partition=closed")
    with project.running("slurm", *closed, status=128 + signal.SIGINT) as process:
        wait_for(lambda: slurm("squeue -h --partition=closed -o %i"), "pending job")
        process.terminate()
        process.wait(timeout=60)
    assert "Stopped. Finished results are kept" in project.said
    assert slurm("squeue -h --partition=closed --states=PENDING -o %i") == []
