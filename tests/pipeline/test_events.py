"""Snakemake itself with the logger plugin: what it sends about small workflows."""

import errno
import logging
import os
import pty
import re
import signal
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path

import pytest

from vibrissa.pipeline.events import (
    Failed,
    Finished,
    Job,
    Planned,
    Problem,
    Progress,
    Queued,
    event_of,
)

pytestmark = pytest.mark.slow

HEAD = """
import errno, os
from vibrissa.errors import StudyError

rule all:
    input: "a"

"""
# Runs each job at once, as a scheduler of a cluster would later.
CLUSTER = [
    *("--executor", "cluster-generic", "--jobs", "1", "--cluster-generic-submit-cmd", "sh"),
    *("--seconds-between-status-checks", "1", "--groups", "one=both", "a=both"),
]


@pytest.fixture
def events(tmp_path, monkeypatch):
    """Run a workflow; return what was sent, the exit status and what was on the screen."""
    monkeypatch.chdir(tmp_path)

    def run(text, *arguments, stderr=subprocess.PIPE):
        Path("Snakefile").write_text(HEAD + text)
        receiver, sender = Pipe(duplex=False)
        command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "1", *arguments]
        process = subprocess.Popen(
            [*command, "--logger", "vibrissa", "--logger-vibrissa-pipe", str(sender.fileno())],
            stdout=subprocess.PIPE,
            stderr=stderr,
            pass_fds=[sender.fileno()],
            text=True,
        )
        sender.close()
        screen = "".join(filter(None, process.communicate()))
        found = []
        while receiver.poll():
            try:
                found.append(receiver.recv())
            except EOFError:
                break
        return found, process.returncode, screen

    return run


def of(kind, found):
    return [event for event in found if isinstance(event, kind)]


MAKES = 'rule a:\n    output: "a"\n    shell: "touch {output}"\n'


def test_a_run_that_succeeds_and_one_with_nothing_to_do(events):
    found, status, screen = events(MAKES)
    assert status == 0
    assert found == [
        *(Planned(jobs=0), Planned(jobs=2)),
        *(Finished(number=1), Progress(done=1, total=2)),
        *(Finished(number=0), Progress(done=2, total=2)),
    ]
    assert screen == ""
    assert events(MAKES)[0] == [Planned(jobs=0)]


def test_a_dry_run_is_shown(events):
    found, status, screen = events(MAKES, "-n")
    assert status == 0
    assert set(found) == {Planned(jobs=0), Planned(jobs=2)}
    assert "This was a dry-run" in screen


@pytest.mark.parametrize(("command", "number"), [("exit 3", None), ("kill -9 $$", signal.SIGKILL)])
def test_a_job_that_fails(events, command, number):
    found, status, _ = events(
        f'rule a:\n    output: "a", "b"\n    log: "a.log"\n    shell: "{command}"\n'
    )
    job = Job(number=1, rule="a", output=["a", "b"], log=["a.log"])
    assert of(Failed, found) == [Failed(jobs=[job], signal=number)]
    assert status == 1


def test_a_retry_that_succeeds(events):
    rule = (
        'rule a:\n    output: "a"\n    resources: n=lambda wildcards, attempt: attempt\n'
        '    shell: "test {resources.n} = 2 && touch a"\n'
    )
    found, status, _ = events(rule, "--retries", "1")
    (failed,) = of(Failed, found)
    assert status == 0
    assert found.index(failed) < found.index(Finished(number=failed.jobs[0].number))


def test_a_group_of_which_one_job_fails(events):
    rules = (
        'rule one:\n    output: "one"\n    log: "one.log"\n    shell: "touch one"\n'
        'rule a:\n    input: "one"\n    output: "a"\n    log: "a.log"\n    shell: "exit 3"\n'
    )
    found, status, _ = events(rules, *CLUSTER)
    (failed,) = of(Failed, found)
    assert sorted((job.rule, *job.output, *job.log) for job in failed.jobs) == [
        ("a", "a", "a.log"),
        ("one", "one", "one.log"),
    ]
    assert status == 1


def test_a_cluster_says_why(events):
    found, _, _ = events(
        'rule a:\n    output: "a"\n    shell: "exit 3"\n', *CLUSTER[:-3], "--latency-wait", "0"
    )
    (failed,) = of(Failed, found)
    assert "see the cluster/cloud log" in failed.reason


def test_why_a_cluster_refuses_a_group_is_told(events):
    rules = (
        'rule one:\n    output: "one"\n    log: "one.log"\n    shell: "touch one"\n'
        'rule a:\n    input: "one"\n    output: "a"\n    log: "a.log"\n    shell: "touch a"\n'
    )
    arguments = [*CLUSTER]
    arguments[arguments.index("sh")] = "echo no such queue; false"
    (failed,) = of(Failed, events(rules, *arguments)[0])
    assert failed.reason == "no such queue"


def test_a_line_about_the_queue(events):
    start = 'onstart: logger.info("SLURM: 1 running", extra={"slurm_run": "vibrissa_1"})\n'
    found, *_ = events("from snakemake.logging import logger\n" + start + MAKES)
    assert of(Queued, found) == [Queued(run="vibrissa_1", text="SLURM: 1 running")]


def test_an_error_of_the_operating_system_is_told_by_its_number(events):
    found, status, _ = events("raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))")
    (problem,) = of(Problem, found)
    assert (problem.errno, problem.locked, status) == (errno.ENOSPC, False, 1)
    assert "No space left on device" in problem.message


def test_where_our_own_errors_were_raised_is_not_told(events):
    found, _, _ = events("raise StudyError('theta is missing')")
    assert found == [Problem(message="theta is missing", ours=True)]


@pytest.mark.parametrize(
    ("level", "told"),
    [(logging.INFO, False), (logging.WARNING, True), (logging.ERROR, True)],
    ids=logging.getLevelName,
)
def test_a_warning_is_told_and_what_is_less_is_not(level, told):
    record = logging.makeLogRecord({"levelno": level, "msg": "the disk of %s", "args": ("a",)})
    assert event_of(record) == (Problem(message="the disk of a") if told else None)


def test_where_a_mistake_in_the_workflow_is_is_told(events):
    (problem,) = of(Problem, events("nothing_here")[0])
    assert re.search("NameError in file .*Snakefile.*, line 8", problem.message)


def test_a_folder_that_another_snakemake_holds(events):
    locks = Path(".snakemake/locks")
    locks.mkdir(parents=True)
    Path(locks, "0.output.lock").write_text("a\n")
    (problem,) = of(Problem, events(MAKES)[0])
    assert problem.locked and "Directory cannot be locked" in problem.message


@pytest.mark.parametrize(("terminal", "shown"), [("xterm", True), ("dumb", False)])
def test_on_a_terminal_snakemake_writes_itself(events, monkeypatch, terminal, shown):
    monkeypatch.setenv("TERM", terminal)
    main, other = pty.openpty()
    found, _, _ = events(MAKES, stderr=other)
    os.close(other)
    screen = os.read(main, 2**16).decode() if shown else ""
    os.close(main)
    assert Progress(done=2, total=2) in found
    assert ("Finished jobid: 1" in screen) == shown


def test_a_workflow_goes_on_when_nobody_listens_any_more(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("Snakefile").write_text(HEAD + MAKES)
    receiver, sender = Pipe(duplex=False)
    command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "1", "--logger", "vibrissa"]
    with sender:
        receiver.close()
        subprocess.run(
            [*command, "--logger-vibrissa-pipe", str(sender.fileno())],
            pass_fds=[sender.fileno()],
            check=True,
        )
    assert Path("a").exists()
