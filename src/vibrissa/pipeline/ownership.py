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
        file still has the name of the folder; or if this cannot be found out.
    """
    record, name = results / RECORD, results.name
    remedy = f"change the value of the key 'study' in {study_file}"
    try:
        owner = Path(record.read_text(encoding="utf-8").strip())
        is_other = not owner.samefile(study_file) and name_in(owner) == name
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, ValueError) as error:
        raise StudyError(
            f"{results} may belong to another study file, which {record} names, but that cannot be "
            f"read ({error}): {remedy}, or delete {record}"
        ) from None
    if is_other:
        raise StudyError(
            f"{study_file}: study: {name!r} is used by {owner}, whose results are in {results}; "
            f"{remedy}"
        )


def claim(results: Path, study_file: Path) -> None:
    """Record the study file in a folder of results, and lock the folder until the process ends.

    The kernel releases the lock when the process dies, so that a killed run leaves no lock.
    Temporary files that the jobs of a killed run left in the folder are removed.

    Raises
    ------
    StudyError
        If another run has the lock, or if the file system has no locks.
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
    except OSError as error:
        raise StudyError(
            f"the file system of the folder {results.absolute()} has no locks (flock: {error}): run "
            "the study on another file system, as in --directory FOLDER"
        ) from None
    _held.append(record)
    record.truncate(0)
    print(near(study_file.absolute()), file=record, flush=True)
    for path in results.rglob(TEMPORARY):
        path.unlink(missing_ok=True)
