"""Files of tables: every table that is written or read passes through here.

A file carries the name and version of its schema, the version and commit of the code, a digest of
all its bytes and, where it belongs to one, the study file.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.ahead import ahead
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.files import write_atomically
from vibrissa.provenance import commit
from vibrissa.tables.parquet import digests, footers
from vibrissa.tables.schemas import NUMBERS, YOUNGER

# Tables up to this long are one row group: some 7 MB in memory.
LEAST_ROW_GROUP = 2**14
# Kind of table and version of its columns, in a file's metadata as in those of its schema.
TABLE, VERSION = b"vibrissa.table", b"vibrissa.schema"
# What refinement added to the grids of a study and left over, in one line for a person.
REFINED = b"vibrissa.refined"


def write(table: pa.Table, path: str | Path, study_file: str = "") -> None:
    """Write a table whole or not at all, with its provenance; see `write_parts`."""
    write_parts([table], table.schema, path, study_file)


def write_parts(
    parts: Iterable[pa.Table],
    schema: pa.Schema,
    path: str | Path,
    study_file: str = "",
    rows: int = 0,
    threads: int = 1,
) -> None:
    """Write the parts of a table, one below the other, whole or not at all, with its provenance.

    No more is held than a part and a row group, or some for each thread.

    Parameters
    ----------
    parts : iterable of pyarrow.Table
    schema : pyarrow.Schema
        One of this module's schemas, perhaps with more metadata.
    path : str or Path
        Parquet file.
    study_file : str, optional
        Text of the study file that the table answers. A table without one is a part of a study
        and belongs where it is written.
    rows : int, optional
        How many rows there are in all, as far as known: long tables get larger row groups.
    threads : int, optional
        In which long tables are encoded.

    Raises
    ------
    TableError
        If the table is not what its schema says.
    """
    metadata = dict(schema.metadata)
    metadata |= {b"vibrissa.version": __version__.encode(), b"vibrissa.commit": commit().encode()}
    if study_file:
        metadata[b"vibrissa.study"] = study_file.encode()
    else:
        metadata[b"vibrissa.file"] = _place(path)
    schema = schema.with_metadata(metadata)
    options = {"use_dictionary": _repeating(schema), "write_page_checksum": True}
    size = row_group_size(rows)
    groups = _regrouped(parts, size)
    with write_atomically(Path(path)) as temporary:
        if size > LEAST_ROW_GROUP:
            encoded = ahead(partial(_encoded, path, options), groups, threads)
            _write_encoded(temporary, encoded, _without_rows(schema, options))
            return
        with pq.ParquetWriter(temporary, schema, **options) as writer:
            for group in groups:
                writer.write_table(_in_one_piece(group, path))
            writer.add_key_value_metadata({digests.DIGEST: digests.NO_DIGEST})
        digests.put(temporary)


class _Encoded(NamedTuple):
    """A row group as bytes of a file, their digest, and the metadata of a file with it alone."""

    data: memoryview
    digest: bytes
    metadata: bytes
    rows: int


def _encoded(path: str | Path, options: Mapping[str, Any], group: pa.Table) -> _Encoded:
    """Encode a row group; see `write_parts` for the path."""
    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(sink, group.schema, **options) as writer:
        writer.write_table(_in_one_piece(group, path), row_group_size=len(group))
    file = memoryview(sink.getvalue())
    end = footers.start(file)
    data = file[len(footers.MARK) : end]
    return _Encoded(
        data=data,
        digest=hashlib.sha256(data).digest(),
        metadata=bytes(file[end : -footers.TAIL]),
        rows=len(group),
    )


def _without_rows(schema: pa.Schema, options: Mapping[str, Any]) -> bytes:
    """Metadata of a file without row groups and with the place of a digest."""
    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(sink, schema, **options) as writer:
        writer.add_key_value_metadata({digests.DIGEST_OF_PARTS: digests.NO_DIGEST})
    file = sink.getvalue().to_pybytes()
    return file[footers.start(file) : -footers.TAIL]


def _write_encoded(path: Path, groups: Iterable[_Encoded], without_rows: bytes) -> None:
    """Write a file of row groups and its digest; see `_without_rows` for its metadata."""
    found: list[bytes] = []
    parts: list[bytes] = []
    rows = 0
    with path.open("wb") as file:
        file.write(footers.MARK)
        for group in groups:
            by = file.tell() - len(footers.MARK)
            parts.append(footers.row_group(group.metadata, by, len(parts)))
            found.append(group.digest)
            rows += group.rows
            file.write(group.data)
        metadata = footers.with_row_groups(without_rows, parts, rows)
        end = metadata + len(metadata).to_bytes(footers.TAIL - len(footers.MARK), "little")
        end += footers.MARK
        file.write(end.replace(digests.NO_DIGEST, digests.of_parts(found, footers.MARK + end)))


def _repeating(schema: pa.Schema) -> list[str]:
    """Columns whose values repeat, as Parquet names them; a dictionary of others takes time."""
    return [
        f"{field.name}.list.element" if pa.types.is_list(field.type) else field.name
        for field in schema
        if field.type != NUMBERS and not field.name.endswith(("_last", "_slip", "_end"))
    ]


def row_group_size(rows: int) -> int:
    """Rows that are written, and found by a query, together.

    A query for a few rows reads the end of the file, about 6 kB for each row group, and one row
    group, about 100 B for each row. Their sum is least where they are equal.
    """
    return max(LEAST_ROW_GROUP, math.isqrt(60 * rows))


def _regrouped(parts: Iterable[pa.Table], size: int) -> Iterator[pa.Table]:
    """Put the same rows into tables of one size; the last may be shorter."""
    held: list[pa.Table] = []
    for part in parts:
        held.append(part)
        while sum(map(len, held)) >= size:
            table = pa.concat_tables(held)
            yield table.slice(0, size)
            held = [table.slice(size)]
    if sum(map(len, held)):
        yield pa.concat_tables(held)


def _place(path: str | Path) -> bytes:
    """Study, folders and name of a file in it."""
    return "/".join(Path(path).parts[-4:]).encode()


def check_file(path: str | Path) -> None:
    """Refuse a file that is not as it was written, or was written elsewhere.

    Parameters
    ----------
    path : str or Path
        Parquet file.

    Raises
    ------
    DamagedTableError
        If it must be deleted.
    TableError
        If it cannot be opened.
    """
    with reading(path):
        metadata = pq.read_metadata(path).metadata or {}
        if not digests.is_right(Path(path)):
            raise pa.ArrowInvalid("its contents are not those that were written")
    if (place := metadata.get(b"vibrissa.file")) not in (None, _place(path)):
        raise DamagedTableError(path, f"is a copy of {place.decode(errors='replace')}")


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Turn errors of reading a file into `TableError`: it is damaged, or cannot be opened."""
    try:
        yield
    except (OSError, ValueError, OverflowError, pa.ArrowException) as error:
        # Only an error of the system has a number: the file may be as it should be.
        if getattr(error, "errno", None):
            raise TableError(f"{path} cannot be read ({error}); see why, and run again") from None
        reason = " ".join(str(error).split())
        raise DamagedTableError(path, f"cannot be read ({reason})") from None


def opened(path: str | Path, schema: pa.Schema) -> pq.ParquetFile:
    """Open a file and refuse one that holds another kind of table; see `check_file` for damage.

    Parameters
    ----------
    path : str or Path
        Parquet file.
    schema : pyarrow.Schema
        The schema that it must have.

    Returns
    -------
    pyarrow.parquet.ParquetFile

    Raises
    ------
    DamagedTableError
        If it is no table of this kind.
    TableError
        If it cannot be opened.
    """
    with reading(path):
        file = pq.ParquetFile(path, page_checksum_verification=True)
        found = file.schema_arrow
    said = {name: value.decode(errors="replace") for name, value in (found.metadata or {}).items()}
    kind, wanted = said.get(TABLE, "none"), schema.metadata[TABLE].decode()
    if kind != wanted:
        raise DamagedTableError(path, f"holds the table {kind} where {wanted} is needed")
    version, current = said.get(VERSION, "none"), schema.metadata[VERSION].decode()
    if version != current:
        raise DamagedTableError(
            path,
            f"has version {version} of the columns, and this program reads version {current}",
            f"run its study again, or read it with the program that wrote it ({writer(said)})",
        )
    if not found.equals(_known_to(found, schema)):
        raise DamagedTableError(path, "has other columns than its schema says")
    return file


def _known_to(found: pa.Schema, schema: pa.Schema) -> pa.Schema:
    """Return a schema without what is younger than a file."""
    return pa.schema([f for f in schema if f.name in found.names or f.name not in YOUNGER])


def completed(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """Give the table of a file all columns of a schema; what is younger than it holds null."""
    there = dict(zip(table.column_names, table.columns, strict=True))
    columns = [
        there[field.name] if field.name in there else pa.nulls(len(table), field.type)
        for field in schema
    ]
    return pa.Table.from_arrays(columns, schema=schema)


def writer(said: Mapping[bytes, str]) -> str:
    """Version and commit of the program that wrote a file, from its metadata."""
    version, commit = said.get(b"vibrissa.version"), said.get(b"vibrissa.commit")
    return f"version {version or 'unknown'}, commit {commit or 'unknown'}"


def kind(path: str | Path) -> str:
    """Name of the table that a file holds; empty for a file of another program.

    Raises
    ------
    TableError
        If it is damaged or cannot be opened.
    """
    return said(path, TABLE)


def said(path: str | Path, key: bytes) -> str:
    """Text in the metadata of a Parquet file; empty if there is none.

    Raises
    ------
    TableError
        If the file is damaged or cannot be opened.
    """
    with reading(path):
        metadata = pq.read_metadata(path).metadata or {}
    return metadata.get(key, b"").decode(errors="replace")


def read(path: str | Path, schema: pa.Schema) -> pa.Table:
    """Read a table and refuse one that is damaged or of another kind.

    Parameters
    ----------
    path : str or Path
        Parquet file.
    schema : pyarrow.Schema
        The schema that it must have.

    Returns
    -------
    pyarrow.Table
        With the metadata of the file; units and descriptions are those of the schema.

    Raises
    ------
    TableError
        As `check_file` and `opened`.
    """
    check_file(path)
    file = opened(path, schema)
    with reading(path):
        table = file.read()
    return completed(table, schema.with_metadata(file.schema_arrow.metadata))


def _in_one_piece(table: pa.Table, where: str | Path) -> pa.Table:
    """Return the rows of a row group as they are encoded; refuse gaps."""
    for field in table.schema:
        if not field.nullable and table.column(field.name).null_count:
            raise TableError(f"{where}: column {field.name} must not be empty anywhere")
    return table.combine_chunks()


def joined(parts: Sequence[pa.Table], schema: pa.Schema) -> pa.Table:
    """Tables of one schema, one below the other, without the provenance of the parts."""
    bare = [part.replace_schema_metadata(schema.metadata) for part in parts]
    return pa.concat_tables(bare) if bare else schema.empty_table()


def status_counts(parts: Iterable[pa.Table]) -> Counter[str]:
    """How many rows of a table in parts have which status."""
    counts: Counter[str] = Counter()
    for part in parts:
        for count in pc.value_counts(part.column("status")).to_pylist():
            counts[count["values"]] += count["counts"]
    return counts
