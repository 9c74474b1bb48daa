"""Whether the tables of a study answer its file."""

from pathlib import Path

from vibrissa.study.model import Study
from vibrissa.tables import store


def need_tables_of(study: Study, results: Path) -> None:
    """Refuse tables that do not answer a study file.

    Parameters
    ----------
    results : Path
        ``results/<study>``.

    Raises
    ------
    TableError
        If one is of another study file, or damaged; with what to do.
    """
    for name in study.tables:
        path = results / f"tables/{name}.parquet"
        if path.is_file():
            store.need_study(path, study.part(name))
