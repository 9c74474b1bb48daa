"""Files of tables: every table that is written or read passes through here.

A file carries the name and version of its schema, the version and commit of the code, a digest of
all its bytes and, where it belongs to one, the study file.
"""

import hashlib
import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.files import write_atomically
from vibrissa.provenance import commit
from vibrissa.tables.schemas import NUMBERS, YOUNGER

# Tables up to this long are one row group: some 7 MB in memory.
LEAST_ROW_GROUP = 2**14
# Kind of table and version of its columns, in a file's metadata as in those of its schema.
TABLE, VERSION = b"vibrissa.table", b"vibrissa.schema"
# Name of the digest in a file's metadata, and what stands in its place while it is computed.
DIGEST = b"vibrissa.sha256"
NO_DIGEST = b"0" * hashlib.sha256().digest_size * 2


def write(table: pa.Table, path: str | Path, study_file: str = "") -> None:
    """Write a table whole or not at all, with its provenance; see `write_parts`."""
    write_parts([table], table.schema, path, study_file)


def write_parts(
    parts: Iterable[pa.Table],
    schema: pa.Schema,
    path: str | Path,
    study_file: str = "",
    rows: int = 0,
) -> None:
    """Write the parts of a table, one below the other, whole or not at all, with its provenance.

    No more is held than a row group and a part.

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
    with write_atomically(Path(path)) as temporary:
        with pq.ParquetWriter(temporary, schema, **options) as writer:
            for group in _regrouped(parts, row_group_size(rows)):
                _check(group, path)
                writer.write_table(group)
            writer.add_key_value_metadata({DIGEST: NO_DIGEST})
        _put_digest(temporary)


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
    """Put the same rows into tables of one size, each in one piece; the last may be shorter."""
    held: list[pa.Table] = []
    for part in parts:
        held.append(part)
        while sum(map(len, held)) >= size:
            table = pa.concat_tables(held)
            yield table.slice(0, size).combine_chunks()
            held = [table.slice(size)]
    if sum(map(len, held)):
        yield pa.concat_tables(held).combine_chunks()


def _digest(path: Path, recorded: bytes) -> bytes:
    """Digest of a Parquet file whose own metadata hold `NO_DIGEST` in place of the recorded one."""
    digest, left = hashlib.sha256(), _start_of_metadata(path)
    with path.open("rb") as file:
        while left > 0 and (data := file.read(min(left, 2**20))):
            digest.update(data)
            left -= len(data)
        digest.update(file.read().replace(recorded, NO_DIGEST))
    return digest.hexdigest().encode()


def _start_of_metadata(path: Path) -> int:
    """Where the metadata of a Parquet file begin: they, their length and a mark are its end."""
    with path.open("rb") as file:
        end = file.seek(-8, os.SEEK_END)
        return end - int.from_bytes(file.read(4), "little")


def _put_digest(path: Path) -> None:
    """Record the digest of a Parquet file in its metadata."""
    digest = _digest(path, NO_DIGEST)
    with path.open("r+b") as file:
        start = file.seek(_start_of_metadata(path))
        file.seek(start + file.read().index(NO_DIGEST))
        file.write(digest)


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
        recorded = metadata.get(DIGEST)
        if recorded is not None and recorded != _digest(Path(path), recorded):
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
    with reading(path):
        metadata = pq.read_metadata(path).metadata or {}
    return metadata.get(TABLE, b"").decode(errors="replace")


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


def _check(table: pa.Table, where: str | Path) -> None:
    for field in table.schema:
        if not field.nullable and table.column(field.name).null_count:
            raise TableError(f"{where}: column {field.name} must not be empty anywhere")


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
