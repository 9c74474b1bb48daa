"""Whether a study's tables are what the code and the study file of today would make."""

import csv
import subprocess
import sys
from collections.abc import Sequence
from itertools import dropwhile
from pathlib import Path

from vibrissa.errors import ComparisonError

# First column of Snakemake's table of files, and what it says of a file that it would not make.
HEAD, CURRENT = "output_file", "no update"


def outdated_rules(tables: Sequence[Path], configfile: str | None) -> list[str]:
    """Ask Snakemake which rules it would run to make some tables.

    Parameters
    ----------
    tables : sequence of Path
        Files of the study in ``results/<study>/tables``, relative to the working directory.
    configfile : str or None
        Study file, instead of config.yaml.

    Returns
    -------
    list of str
        Names of rules; empty if the tables are current.

    Raises
    ------
    ComparisonError
        If Snakemake cannot plan the study.
    """
    study = ["--configfile", configfile] if configfile else []
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--summary"]
    result = subprocess.run(
        [*command, *map(str, tables), *study],
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


def need_current(results: Path, configfile: str | None) -> None:
    """Refuse tables that are older than the code or the study file.

    Raises
    ------
    ComparisonError
        If there are any; with what to do.
    """
    names = ("stiction", "scans", "states")
    tables = [path for name in names if (path := results / f"tables/{name}.parquet").is_file()]
    if rules := outdated_rules(tables, configfile) if tables else []:
        run = f"make study STUDY={configfile}" if configfile else "make reproduce"
        raise ComparisonError(
            f"the tables in {results} are older than the code or the study file (to be run: "
            f"{', '.join(rules)}); run {run} first"
        )
