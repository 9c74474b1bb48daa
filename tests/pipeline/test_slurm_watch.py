"""What a run asks of SLURM before its first job, and what it says while its jobs wait.

The executor is made up; the plugin's own words for sbatch are real. tests/slurm runs a real SLURM.
"""

import logging
import threading
from types import SimpleNamespace

import pytest
from snakemake_interface_common.exceptions import WorkflowError

from vibrissa.errors import ClusterError
from vibrissa.pipeline import slurm


class Resources(SimpleNamespace):
    def get(self, name, default=None):
        return getattr(self, name, default)


class Job(SimpleNamespace):
    __hash__ = object.__hash__


class Executor:
    run_uuid = "run-1"
    workflow = SimpleNamespace(executor_settings=None)
    partition = " -p 'short'"

    def get_partition_arg(self, job):
        return self.partition

    def get_account_arg(self, job):
        yield " -A 'me'"


def job(runtime=10, is_local=False):
    return Job(is_local=is_local, threads=1, resources=Resources(runtime=runtime, mem_mb=500))


def workflow_of(jobs, executor=None, groups=None):
    """Put jobs into a workflow; groups are submitted as one."""
    dag = SimpleNamespace(
        needrun_jobs=lambda: jobs, get_job_group=lambda one: (groups or {}).get(id(one))
    )
    scheduler = SimpleNamespace(get_executor=lambda one: executor or Executor())
    return SimpleNamespace(dag=dag, scheduler=scheduler)


@pytest.fixture
def asked(monkeypatch):
    """Answer as SLURM, and keep what it was asked."""
    commands, answers = [], {"sinfo": "short|up|30:00\n"}

    def ask(*command):
        commands.append(command)
        answer = answers.get(command[0], "")
        if isinstance(answer, list):
            answer = answer.pop(0)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    monkeypatch.setattr(slurm, "ask", ask)
    monkeypatch.setattr(slurm.shutil, "which", lambda name: f"/bin/{name}")
    return SimpleNamespace(commands=commands, answers=answers)


@pytest.fixture
def said(monkeypatch):
    lines = []
    monkeypatch.setattr(slurm, "_say", lambda text, run: lines.append((text, run)))
    return lines


@pytest.fixture
def started(monkeypatch):
    """Keep threads from running."""
    threads = []

    class Thread:
        def __init__(self, target, args, daemon):
            threads.append((target, args, daemon))

        def start(self):
            pass

    monkeypatch.setattr(slurm, "threading", SimpleNamespace(Thread=Thread))
    return threads


def test_jobs_are_asked_for_as_the_plugin_will_submit_them(asked, said, started):
    slurm.watch(workflow_of([job(is_local=True), job(), job(runtime=20)]))
    sinfo, one, two = sorted(asked.commands, key=lambda command: (command[0] != "sinfo", command))
    assert sinfo == ("sinfo", "-h", "-o", "%R|%a|%l")
    for command, runtime in ((one, "10"), (two, "20")):
        assert command[:2] == ("sbatch", "--test-only") and command[-2:] == ("--wrap", "true")
        options = command[2:-2]
        assert options[:6] == ("-A", "me", "-p", "short", "-t", runtime)
        assert options[options.index("--mem") + 1] == "500"
    assert said == [("SLURM takes the jobs.", "run-1")]
    ((_, arguments, daemon),) = started
    assert arguments == ["run-1"] and daemon


def test_jobs_that_ask_for_the_same_and_jobs_of_a_group_are_asked_for_once(asked, said, started):
    two = [job(), job()]
    group = job(runtime=25)
    slurm.watch(workflow_of([job(), *two], groups={id(one): group for one in two}))
    assert sorted(command[7] for command in asked.commands[1:]) == ["10", "25"]
    asked.commands.clear()
    slurm.watch(workflow_of([job() for _ in range(5)]))
    assert len(asked.commands) == 2


def test_a_run_without_jobs_for_slurm_asks_nothing(asked, said, started):
    slurm.watch(workflow_of([job(is_local=True)]))
    assert not asked.commands and not said and not started


def test_too_long_a_job_is_refused_before_the_first_is_submitted(asked, said, started):
    with pytest.raises(ClusterError, match=r"Partition short allows 30 minutes, .* ask for 31\."):
        slurm.watch(workflow_of([job(runtime=31)]))
    assert not said and not started
    # Of SLURM's default partition, which is not known, nothing is said.
    executor = Executor()
    executor.partition = ""
    slurm.watch(workflow_of([job(runtime=31)], executor))
    assert started


@pytest.mark.parametrize("error", [WorkflowError("no account"), OSError("no account")])
def test_a_plugin_that_cannot_submit_says_why(asked, said, started, error):
    class Lost(Executor):
        def get_account_arg(self, job):
            raise error
            yield

    with pytest.raises(ClusterError, match="plugin for SLURM cannot submit jobs:\n    no account"):
        slurm.watch(workflow_of([job()], Lost()))


def test_what_jobs_wait_for_is_said_whenever_it_changes(asked, said, monkeypatch):
    class Enough(Exception):
        pass

    asked.answers["squeue"] = [
        "PENDING|Priority\n",
        "PENDING|Priority\n",
        ClusterError("no answer"),
        "RUNNING|None\n",
    ]
    slept = []

    def sleep(seconds):
        slept.append(seconds)
        if not asked.answers["squeue"]:
            raise Enough

    monkeypatch.setattr(slurm, "time", SimpleNamespace(sleep=sleep))
    with pytest.raises(Enough):
        slurm._report("run-1")
    assert said == [
        ("SLURM: 0 running, 1 pending: Priority (jobs of others come first: wait)", "run-1"),
        ("SLURM does not answer, and is asked again: no answer", "run-1"),
        ("SLURM: 1 running, 0 pending", "run-1"),
    ]
    assert slept == [slurm.FIRST_LOOK, *[slurm.EVERY] * 4]
    assert set(asked.commands) == {("squeue", "-h", "--me", "--name=run-1", "-o", "%T|%r")}


def test_jobs_that_are_left_are_cancelled_by_their_run(asked):
    slurm.cancel("run-1")
    assert asked.commands == [("scancel", "--me", "--name=run-1")]


def test_a_line_names_the_run_for_the_screen(caplog):
    records = []
    handler = logging.Handler()
    handler.emit = records.append
    logger = logging.getLogger("snakemake.logging")
    logger.addHandler(handler)
    before = logger.level
    logger.setLevel(logging.INFO)
    try:
        slurm._say("SLURM: 1 running, 0 pending", "run-1")
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)
    ((text, run),) = [(record.getMessage(), record.slurm_run) for record in records]
    assert (text, run) == ("SLURM: 1 running, 0 pending", "run-1")


def test_the_queue_is_looked_at_beside_the_run(asked, said, monkeypatch):
    """The thread ends with the run, and does not hold it up."""
    looked = threading.Event()
    monkeypatch.setattr(slurm, "_report", lambda run: looked.set())
    slurm.watch(workflow_of([job()]))
    assert looked.wait(5)
