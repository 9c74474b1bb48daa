"""Outdated results: those that this code would not make from this study file.

A run makes them again (`to_make_again`); check and archive refuse them (`need_current`). Tables
carry what made them (`vibrissa.tables.store`); captions and report have a mark. So results are
judged wherever they come from, and whatever Snakemake has recorded of them.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from vibrissa.errors import ComparisonError, DamagedTableError, VibrissaError
from vibrissa.pipeline.places import PAPER, near
from vibrissa.provenance import SCANNED, display_code
from vibrissa.tables import store

# Jobs that name outdated files need no study file, whose checks take time to load.
if TYPE_CHECKING:
    from vibrissa.study.model import Study

CAPTIONS, REPORT = "figures/captions.md", "report.html"
# A mark in a text, as a comment of HTML or Markdown.
_MARK = re.compile(rb"<!-- made of ([0-9a-f-]+) -->")
# Bytes at the end of a file in which its mark is.
_TAIL = 200
# What a figure that could not be drawn leaves beside its files: a text with the reason.
FAILED = ".failed.txt"
# Largest number of tables that are named.
SHOWN = 5


def marks(study: Study) -> dict[str, str]:
    """Return the marks of captions and report: digests of all that determines them.

    The mark of the report begins with the digest of the scripts that draw figures.
    """
    folder = study.folder
    scripts = {
        name: sha256((folder / figure.script).read_bytes()).hexdigest()
        for name, figure in study.figures.items()
        if figure.script
    }
    figures = {name: {**one, "script": None} for name, one in study.figure_params.items()}
    drawn = (display_code(), figures)
    return {
        CAPTIONS: _digest(drawn),
        REPORT: f"{_digest(scripts)}-{_digest((*drawn, study.title, study.text))}",
    }


def _digest(content: object) -> str:
    return sha256(repr(content).encode()).hexdigest()[:16]


def marked(mark: str) -> str:
    """Return the line that ends a marked file."""
    return f"<!-- made of {mark} -->\n"


def _mark_of(path: Path) -> str:
    """Return the mark of a file; empty if it has none."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _TAIL))
        found = _MARK.findall(file.read())
    return found[-1].decode() if found else ""


def _scripts_in(mark: str) -> str:
    """Return the part of the report's mark that is the digest of the scripts."""
    return mark.partition("-")[0]


def outdated(folder: Path, study: Study) -> dict[Path, str]:
    """Find existing results that must be made again, with the reason of each.

    Chunks are looked at only where their table must be made again.

    Parameters
    ----------
    folder : Path
        The study's folder of results.

    Raises
    ------
    TableError
        If a table cannot be read although it may be sound.
    """
    parts = {f"tables/{name}.parquet": study.study_part(name) for name in study.tables}
    found = dict(_outdated_tables(folder, parts))
    joined = folder / "tables/stiction.parquet"
    if joined in found or not joined.is_file():
        chunks = {f"chunks/{name}.parquet": study.chunk_part(name) for name in study.chunks}
        found |= dict(_outdated_tables(folder, chunks))
    for table in SCANNED.intersection(study.tables):
        joined = folder / f"tables/{table}.parquet"
        if joined in found or not joined.is_file():
            chunks = {
                f"scan_chunks/{table}/{name}.parquet": study.scan_chunk_part(name)
                for name in study.scan_chunks
            }
            found |= dict(_outdated_tables(folder, chunks))
    joined = folder / "tables/friction.parquet"
    if joined in found or not joined.is_file():
        chunks = {
            f"reading_chunks/{name}.parquet": study.reading_chunk_part(name)
            for name in study.reading_chunks
        }
        found |= dict(_outdated_tables(folder, chunks))
    for name, mark in marks(study).items():
        path = folder / name
        if not path.is_file() or (made := _mark_of(path)) == mark:
            continue
        found[path] = "was made by other code or from another study file"
        if name == REPORT and _scripts_in(made) != _scripts_in(mark):
            scripted = [name for name, figure in study.figures.items() if figure.script]
            reason = "was drawn by another script"
            found |= {folder / f"figures/{name}.png": reason for name in scripted}
    for name in study.figures:
        if (folder / f"figures/{name}{FAILED}").is_file():
            found[folder / f"figures/{name}.png"] = "shows why it could not be drawn"
    return found


def _outdated_tables(folder: Path, parts: Mapping[str, str]) -> Iterator[tuple[Path, str]]:
    for name, part in parts.items():
        path = folder / name
        try:
            reason = store.why_outdated(path, part) if path.is_file() else ""
        except DamagedTableError as error:
            reason = error.reason
        if reason:
            yield path, reason


def to_make_again(folder: Path, study: Study) -> set[str]:
    """Return existing results that must be made again, and print why.

    Changes of the study file are not printed.

    Raises
    ------
    TableError
        If a table cannot be read although it may be sound.
    """
    found = outdated(folder, study)
    told = [
        f"{path} {reason}: it is made again"
        for path, reason in found.items()
        if path.suffix == ".parquet" and not reason.startswith(store.OTHER_STUDY)
    ]
    more = [f"and {len(told) - SHOWN:,} more tables"] if len(told) > SHOWN else []
    for line in [*told[:SHOWN], *more]:
        print(line, file=sys.stderr)
    paths = set(found)
    if folder / CAPTIONS in paths:
        paths |= {
            folder / "summary.txt",
            *(folder / f"figures/{name}.png" for name in study.figures),
        }
    return set(map(str, paths))


def kept(folder: Path, study: Study, old: Collection[str], began: float) -> str:
    """Describe in one line which chunks and tables are there after a run that was stopped.

    Parameters
    ----------
    old : collection of str
        Results that must be made again, unless this was done since the time `began`.
    """

    def finished(names: Iterable[str]) -> str:
        paths = [folder / f"{name}.parquet" for name in names]
        there = [path for path in paths if path.is_file()]
        done = [one for one in there if str(one) not in old or one.stat().st_mtime > began]
        return f"{len(done):,} of {len(paths):,}"

    chunks = finished(
        [
            *(f"chunks/{name}" for name in study.chunks),
            *(f"scan_chunks/scans/{name}" for name in study.scan_chunks),
            *(f"reading_chunks/{name}" for name in study.reading_chunks),
        ]
    )
    tables = finished(f"tables/{name}" for name in study.tables)
    return f"{folder} has {chunks} chunks and {tables} tables."


def need_drawn(folder: Path, figures: Iterable[str]) -> None:
    """Refuse figures that could not be drawn.

    Raises
    ------
    VibrissaError
        If there are any; the message has the reasons.
    """
    paths = {name: folder / f"figures/{name}{FAILED}" for name in figures}
    reasons = [
        f"figure {name} could not be drawn: {path.read_text(encoding='utf-8').strip()}"
        for name, path in paths.items()
        if path.is_file()
    ]
    if reasons:
        raise VibrissaError("\n".join(reasons))


def need_current(study: Study, study_file: Path, results: Iterable[str]) -> None:
    """Refuse results that are missing, or that this code does not make from this study file.

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
    command = f"make study STUDY={near(study_file)}"
    remedy = f"run {'make reproduce' if study_file == PAPER else command} first"
    old = outdated(folder, study)
    for name in results:
        path = folder / name
        if not path.is_file():
            raise ComparisonError(f"the folder {folder} has no file {name}; {remedy}")
        if path in old:
            raise ComparisonError(f"{path} {old[path]}; {remedy}")
