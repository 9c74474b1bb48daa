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
    try:
        owner = Path(record.read_text(encoding="utf-8").strip())
        if owner.samefile(study_file) or name_in(owner) != name:
            return
        used = f"is used by {owner}"
    except (FileNotFoundError, NotADirectoryError, StudyError):  # no record, or of no study file
        return
    except (OSError, ValueError) as error:
        used = f"may be used by the study file in {record} ({error}; delete it if it is wrong)"
    raise StudyError(
        f"{study_file}: study: {name!r} {used}, whose results are in {results}; "
        f"change the value of the key 'study' in {study_file}"
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
        raise StudyError(f"{results} cannot be locked ({error}): use another file system") from None
    _held.append(record)
    record.truncate(0)
    print(near(study_file.absolute()), file=record, flush=True)
    for path in results.rglob(TEMPORARY):
        path.unlink(missing_ok=True)
