"""Run the Snakemake workflow for a person (or CI log) to watch; `workflow/run.py` is the command.

On a terminal Snakemake's logger `rich` draws progress bars. This module does what neither that
logger nor Snakemake's `onsuccess` and `onerror` can do (`onsuccess` is skipped if there is nothing
to do, and Snakemake writes further lines after `onerror`):

* It ends with what counts: why jobs failed and where their logs are; or the figures, how many of
  the paper's statements hold, and the path of the report.
* Without a terminal it prints a line of progress every few percent.
* It removes the lock of a run that was killed.
* It removes damaged files and makes them anew, so that the same command heals a study.
"""

import argparse
import fcntl
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Timer
from typing import IO

from vibrissa.errors import ClusterError, StudyError, TableError
from vibrissa.pipeline import jobs, places, repair, slurm
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
from vibrissa.study.reading import as_text_says, read_study, read_yaml

SNAKEMAKE = [sys.executable, "-m", "vibrissa.pipeline"]
SNAKEMAKE_LOCKS = Path(".snakemake/locks")
# As `vibrissa.study.values.Name` has it; a run need not wait for pydantic.
STUDY_NAME = "[A-Za-z0-9][A-Za-z0-9_-]{0,99}"
# Rules that read the study file, but for curves: blocks of these are named by what they hold. What
# depends on them follows.
REREAD = ("points", "scan", "states", "comparisons", "captions")
# Percents between two progress lines, lines of a log, and jobs that are shown with their lines.
STEP, TAIL, IN_FULL = 5, 6, 3
# Seconds until an interrupted Snakemake that has jobs on a cluster is killed: it may wait for
# minutes before it looks after them.
GRACE = 10
SHOW_CURSOR = "\033[?25h"


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


def study_of(
    configfiles: list[str], changes: list[str] | None = None, is_study: bool = True
) -> tuple[str, list[str]]:
    """Return the study's name and `Study.results`, or end with all mistakes of its file.

    A study file given takes the place of config.yaml; `changes` are what stands after --config.
    A workflow of which this is a module has a file of its own: `is_study` is false, and its results
    are not known.
    """
    paths = [Path(path) for path in configfiles or [str(places.PAPER)]]
    try:
        config = read_yaml(paths[0]).config
        for key, equals, value in (change.partition("=") for change in changes or ()):
            if equals:
                config[key] = as_text_says(value)
        if not is_study:
            return str(config.get("study")), []
        study = read_study(paths, config)
        return study.name, study.results
    except StudyError as error:
        sys.exit("\n".join(error.mistakes))


def find_profile(name: str) -> Path:
    """Find a profile by its path, also as seen from the workflow, or by its name."""
    if name == "none":  # Snakemake's word for no profile
        return Path(name)
    for path in (Path(name), places.HOME / name, places.PROFILES / name):
        if path.is_dir():
            return path.absolute()
    there = ", ".join(path.name for path in sorted(places.PROFILES.glob("*")))
    sys.exit(f"No such profile: {name}; there are: {there}")


def acquire_lock() -> IO[str]:
    """Take the working directory for this run and clear the lock of a run that was killed.

    The kernel drops a `flock` when its holder dies, so text in a file that nobody holds means
    that the last run did not come to its end. Only then is Snakemake's own lock removed; the lock
    of a Snakemake that somebody started directly stays respected.
    """
    path = Path(".snakemake/run.lock")
    path.parent.mkdir(exist_ok=True)
    handle = path.open("a+", encoding="utf-8")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit("Another run of this workflow is active in this folder; wait for it or stop it.")
    os.utime(path)
    handle.seek(0)
    if handle.read():
        say("The last run was killed; its finished results are kept and it is continued.")
        shutil.rmtree(SNAKEMAKE_LOCKS, ignore_errors=True)
    else:
        handle.write("running\n")
        handle.flush()
        os.fsync(handle.fileno())
    return handle


def remove_damaged(paths: Iterable[Path], removed: set[Path]) -> bool:
    """Remove damaged files, so that they are made anew; return whether there were any."""
    before = len(removed)
    for path in paths:
        # A file that is damaged again was not made well: a person has to look at it.
        if path.is_file() and path not in removed:
            try:
                path.unlink()
            except OSError as error:
                say(f"{path} is damaged, and cannot be removed ({error.strerror}).")
                continue
            removed.add(path)
            # Snakemake does without a block as long as nothing that needs it is to be made.
            say(f"{path} is damaged or does not belong there: removed, made anew where needed.")
    return len(removed) > before


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


def run_snakemake(arguments: list[str], lock: IO[str]) -> Outcome:
    """Run Snakemake to its end."""
    outcome = Outcome(since=os.fstat(lock.fileno()).st_mtime)
    terminal = has_terminal()
    receiver, sender = Pipe(duplex=False)
    loggers = ["--logger", "vibrissa", *(["rich"] if terminal else [])]
    child = subprocess.Popen(
        [*SNAKEMAKE, *arguments, *loggers, "--logger-vibrissa-pipe", str(sender.fileno())],
        stdin=subprocess.DEVNULL,
        # If this process is killed, the running Snakemake keeps the lock.
        pass_fds=[lock.fileno(), sender.fileno()],
    )

    def stop(number: int, frame: object) -> None:
        # Ctrl-C reaches Snakemake, too, which then ends its jobs.
        by_hand = number == signal.SIGINT
        if outcome.slurm_run and not outcome.interrupted:
            # At SIGTERM Snakemake would wait for all jobs in the queue.
            if not by_hand:
                child.send_signal(signal.SIGINT)
            timer = Timer(GRACE, child.kill)
            timer.daemon = True
            timer.start()
        elif not (by_hand or outcome.slurm_run):
            child.send_signal(number)
        outcome.interrupted |= by_hand or bool(outcome.slurm_run)

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    sender.close()
    outcome.watch(receiver, progress=not terminal)
    outcome.status = child.wait()
    if outcome.slurm_run and (outcome.interrupted or outcome.status < 0):
        cancel(outcome.slurm_run)
    if terminal and outcome.status < 0:
        print(SHOW_CURSOR, end="", file=sys.stderr)
    return outcome


def cancel(slurm_run: str) -> None:
    """Cancel the jobs that an interrupted or killed Snakemake left in SLURM's queue."""
    try:
        slurm.cancel(slurm_run)
    except ClusterError as error:
        say(f"Jobs may be left in the queue: scancel --name={slurm_run} ends them. ({error})")


def run_and_heal(arguments: list[str], folder: Path, removed: set[Path], lock: IO[str]) -> Outcome:
    """Run Snakemake, and again if a job met a damaged table, other than those that were removed."""
    again: list[str] = []
    while True:
        outcome = run_snakemake([*arguments, *again], lock)
        found = records(outcome.jobs)
        named = [Path(record.damaged) for record in found if record.damaged]
        named = [path for path in named if path.is_relative_to(folder)]
        # If one table is damaged, others may be, too: now it is worth the time to read them all.
        suspects = sorted(folder.glob("*/**/[!.]*.parquet")) if named else []
        if outcome.interrupted or not remove_damaged([*named, *repair.damaged(suspects)], removed):
            return outcome
        say("Running again.")
        # The output of a failed job is gone, and Snakemake may think that nothing needs it.
        again = ["--forcerun", *(path for job in outcome.jobs for path in job.output)]


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
            f"was killed in it. If none is, 'rm -r {SNAKEMAKE_LOCKS}' and run the same command "
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


def parsed(arguments: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """Take from Snakemake's arguments what a run needs to know, and complete them.

    Enters the folder of the option --directory.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", default=[])
    parser.add_argument("--config", "-C", nargs="+", default=[])
    parser.add_argument("--workflow-profile", default="default")
    parser.add_argument("--snakefile", "-s", default=places.SNAKEFILE, type=Path)
    parser.add_argument("--directory", "-d", type=Path)
    known, others = parser.parse_known_args(arguments)
    profile = find_profile(known.workflow_profile)
    if known.directory:
        known.configfile = [str(Path(path).absolute()) for path in known.configfile]
        known.snakefile = known.snakefile.absolute()
        known.directory.mkdir(parents=True, exist_ok=True)
        os.chdir(known.directory)
    arguments = [
        *(["--configfile", *known.configfile] if known.configfile else []),
        *(["--config", *known.config] if known.config else []),
        *("--snakefile", str(places.near(known.snakefile))),
        *("--workflow-profile", str(places.near(profile))),
        *others,
    ]
    return known, arguments


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    known, arguments = parsed(arguments)
    is_study = known.snakefile.resolve() in (places.SNAKEFILE, places.HOME / "workflow/Snakefile")
    study, made = study_of(known.configfile, known.config, is_study)
    folder = Path("results", study)
    # The workflow refuses any other name, and its folder is not to be changed.
    named_well = re.fullmatch(STUDY_NAME, study) is not None
    if named_well and (problem := repair.misplaced(folder)):
        sys.exit(problem)
    try:
        lock = acquire_lock()
    except OSError as error:
        obstacles = repair.obstacles(folder, [error.errno])
        sys.exit("\n".join([f"The run cannot start: {error}", *obstacles]))
    removed: set[Path] = set()
    if named_well and not {"-n", "--dry-run", "--dryrun"}.intersection(arguments):
        repair.remove_leftovers(folder)
        remove_damaged(repair.cut_short(folder), removed)
    if is_study and (path := repair.without_record(folder)):
        say(
            f"Nothing here says how {path} was made: all but the curves is made anew, to be of the "
            "study file as it is. (docs/cluster.md says how results of another machine are used.)"
        )
        arguments = ["--forcerun", *REREAD, *arguments]
    say(f"Study '{study}': {shlex.join(['snakemake', *arguments])}")
    outcome = run_and_heal(arguments, folder, removed, lock)
    # A killed Snakemake leaves its own lock, which the next run removes if nobody does it here.
    if outcome.status < 0 and outcome.interrupted:
        shutil.rmtree(SNAKEMAKE_LOCKS, ignore_errors=True)
    if outcome.status >= 0 or outcome.interrupted:
        lock.truncate(0)
    if outcome.interrupted:
        say("\nInterrupted. Finished results are kept: the same command continues from here.")
        return 128 + signal.SIGINT
    if outcome.status:
        report_failure(outcome, folder)
        return outcome.status if outcome.status > 0 else 128 - outcome.status
    report_results(outcome, folder, made)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
