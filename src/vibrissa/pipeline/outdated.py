"""Check that the results of a study are current: made by this code from this study file."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from vibrissa.errors import ComparisonError
from vibrissa.pipeline.places import PAPER, SNAKEFILE
from vibrissa.study.model import Study
from vibrissa.tables import store

# Output of a dry run of Snakemake if all results are current.
CURRENT = "Nothing to be done"


def need_current(study: Study, study_file: Path, tables: Sequence[str] = ()) -> None:
    """Refuse results older than the code or the study file, or made from another study file.

    Parameters
    ----------
    tables : sequence of str, optional
        Tables that must be current; by default all results.

    Raises
    ------
    ComparisonError
        If results are missing or outdated; the message has the command to run.
    """
    folder = Path("results", study.name)
    files = [folder / f"tables/{name}.parquet" for name in tables if name in study.tables]
    for path in files:
        if not path.is_file():
            raise ComparisonError(
                f"the folder {folder} has no file tables/{path.name}; run the study first"
            )
        store.need_study(path, study.part(path.stem))
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE), "--dry-run"]
    command += [*map(str, files), "--configfile", str(study_file)]
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    screen = " ".join(f"{result.stdout} {result.stderr}".split())
    if result.returncode:
        raise ComparisonError(f"Snakemake cannot check whether results are current: {screen}")
    if CURRENT not in screen:
        run = "make reproduce" if study_file == PAPER else f"make study STUDY={study_file}"
        raise ComparisonError(
            f"the results are older than the code or the study file; run {run} first"
        )
