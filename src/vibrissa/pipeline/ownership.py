"""A folder of results belongs to one study file, and to one run at a time."""

import fcntl
from pathlib import Path
from typing import IO

from vibrissa.errors import StudyError
from vibrissa.files import TEMPORARY
from vibrissa.pipeline.places import near
from vibrissa.study.reading import name_in

RECORD = "study_file.txt"
# Record files, kept open, and thereby locked, until the process ends.
_held: list[IO[str]] = []


def check(results: Path, study_file: Path) -> None:
    """Refuse to overwrite the results of another study file.

    Raises
    ------
    StudyError
        If the folder belongs to another study file that still exists, and if the study in that
        file still has the name of the folder.
    """
    record = results / RECORD
    owner = Path(record.read_text(encoding="utf-8").strip()) if record.is_file() else study_file
    name = results.name
    if owner.is_file() and not owner.samefile(study_file) and name_in(owner) == name:
        raise StudyError(
            f"{study_file}: study: {name!r} is used by {owner}, whose results are in {results}; "
            f"change the value of the key 'study' in {study_file}"
        )


def claim(results: Path, study_file: Path) -> None:
    """Record the study file in a folder of results, and lock the folder until the process ends.

    The kernel releases the lock when the process dies, so that a killed run leaves no lock.
    Temporary files that the jobs of a killed run left in the folder are removed.

    Raises
    ------
    StudyError
        If another run has the lock.
    """
    results.mkdir(parents=True, exist_ok=True)
    record = (results / RECORD).open("a", encoding="utf-8")
    try:
        fcntl.flock(record, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise StudyError(
            f"another run of this study is active in the folder {results.absolute()}: wait for it "
            "or stop it"
        ) from None
    _held.append(record)
    record.truncate(0)
    print(near(study_file.absolute()), file=record, flush=True)
    for path in results.rglob(TEMPORARY):
        path.unlink(missing_ok=True)
