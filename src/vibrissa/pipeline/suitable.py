"""Check, before Snakemake starts, that a run is possible here."""

import os
import re
import shutil
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from vibrissa.errors import StudyError

if TYPE_CHECKING:
    from vibrissa.study.model import Study
    from vibrissa.study.sections import Mistake

DIRECTORY = ("--directory", "-d")
DRY_RUN = ("--dry-run", "--dryrun", "-n")
PROFILE = ("--workflow-profile", "--profile")
STUDY_FILE = ("--configfile", "--configfiles")


def unsuitable(arguments: list[str]) -> str:
    """Return what prevents a run with these arguments here, and what to type; or nothing."""
    if not os.access(".", os.W_OK) and not set(DIRECTORY) & set(arguments):
        return (
            f"error: {Path.cwd()} cannot be written, and results go there. Name another folder: "
            "python -m vibrissa.pipeline --directory FOLDER"
        )
    if _executor(arguments) == "slurm" and not shutil.which("sbatch"):
        if not set(DRY_RUN) & set(arguments):
            return (
                "error: there is no SLURM on this machine (no command sbatch). Run the command on "
                "the login node of a cluster, or without PROFILE on this machine"
            )
    for file in _study_files(arguments):
        if not file.is_file():
            return (
                f"error: there is no study file {file}. All that follows --configfile, up to the "
                "next option, are study files: write what to make before it"
            )
        from vibrissa.study.yaml12 import loaded, text_of  # some tenths of a second to load

        # Snakemake, which reads it first, would name neither the file nor the line.
        try:
            loaded(file, text_of(file))
        except StudyError as error:
            return str(error)
    return ""


def readings(study: "Study") -> "list[Mistake]":
    """Find mistakes in the section `readings`; a second to load, but only if there is one."""
    if not study.readings:
        return []
    from vibrissa.readings.checks import misfits

    return misfits(study)


def _study_files(arguments: list[str]) -> list[Path]:
    """Return the files that follow ``--configfile`` up to the next option."""
    files, option = [], ""
    for argument in arguments:
        if argument.startswith("-"):
            option = argument
        elif option in STUDY_FILE:
            files.append(Path(argument))
    return files


def _executor(arguments: list[str]) -> str:
    """Return the executor that the last profile names; empty for jobs on this machine."""
    profiles = [value for option, value in pairwise(arguments) if option in PROFILE]
    for profile in reversed(profiles):
        with suppress(OSError):
            text = Path(profile, "config.yaml").read_text(encoding="utf-8")
            if found := re.search(r"^executor: *(\S+)", text, re.M):
                return found[1]
    return ""
