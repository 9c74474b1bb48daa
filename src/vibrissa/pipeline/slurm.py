"""What SLURM says to a run: whether it takes the jobs, and then what they wait for.

Snakemake's plugin submits the jobs and asks for their states. It says nothing of what a job
waits for, and little of why SLURM refuses one. The Snakefile calls `watch` before the first job.
"""

import math
import shlex
import shutil
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from vibrissa.errors import ClusterError

if TYPE_CHECKING:
    from snakemake.workflow import Workflow

# Seconds until an answer of SLURM is given up, until the queue is first looked at, and between two
# looks.
PATIENCE, FIRST_LOOK, EVERY = 20, 10, 20
# The comment of a job, after which in sbatch's command stands what the job asks for.
MARK = "asks-for"

# What to do about SLURM's reasons for a job to wait; about any other, SLURM's manual says more
# (`man squeue`, under JOB REASON CODES).
REMEDIES = {
    "AccountNotAllowed": "the partition does not take this account: set another of the two",
    "BadConstraints": "no node has what the jobs ask for: lower mem_mb, or change the constraint",
    "InvalidAccount": "set slurm_account",
    "InvalidQOS": "set qos",
    "JobHeldAdmin": "an administrator holds the jobs: ask why",
    "JobHeldUser": "the jobs are held: scontrol release",
    "PartitionDown": "the partition is closed: wait, or set another slurm_partition",
    "PartitionInactive": "the partition is closed: wait, or set another slurm_partition",
    "PartitionTimeLimit": "the partition allows less time: lower block_size or runtime, or set "
    "another slurm_partition",
    "Priority": "jobs of others come first: wait",
    "QOSNotAllowed": "the partition does not take this qos: set another of the two",
    "ReqNodeNotAvail": "nodes are down or reserved: wait, or set another slurm_partition",
    "Resources": "all nodes are in use: wait",
}
SETTINGS = (
    "Set slurm_partition, slurm_account, runtime, mem_mb or block_size as docs/cluster.md says, "
    "and run the same command again."
)


@dataclass(frozen=True, kw_only=True)
class Partition:
    """A partition of the cluster; without a limit of time its minutes are infinite."""

    name: str
    state: str
    minutes: float


@dataclass(frozen=True, kw_only=True)
class Request:
    """What jobs ask SLURM for."""

    options: tuple[str, ...]  # of sbatch
    partition: str | None  # None: SLURM's default
    minutes: float


@dataclass(frozen=True, kw_only=True)
class Queue:
    """What SLURM has of the jobs of a run."""

    running: int = 0
    pending: Counter[str] = field(default_factory=Counter)  # by SLURM's reason

    def __str__(self) -> str:
        """Return a line for the screen."""
        if not (self.running or self.pending):
            return "SLURM: no job in the queue"
        text = f"SLURM: {self.running} running, {self.pending.total()} pending"
        if not self.pending:
            return text
        one = len(self.pending) == 1
        reasons = (f"{'' if one else f'{n} '}{r}" for r, n in self.pending.most_common())
        # After the reason itself may stand the names of nodes.
        codes = dict.fromkeys(reason.partition(",")[0] for reason in self.pending)
        remedies = [REMEDIES[code] for code in codes if code in REMEDIES]
        return f"{text}: {', '.join(reasons)}" + "".join(f" ({text})" for text in remedies)


def minutes(text: str) -> float:
    """Return a time of SLURM's, such as 1-12:00:00 or 30:00, in minutes.

    Parameters
    ----------
    text : str
        [[days-]hours:]minutes:seconds, or a word, as `infinite`, where there is no limit.

    Returns
    -------
    float
        Infinite where there is no limit.
    """
    days, _, clock = text.rpartition("-")
    parts = clock.split(":")
    if not all(part.isdecimal() for part in parts):
        return math.inf
    hours, mins, seconds = [0, 0, *map(int, parts)][-3:]
    return (int(days or 0) * 24 + hours) * 60 + mins + seconds / 60


def partitions(text: str) -> list[Partition]:
    """Return the partitions that `sinfo -h -o '%R|%a|%l'` prints."""
    rows = (line.split("|") for line in text.splitlines())
    # A line for each kind of nodes, so that a name may come twice.
    found = {row[0]: Partition(name=row[0], state=row[1], minutes=minutes(row[2])) for row in rows}
    return list(found.values())


def queue(text: str) -> Queue:
    """Return the queue that `squeue -h -o '%T|%r'` prints."""
    rows = [line.split("|", 1) for line in text.splitlines()]
    pending = Counter(reason for state, reason in rows if state == "PENDING")
    return Queue(running=len(rows) - pending.total(), pending=pending)


def too_long(request: Request, offered: Iterable[Partition]) -> str:
    """Tell by how much a request is longer than its partition allows; nothing if it is not.

    Most clusters would take the job and never start it.
    """
    for partition in offered:
        if partition.name == request.partition and request.minutes > partition.minutes:
            return (
                f"Partition {partition.name} allows {partition.minutes:g} minutes, "
                f"the jobs ask for {request.minutes:g}."
            )
    return ""


def refusal(words: str, request: Request, offered: Iterable[Partition]) -> str:
    """Return a text about a refused request: SLURM's words, what was asked, what there is."""
    there = (
        f"{partition.name} ({partition.state}, "
        + ("no limit of time)" if math.isinf(partition.minutes) else f"{partition.minutes:g} min)")
        for partition in offered
    )
    return (
        f"SLURM does not take the jobs:\n{_indented(words)}"
        f"  asked for: sbatch {shlex.join(request.options)}\n"
        f"  partitions: {', '.join(there)}\n{SETTINGS}"
    )


def _indented(words: str) -> str:
    return "".join(f"    {line}\n" for line in words.splitlines())


def ask(*command: str) -> str:
    """Return what a command of SLURM prints.

    Raises
    ------
    ClusterError
        With the command's words, if it fails or does not end.
    """
    try:
        result = subprocess.run(
            command, capture_output=True, text=True, timeout=PATIENCE, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        raise ClusterError(f"no answer to {command[0]} within {PATIENCE} s") from None
    except OSError as error:
        raise ClusterError(f"{command[0]}: {error.strerror}") from None
    if result.returncode:
        raise ClusterError((result.stderr + result.stdout).strip() or f"{command[0]} failed")
    return result.stdout


def check(requests: Iterable[Request]) -> None:
    """Ask SLURM whether it would take some jobs.

    Parameters
    ----------
    requests : iterable of Request
        Read only once SLURM has answered.

    Raises
    ------
    ClusterError
        If it would not, or does not answer.
    """
    if shutil.which("sbatch") is None:
        raise ClusterError(
            "There is no command sbatch here: this profile is for a login node of a SLURM cluster. "
            "Without the profile, the study runs on this machine."
        )
    try:
        offered = partitions(ask("sinfo", "-h", "-o", "%R|%a|%l"))
    except ClusterError as error:
        raise ClusterError(
            f"SLURM does not answer:\n    {error}\nTry 'sinfo' yourself; when it answers, "
            "run the same command again."
        ) from None
    for request in dict.fromkeys(requests):
        if words := too_long(request, offered):
            raise ClusterError(refusal(words, request, offered))
        try:
            ask("sbatch", "--test-only", *request.options, "--wrap", "true")
        except ClusterError as error:
            raise ClusterError(refusal(str(error), request, offered)) from None


def cancel(run: str) -> None:
    """Cancel what is left of a run's jobs; without SLURM's answer they stay."""
    ask("scancel", "--me", f"--name={run}")


def watch(workflow: "Workflow") -> None:
    """Check that SLURM takes the jobs of a workflow, and from then on say what they wait for.

    Parameters
    ----------
    workflow : snakemake.workflow.Workflow
        About to start its first job, by the executor `slurm`.

    Raises
    ------
    ClusterError
        If SLURM would refuse a job, or does not answer.
    """
    dag = workflow.dag
    remote = [job for job in dag.needrun_jobs() if not job.is_local]
    if not remote:
        return
    executor = workflow.scheduler.get_executor(remote[0])
    jobs = {dag.get_job_group(job) or job for job in remote}
    check(_request(executor, job) for job in jobs)
    _say("SLURM takes the jobs.", executor.run_uuid)
    threading.Thread(target=_report, args=[executor.run_uuid], daemon=True).start()


def _request(executor: Any, job: Any) -> Request:
    """Return what the plugin would ask SLURM for."""
    from snakemake_executor_plugin_slurm.submit_string import get_submit_command
    from snakemake_interface_common.exceptions import WorkflowError

    try:
        partition = executor.get_partition_arg(job)
        params = {
            "run_uuid": executor.run_uuid,
            "slurm_logfile": "",
            "comment_str": MARK,
            "account": next(executor.get_account_arg(job)),
            "partition": partition,
            "workdir": None,
        }
        command = get_submit_command(job, params, settings=executor.workflow.executor_settings)
    except (WorkflowError, OSError) as error:
        # It looks itself whether there is the account.
        raise ClusterError(
            f"The plugin for SLURM cannot submit jobs:\n{_indented(str(error))}{SETTINGS}"
        ) from None
    return Request(
        # What stands before concerns names and logs.
        options=tuple(shlex.split(command.partition(MARK)[2])),
        partition=shlex.split(partition)[1] if partition else None,
        minutes=float(job.resources.get("runtime", 0)),
    )


def _report(run: str) -> None:
    """Say what a run's jobs wait for, whenever that has changed."""
    said = ""
    time.sleep(FIRST_LOOK)
    while True:
        try:
            text = str(queue(ask("squeue", "-h", "--me", f"--name={run}", "-o", "%T|%r")))
        except ClusterError as error:
            text = f"SLURM does not answer, and is asked again: {error}"
        if text != said:
            said = text
            _say(text, run)
        time.sleep(EVERY)


def _say(text: str, run: str) -> None:
    """Log a line for the screen, with the name that the run's jobs share in SLURM."""
    # Snakemake takes a second to load, and only the process that it runs in calls this function.
    from snakemake.logging import logger

    logger.info(text, extra={"slurm_run": run})
