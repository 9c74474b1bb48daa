"""Run a study with Snakemake for a person (or a CI log) to watch; `workflow/run.py` is the command.

It checks the study file, removes the lock of a killed run, and prints what came out and where.
"""

import argparse
import fcntl
import os
import shlex
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import IO

from vibrissa.errors import StudyError
from vibrissa.files import TEMPORARY
from vibrissa.pipeline import places
from vibrissa.study.chunks import number_of_points
from vibrissa.study.model import Study
from vibrissa.study.reading import read_study
from vibrissa.wording import counted

SNAKEMAKE = [sys.executable, "-m", "vibrissa.pipeline"]
# Options of Snakemake that run no job.
ONLY_SHOWS = {"-n", "--dry-run", "--dryrun", "-h", "--help", "--version", "-v", "--touch", "-t"}
# Bytes. A full disk has a little room again once the files of a failed job are removed.
LEAST_SPACE = 1024**2
# Seconds until an answer of SLURM is given up.
PATIENCE = 20


def show(text: str) -> None:
    """Print to stderr, where Snakemake writes too, so that the order on the screen is kept."""
    print(text, file=sys.stderr, flush=True)


def find_profile(name: str) -> Path:
    """Find a profile by its path, or by its name."""
    for path in (Path(name), places.PROFILES / name):
        if path.is_dir():
            return path.absolute()
    there = ", ".join(path.name for path in sorted(places.PROFILES.glob("*")))
    sys.exit(f"No such profile: {name}; there are: {there}")


def parsed(arguments: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """Parse and complete Snakemake's arguments.

    Enters the folder of the option --directory.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", default=places.PAPER, type=Path)
    parser.add_argument("--config", "-C", nargs="+", default=[])
    parser.add_argument("--workflow-profile", default="default", type=find_profile)
    parser.add_argument("--directory", "-d", type=Path)
    known, others = parser.parse_known_args(arguments)
    study_file = known.configfile.absolute()
    if known.directory:
        known.directory.mkdir(parents=True, exist_ok=True)
        os.chdir(known.directory)
    known.configfile = places.near(study_file)
    return known, [
        *("--configfile", str(known.configfile)),
        *(["--config", *known.config] if known.config else []),
        *("--snakefile", str(places.near(places.SNAKEFILE))),
        *("--workflow-profile", str(places.near(known.workflow_profile))),
        *others,
    ]


def checked_study(path: Path, changes: list[str]) -> Study:
    """Read the study file, or exit with all its errors; `changes` are the values of --config."""
    import yaml

    pairs = (change.partition("=") for change in changes)
    try:
        return read_study(path, {key: yaml.safe_load(value) for key, _, value in pairs})
    except StudyError as error:
        sys.exit("\n".join(error.mistakes))


def need_slurm(profile: Path) -> None:
    """Exit with a message if a SLURM profile is used without SLURM."""
    config = profile / "config.yaml"
    if not config.is_file() or "executor: slurm" not in config.read_text(encoding="utf-8"):
        return
    try:
        command = ["sinfo", "--noheader"]
        subprocess.run(command, capture_output=True, check=True, timeout=PATIENCE, text=True)
    except FileNotFoundError:
        sys.exit(
            f"There is no command sinfo here: the profile {profile.name} is for a login node of a "
            "SLURM cluster. Without the profile, the study runs on this machine."
        )
    except (subprocess.SubprocessError, OSError) as error:
        words = getattr(error, "stderr", None) or str(error)
        sys.exit(f"SLURM does not answer (sinfo): {words.strip()}; when it does, run this again.")


def take_folder() -> tuple[IO[str], bool]:
    """Take the working directory for this run, and find out whether the last one was killed.

    The kernel drops a `flock` when its holder dies: a killed run leaves text that nobody holds.
    """
    path = Path(".snakemake/run.lock")
    path.parent.mkdir(exist_ok=True)
    lock = path.open("a+", encoding="utf-8")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(
            "Another run is active in this folder. Wait for it or stop it; or run this study in "
            "another folder: --directory other"
        )
    lock.seek(0)
    was_killed = bool(lock.read())
    lock.write("running\n")
    lock.flush()
    os.fsync(lock.fileno())
    return lock, was_killed


def run_snakemake(arguments: list[str], lock: IO[str]) -> tuple[int, signal.Signals | None]:
    """Run Snakemake to its end; return its status, and the signal that ended it early."""
    stopped: list[signal.Signals] = []
    # With a session of its own it gets each signal once. If this process is killed, the running
    # Snakemake keeps the lock.
    child = subprocess.Popen(
        [*SNAKEMAKE, *arguments],
        stdin=subprocess.DEVNULL,
        pass_fds=[lock.fileno()],
        start_new_session=True,
    )

    def stop(number: int, frame: FrameType | None) -> None:
        # Snakemake takes its jobs out of a cluster's queue at SIGINT, and waits for those that run
        # here: SIGTERM ends them, and a Snakemake that is still loading, without a word.
        stopped.append(signal.Signals(number))
        with suppress(ProcessLookupError):
            child.send_signal(signal.SIGINT)
            os.killpg(child.pid, signal.SIGTERM)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    status = child.wait()
    return status, stopped[0] if stopped else None


def report(study: Study, folder: Path) -> None:
    """Print the counts by status, and where the results are."""
    if (path := folder / "summary.txt").is_file():
        show(path.read_text(encoding="utf-8").rstrip())
    if study.claims and (path := folder / "claims.md").is_file():
        # The counts of verdicts are the first sentence under the title.
        show(path.read_text(encoding="utf-8").splitlines()[2].partition(". ")[0])
    made = {folder / name for name in study.results}
    there = {*folder.glob("tables/[!.]*"), *folder.glob("figures/[!.]*")}
    if others := sorted(path.name for path in there - made):
        more = ", ..." if len(others) > 3 else ""
        show(f"Left over from an earlier study file, in {folder}: {', '.join(others[:3])}{more}")
    if study.figures:
        show(f"Figures: {folder / 'figures'}")
    show(f"Report: {folder / 'report.html'}")


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    known, arguments = parsed(arguments)
    if ONLY_SHOWS.intersection(arguments):
        return subprocess.run([*SNAKEMAKE, *arguments], check=False).returncode
    study = checked_study(known.configfile, known.config)
    need_slurm(known.workflow_profile)
    folder = Path("results", study.name)
    try:
        lock, was_killed = take_folder()
    except OSError as error:
        sys.exit(f"The run cannot start: {error}")
    if was_killed:
        show("The last run was interrupted. Its finished results are kept; this run continues it.")
        command = [*SNAKEMAKE, *arguments, "--unlock", "--quiet", "all"]
        subprocess.run(command, check=False, stdin=subprocess.DEVNULL)
    for path in folder.rglob(TEMPORARY):  # of jobs that were ended by a signal
        path.unlink(missing_ok=True)
    points = sum(number_of_points(grid.axes) for grid in study.grids.values())
    show(f"Study '{study.name}', {points:,} points in {counted(len(study.chunks), 'chunk')}:")
    show(f"  {shlex.join(['snakemake', *arguments])}")
    # The logger `rich` draws on the screen.
    if sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb":
        arguments = [*arguments, "--logger", "rich"]
    status, stopped = run_snakemake(arguments, lock)
    if status >= 0:  # a Snakemake that was killed leaves its lock
        lock.truncate(0)
    if stopped is not None:
        show(f"\nStopped by {stopped.name}. Finished results are kept: the same command continues.")
        return 128 + stopped
    if not status:
        report(study, folder)
        return 0
    if status < 0:
        show(f"Snakemake was ended by {signal.Signals(-status).name}; the same command continues.")
    if shutil.disk_usage(Path.cwd()).free < LEAST_SPACE:
        show("The disk is full; make space and run the same command again.")
    elif status > 0:
        show(f"The study is not complete; {folder / 'logs'} says why. The same command continues.")
    return abs(status)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
