"""Writing and reading of all table files, which include their provenance.

A table's metadata name what made it: the code (`vibrissa.provenance.code_of`), its commit, and the
part of the study file that determines it. A table is outdated if the code or the part differ from
those of now. Beside each table is its checksum, in a file for the command ``sha256sum -c``.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.files import write_atomically
from vibrissa.provenance import code_of, commit
from vibrissa.tables.schemas import TEXT

TABLE, VERSION, STUDY = "vibrissa.table", "vibrissa.schema", "vibrissa.study"
PROGRAM, COMMIT, CODE = "vibrissa.version", "vibrissa.commit", "vibrissa.code"
# Rows of a row group, the unit in which files are written and read: some 7 MB in memory.
ROW_GROUP = 2**14
# First words of the reason why a table of another study file is outdated.
OTHER_STUDY = "was made from another study file"


def write(table: pa.Table, path: str | Path, study_part: str = "") -> None:
    """Write a table atomically, with its provenance; see `write_batches`."""
    write_batches([table], table.schema, path, study_part)


def write_batches(
    batches: Iterable[pa.Table], schema: pa.Schema, path: str | Path, study_part: str = ""
) -> None:
    """Write a table atomically, batch by batch, with its provenance."""
    with writing(schema, path, study_part) as rows:
        for batch in batches:
            rows.add(batch)


@contextmanager
def writing(schema: pa.Schema, path: str | Path, study_part: str = "") -> Iterator["RowWriter"]:
    """Open a table for writing; at the end it replaces the file, unless an error was raised.

    Parameters
    ----------
    study_part : str
        The part of the study file that determines the table.
    """
    code = code_of(schema.metadata[TABLE.encode()].decode())
    added = {PROGRAM: __version__, COMMIT: commit(), CODE: code, STUDY: study_part}
    schema = schema.with_metadata({**schema.metadata, **added})
    # Dictionaries of numbers, which seldom repeat, take longer to write than the numbers.
    texts = [field.name for field in schema if field.type == TEXT]
    # Removed first: a kill between the two files must not leave the checksum of the former table.
    checksum_file(path).unlink(missing_ok=True)
    with (
        write_atomically(Path(path)) as temporary,
        pq.ParquetWriter(
            temporary,
            schema,
            write_page_checksum=True,
            use_dictionary=texts,
            compression="zstd",
            compression_level=1,
        ) as file,
    ):
        rows = RowWriter(file)
        yield rows
        rows.write_rest()
    with write_atomically(checksum_file(path)) as temporary:
        temporary.write_text(f"{_checksum(path)}  {Path(path).name}\n", encoding="utf-8")


class RowWriter:
    """Writes the rows of a table in row groups of `ROW_GROUP` rows; the last may be shorter."""

    def __init__(self, file: pq.ParquetWriter) -> None:
        self._file = file
        # Rows that do not fill a row group yet.
        self._waiting: list[pa.Table] = []

    def add(self, batch: pa.Table) -> None:
        """Append rows to the table."""
        self._waiting.append(batch)
        while sum(map(len, self._waiting)) >= ROW_GROUP:
            rows = pa.concat_tables(self._waiting)
            self._write(rows.slice(0, ROW_GROUP))
            self._waiting = [rows.slice(ROW_GROUP)]

    def write_rest(self) -> None:
        """Write the rows that are left, at the end of the table."""
        if sum(map(len, self._waiting)):
            self._write(pa.concat_tables(self._waiting))

    def _write(self, group: pa.Table) -> None:
        own = group.replace_schema_metadata(self._file.schema.metadata)
        self._file.write_table(own.combine_chunks())


def checksum_file(path: str | Path) -> Path:
    """Path of the file with the checksum of a table."""
    return Path(path).with_suffix(".sha256")


def _checksum(path: str | Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Turn errors of reading a file into `TableError`, or `DamagedTableError` if it is damaged."""
    try:
        yield
    except FileNotFoundError:
        raise TableError(f"No such file: {path}") from None
    except (OSError, ValueError, OverflowError, pa.ArrowException) as error:
        # Only an error of the operating system has an errno: the file itself may be sound.
        if getattr(error, "errno", None):
            raise TableError(
                f"{path} cannot be read ({error}); remove the cause and run again"
            ) from None
        reason = " ".join(str(error).split())
        raise DamagedTableError(path, f"cannot be read ({reason})") from None


def metadata(path: str | Path) -> dict[str, str]:
    """Return the metadata of a Parquet file."""
    with reading(path):
        return _texts(pq.read_metadata(path).metadata or {})


def opened(path: str | Path, schema: pa.Schema) -> pq.ParquetFile:
    """Open the file of a table.

    Raises
    ------
    DamagedTableError
        If the file is damaged or has another schema.
    """
    held, own = metadata(path), _texts(schema.metadata)
    with reading(path):
        file = pq.ParquetFile(path, page_checksum_verification=True)
        found = file.schema_arrow
    kind, wanted = (texts.get(TABLE, "none") for texts in (held, own))
    if kind != wanted:
        raise DamagedTableError(path, f"holds the table {kind!r}, not the table {wanted!r}")
    version, current = (texts.get(VERSION, "none") for texts in (held, own))
    if version != current:
        raise DamagedTableError(
            path,
            f"has version {version} of the columns, and this program reads version {current}",
            "run its study again, or read it with the program that wrote it "
            f"(version {held.get(PROGRAM)}, commit {held.get(COMMIT)})",
        )
    if not found.equals(schema):
        raise DamagedTableError(path, "has other columns than this version writes")
    return file


def _texts(found: Mapping[bytes, bytes]) -> dict[str, str]:
    return {
        key.decode(errors="replace"): value.decode(errors="replace") for key, value in found.items()
    }


def read(path: str | Path, schema: pa.Schema) -> pa.Table:
    """Read a table; see `opened` for errors."""
    file = opened(path, schema)
    with reading(path):
        table = file.read()
    return table.cast(schema.with_metadata(file.schema_arrow.metadata))


def current_batches(path: str | Path, schema: pa.Schema, study_part: str) -> Iterator[pa.Table]:
    """Yield the rows of a table a few at a time; refuse one that is damaged or not current.

    Unlike `vibrissa.tables.query`, which selects rows, this does not load pandas.
    """
    need_current(path, study_part)
    file = opened(path, schema)
    with reading(path):
        for batch in file.iter_batches():
            yield pa.Table.from_batches([batch]).cast(schema)


def need_current(path: str | Path, study_part: str) -> None:
    """Check that a table is the one that this code makes from this part of a study file.

    Raises
    ------
    DamagedTableError
        If it was made by other code or from another study file, or was changed afterwards.
    """
    if reason := why_outdated(path, study_part):
        raise DamagedTableError(path, reason)


def why_outdated(path: str | Path, study_part: str) -> str:
    """Return why a table is not one that this code makes from this study file; empty if it is.

    Raises
    ------
    TableError
        If the file cannot be read.
    """
    made = metadata(path)
    return _other_study(made, study_part) or _other_code(made) or _changed(path)


def _other_study(made: Mapping[str, str], study_part: str) -> str:
    found = made.get(STUDY, "")
    if found == study_part:
        return ""
    others = [line for line in found.splitlines() if line not in study_part.splitlines()]
    has = f"the line '{others[0].strip()}'" if others else "fewer entries"
    return f"{OTHER_STUDY}, which has {has}"


def _other_code(made: Mapping[str, str]) -> str:
    found, current = made.get(CODE, ""), _running_code(made.get(TABLE, ""))
    if found == current:
        return ""
    parts = zip(found.split(", "), current.split(", "), strict=False)
    changes = [f"{was} (now {now})" for was, now in parts if was != now]
    return f"was made by other code: {', '.join(changes) or 'unknown'}"


@cache
def _running_code(table: str) -> str:
    """Describe the code of a table once for all its chunks: all sources are read for it."""
    return code_of(table)


def _changed(path: str | Path) -> str:
    """Return that the file is not the one that was written, by its checksum where it has one."""
    try:
        checksum = checksum_file(path).read_text(encoding="utf-8", errors="replace").split()
    except FileNotFoundError:
        return ""
    return "" if checksum[:1] == [_checksum(path)] else "does not have its checksum"
