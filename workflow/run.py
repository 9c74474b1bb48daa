"""Run the Snakemake workflow for a person (or CI log) to watch; used by the Makefile.

Usage: python workflow/run.py [--configfile FILE] [--workflow-profile FOLDER]
                              [any other Snakemake arguments]

Snakemake's `rich` logger draws the progress bars. This wrapper adds what neither that logger nor
Snakemake's `onsuccess`/`onerror` can do (`onsuccess` is skipped when there is nothing to do, and
Snakemake writes further lines after `onerror`):

* the failed job's message and log path, or the figures, what became of the paper's statements and
  where the report is, are the *last* thing on the screen;
* without a terminal (where `rich` stays silent) a progress line is printed every few percent;
* a run that was killed outright does not leave the working directory locked;
* files that were damaged are removed and made anew, so that the same command heals a study.
"""

from __future__ import annotations

import argparse
import fcntl
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import IO

import yaml

from vibrissa import repair

PROFILE = "workflow/profiles/default"
PROFILES = [str(path) for path in sorted(Path("workflow/profiles").glob("*"))]
SNAKEMAKE_LOGS = Path(".snakemake/log")
SNAKEMAKE_LOCKS = Path(".snakemake/locks")
# As in workflow/schemas/study.schema.yaml.
STUDY_NAME = "[A-Za-z0-9][A-Za-z0-9_-]*"
FIGURE_SUFFIXES = {".pdf", ".svg", ".png"}
PROGRESS = re.compile(r"^(\d+) of (\d+) steps \(([\d.]+)%\) done$")
# Snakemake's report of a failed job in its own log file: a title and indented lines.
JOB_ERROR = re.compile(r"^Error in rule (?P<rule>\S+):\n(?P<body>(?:    .*\n)+)", re.MULTILINE)
# The same of a cluster job that was to run several, whether they failed or not.
GROUP_ERROR = re.compile(
    r"^    message: Error in group (?P<group>\S+)\n(?P<body>(?:    (?!\[).*\n)+)", re.MULTILINE
)


def say(text: str) -> None:
    """Print to stderr, where Snakemake writes too, so that the order on the screen is kept."""
    print(text, file=sys.stderr, flush=True)


def study_name(configfiles: list[str]) -> str:
    """Return the study's name; a study file given takes the place of config.yaml."""
    study = None
    for path in configfiles or ["config.yaml"]:
        try:
            config = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            sys.exit(f"{path} is not valid YAML: {error}")
        if isinstance(config, dict):
            study = config.get("study", study)
    return str(study)


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
    handle.seek(0)
    if handle.read():
        say("The last run was killed; its finished results are kept and it is continued.")
        shutil.rmtree(SNAKEMAKE_LOCKS, ignore_errors=True)
    else:
        handle.write("running\n")
        handle.flush()
        os.fsync(handle.fileno())
    return handle


def print_progress(lines: IO[str]) -> list[str]:
    """Copy a progress line every few percent to the screen; return the last other lines."""
    other: deque[str] = deque(maxlen=30)
    shown = 0.0
    for line in lines:
        line = line.rstrip()
        match = PROGRESS.match(line)
        if match is None:
            other.append(line)
        elif float(match[3]) >= shown + 5 or match[1] == match[2]:
            shown = float(match[3])
            say(line)
    return list(other)


def fields(body: str, name: str) -> list[str]:
    """Return the values of a field in the indented lines of an error report."""
    return re.findall(rf"^ *{name}: (.*?)(?: \(check log.*)?$", body, re.MULTILINE)


def last_words(logs: list[str]) -> list[str]:
    """Return the last lines of the first of some log files that has any."""
    for path in map(Path, logs):
        if path.is_file():
            lines = path.read_text(errors="replace").splitlines()
            if tail := [line for line in lines if line.strip()][-6:]:
                return tail
    return []


def failed_jobs(snakemake_log: str) -> list[str]:
    """Return a short text for each job that failed for good: what, why, and where its log is."""
    texts: dict[tuple[str, str], str] = {}  # of the last attempt at each
    for match in sorted(
        [*JOB_ERROR.finditer(snakemake_log), *GROUP_ERROR.finditer(snakemake_log)],
        key=lambda match: match.start(),
    ):
        body = match["body"]
        later = snakemake_log[match.end() :]
        if any(f"Finished jobid: {jobid} " in later for jobid in fields(body, "jobid")):
            continue  # a retry succeeded
        output = ", ".join(fields(body, "output")) or "(no output)"
        logs = [log for value in fields(body, "log") for log in value.split(", ")]
        group = match.groupdict().get("group")
        what = f"group {group}" if group else f"rule {match['rule']}"
        if group and body.startswith("    log: "):
            # The job's own Snakemake knows which rule it was, unless it was killed, too.
            own = Path(logs[0]).read_text(errors="replace") if Path(logs[0]).is_file() else ""
            if inner := failed_jobs(own):
                texts[what, output] = "\n".join(inner)
                continue
        elif group:
            logs.reverse()  # the rule that came last was the one that failed
        tail = last_words(logs)
        status = re.findall(r"SLURM status is: '\w+'", (fields(body, "message") or [""])[0])
        if not tail and not status:  # e.g. killed for lack of memory, before it could say anything
            ends = re.findall(r"(?:died with|returned non-zero).*", snakemake_log)
            tail = [f"(nothing in its log; the command {ends[-1]})" if ends else "(empty log)"]
        texts[what, output] = (
            f"FAILED: {what}, making {output}\n"
            + "".join(f"    {line}\n" for line in [*tail, *status])
            + f"  log: {', '.join(logs) or '(the rule has no log file)'}"
        )
    return list(texts.values())


def verdicts(ledger: str) -> str:
    """Return the counts of verdicts, which are the first sentence under the ledger's title."""
    return ledger.splitlines()[2].partition(". ")[0]


def remove_damaged(paths: Iterable[Path], removed: set[Path]) -> bool:
    """Remove damaged files, so that they are made anew; tell whether there were any."""
    before = len(removed)
    for path in paths:
        # What is damaged again was not made well: somebody has to look at it.
        if path.is_file() and path not in removed:
            try:
                path.unlink()
            except OSError as error:
                say(f"{path} is damaged, and cannot be removed ({error.strerror}).")
                continue
            removed.add(path)
            # Snakemake does without a block as long as what was made of it is there.
            say(f"{path} is damaged or does not belong there: removed, made anew where needed.")
    return len(removed) > before


def run_snakemake(snakemake: list[str], lock: IO[str]) -> tuple[int, bool, list[str], str]:
    """Run Snakemake; return its status, whether Ctrl-C ended it, what it said, and its log."""
    terminal = sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"
    logs_before = set(SNAKEMAKE_LOGS.glob("*.log"))
    child = subprocess.Popen(
        [*snakemake, "--logger", "rich"] if terminal else snakemake,
        stdin=subprocess.DEVNULL,
        stderr=None if terminal else subprocess.PIPE,
        text=True,
        errors="replace",
        # Should only this wrapper be killed, the running Snakemake keeps holding the lock.
        pass_fds=[lock.fileno()],
    )
    interrupted: list[int] = []
    # Ctrl-C reaches Snakemake directly; wait for it to end its jobs instead of dying first.
    signal.signal(signal.SIGINT, lambda number, frame: interrupted.append(number))
    signal.signal(signal.SIGTERM, lambda number, frame: child.send_signal(number))
    other = print_progress(child.stderr) if child.stderr else []
    status = child.wait()
    new_logs = sorted(set(SNAKEMAKE_LOGS.glob("*.log")) - logs_before)
    log = new_logs[-1].read_text(errors="replace") if new_logs else ""
    return status, bool(interrupted), other, log


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", default=[])
    parser.add_argument("--config", nargs="+", default=[])
    parser.add_argument("--workflow-profile")
    known, _ = parser.parse_known_args(argv)
    configfiles = known.configfile
    for name in configfiles:
        if not Path(name).is_file():
            sys.exit(f"No such study file: {name}")
    if known.workflow_profile not in (None, "none") and not Path(known.workflow_profile).is_dir():
        sys.exit(f"No such profile: {known.workflow_profile}; there are: {', '.join(PROFILES)}")
    overrides = dict(entry.split("=", 1) for entry in known.config if "=" in entry)
    study = overrides.get("study") or study_name(configfiles)

    folder = Path("results", study)
    # Any other name is refused by the workflow, and is no folder to look into.
    named_well = re.fullmatch(STUDY_NAME, study) is not None
    if named_well and (problem := repair.misplaced(folder)):
        sys.exit(problem)
    profile = [] if known.workflow_profile else ["--workflow-profile", PROFILE]
    snakemake = [sys.executable, "-m", "snakemake", *profile, *argv]
    try:
        lock = acquire_lock()
    except OSError as error:
        obstacles = repair.obstacles(folder, str(error))
        sys.exit("\n".join([f"The run cannot start: {error}", *obstacles]))
    removed: set[Path] = set()
    mending = named_well and not {"-n", "--dry-run", "--dryrun"} & set(argv)
    if mending:
        repair.remove_leftovers(folder)
        remove_damaged(repair.cut_short(folder), removed)
    say(f"Study '{study}': {shlex.join(['snakemake', *snakemake[3:]])}")

    again: list[str] = []
    while True:
        status, interrupted, other, log = run_snakemake([*snakemake, *again], lock)
        jobs = failed_jobs(log) if status > 0 else []
        # Where one table is damaged, others may be; all are looked at, now that it is worth while.
        named = [Path(name) for name in repair.NAMED.findall("\n".join(jobs))]
        named = [path for path in named if mending and path.is_relative_to(folder)]
        suspects = sorted(folder.glob("*/**/[!.]*.parquet")) if named else []
        if interrupted or not remove_damaged([*named, *repair.damaged(suspects)], removed):
            break
        say("Running again.")
        # A job that failed has no output any more, without which Snakemake may do by itself.
        outputs = re.findall("^FAILED: .*, making (.*)$", "\n".join(jobs), re.MULTILINE)
        again = ["--forcerun", *", ".join(outputs).split(", ")]
    # A killed Snakemake has left its own lock, which the next run is to remove.
    if status >= 0:
        lock.truncate(0)

    if interrupted:
        say("\nInterrupted. Finished results are kept: the same command continues from here.")
        return 130
    if status != 0:
        obstacles = repair.obstacles(folder, "\n".join([*jobs, *other]))
        if jobs:
            say("")
            for text in jobs[3:]:
                say(text.splitlines()[0])
            say("\n".join(jobs[:3]))
        elif obstacles and "Traceback" in "".join(other):
            pass  # a full disk stops Snakemake anywhere; the reader need not know where
        elif other:  # without a terminal nothing of Snakemake's own message was shown yet
            # Where in the workflow's code a message was raised does not help its reader.
            say("\n".join(line for line in other if not line.startswith('  File "')))
        if status < 0:
            name = signal.Signals(-status).name
            say(f"Snakemake was ended by signal {-status} ({name}); the same command continues.")
        for obstacle in obstacles:
            say(obstacle)
        if "Directory cannot be locked" in log + "".join(other):
            say(
                "A Snakemake that was not started by this command is at work in this folder, or "
                f"was killed in it. If none is, 'rm -r {SNAKEMAKE_LOCKS}' and run the same command "
                "again."
            )
        return status if status > 0 else 128 - status

    if "Nothing to be done" in log:
        say("Nothing to do: all results are up to date.")
    folder = folder / "figures"
    endings: dict[str, list[str]] = {}
    for path in sorted(folder.glob("[!.]*")):
        if path.suffix in FIGURE_SUFFIXES:
            endings.setdefault(path.stem, []).append(path.suffix)
    say(f"Figures in {folder}:" if endings else f"No figures in {folder}.")
    for name, suffixes in endings.items():
        say(f"  {folder / name} {' '.join(suffixes)}")
    claims = folder.parent / "claims.md"
    if claims.is_file():
        say(f"{verdicts(claims.read_text(encoding='utf-8'))} ({claims})")
    report = folder.parent / "report.html"
    if report.is_file():
        say(f"All on one page: {report}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
