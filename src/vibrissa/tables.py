"""The tables: one Arrow schema for each, with a description and a unit on every column.

Every table that is written or read passes through here. A file carries the name and version of its
schema, the version and commit of the code and, where it belongs to one, the study file.
"""

import subprocess
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vibrissa import __version__
from vibrissa.curve import StickingCurve, StickingState
from vibrissa.cycles import Scan
from vibrissa.files import write_atomically
from vibrissa.grid import CurveKey, Point
from vibrissa.status import Status
from vibrissa.stiction import Stiction

# Goes up when a column changes its meaning, name or type: older files are refused.
SCHEMA_VERSION = "1"

LENGTH, FORCE, MOMENT, ANGLE, NONE = "L", "E*I0/L^2", "E*I0/L", "rad", "1"
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
        _column("status", TEXT, NONE, "solved or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        _column("x1_init", NUMBER, LENGTH, "contact point at alpha = 0, clamp at 0", True),
        _column("residual", NUMBER, NONE, RESIDUAL, True),
        _column("x0_lock", NUMBER, LENGTH, "displacement at which -tan(alpha) is largest", True),
        _column("mu_lock", NUMBER, NONE, "largest value of -tan(alpha)", True),
        _column("x0_touch", NUMBER, LENGTH, "first displacement with phi1 = 0, if any", True),
        _column("x0", NUMBERS, LENGTH, "footpoint displacements of the states"),
        _column("reaction_fx", NUMBERS, FORCE, "f*sin(alpha) of the states"),
        _column("reaction_fy", NUMBERS, FORCE, "-f*cos(alpha) of the states"),
        _column("reaction_m", NUMBERS, MOMENT, "phi'(0) of the states"),
        _column("phi1", NUMBERS, ANGLE, "slope at the contact point of the states"),
    ],
)

STICTION = _schema(
    "stiction",
    [
        _column("grids", pa.list_(TEXT), NONE, "names of the grids that the point belongs to"),
        *AXES,
        _column("status", TEXT, NONE, "slip, lock (the tip never slips backward) or failed"),
        _column("contact", TEXT, NONE, "point or line, at the onset of slip"),
        _column("x0_slip", NUMBER, LENGTH, "exact onset of slip", True),
        _column("x0_max", NUMBER, LENGTH, "last state of stiction on the step grid", True),
        _column("n_steps", WHOLE, NONE, "steps to the last state of stiction", True),
        _column("mu_lock", NUMBER, NONE, "largest friction at which the tip slips", True),
        *_state_columns("_init", ", at alpha = 0", True),
        *_state_columns("_last", ", at the last state of stiction", True),
        *_state_columns("_slip", ", at the exact onset of slip", True),
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

_SHAPE = (
    _column("shape_s", NUMBERS, LENGTH, "arc lengths of the shape's points"),
    _column("shape_x", NUMBERS, LENGTH, "positions along the surface of the shape's points"),
    _column("shape_y", NUMBERS, LENGTH, "positions normal to the surface of the shape's points"),
    _column("shape_phi", NUMBERS, ANGLE, "slopes of the shape's points"),
)
_SHAPE_RESIDUAL = "distance between the contact point and the end of the shape integrated by an independent method"

SCANS = _schema(
    "scans",
    [
        _column("scan", TEXT, NONE, "name of the set of scans"),
        *AXES,
        _column(
            "status", TEXT, NONE, "slip, lock (one period, up to the lock) or failed (no step)"
        ),
        _column("cycle", WHOLE, NONE, "stick-slip cycle, from 1; it ends with its slip", True),
        _column("step", WHOLE, NONE, "steps since the cycle began", True),
        _column("phase", TEXT, NONE, "slip where the tip has just slipped, stick otherwise", True),
        _column("footpoint", NUMBER, LENGTH, "position of the clamp", True),
        _column("x0", NUMBER, LENGTH, "clamp displacement since the last alpha = 0 state", True),
        _column("x1", NUMBER, LENGTH, "position of the contact point", True),
        *_state_columns("", "", True),
        _column("residual", NUMBER, LENGTH, _SHAPE_RESIDUAL, True),
        *_SHAPE,
    ],
)

STATES = _schema(
    "states",
    [
        _column("state", TEXT, NONE, "name of the state"),
        _column("theta", NUMBER, NONE, "taper factor, base over tip diameter"),
        _column("eta", NUMBER, LENGTH, "distance between clamp and contact line"),
        _column("x1", NUMBER, LENGTH, "contact point, clamp at 0"),
        _column("status", TEXT, NONE, "solved or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        *[c for c in _state_columns("", "", True) if c.name != "s_c"],
        _column("penetrates", FLAG, NONE, "whether phi1 < 0: the shape passes the surface", True),
        _column("residual", NUMBER, NONE, RESIDUAL.replace(" of the sticking curve", ""), True),
        *_SHAPE,
    ],
)


# --- Files -----------------------------------------------------------------------------------


def write(table: pa.Table, path: str | Path, study_file: str = "") -> None:
    """Write a table whole or not at all, with its provenance.

    Parameters
    ----------
    table : pyarrow.Table
        A table with one of this module's schemas.
    path : str or Path
        Parquet file.
    study_file : str, optional
        Text of the study file that the table answers.

    Raises
    ------
    TableError
        If the table is not what its schema says.
    """
    _check(table, str(path))
    metadata = dict(table.schema.metadata)
    metadata |= {b"vibrissa.version": __version__.encode(), b"vibrissa.commit": commit().encode()}
    if study_file:
        metadata[b"vibrissa.study"] = study_file.encode()
    with write_atomically(Path(path)) as temporary:
        pq.write_table(table.replace_schema_metadata(metadata), temporary, write_page_checksum=True)


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
    try:
        # A flipped byte in a compressed page would otherwise surface as a wrong number.
        table = pq.read_table(path, page_checksum_verification=True)
    except (OSError, pa.ArrowException) as error:
        raise TableError(
            f"{path} cannot be read ({error}); delete it and run again, it is made anew"
        ) from None
    found = {name: (table.schema.metadata or {}).get(name, b"none") for name in schema.metadata}
    for name, value in schema.metadata.items():
        if found[name] != value:
            raise TableError(
                f"{path} has {name.decode()} = {found[name].decode()} where {value.decode()} is "
                "needed; delete it and run again, it is made anew"
            )
    if not table.schema.equals(schema):
        raise TableError(
            f"{path} has other columns than its schema says; delete it and run again, it is made "
            "anew"
        )
    _check(table, str(path))
    return table


def commit() -> str:
    """Commit of the code that is running, with ``-dirty`` if it was edited; or ``unknown``."""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        answer = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return answer.stdout.strip()


def _check(table: pa.Table, where: str) -> None:
    for field in table.schema:
        if not field.nullable and table.column(field.name).null_count:
            raise TableError(f"{where}: column {field.name} must not be empty anywhere")


# --- Records to tables -------------------------------------------------------------------------


def _array(values: Any, kind: pa.DataType) -> pa.Array:
    """Arrow array of a column; NaN stands for nothing."""
    if isinstance(values, np.ndarray):
        if kind == WHOLE and values.dtype.kind == "f":
            return pa.array(np.nan_to_num(values).astype(np.int64), kind, mask=np.isnan(values))
        return pa.array(values, kind, from_pandas=True)
    return pa.array(values, kind)


def _table(schema: pa.Schema, columns: Mapping[str, Any]) -> pa.Table:
    arrays = [_array(columns[field.name], field.type) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)


def _state_values(state: StickingState, suffix: str = "") -> dict[str, Any]:
    return {f"{name}{suffix}": getattr(state, name) for name, _, _ in STATE}


def curves_table(keys: Sequence[CurveKey], curves: Sequence[StickingCurve]) -> pa.Table:
    """Table of sticking curves under the keys that they were solved for.

    Parameters
    ----------
    keys : sequence of CurveKey
    curves : sequence of StickingCurve
        In the order of the keys.

    Returns
    -------
    pyarrow.Table
        With the schema `CURVES`.
    """
    columns: dict[str, Any] = {
        "theta": [key[0] for key in keys],
        "eta": [key[1] for key in keys],
        "dx0": [key[2] if len(key) > 2 else None for key in keys],
    }
    for name in ("method", "status", "message", "x0", *_CURVE_VALUES):
        columns[name] = [getattr(curve, name) for curve in curves]
    for name in _CURVE_SCALARS:
        columns[name] = np.array([getattr(curve, name) for curve in curves])
    return _table(CURVES, columns)


_CURVE_VALUES = ("reaction_fx", "reaction_fy", "reaction_m", "phi1")
_CURVE_SCALARS = ("x1_init", "residual", "x0_lock", "mu_lock", "x0_touch")


def curves_from_table(table: pa.Table) -> dict[CurveKey, StickingCurve]:
    """Sticking curves of a table by the keys that they were solved for.

    Parameters
    ----------
    table : pyarrow.Table
        With the schema `CURVES`.

    Returns
    -------
    dict
    """
    curves = {}
    for row in table.to_pylist():
        key = tuple(row[name] for name in ("theta", "eta", "dx0") if row[name] is not None)
        values = {name: np.array(row[name]) for name in ("x0", *_CURVE_VALUES)}
        scalars = {name: np.nan if row[name] is None else row[name] for name in _CURVE_SCALARS}
        curves[key] = StickingCurve(
            float(key[0]),
            float(key[1]),
            row["method"],
            Status(row["status"]),
            row["message"],
            **values,
            **scalars,
        )
    return curves


def stiction_table(
    points: Mapping[Point, Sequence[str]], curve: StickingCurve, contact: str, stiction: Stiction
) -> pa.Table:
    """Table of the grid points that were read off one curve.

    Parameters
    ----------
    points : mapping
        Names of the grids that each point belongs to.
    curve : StickingCurve
    contact : str
        Contact model.
    stiction : Stiction
        In the order of the points.

    Returns
    -------
    pyarrow.Table
        With the schema `STICTION`.
    """
    n = len(points)
    solved = curve.status is Status.SOLVED
    return _table(
        STICTION,
        {
            "grids": list(points.values()),
            **{name: _floats(points, name) for name in Point._fields},
            "status": stiction.status,
            "contact": [contact] * n,
            "x0_slip": stiction.x0_slip,
            "x0_max": stiction.x0_max,
            "n_steps": stiction.n_steps,
            "mu_lock": np.full(n, curve.mu_lock),
            **_state_values(stiction.init, "_init"),
            **_state_values(stiction.last, "_last"),
            **_state_values(stiction.slip, "_slip"),
            "x1_init": np.full(n, curve.x1_init),
            "penetrates": stiction.penetrates if solved else [None] * n,
            "residual": np.full(n, curve.residual),
        },
    )


def _floats(points: Mapping[Point, Any], name: str) -> np.ndarray:
    return np.array([float(getattr(point, name)) for point in points])


def scan_table(name: str, point: Point, scan: Scan) -> pa.Table:
    """Table of one scan, a row for each footpoint position.

    Parameters
    ----------
    name : str
        Name of the set of scans.
    point : Point
    scan : Scan

    Returns
    -------
    pyarrow.Table
        With the schema `SCANS`; a failed scan has one row that says so.
    """
    failed = scan.status is Status.FAILED
    n = 1 if failed else len(scan.step)
    columns: dict[str, Any] = {
        "scan": [name] * n,
        **{axis: np.full(n, float(getattr(point, axis))) for axis in Point._fields},
        "status": [scan.status] * n,
    }
    values = {
        "cycle": scan.cycle,
        "step": scan.step,
        "phase": scan.phase,
        "footpoint": scan.footpoint,
        "x0": scan.state.x0,
        "x1": scan.x1,
        **_state_values(scan.state),
        "residual": scan.residual,
    }
    shapes = {"x": scan.x, "y": scan.y, "phi": scan.phi}
    if failed:
        columns |= dict.fromkeys(values, [None])
        columns |= dict.fromkeys((column.name for column in _SHAPE), [[]])
    else:
        columns |= values | {f"shape_{axis}": list(shape) for axis, shape in shapes.items()}
        columns["shape_s"] = [scan.s] * n
    return _table(SCANS, columns)


def states_table(states: Mapping[str, Any]) -> pa.Table:
    """Table of single equilibria with their shapes.

    Parameters
    ----------
    states : mapping of EquilibriumState
        By name.

    Returns
    -------
    pyarrow.Table
        With the schema `STATES`.
    """
    columns: dict[str, list[Any]] = {field.name: [] for field in STATES}
    s = np.linspace(0.0, 1.0, 101)
    for name, state in states.items():
        solved = state.status is Status.SOLVED
        shape = dict(
            zip(("x", "y", "phi"), state.shape(s) if solved else ([], [], []), strict=True)
        )
        for field in STATES:
            if field.name == "state":
                value = name
            elif field.name == "shape_s":
                value = s if solved else []
            elif field.name.startswith("shape_"):
                value = shape[field.name.removeprefix("shape_")]
            else:
                value = getattr(state, field.name)
                if not solved and field.nullable:
                    value = None
            columns[field.name].append(value)
    return _table(STATES, columns)


# --- Collecting --------------------------------------------------------------------------------


def collect(paths: Sequence[str | Path], schema: pa.Schema) -> pa.Table:
    """Read tables of one schema and put them one below the other.

    Parameters
    ----------
    paths : sequence of path
    schema : pyarrow.Schema

    Returns
    -------
    pyarrow.Table

    Raises
    ------
    TableError
        If one of the files is not what it should be.
    """
    return joined([read(path, schema) for path in paths], schema)


def joined(parts: Sequence[pa.Table], schema: pa.Schema) -> pa.Table:
    """Tables of one schema, one below the other, without the provenance of the parts."""
    bare = [part.replace_schema_metadata(schema.metadata) for part in parts]
    return pa.concat_tables(bare) if bare else schema.empty_table()


def status_counts(table: pa.Table) -> str:
    """How many rows have which status, as text."""
    counts = Counter(table.column("status").to_pylist())
    return ", ".join(f"{count} {status}" for status, count in sorted(counts.items()))


def check_points(table: pa.Table, points: Mapping[Point, Sequence[str]]) -> None:
    """Refuse a table in which a grid point is missing, stands twice or does not belong.

    Parameters
    ----------
    table : pyarrow.Table
        With the schema `STICTION`.
    points : mapping
        All points of the study with the names of the grids they belong to.

    Raises
    ------
    TableError
        With examples of the points.
    """
    names = Point._fields
    rows = list(zip(*(table.column(name).to_pylist() for name in names), strict=True))
    wanted = {tuple(float(value) for value in point): list(g) for point, g in points.items()}
    found = dict(zip(rows, table.column("grids").to_pylist(), strict=True))
    doubled = [row for row, count in Counter(rows).items() if count > 1]
    problems = {
        "missing": [row for row in wanted if row not in found],
        "doubled": doubled,
        "not in the study": [row for row in found if row not in wanted],
        "of other grids": [row for row in found if row in wanted and found[row] != wanted[row]],
    }
    for problem, examples in problems.items():
        if examples:
            shown = ", ".join(f"({', '.join(f'{v:g}' for v in row)})" for row in examples[:3])
            raise TableError(
                f"stiction: {len(examples)} grid points are {problem}, such as (theta, mu0, eta, "
                f"dx0) = {shown}; delete the study's blocks folder and run again"
            )
