"""The tables: one Arrow schema for each, with a description and a unit on every column.

Every table that is written or read passes through here. A file carries the name and version of its
schema, the version and commit of the code and, where it belongs to one, the study file.
"""

from __future__ import annotations

import hashlib
import math
import subprocess
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import reduce
from operator import and_, or_
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.files import write_atomically

if TYPE_CHECKING:
    import pandas as pd

# Goes up when a column changes its meaning, name or type: older files are refused.
SCHEMA_VERSION = "3"

LENGTH, FORCE, MOMENT, ANGLE, NONE = "L", "E*I0/L^2", "E*I0/L", "rad", "1"
# Tables up to this long are one row group: some 7 MB in memory.
LEAST_ROW_GROUP = 2**14
TEXT, NUMBER, WHOLE, FLAG = pa.string(), pa.float64(), pa.int64(), pa.bool_()
NUMBERS = pa.list_(NUMBER)


class TableError(RuntimeError):
    """A table that is damaged or is not what it should be; the message says what to do."""


def _column(
    name: str, kind: pa.DataType, unit: str, description: str, nullable: bool = False
) -> pa.Field:
    return pa.field(name, kind, nullable, {"unit": unit, "description": description})


def _schema(name: str, columns: Sequence[pa.Field]) -> pa.Schema:
    return pa.schema(columns, {"vibrissa.table": name, "vibrissa.schema": SCHEMA_VERSION})


AXES = (
    _column("theta", NUMBER, NONE, "taper factor, base over tip diameter"),
    _column("mu0", NUMBER, NONE, "coefficient of static friction"),
    _column("eta", NUMBER, LENGTH, "distance between clamp and contact line"),
    _column("dx0", NUMBER, LENGTH, "footpoint displacement step"),
)
STATE = (
    ("f", FORCE, "contact force magnitude"),
    ("alpha", ANGLE, "contact force inclination; the force on the rod is f*(sin, -cos)(alpha)"),
    ("phi1", ANGLE, "slope at the contact point"),
    ("s_c", LENGTH, "arc length of the contact point, 1 in point contact"),
    ("reaction_fx", FORCE, "clamp reaction along the surface, f*sin(alpha)"),
    ("reaction_fy", FORCE, "clamp reaction normal to the surface, -f*cos(alpha)"),
    ("reaction_m", MOMENT, "clamp reaction moment, phi'(0)"),
    ("stability", NONE, "least second variation per bending energy, positive where stable"),
)
RESIDUAL = (
    "largest equilibrium misfit of the sticking curve: collocation, of the slope (rad) and the "
    "closing conditions (L), also between its nodes and states; shooting, of the tip's position (L)"
)


def _state_columns(suffix: str, when: str, nullable: bool) -> list[pa.Field]:
    return [
        _column(f"{name}{suffix}", NUMBER, unit, f"{description}{when}", nullable)
        for name, unit, description in STATE
    ]


CURVES = _schema(
    "curves",
    [
        _column("theta", TEXT, NONE, "taper factor, exact decimal"),
        _column("eta", TEXT, LENGTH, "distance between clamp and contact line, exact decimal"),
        _column("dx0", TEXT, LENGTH, "step of the walk, exact decimal; null: serves all", True),
        _column("method", TEXT, NONE, "collocation or shooting"),
        _column("status", TEXT, NONE, "solved, out_of_reach or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        _column("end", TEXT, NONE, "snaps, out_of_reach, lifts_off or not_followed"),
        _column("end_message", TEXT, NONE, "more about the end of the curve, or empty"),
        _column("x1_init", NUMBER, LENGTH, "contact point at alpha = 0, clamp at 0", True),
        _column("residual", NUMBER, NONE, RESIDUAL, True),
        _column("x0_lock", NUMBER, LENGTH, "displacement at which -tan(alpha) is largest", True),
        _column("mu_lock", NUMBER, NONE, "largest value of -tan(alpha)", True),
        _column("x0_touch", NUMBER, LENGTH, "first displacement with phi1 = 0, if any", True),
        _column("piece_contact", pa.list_(TEXT), NONE, "kind of contact of each smooth piece"),
        _column("piece_states", pa.list_(WHOLE), NONE, "number of states on each smooth piece"),
        _column("piece_parameter", pa.list_(TEXT), NONE, "x0 or advance: what counts the states"),
        _column("piece_start", NUMBERS, NONE, "first value of the parameter (x0 in L)"),
        _column("piece_stop", NUMBERS, NONE, "last value of the parameter (x0 in L)"),
        _column("x0", NUMBERS, LENGTH, "footpoint displacements of the states, piece by piece"),
        _column("reaction_fx", NUMBERS, FORCE, "f*sin(alpha) of the states"),
        _column("reaction_fy", NUMBERS, FORCE, "-f*cos(alpha) of the states"),
        _column("reaction_m", NUMBERS, MOMENT, "phi'(0) of the states"),
        _column("phi1", NUMBERS, ANGLE, "slope at the contact point of the states"),
        _column("s_c", NUMBERS, LENGTH, "arc length of the contact point of the states"),
        _column("stability", NUMBERS, NONE, "least second variation of the states"),
    ],
)

STICTION = _schema(
    "stiction",
    [
        _column("grids", pa.list_(TEXT), NONE, "names of the grids that the point belongs to"),
        *AXES,
        _column(
            "status",
            TEXT,
            NONE,
            "slip, lock (the tip never slips forward), out_of_reach or failed",
        ),
        _column("message", TEXT, NONE, "why there is no result, or empty"),
        _column("contact", TEXT, NONE, "point or line, at the onset of slip or the lock", True),
        _column("x0_slip", NUMBER, LENGTH, "exact onset of slip", True),
        _column("x0_max", NUMBER, LENGTH, "last state of stiction on the step grid", True),
        _column("n_steps", WHOLE, NONE, "steps to the last state of stiction", True),
        _column("mu_lock", NUMBER, NONE, "largest friction at which the tip slips", True),
        _column("x0_lock", NUMBER, LENGTH, "onset of slip at that friction", True),
        *_state_columns("_init", ", at alpha = 0", True),
        *_state_columns("_last", ", at the last state of stiction", True),
        *_state_columns("_slip", ", at the exact onset of slip", True),
        _column("end", TEXT, NONE, "past the lock: slips_back, snaps, out_of_reach", True),
        _column(
            "x0_end", NUMBER, LENGTH, "displacement at which sticking past the lock ends", True
        ),
        *_state_columns("_end", ", where sticking past the lock ends", True),
        _column("x1_init", NUMBER, LENGTH, "contact point at alpha = 0, clamp at 0", True),
        _column(
            "penetrates",
            FLAG,
            NONE,
            "point contact with phi1 < 0 up to the last state of stiction, or up to the lock",
            True,
        ),
        _column("residual", NUMBER, NONE, RESIDUAL, True),
    ],
)


def _model_columns(suffix: str) -> list[pa.Field]:
    """Column of a comparison for one contact model."""
    return [
        _column(f"status{suffix}", TEXT, NONE, "slip, lock, out_of_reach or failed"),
        _column(f"x0_slip{suffix}", NUMBER, LENGTH, "exact onset of slip", True),
        _column(f"f_slip{suffix}", NUMBER, FORCE, "contact force at the onset", True),
        _column(f"reaction_m_slip{suffix}", NUMBER, MOMENT, "clamp moment at the onset", True),
        _column(f"mu_lock{suffix}", NUMBER, NONE, "largest friction at which the tip slips", True),
        _column(f"residual{suffix}", NUMBER, NONE, RESIDUAL, True),
    ]


COMPARISONS = _schema(
    "comparisons",
    [
        _column("comparison", TEXT, NONE, "name of the comparison"),
        *AXES[:3],
        _column(
            "penetrates", FLAG, NONE, "point contact with phi1 < 0 up to the onset or to the lock"
        ),
        *_model_columns("_point"),
        *_model_columns("_line"),
    ],
)

SHAPE = (
    _column("shape_s", NUMBERS, LENGTH, "arc lengths of the shape's points"),
    _column("shape_x", NUMBERS, LENGTH, "positions along the surface of the shape's points"),
    _column("shape_y", NUMBERS, LENGTH, "positions normal to the surface of the shape's points"),
    _column("shape_phi", NUMBERS, ANGLE, "slopes of the shape's points"),
)
_SHAPE_RESIDUAL = (
    "distance of the contact point from the end of the shape, integrated independently"
)

SCANS = _schema(
    "scans",
    [
        _column("scan", TEXT, NONE, "name of the set of scans"),
        *AXES,
        _column(
            "status",
            TEXT,
            NONE,
            "slip, lock (one period, on past the lock), out_of_reach or failed",
        ),
        _column("cycle", WHOLE, NONE, "stick-slip cycle, from 1; it ends with its slip", True),
        _column("step", WHOLE, NONE, "steps since the cycle began", True),
        _column("phase", TEXT, NONE, "slip where the tip has just slipped, stick otherwise", True),
        _column("footpoint", NUMBER, LENGTH, "position of the clamp", True),
        _column("x0", NUMBER, LENGTH, "clamp displacement since the last alpha = 0 state", True),
        _column("x1", NUMBER, LENGTH, "position of the contact point", True),
        *_state_columns("", "", True),
        _column("residual", NUMBER, LENGTH, _SHAPE_RESIDUAL, True),
        *SHAPE,
    ],
)

STATES = _schema(
    "states",
    [
        _column("state", TEXT, NONE, "name of the state"),
        _column("theta", NUMBER, NONE, "taper factor, base over tip diameter"),
        _column("eta", NUMBER, LENGTH, "distance between clamp and contact line"),
        _column("x1", NUMBER, LENGTH, "contact point, clamp at 0"),
        _column("status", TEXT, NONE, "solved, out_of_reach or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        _column("contact", TEXT, NONE, "point or line", True),
        *_state_columns("", "", True),
        _column("penetrates", FLAG, NONE, "whether phi1 < 0: the shape passes the surface", True),
        _column("residual", NUMBER, NONE, RESIDUAL.replace(" of the sticking curve", ""), True),
        *SHAPE,
    ],
)


CLAIMS = _schema(
    "claims",
    [
        _column("claim", TEXT, NONE, "short name of the statement"),
        _column("section", TEXT, NONE, "section of the paper that makes it"),
        _column("statement", TEXT, NONE, "what it says, in other words"),
        _column("computed", TEXT, NONE, "what was computed to decide it"),
        _column("figure_name", pa.list_(TEXT), NONE, "what each computed figure is"),
        _column("figure_value", NUMBERS, NONE, "computed figures, each in its unit"),
        _column("figure_unit", pa.list_(TEXT), NONE, "unit of each figure"),
        _column("verdict", TEXT, NONE, "holds, holds with a condition, ambiguous or contradicted"),
        _column("reason", TEXT, NONE, "the condition or the reason"),
    ],
)


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
    with write_atomically(Path(path)) as temporary, temporary.open("wb") as file:
        sink = _Digesting(file)
        options = {"use_dictionary": _repeating(schema), "write_page_checksum": True}
        with pq.ParquetWriter(sink, schema, **options) as writer:
            for group in _regrouped(parts, row_group_size(rows)):
                _check(group, str(path))
                writer.write_table(group)
            # Checksums of pages leave out what stands before each page.
            digest = {"vibrissa.bytes": str(sink.count), "vibrissa.digest": sink.hash.hexdigest()}
            writer.add_key_value_metadata(digest)


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


class _Digesting:
    """A file that is written through a hash."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.count, self.hash = file, 0, hashlib.sha256()
        self.closed = False

    def write(self, data: bytes) -> int:
        self.count += len(data)
        self.hash.update(data)
        return self.file.write(data)

    def tell(self) -> int:
        return self.count

    def flush(self) -> None:
        self.file.flush()

    def close(self) -> None:
        self.closed = True


def _place(path: str | Path) -> bytes:
    """Study, folders and name of a file in it."""
    return "/".join(Path(path).parts[-4:]).encode()


def check_file(path: str | Path) -> None:
    """Refuse a file whose pages are not those that were written, or were written elsewhere.

    Parameters
    ----------
    path : str or Path
        Parquet file.

    Raises
    ------
    TableError
        With the file's name, what is wrong and what to do.
    """
    with _refusing(path):
        metadata = pq.read_metadata(path).metadata or {}
        digest, left = hashlib.sha256(), int(metadata.get(b"vibrissa.bytes", 0))
        with Path(path).open("rb") as file:
            while left > 0 and (data := file.read(min(left, 2**20))):
                digest.update(data)
                left -= len(data)
        if metadata.get(b"vibrissa.digest") not in (None, digest.hexdigest().encode()):
            raise pa.ArrowInvalid("its contents are not those that were written")
    if (place := metadata.get(b"vibrissa.file")) not in (None, _place(path)):
        raise TableError(
            f"{path} is a copy of {place.decode(errors='replace')}; delete it and run again, it is "
            "made anew"
        )


@contextmanager
def _refusing(path: str | Path) -> Iterator[None]:
    """Say which file cannot be read, and what to do."""
    try:
        yield
    except (OSError, ValueError, OverflowError, pa.ArrowException) as error:
        # Only an error of the system has a number: the file may be as it should be.
        if getattr(error, "errno", None):
            raise TableError(f"{path} cannot be read ({error}); see why, and run again") from None
        # On one line, as `vibrissa.repair` looks for it.
        reason = " ".join(str(error).split())
        raise TableError(
            f"{path} cannot be read ({reason}); delete it and run again, it is made anew"
        ) from None


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

    Raises
    ------
    TableError
        With the file's name, what is wrong and what to do.
    """
    return Stored(path, schema).read()


class Stored:
    """A table in a file, of which as much is read as is asked for.

    Parameters
    ----------
    path : str or Path
        Parquet file.
    schema : pyarrow.Schema
        The schema that it must have.
    checked : bool, optional
        Whether the file's pages were compared with what was written before.

    Attributes
    ----------
    schema : pyarrow.Schema
        With the metadata of the file.

    Raises
    ------
    TableError
        If it is damaged or of another kind, with the file's name, what is wrong and what to do;
        the methods do so, too.
    """

    def __init__(self, path: str | Path, schema: pa.Schema, checked: bool = False) -> None:
        # A flipped byte would otherwise surface as a wrong number.
        if not checked:
            check_file(path)
        self._path = path
        with _refusing(path):
            self._file = pq.ParquetFile(path, page_checksum_verification=True)
            found = self._file.schema_arrow
        metadata = found.metadata or {}
        for key, value in schema.metadata.items():
            if (other := metadata.get(key, b"none")) != value:
                raise TableError(
                    f"{path} has {key.decode()} = {other.decode(errors='replace')} where "
                    f"{value.decode()} is needed; delete it and run again, it is made anew"
                )
        if not found.equals(schema):
            raise TableError(
                f"{path} has other columns than its schema says; delete it and run again, it is "
                "made anew"
            )
        # Units and descriptions are the schema's own, whatever the file says.
        self.schema = schema.with_metadata(metadata)

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self._file.metadata.num_rows)

    @property
    def groups(self) -> int:
        """Number of row groups."""
        return int(self._file.num_row_groups)

    def group(self, index: int, columns: Sequence[str] | None = None) -> pa.Table:
        """Rows of one row group, in all or some columns."""
        names = self.schema.names if columns is None else list(columns)
        with _refusing(self._path):
            table = self._file.read_row_group(index, names)
        fields = [self.schema.field(name) for name in names]
        schema = pa.schema(fields, self.schema.metadata)
        table = pa.Table.from_arrays([table.column(name) for name in names], schema=schema)
        _check(table, str(self._path))
        return table

    def parts(
        self, columns: Sequence[str] | None = None, where: Mapping[str, Any] | None = None
    ) -> Iterator[pa.Table]:
        """Rows by row group, with what can be told apart by statistics left unread.

        Parameters
        ----------
        columns : sequence of str, optional
            Columns that are wanted, instead of all.
        where : mapping, optional
            Value, or list of values, that a column must have; under the name ``grid`` the name of
            one of a point's grids.

        Yields
        ------
        pyarrow.Table
        """
        wanted = dict(where or {})
        needed = {"grids" if name == "grid" else name for name in wanted}
        names = None if columns is None else list(dict.fromkeys([*columns, *sorted(needed)]))
        for index in self.groups_where(wanted):
            table = chosen(self.group(index, names), wanted)
            if len(table):
                yield table if columns is None else table.select(list(columns))

    def groups_where(self, where: Mapping[str, Any]) -> Iterable[int]:
        """Row groups that can hold what is asked for, by their statistics; see `parts`."""
        conditions = [_condition(name, value) for name, value in where.items() if name != "grid"]
        if not conditions:
            return range(self.groups)
        # Only who looks for something waits for it.
        from pyarrow import dataset

        with _refusing(self._path):
            (fragment,) = dataset.dataset(self._path).get_fragments()
            found = fragment.subset(reduce(and_, conditions), schema=self.schema)
        return [group.id for group in found.row_groups]

    def read(
        self, columns: Sequence[str] | None = None, where: Mapping[str, Any] | None = None
    ) -> pa.Table:
        """Rows as one table; see `parts`."""
        names = self.schema.names if columns is None else columns
        schema = pa.schema([self.schema.field(name) for name in names], self.schema.metadata)
        return pa.concat_tables([schema.empty_table(), *self.parts(columns, where)])


def parts_of(
    table: pa.Table | Stored, columns: Sequence[str], where: Mapping[str, Any] | None = None
) -> Iterator[pa.Table]:
    """Rows of a table in memory or in a file; see `Stored.parts`."""
    if isinstance(table, Stored):
        yield from table.parts(columns, where)
    else:
        yield chosen(table, where or {}).select(list(columns))


def frame(
    table: pa.Table | Stored, columns: Sequence[str], where: Mapping[str, Any] | None = None
) -> pd.DataFrame:
    """Rows of a table in memory or in a file, as pandas has them; see `Stored.parts`."""
    schema = pa.schema([table.schema.field(name) for name in columns])
    parts = [part.cast(schema) for part in parts_of(table, columns, where)]
    return pa.concat_tables([schema.empty_table(), *parts]).to_pandas()


def chosen(table: pa.Table, where: Mapping[str, Any]) -> pa.Table:
    """Rows of a table that have given values.

    Parameters
    ----------
    table : pyarrow.Table
    where : mapping
        As in `Stored.parts`.

    Returns
    -------
    pyarrow.Table
    """
    for name, value in where.items():
        table = table.filter(
            in_grid(table.column("grids"), value) if name == "grid" else _condition(name, value)
        )
    return table


def in_grid(grids: pa.ChunkedArray, name: str) -> pa.Array:
    """Which rows belong to a grid, by the column of the names of their grids."""
    lists = grids.combine_chunks()
    rows = pc.list_parent_indices(lists).filter(pc.equal(pc.list_flatten(lists), name))
    belongs = np.zeros(len(lists), dtype=bool)
    belongs[rows.to_numpy()] = True
    return pa.array(belongs)


def _condition(name: str, value: Any) -> pc.Expression:
    values = value if isinstance(value, list) else [value]
    return reduce(or_, [pc.field(name) == one for one in values])


def commit() -> str:
    """Commit of the code that is running, with ``-dirty`` if it was edited; or ``unknown``."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(Path(__file__).parent), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        # Installed inside somebody else's repository, that repository's commit says nothing.
        git("ls-files", "--error-unmatch", __file__)
        return git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _check(table: pa.Table, where: str) -> None:
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
