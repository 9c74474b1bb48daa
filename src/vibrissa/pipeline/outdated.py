"""Check that the results of a study are current: made by this code from this study file."""

import subprocess
import sys
from base64 import urlsafe_b64encode
from collections.abc import Iterable, Mapping
from pathlib import Path

from vibrissa.errors import ComparisonError
from vibrissa.pipeline.places import SNAKEFILE, near
from vibrissa.study.model import Study
from vibrissa.tables import store

# Folders in which Snakemake records how files were made, and that their making has begun.
RECORDS = (Path(".snakemake/metadata"), Path(".snakemake/incomplete"))


def need_records(folder: Path, parts: Mapping[str, str]) -> None:
    """Refuse tables of another study file of which Snakemake has no record.

    Snakemake would take them for results of this study file. Its records are missing if the folder
    ``.snakemake`` was removed, or if the results were copied from elsewhere.

    Parameters
    ----------
    folder : Path
        The study's folder of results.
    parts : mapping
        Part of the study file that determines a table, by the table's path in `folder`.

    Raises
    ------
    DamagedTableError
        If there is such a table.
    """
    for name, part in parts.items():
        path = folder / name
        coded = urlsafe_b64encode(str(path).encode()).decode()
        # A name that is too long for a file is split into folders.
        record = coded if len(coded) < 255 else f"@{coded[:254]}"
        if path.is_file() and not any((place / record).exists() for place in RECORDS):
            remedy = f"delete the folder {folder}, or change the key 'study'"
            store.need_study(path, part, f"Snakemake has no record of it: {remedy}")


def need_current(study: Study, study_file: Path, results: Iterable[str]) -> None:
    """Refuse results older than the code or the study file, or made from another study file.

    Parameters
    ----------
    results : iterable of str
        Files that must be current, as in `vibrissa.study.model.Study.results`.

    Raises
    ------
    ComparisonError
        If results are missing or outdated; the message has the command to run.
    """
    folder = Path("results", study.name)
    files = [folder / name for name in results]
    for path in files:
        if not path.is_file():
            name = path.relative_to(folder)
            raise ComparisonError(f"the folder {folder} has no file {name}; run the study first")
        if path.suffix == ".parquet":
            store.need_study(path, study.part(path.stem))
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE), "--dry-run"]
    command += [*map(str, files), "--configfile", str(study_file)]
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    screen = " ".join(f"{result.stdout} {result.stderr}".split())
    if result.returncode:
        raise ComparisonError(f"Snakemake cannot check whether results are current: {screen}")
    if "Nothing to be done" not in screen:
        raise ComparisonError(
            "the results are older than the code or the study file; "
            f"run make study STUDY={near(study_file)} first"
        )
