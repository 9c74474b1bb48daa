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
from collections.abc import Iterable
from multiprocessing import Pipe
from pathlib import Path
from threading import Timer
from typing import IO

from vibrissa.errors import ClusterError, StudyError
from vibrissa.pipeline import places, repair, slurm
from vibrissa.pipeline.ending import Outcome, records, report_failure, report_results, say
from vibrissa.pipeline.events import has_terminal
from vibrissa.study.reading import as_text_says, read_study, read_yaml

SNAKEMAKE = [sys.executable, "-m", "vibrissa.pipeline"]
# As `vibrissa.study.values.Name` has it; a run need not wait for pydantic.
STUDY_NAME = "[A-Za-z0-9][A-Za-z0-9_-]{0,99}"
# Rules that read the study file, but for curves: blocks of these are named by what they hold. What
# depends on them follows.
REREAD = ("points", "scan", "states", "comparisons", "captions")
# Seconds until an interrupted Snakemake that has jobs on a cluster is killed: it may wait for
# minutes before it looks after them.
GRACE = 10
SHOW_CURSOR = "\033[?25h"


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
        shutil.rmtree(repair.LOCKS, ignore_errors=True)
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
            outcome.asked_to_end = True
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
        over = outcome.interrupted or outcome.asked_to_end
        if over or not remove_damaged([*named, *repair.damaged(suspects)], removed):
            return outcome
        say("Running again.")
        # The output of a failed job is gone, and Snakemake may think that nothing needs it.
        again = ["--forcerun", *(path for job in outcome.jobs for path in job.output)]


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
        shutil.rmtree(repair.LOCKS, ignore_errors=True)
    if outcome.status >= 0 or outcome.interrupted:
        lock.truncate(0)
    if outcome.interrupted:
        say("\nInterrupted. Finished results are kept: the same command continues from here.")
        return 128 + signal.SIGINT
    if outcome.status:
        if outcome.asked_to_end and not outcome.failed:
            say(
                "Ended as asked, by SIGTERM. Finished results are kept: the same command continues."
            )
        else:
            report_failure(outcome, folder)
        return outcome.status if outcome.status > 0 else 128 - outcome.status
    report_results(outcome, folder, made)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
