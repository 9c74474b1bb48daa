"""Whether the results of a study are current: made by this code from this study file."""

import csv
import subprocess
import sys
from collections.abc import Sequence
from itertools import dropwhile
from pathlib import Path

from vibrissa.errors import ComparisonError
from vibrissa.pipeline.places import PAPER, SNAKEFILE
from vibrissa.study.model import Study
from vibrissa.tables import store

# First column of Snakemake's table of files, and what it says of a file that it would not make.
HEAD, CURRENT = "output_file", "no update"
COMPARED = ("stiction", "scans", "states")


def need_current(study: Study, configfile: Path, *, everything: bool = False) -> None:
    """Refuse results that are older than the code or the study file, or of another study file.

    Parameters
    ----------
    everything : bool, optional
        Check all results, and not only the tables on disk that are compared.

    Raises
    ------
    ComparisonError
        If there are such results; the message has the command to run.
    """
    results = Path("results", study.name)
    tables = {name: results / f"tables/{name}.parquet" for name in study.tables}
    there = {name: path for name, path in tables.items() if path.is_file()}
    for name, path in there.items():
        store.need_study(path, study.part(name))
    compared = [str(path) for name, path in there.items() if name in COMPARED]
    if not everything and not compared:
        return
    if rules := _outdated_rules([] if everything else compared, configfile):
        run = "make reproduce" if configfile == PAPER else f"make study STUDY={configfile}"
        raise ComparisonError(
            f"the results in {results} are older than the code or the study file (to be run: "
            f"{', '.join(rules)}); run {run} first"
        )


def _outdated_rules(files: Sequence[str], configfile: Path) -> list[str]:
    """List the rules that Snakemake would run for some files, or for the whole study."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE)]
    command += ["--dry-run", "--summary", *files, "--configfile", str(configfile)]
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if result.returncode:
        reason = " ".join(f"{result.stdout} {result.stderr}".split())
        raise ComparisonError(f"Snakemake cannot tell whether the results are current: {reason}")
    # Above the table stands what Snakemake is doing.
    lines = dropwhile(lambda line: not line.startswith(HEAD), result.stdout.splitlines())
    rows = csv.DictReader(lines, delimiter="\t")
    return sorted({row["rule"] for row in rows if row["plan"] != CURRENT})
