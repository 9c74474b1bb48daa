"""What happens in a run of Snakemake, as types, and the logger plugin that sends it to `run`."""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from subprocess import CalledProcessError
from typing import Any

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent
from snakemake_interface_logger_plugins.settings import LogHandlerSettingsBase

from vibrissa.errors import VibrissaError


@dataclass(frozen=True, kw_only=True)
class Planned:
    """So many jobs are to be done."""

    jobs: int


@dataclass(frozen=True, kw_only=True)
class Progress:
    """So many of all jobs are done."""

    done: int
    total: int


@dataclass(frozen=True, kw_only=True)
class Finished:
    """The job of this number is done; an earlier attempt may have failed."""

    number: int


@dataclass(frozen=True, kw_only=True)
class Job:
    """A job with its number in Snakemake, its rule, and its files."""

    number: int
    rule: str
    output: list[str]
    log: list[str]


@dataclass(frozen=True, kw_only=True)
class Failed:
    """An attempt at a job failed, or at a group of jobs, of which some may be done."""

    jobs: list[Job]
    logs: list[str] = field(default_factory=list)  # of the group
    reason: str = ""  # what the scheduler of a cluster says
    signal: int | None = None  # that ended the job on this machine
    errno: int | None = None  # of the operating system's error that Snakemake met


@dataclass(frozen=True, kw_only=True)
class Queued:
    """What SLURM does with the run's jobs."""

    run: str  # the name that the jobs share in SLURM
    text: str


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Snakemake warns or stops."""

    message: str
    ours: bool = False  # one of our own errors, whose message says all
    locked: bool = False  # another Snakemake holds the folder
    errno: int | None = None


Event = Planned | Progress | Finished | Failed | Queued | Problem


def has_terminal() -> bool:
    """Whether the logger `rich` can draw on the screen."""
    return sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"


def note_exception(record: logging.LogRecord) -> bool:
    """Add the exception that is being handled to a record, in the thread where it is logged."""
    record.handled = sys.exception()
    return True


def event_of(record: logging.LogRecord) -> Event | None:
    """Return the event that a record of Snakemake's logger stands for, if any.

    Parameters
    ----------
    record : LogRecord
        With the exception that `note_exception` added.

    Returns
    -------
    Event or None
    """
    # Snakemake takes a second to load, and only the process that it runs in calls this function.
    from snakemake.exceptions import LockException

    fields: dict[str, Any] = vars(record)
    errors = list(_chain(fields.get("handled")))
    errno = next((error.errno for error in errors if isinstance(error, OSError)), None)
    match fields.get("event"):
        case LogEvent.WORKFLOW_STARTED:
            return Planned(jobs=0)
        case LogEvent.RUN_INFO:
            return Planned(jobs=fields["stats"]["total"])
        case LogEvent.PROGRESS:
            return Progress(done=fields["done"], total=fields["total"])
        case LogEvent.JOB_FINISHED:
            return Finished(number=fields["job_id"])
        case LogEvent.GROUP_ERROR:
            jobs = [_job(job) for job in fields["job_error_info"]]
            # Snakemake drops the scheduler's words if it refuses a group.
            reason = _words(errors)
            return Failed(jobs=jobs, logs=fields["aux_logs"], reason=reason, errno=errno)
        # After the error of a group comes one for each of its jobs, with an indent.
        case LogEvent.JOB_ERROR if not fields["indent"]:
            ends = (error.returncode for error in errors if isinstance(error, CalledProcessError))
            signal = next((-end for end in ends if end < 0), None)
            reason = _words(errors) or fields["rule_msg"] or ""
            return Failed(jobs=[_job(fields)], reason=reason, signal=signal, errno=errno)
        case None if "slurm_run" in fields:
            return Queued(run=fields["slurm_run"], text=record.getMessage())
        case LogEvent.ERROR | None if record.levelno >= logging.WARNING:
            ours = any(isinstance(error, VibrissaError) for error in errors)
            locked = any(isinstance(error, LockException) for error in errors)
            # The reader of our own errors does not need their places in the workflow's code.
            message = str(errors[0]) if ours else record.getMessage()
            return Problem(message=message, ours=ours, locked=locked, errno=errno)
    return None


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an exception and those that led to it."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _words(errors: list[BaseException]) -> str:
    """Return what the command said that failed; nothing if it was not listened to."""
    outputs = (error.output for error in errors if isinstance(error, CalledProcessError))
    output = next(filter(None, outputs), "")
    return (output.decode(errors="replace") if isinstance(output, bytes) else output).strip()


def _job(fields: dict[str, Any]) -> Job:
    return Job(
        number=fields["jobid"], rule=fields["rule_name"], output=fields["output"], log=fields["log"]
    )


@dataclass
class LogHandlerSettings(LogHandlerSettingsBase):
    """Arguments of the plugin on Snakemake's command line."""

    pipe: int = field(default=-1, metadata={"help": "File descriptor to send events to."})


class LogHandler(LogHandlerBase):
    """The logger plugin, which sends events to `run`."""

    settings: LogHandlerSettings
    writes_to_file = False
    has_filter = True
    has_formatter = True
    needs_rulegraph = False

    @property
    def writes_to_stream(self) -> bool:
        """Whether Snakemake shall not write to the screen: without a terminal `run` says enough."""
        return not (has_terminal() or self.common_settings.dryrun)

    def __post_init__(self) -> None:
        """Open the pipe."""
        self.connection = Connection(self.settings.pipe, readable=False)

    def emit(self, record: logging.LogRecord) -> None:
        """Send the event of a record; if `run` was killed, the workflow goes on."""
        if (event := event_of(record)) is not None:
            with suppress(OSError):
                self.connection.send(event)
