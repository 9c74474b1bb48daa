"""Whether a study's tables are what the code and the study file of today would make."""

import csv
import subprocess
import sys
from collections.abc import Sequence
from itertools import dropwhile
from pathlib import Path

from vibrissa.errors import ComparisonError
from vibrissa.pipeline.places import PAPER, SNAKEFILE

# First column of Snakemake's table of files, and what it says of a file that it would not make.
HEAD, CURRENT = "output_file", "no update"


def outdated_rules(tables: Sequence[Path], configfile: Path) -> list[str]:
    """Ask Snakemake which rules it would run to make some tables.

    Parameters
    ----------
    tables : sequence of Path
        Files of the study in ``results/<study>/tables``, relative to the working directory; without
        any, all that the study makes.
    configfile : Path
        Study file.

    Returns
    -------
    list of str
        Names of rules; empty if the tables are current.

    Raises
    ------
    ComparisonError
        If Snakemake cannot plan the study.
    """
    study = ["--configfile", str(configfile)]
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE)]
    result = subprocess.run(
        [*command, "--dry-run", "--summary", *map(str, tables), *study],
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    if result.returncode:
        reason = " ".join(f"{result.stdout} {result.stderr}".split())
        raise ComparisonError(f"Snakemake cannot tell whether the tables are current: {reason}")
    # Above the table stands what Snakemake is doing.
    lines = dropwhile(lambda line: not line.startswith(HEAD), result.stdout.splitlines())
    rows = csv.DictReader(lines, delimiter="\t")
    return sorted({row["rule"] for row in rows if row["plan"] != CURRENT})


def need_current(results: Path, configfile: Path, *, everything: bool = False) -> None:
    """Refuse tables that are older than the code or the study file.

    Parameters
    ----------
    results : Path
        ``results/<study>``.
    configfile : Path
        Study file.
    everything : bool, optional
        Whether this goes for all results, and not for those tables alone that are compared and are
        there.

    Raises
    ------
    ComparisonError
        If there are any; with what to do.
    """
    names = ("stiction", "scans", "states")
    tables = [path for name in names if (path := results / f"tables/{name}.parquet").is_file()]
    if everything:
        what, rules = "results", outdated_rules([], configfile)
    else:
        what, rules = "tables", outdated_rules(tables, configfile) if tables else []
    if rules:
        run = "make reproduce" if configfile == PAPER else f"make study STUDY={configfile}"
        raise ComparisonError(
            f"the {what} in {results} are older than the code or the study file (to be run: "
            f"{', '.join(rules)}); run {run} first"
        )
