"""What became of a run of Snakemake, and what is said of it at the end."""

import signal
import sys
from collections.abc import Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from pathlib import Path

from vibrissa.errors import TableError
from vibrissa.pipeline import jobs, repair
from vibrissa.pipeline.events import (
    Failed,
    Finished,
    Job,
    Planned,
    Problem,
    Progress,
    Queued,
    has_terminal,
)
from vibrissa.study.model import FIGURE_ENDINGS

# Percents between two progress lines, lines of a log, and jobs that are shown with their lines.
STEP, TAIL, IN_FULL = 5, 6, 3


@dataclass
class Outcome:
    """What became of a run of Snakemake."""

    planned: int | None = None  # number of jobs, once it is known
    # Last attempts at jobs that failed for good, by the numbers of the jobs.
    failed: dict[tuple[int, ...], Failed] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    since: float = 0  # when it was started, by the clock of the file system
    status: int = 0  # exit status, or the negative number of a signal
    interrupted: bool = False  # by Ctrl-C
    asked_to_end: bool = False  # by SIGTERM, which lets the running jobs finish
    slurm_run: str = ""  # name that the jobs share in SLURM, if they are there

    def watch(self, pipe: Connection, progress: bool) -> None:
        """Gather the events until Snakemake ends; print the progress, if asked to."""
        shown = 0
        # A Snakemake that is killed may leave half an event.
        with suppress(EOFError, OSError):
            while True:
                match event := pipe.recv():
                    case Planned(jobs=number):
                        self.planned = number
                    case Progress(done=done, total=total):
                        percent = 100 * done // total
                        if progress and (percent >= shown + STEP or done == total):
                            shown = percent
                            say(f"{done} of {total} steps ({percent}%) done")
                    case Failed():
                        self.failed[tuple(job.number for job in event.jobs)] = event
                    case Finished(number=number):
                        self.failed = {n: f for n, f in self.failed.items() if number not in n}
                    case Queued(run=name, text=text):
                        self.slurm_run = name
                        if progress:
                            say(text)
                    case Problem():
                        self.problems.append(event)

    @property
    def failures(self) -> list[Failed]:
        """Failures of single jobs; that of a group as a whole if none of its jobs recorded one."""
        found = []
        for failed in self.failed.values():
            alone = [replace(failed, jobs=[job]) for job in failed.jobs if records([job])]
            found += alone or [failed]
        return found

    @property
    def jobs(self) -> list[Job]:
        """Jobs that failed, with all jobs of a group of which none recorded a failure."""
        return [job for failed in self.failures for job in failed.jobs]


def say(text: str) -> None:
    """Print to stderr, where Snakemake writes too, so that the order on the screen is kept."""
    print(text, file=sys.stderr, flush=True)


def records(found: list[Job]) -> list[jobs.Failure]:
    """Return the records of those jobs that left one."""
    return [record for job in found for record in map(jobs.failure, job.log) if record]


def last_lines(logs: Iterable[str], since: float) -> list[str]:
    """Return the last lines of the first of some log files that has any since a time."""
    for path in map(Path, logs):
        if path.is_file() and path.stat().st_mtime >= since:
            lines = path.read_text(errors="replace").splitlines()
            if tail := [line for line in lines if line.strip()][-TAIL:]:
                return tail
    return []


def explain(failed: Failed, since: float = 0) -> str:
    """Return a short text about a failure: what, why, and where the logs are."""
    rules = ", ".join(job.rule for job in failed.jobs)
    output = ", ".join(path for job in failed.jobs for path in job.output)
    logs = [log for job in failed.jobs for log in job.log]
    # The log of a group says more than those of its jobs if none of these failed by itself.
    logs = [*failed.logs, *logs] if len(failed.jobs) > 1 else [*logs, *failed.logs]
    lines = [*last_lines(logs, since), *failed.reason.splitlines()]
    if failed.signal:
        lines.append(f"(ended by {signal.Signals(failed.signal).name})")
    return (
        f"FAILED: rule {rules}, making {output or '(no output)'}\n"
        + "".join(f"    {line}\n" for line in lines or ["(nothing in its log)"])
        + f"  log: {', '.join(logs) or '(the rule has no log file)'}"
    )


def report_failure(outcome: Outcome, folder: Path) -> None:
    """Say why a run failed and what to do."""
    met: list[jobs.Failure | Failed | Problem]
    met = [*records(outcome.jobs), *outcome.failed.values(), *outcome.problems]
    obstacles = repair.obstacles(folder, [error.errno for error in met])
    if texts := [explain(failed, outcome.since) for failed in outcome.failures]:
        say("")
        for text in texts[IN_FULL:]:
            say(text.splitlines()[0])
        say("\n".join(texts[:IN_FULL]))
    elif not has_terminal():  # on a terminal `rich` has shown them
        for problem in [p for p in outcome.problems if p.ours] or outcome.problems:
            # A full disk stops Snakemake anywhere; where, is of no use to the reader.
            if not (obstacles and problem.errno):
                say(problem.message)
    if outcome.status < 0:
        name = signal.Signals(-outcome.status).name
        say(
            f"Snakemake was ended by signal {-outcome.status} ({name}); the same command continues."
        )
    for obstacle in obstacles:
        say(obstacle)
    if any(problem.locked for problem in outcome.problems):
        say(
            "A Snakemake that was not started by this command is at work in this folder, or "
            f"was killed in it. If none is, 'rm -r {repair.LOCKS}' and run the same command "
            "again."
        )


def refined(folder: Path) -> str:
    """Return what the table of grid points says about `refine`; nothing if it had none."""
    table = folder / "tables/stiction.parquet"
    if not table.is_file():
        return ""
    # It imports pyarrow, which takes time.
    from vibrissa.tables import store

    with suppress(TableError):  # a file that cannot be opened
        return store.said(table, store.REFINED)
    return ""


def report_results(outcome: Outcome, folder: Path, made: Collection[str]) -> None:
    """Say where the results are, and which files are not `made` by the study; all are if empty."""
    if outcome.planned == 0:
        say("Nothing to do: all results are up to date.")
    if text := refined(folder):
        say(f"{text} (for each line: {folder}/logs/points)")
    figures = folder / "figures"
    endings: dict[str, list[str]] = {}
    for path in sorted(figures.glob("[!.]*.*")):
        if path.suffix[1:] in FIGURE_ENDINGS and (not made or f"figures/{path.name}" in made):
            endings.setdefault(path.stem, []).append(path.suffix)
    say(f"Figures in {figures}:" if endings else f"No figures in {figures}.")
    for name, suffixes in endings.items():
        say(f"  {figures / name} {' '.join(suffixes)}")
    claims = folder / "claims.md"
    if claims.is_file() and (not made or claims.name in made):
        # The counts of verdicts are the first sentence under the title.
        counts, _, _ = claims.read_text(encoding="utf-8").splitlines()[2].partition(". ")
        say(f"{counts} ({claims})")
    report = folder / "report.html"
    if report.is_file():
        say(f"All on one page: {report}")
    if made and (others := repair.others(folder, made)):
        say(others)
