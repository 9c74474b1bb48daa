"""Writing and reading of all table files, which include their provenance."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.files import write_atomically
from vibrissa.provenance import commit

TABLE, VERSION, STUDY = "vibrissa.table", "vibrissa.schema", "vibrissa.study"
PROGRAM, COMMIT = "vibrissa.version", "vibrissa.commit"
# Rows of a row group, the unit in which files are written and read: some 7 MB in memory.
ROW_GROUP = 2**14


def write(table: pa.Table, path: str | Path, study_part: str = "") -> None:
    """Write a table atomically, with its provenance; see `write_batches`."""
    write_batches([table], table.schema, path, study_part)


def write_batches(
    batches: Iterable[pa.Table], schema: pa.Schema, path: str | Path, study_part: str = ""
) -> None:
    """Write a table atomically, batch by batch, with its provenance."""
    added = {PROGRAM: __version__, COMMIT: commit(), STUDY: study_part}
    schema = schema.with_metadata({**schema.metadata, **added})
    with (
        write_atomically(Path(path)) as temporary,
        pq.ParquetWriter(temporary, schema, write_page_checksum=True) as writer,
    ):
        for group in _regrouped(batches, ROW_GROUP):
            writer.write_table(group.replace_schema_metadata(schema.metadata).combine_chunks())


def _regrouped(batches: Iterable[pa.Table], size: int) -> Iterator[pa.Table]:
    """Yield the same rows in tables of `size` rows; the last may be shorter."""
    held: list[pa.Table] = []
    for batch in batches:
        held.append(batch)
        while sum(map(len, held)) >= size:
            table = pa.concat_tables(held)
            yield table.slice(0, size)
            held = [table.slice(size)]
    if sum(map(len, held)):
        yield pa.concat_tables(held)


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Turn errors of reading a file into `TableError`, or `DamagedTableError` if it is damaged."""
    try:
        yield
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


def need_study(path: str | Path, study_part: str, remedy: str = DamagedTableError.REMEDY) -> None:
    """Check that a table was made from this part of a study file.

    Raises
    ------
    DamagedTableError
        If it was made from another study file.
    """
    found = metadata(path).get(STUDY, "")
    if found != study_part:
        others = [line for line in found.splitlines() if line not in study_part.splitlines()]
        has = f"the line '{others[0].strip()}'" if others else "fewer entries"
        raise DamagedTableError(path, f"was made from another study file, which has {has}", remedy)
