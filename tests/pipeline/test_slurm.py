"""What SLURM says, read; tests/slurm runs the profile on a real one."""

import math
import os
import shutil
import time

import pytest

from vibrissa.errors import ClusterError
from vibrissa.pipeline import slurm
from vibrissa.pipeline.slurm import Partition, Request

SHORT = Partition(name="short", state="up", minutes=30)
LONG = Partition(name="long", state="up", minutes=math.inf)


def request(partition="short", minutes=10):
    return Request(options=("-p", partition), partition=partition, minutes=minutes)


@pytest.fixture
def commands(tmp_path, monkeypatch):
    """Make commands of SLURM from lines of shell; there are no others."""
    monkeypatch.setenv("PATH", str(tmp_path))

    def make(**lines):
        for name, line in lines.items():
            path = tmp_path / name
            path.write_text(f"#!/bin/sh\n{line}\n")
            path.chmod(0o755)

    return make


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("30:00", 30),
        ("1:30:00", 90),
        ("2-00:00:00", 2880),
        ("00:30", 0.5),
        ("infinite", math.inf),
        ("n/a", math.inf),
    ],
)
def test_a_time_of_slurm(text, expected):
    assert slurm.minutes(text) == expected


def test_partitions_are_read_once_each():
    assert slurm.partitions("short|up|30:00\nlong|up|infinite\nshort|up|30:00\n") == [SHORT, LONG]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "SLURM: no job in the queue"),
        ("RUNNING|None\n" * 2, "SLURM: 2 running, 0 pending"),
        (
            "RUNNING|None\nPENDING|Resources\nPENDING|Resources\n",
            "SLURM: 1 running, 2 pending: Resources (all nodes are in use: wait)",
        ),
        (
            "PENDING|ReqNodeNotAvail, UnavailableNodes:n1\n",
            "SLURM: 0 running, 1 pending: ReqNodeNotAvail, UnavailableNodes:n1 "
            "(nodes are down or reserved: wait, or set another slurm_partition)",
        ),
        (
            "PENDING|Licenses\nPENDING|Prolog\nPENDING|Prolog\n",
            "SLURM: 0 running, 3 pending: 2 Prolog, 1 Licenses",
        ),
    ],
)
def test_the_queue_in_a_line(text, said):
    assert str(slurm.queue(text)) == said


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (request(minutes=31), "Partition short allows 30 minutes, the jobs ask for 31."),
        (request(minutes=30), ""),
        (request("long", 1e6), ""),
        (request("hidden", 1e6), ""),
    ],
)
def test_a_request_that_would_never_start(asked, said):
    assert slurm.too_long(asked, [SHORT, LONG]) == said


SINFO = "echo 'short|up|30:00'"


def test_jobs_that_slurm_takes(commands):
    commands(sinfo=SINFO, sbatch='[ "$1 $2 $3" = "--test-only -p short" ]')
    slurm.check([request()])


def test_a_refusal_has_the_words_the_request_and_what_there_is(commands):
    commands(sinfo=SINFO, sbatch="echo 'sbatch: error: no such account' >&2; exit 1")
    with pytest.raises(ClusterError) as error:
        slurm.check([request()])
    assert str(error.value).splitlines()[:-1] == [
        "SLURM does not take the jobs:",
        "    sbatch: error: no such account",
        "  asked for: sbatch -p short",
        "  partitions: short (up, 30 min)",
    ]


def test_too_long_a_request_is_refused_although_sbatch_takes_it(commands):
    commands(sinfo=SINFO, sbatch="exit 0")
    with pytest.raises(ClusterError, match=r"allows 30 minutes, the jobs ask for 45\."):
        slurm.check([request(), request(minutes=45)])


def test_without_sbatch(commands):
    with pytest.raises(ClusterError, match="no command sbatch here"):
        slurm.check([request()])


def test_without_a_controller(commands):
    commands(sbatch="exit 0", sinfo="echo 'Unable to contact slurm controller' >&2; exit 1")
    with pytest.raises(ClusterError, match=r"does not answer:\n    Unable to contact"):
        slurm.check([request()])


def test_a_controller_that_never_answers(commands, monkeypatch):
    monkeypatch.setattr(slurm, "PATIENCE", 0.2)
    commands(sbatch="exit 0", sinfo=f"exec {shutil.which('sleep', path=os.defpath)} 9")
    start = time.monotonic()
    with pytest.raises(ClusterError, match=r"no answer to sinfo within 0\.2 s"):
        slurm.check([request()])
    assert time.monotonic() - start < 5
