"""Which study file a folder of results belongs to."""

from pathlib import Path

from vibrissa.errors import StudyError
from vibrissa.study.reading import name_in

RECORD = "study_file.txt"


def check(results: str, study_file: Path) -> None:
    """Refuse to overwrite the results of another study file.

    Raises
    ------
    StudyError
        If the folder belongs to another file that still has this name of a study.
    """
    record = Path(results, RECORD)
    if not record.is_file():
        return
    owner = Path(record.read_text(encoding="utf-8").strip())
    name = Path(results).name
    if owner.is_file() and not owner.samefile(study_file) and name_in(owner) == name:
        raise StudyError(
            f"{study_file}: study: {name!r} is the study of {owner}, with the results {results}; "
            f"give the key study another value in {study_file}"
        )


def claim(results: str, study_file: Path) -> None:
    """Write down the study file that a folder of results belongs to."""
    here, path = Path.cwd(), study_file.absolute()
    path = path.relative_to(here) if path.is_relative_to(here) else path
    record = Path(results, RECORD)
    record.parent.mkdir(parents=True, exist_ok=True)
    if not record.is_file() or record.read_text(encoding="utf-8") != f"{path}\n":
        record.write_text(f"{path}\n", encoding="utf-8")
