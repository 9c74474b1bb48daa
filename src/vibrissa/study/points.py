"""Points of a study from a file, a row for each point, in place of all combinations of axes."""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, Self, cast

from pydantic import (
    Field,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import ErrorDetails

from vibrissa.errors import ArgumentError, StudyError
from vibrissa.limits import check_bore
from vibrissa.study.axes import AXES, MOUNTING_AXES, POWERS, Value, Values, sortable
from vibrissa.study.chunks import MOST_RODS, minutes_for, number_of_points
from vibrissa.study.data_files import file_below, lines_of
from vibrissa.study.sections import Mistakes, Section, in_words

# Largest number of rows of a file; more are taken for a mistake.
MOST_ROWS = 1_000_000
# Largest number of wrong cells that are reported.
REPORTED_CELLS = 5
# Values of the axes at which a point's rod has its default mounting.
_DEFAULTS = dict.fromkeys(MOUNTING_AXES, 0.0)
# Axes that have one value for all points.
_Common = create_model(
    "_Common",
    __base__=Section,
    **{  # type: ignore[call-overload]
        name: (axis.number | None, Field(default=None, description=axis.meaning))
        for name, axis in AXES.items()
    },
)


class PointsSection(_Common):  # type: ignore[misc,valid-type]
    """Points at which a period of sticking is solved: the rows of a file."""

    points: str = Field(
        description="CSV or Parquet file with a row for each point, relative to the study file; "
        "its columns are axes. An axis that is the same for all points may be a key instead"
    )
    _folder: Path = PrivateAttr(default=Path())

    def model_post_init(self, context: Any) -> None:
        """Keep the folder of the study file."""
        self._folder = Path(context["folder"])

    @model_validator(mode="after")
    def _can_be_read(self) -> Self:
        mistakes = Mistakes()
        try:
            self.table  # noqa: B018
        except StudyError as error:
            for line in str(error).splitlines():
                mistakes.add(line, "points")
        mistakes.refuse()
        return self

    @property
    def common(self) -> dict[str, Value]:
        """Values of the axes that are keys."""
        return {axis: getattr(self, axis) for axis in AXES if getattr(self, axis) is not None}

    @property
    def file(self) -> Path:
        """The file of the points."""
        return self._folder / self.points

    @cached_property
    def table(self) -> "PointTable":
        """The points."""
        try:
            file_below(self._folder, self.points)
        except ValueError as error:
            raise StudyError(str(error)) from None
        return read_points(self.file, self.common)

    @cached_property
    def axes(self) -> dict[str, Values]:
        """Values of each axis in increasing order."""
        return {
            axis: tuple(sorted(set(values), key=sortable))
            for axis, values in self.table.columns.items()
        }

    @property
    def number(self) -> int:
        """Number of points."""
        return len(self.table)

    @property
    def is_product(self) -> bool:
        """Whether the points are all combinations of the values of their axes."""
        return number_of_points(self.axes) == self.number

    def chunks(self, grid: str, by_step: bool, fixed: Mapping[str, int]) -> Iterator["PointsChunk"]:
        """Cut the points into chunks of at most `fixed["rods"]` rods."""
        most = fixed.get("rods", 1 if by_step else MOST_RODS)
        rods = self.table.rods(by_step)
        for first in range(0, len(rods), most):
            some = rods[first : first + most]
            yield PointsChunk(
                grid=grid,
                file=self.file.as_posix(),
                common=self.common,
                first=first,
                rods=len(some),
                points=sum(map(len, some)),
                content=self.table.digest([row for rows in some for row in rows]),
            )


@dataclass(frozen=True, kw_only=True)
class PointTable:
    """Points as columns, in the order of the file.

    Attributes
    ----------
    columns : mapping
        Values of each axis; all columns have the same length.
    """

    columns: Mapping[str, Sequence[Value]]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.columns["theta"])

    def rods(self, by_step: bool) -> list[list[int]]:
        """List the rows of each rod, in the order of the first row of each.

        Points of the same rod differ in μ0 and Δx0; `by_step`: in μ0 alone.
        """
        same = [axis for axis in AXES if axis != "mu0" and (by_step or axis != "dx0")]
        found: dict[tuple[Value, ...], list[int]] = {}
        for row, rod in enumerate(zip(*(self.columns[axis] for axis in same), strict=True)):
            found.setdefault(rod, []).append(row)
        return list(found.values())

    def rod(self, rows: Sequence[int], by_step: bool) -> dict[str, Value | None]:
        """Return the values of a rod by axis; `dx0` is None unless `by_step`."""
        same = [axis for axis in AXES if axis != "mu0"]
        values: dict[str, Value | None] = {axis: self.columns[axis][rows[0]] for axis in same}
        return values if by_step else values | {"dx0": None}

    def at(self, rows: Sequence[int]) -> dict[str, list[Value]]:
        """Return the values of each axis in some rows."""
        return {axis: [values[row] for row in rows] for axis, values in self.columns.items()}

    def digest(self, rows: Sequence[int] | None = None) -> str:
        """Compute a digest of the values in some rows, or in all."""
        chosen = self.columns if rows is None else self.at(rows)
        text = "\n".join(f"{axis} {list(chosen[axis])}" for axis in AXES)
        return sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True, kw_only=True)
class PointsChunk:
    """Part of the points of a file: some consecutive rods, each with all its μ0 and Δx0.

    Attributes
    ----------
    grid, file : str
        Name in the study file, and path of the file.
    common : mapping
        Values of the axes that are the same for all points.
    first, rods, points : int
        Number of the first rod, from 0, and the numbers of rods and points.
    content : str
        Digest of the points of the chunk.
    """

    grid: str
    file: str
    common: Mapping[str, Value]
    first: int
    rods: int
    points: int
    content: str

    @property
    def name(self) -> str:
        """Name such as ``mine/rod513``."""
        return f"{self.grid}/rod{self.first + 1}"

    @property
    def params(self) -> dict[str, Any]:
        """Inputs of the job, as plain values."""
        names = ("grid", "file", "common", "first", "rods", "content")
        return {name: getattr(self, name) for name in names}

    def study_part(self, solver: Mapping[str, str]) -> str:
        """Return the inputs that determine the chunk's rows, as text for its file's metadata."""
        # The content of the file counts, not its path, which may be another in an archive.
        lines = {"grid": self.grid, "points": self.content, **solver}
        return "".join(f"{key}: {value}\n" for key, value in lines.items())

    def minutes(self, by_step: bool) -> int:
        """Return the minutes to request from a cluster; `by_step`: one solution for each Δx0."""
        return minutes_for(self.rods, self.points, by_step)


def read_points(path: Path, common: Mapping[str, Value]) -> PointTable:
    """Read points from a CSV or Parquet file.

    Parameters
    ----------
    common : mapping
        Values of the axes that are the same for all points.

    Raises
    ------
    StudyError
        If the file cannot be used: a line for each mistake, with its row, its column, and what is
        allowed.
    """
    match path.suffix.lower():
        case ".csv":
            cells = _read_csv(path)
        case ".parquet":
            cells = _read_parquet(path)
        case _:
            raise StudyError(f"{path.name}: the name must end in .csv or .parquet")
    _check_columns(path, cells, common)
    checked = {axis: _checked(cells, axis) for axis in cells.columns}
    mistakes = [mistake for column in checked.values() for mistake in column.mistakes]
    if mistakes:
        more = [f"{path.name}: and {len(mistakes) - REPORTED_CELLS} more cells"]
        shown = mistakes[:REPORTED_CELLS] + (more if len(mistakes) > REPORTED_CELLS else [])
        raise StudyError("\n".join(shown))
    same = {axis: common.get(axis, _DEFAULTS.get(axis, 0.0)) for axis in AXES}
    columns = {
        axis: checked[axis].values if axis in checked else [same[axis]] * len(cells.rows)
        for axis in AXES
    }
    table = PointTable(columns=columns)
    _check_bores(table, cells)
    _check_doubles(table, cells)
    return table


@dataclass(frozen=True, kw_only=True)
class _Cells:
    """Cells of a file as they are written.

    Attributes
    ----------
    columns : mapping
        Cells of each column.
    rows : sequence of str
        Name of each row, such as ``mine.csv:7``.
    """

    columns: Mapping[str, Sequence[Any]]
    rows: Sequence[str]


def _read_csv(path: Path) -> _Cells:
    """Read a CSV file. Lines that are empty or begin with # are left out."""
    try:
        lines = lines_of(path)
    except ValueError as error:
        raise StudyError(str(error)) from None
    _check_size(path, len(lines) - 1)
    try:
        head, *rows = csv.reader([line.text for line in lines], skipinitialspace=True)
    except csv.Error as error:
        raise StudyError(f"{path.name} cannot be read as a CSV file: {error}") from None
    for (number, _), row in zip(lines[1:], rows, strict=True):
        if len(row) != len(head):
            raise StudyError(
                f"{path.name}:{number}: the row has {len(row)} values, but the first row has "
                f"{len(head)} names; separate values by commas"
            )
    names = [name.strip() for name in head]
    if doubled := sorted({name for name in names if names.count(name) > 1}):
        raise StudyError(f"{path.name} has two columns {doubled[0]!r}; remove one of them")
    return _Cells(
        columns=dict(zip(names, zip(*rows, strict=True), strict=True)),
        rows=[f"{path.name}:{number}" for number, _ in lines[1:]],
    )


def _read_parquet(path: Path) -> _Cells:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        _check_size(path, parquet.read_metadata(path).num_rows)
        table = parquet.read_table(path)
    except (OSError, pa.ArrowException) as error:
        reason = " ".join(str(error).split())
        raise StudyError(f"{path.name} cannot be read as a Parquet file: {reason}") from None
    return _Cells(
        columns=table.to_pydict(),
        rows=[f"{path.name}, row {number}" for number in range(1, table.num_rows + 1)],
    )


def _check_size(path: Path, rows: int) -> None:
    if rows < 1:
        raise StudyError(f"{path.name} has no rows; it needs a row for each point")
    if rows > MOST_ROWS:
        raise StudyError(
            f"{path.name} has {rows:,} rows; allowed: {MOST_ROWS:,}; spread them over several "
            "studies"
        )


def _check_columns(path: Path, cells: _Cells, common: Mapping[str, Value]) -> None:
    """Refuse missing and unknown columns, and axes that are a column and a key."""
    mistakes, has = [], ", ".join(cells.columns)
    for name in cells.columns:
        if name not in AXES:
            allowed = ", ".join(AXES)
            mistakes.append(f"{path.name}: {name!r} is not an axis; remove it; allowed: {allowed}")
        elif name in common:
            mistakes.append(
                f"{path.name} has the column {name!r}, which is also a key of the grid; remove "
                "one of them"
            )
    for axis in AXES:
        if axis not in (*cells.columns, *common, *_DEFAULTS):
            mistakes.append(
                f"{path.name} has no column {axis!r}; it has {has}. Add the column, or the key "
                f"{axis} to the grid"
            )
    if mistakes:
        raise StudyError("\n".join(mistakes))


class _Column(NamedTuple):
    """Values of an axis, or the mistakes in its cells."""

    values: Sequence[Value] = ()
    mistakes: Sequence[str] = ()


def _checked(cells: _Cells, axis: str) -> _Column:
    """Check the cells of an axis."""
    written: Sequence[Any] = cells.columns[axis]
    if axis in POWERS:
        written = [_with_coefficients(cell) for cell in written]
    try:
        numbers: Any = list[AXES[axis].number]  # type: ignore[misc]
        return _Column(values=TypeAdapter(numbers).validate_python(list(written)))
    except ValidationError as error:
        return _Column(mistakes=[_mistake(cells, axis, one) for one in error.errors()])


def _mistake(cells: _Cells, axis: str, error: ErrorDetails) -> str:
    row, *_ = error["loc"]
    return f"{cells.rows[int(row)]}: {axis}: {in_words(error)}; correct it, or remove the row"


def _with_coefficients(cell: Any) -> Any:
    """Split the coefficients of a polynomial, which are separated by spaces."""
    parts = cell.split() if isinstance(cell, str) else []
    return parts if len(parts) > 1 else cell


def _check_bores(table: PointTable, cells: _Cells) -> None:
    """Refuse rods whose bore is not narrower than their tip."""
    pairs = zip(table.columns["bore"], table.columns["theta"], strict=True)
    for row, (bore, theta) in enumerate(pairs):
        try:
            check_bore(cast("float", bore), cast("float", theta))
        except ArgumentError as error:
            raise StudyError(f"{cells.rows[row]}: bore: {error}") from None


def _check_doubles(table: PointTable, cells: _Cells) -> None:
    """Refuse points that are in two rows."""
    first: dict[tuple[Value, ...], int] = {}
    mistakes = []
    for row, point in enumerate(zip(*table.columns.values(), strict=True)):
        before = first.setdefault(point, row)
        if before != row:
            mistakes.append(f"{cells.rows[row]}: the same point as in {cells.rows[before]}")
    if mistakes:
        more = f", and {len(mistakes) - 1} more such rows" if len(mistakes) > 1 else ""
        raise StudyError(f"{mistakes[0]}{more}; remove one of them")
