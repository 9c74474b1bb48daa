import re
from dataclasses import fields, replace
from decimal import Decimal
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from vibrissa import Mounting, __version__, solve_curve, solve_state, stick_slip
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.mechanics.states import ContactState
from vibrissa.outcomes import Contact, Parameter, Solver, Status
from vibrissa.provenance import commit
from vibrissa.sticking.api import EquilibriumState
from vibrissa.sticking.assembly import Solved, assembled_curves
from vibrissa.sticking.comparison import compare
from vibrissa.sticking.curve import failed_curve
from vibrissa.sticking.piece import MARGINS, Piece
from vibrissa.study.codec import decode_grid, decode_key
from vibrissa.study.grid import points_on_curves
from vibrissa.tables import query, records, schemas, store
from vibrissa.tables.collect import collect
from vibrissa.tables.parquet import digests
from vibrissa.tables.points import points_tables
from vibrissa.tables.schemas import COMPARISONS, CURVES, SCANS, STATE, STATES, STICTION, YOUNGER

SCHEMAS = {"curves": CURVES, "stiction": STICTION, "scans": SCANS, "states": STATES}
SCHEMAS |= {"comparisons": COMPARISONS}
ENDS = {"−∞": -np.inf, "−π": -np.pi, "−π/2": -np.pi / 2, "0": 0, "1": 1}
ENDS |= {"π/2": np.pi / 2, "π": np.pi, "2π": 2 * np.pi, "∞": np.inf}
UNITS = {"L", "E*I0/L^2", "E*I0/L", "rad", "1", "rad*L/(E*I0)", "1/L"}
AGAIN = "delete it and run again, it is made anew"


def curve_by_shooting(curve, states):
    """A curve as the shooting method makes it, from states of another one."""
    x0 = np.linspace(0.0, 1.05 * curve.x0_lock, states)
    piece = Piece(
        contact=Contact.POINT,
        parameter=Parameter.X0,
        start=0.0,
        stop=float(x0[-1]),
        states=replace(curve.state(x0), **dict.fromkeys(MARGINS, np.full(states, np.nan))),
        stepped=True,
    )
    solved = Solved(
        theta=curve.theta,
        eta=curve.eta,
        method=Solver.SHOOTING,
        x1_init=curve.x1_init,
        pieces=[piece],
        residual=1e-10,
    )
    return assembled_curves([solved])[0]


@cache
def collocation():
    return solve_curve(theta=2, eta=0.85)


@cache
def curved():
    return solve_curve(theta=2, eta=0.85, mounting=Mounting(curvature=(-0.05, 0.0, 0.1)))


FAILED = failed_curve(theta=3.0, eta=0.85, method="collocation", message="no luck; try less")
METHODS = ("collocation", "mounted", "shooting")


@cache
def curves_of(method):
    """Curves of a table by their key."""
    if method == "shooting":
        return {decode_key(["2", "0.85", "0.001"]): curve_by_shooting(collocation(), 60)}
    if method == "collocation":
        return {
            decode_key(["2", "0.85"]): collocation(),
            decode_key(["3", "0.85"]): FAILED,
            # In two pieces.
            decode_key(["5", "0.85"]): solve_curve(theta=5, eta=0.85, contact="line"),
        }
    tilted = solve_curve(2, 0.85, mounting=Mounting(clamp_angle=0.02, curvature=-0.1))
    # Past its lock it is counted by an advance that begins below 0.
    leaning = solve_curve(1, 0.4, contact="line", mounting=Mounting(clamp_angle=-0.35))
    return {
        decode_key(["2", "0.85", "clamp_angle=0.02", "curvature=-0.1"]): tilted,
        decode_key(["2", "0.85", "curvature=-0.05, 0, 0.1"]): curved(),
        decode_key(["1", "0.4", "clamp_angle=-0.35"]): leaning,
    }


def grid(theta=("2",), mu0=("0.2", "0.4"), eta=("0.85",), dx0=("0.001",)):
    return decode_grid({"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0})


def stiction_table(curve, key, grids):
    ((_, points),) = points_on_curves([decode_key(key)], grids)
    (table,) = points_tables([(points, curve)], "a")
    return table


def scan_table(curve, mu0, cycles=2):
    (point,) = grid(mu0=(mu0,), dx0=("0.01",)).points()
    scan = stick_slip(curve, point.mu0, point.dx0, cycles)
    return records.scan_table("runs", point, scan, study="a", method=curve.method)


def failed_state():
    return EquilibriumState(
        **dict.fromkeys(ContactState.names(), float("nan")),
        status=Status.FAILED,
        message="no luck",
        contact="point",
        theta=1.0,
        x1=0.1,
        eta=0.5,
        residual=float("nan"),
    )


GRIDS = {"more": grid(mu0=("0.3", "0.4", "2.5")), "main": grid()}


@cache
def tables():
    """A table of each kind with every status that it can have."""
    curve, curves = collocation(), curves_of("collocation")
    points = [
        stiction_table(curve, ("2", "0.85"), GRIDS),
        stiction_table(FAILED, ("3", "0.85"), {"main": grid(theta=("3",))}),
    ]
    scans = [scan_table(curve, "0.3"), scan_table(curve, "2.5"), scan_table(FAILED, "0.3")]
    return {
        "curves": records.curves_table(list(curves), list(curves.values())),
        "stiction": store.joined(points, STICTION),
        "scans": store.joined(scans, SCANS),
        "states": records.states_table({"a": solve_state(1, 0.55, 0.15), "b": failed_state()}, "a"),
        "comparisons": records.comparison_table("both", compare([1, 8], [0.2, 9], [0.85]), "a"),
    }


@pytest.fixture
def path(tmp_path):
    return tmp_path / "table.parquet"


@pytest.mark.parametrize("kind", schemas.TABLES)
def test_every_column_has_a_unit_and_a_description(kind):
    for field in schemas.TABLES[kind]:
        assert field.metadata[b"unit"].decode() in UNITS, field.name
        assert field.metadata[b"description"].strip(), field.name


@pytest.mark.slow
@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_value_is_in_the_range_of_its_column(kind):
    for field in SCHEMAS[kind]:
        values = tables()[kind].column(field.name).combine_chunks().drop_null()
        if pa.types.is_list(field.type):
            values = values.flatten()
        range = field.metadata[schemas.RANGE].decode()
        if interval := re.fullmatch(r"([\[(])(.+), (.+)([\])])", range):
            opening, *ends, closing = interval.groups()
            low, high = (ENDS[end] for end in ends)
            numbers = values.to_numpy(zero_copy_only=False).astype(float)
            numbers = numbers[~np.isnan(numbers)]  # the stability of a failed path
            assert ((numbers >= low) if opening == "[" else (numbers > low)).all(), field.name
            assert ((numbers <= high) if closing == "]" else (numbers < high)).all(), field.name
        elif range and field.name != "study":
            assert set(values.to_pylist()) <= set(range.split(", ")), field.name


def test_columns_of_the_stiction_table():
    reactions = ("reaction_fx", "reaction_fy", "reaction_m")
    states = ("f", "alpha", "phi1", "s_c", *reactions, *MARGINS)
    assert STICTION.names == [
        *("study", "method", "grids", "added_to", "theta", "mu0", "eta", "dx0"),
        *("clamp_angle", "clamp_compliance", "curvature", "stage_angle", "curvature_powers"),
        *("status", "message", "contact"),
        *("x0_slip", "x0_max", "n_steps", "mu_lock", "x0_lock"),
        *(f"{name}{suffix}" for suffix in ("_init", "_last", "_slip") for name in states),
        *("ends_by", "x0_end", *(f"{name}_end" for name in states)),
        *("x0_trail", *(f"{name}_trail" for name in states)),
        *("x1_init", "penetrates", "residual"),
    ]


@pytest.mark.parametrize("kind", SCHEMAS)
def test_a_table_comes_back_from_its_file(kind, path):
    store.write(tables()[kind], path)
    table = store.read(path, SCHEMAS[kind])
    assert table.equals(tables()[kind])
    assert [f.metadata for f in table.schema] == [f.metadata for f in SCHEMAS[kind]]


@pytest.mark.parametrize("method", METHODS)
def test_curves_come_back_bit_for_bit(method, path):
    curves = curves_of(method)
    store.write(records.curves_table(list(curves), list(curves.values())), path)
    restored = records.curves_from_table(store.read(path, CURVES))
    assert list(restored) == list(curves)
    for key, curve in curves.items():
        assert len(curve.pieces) == len(restored[key].pieces)
        assert len(curve.pulled) == len(restored[key].pulled)
        assert restored[key].mounting == curve.mounting
        parts = ("pieces", "pulled", "mounting")
        scalars = [field.name for field in fields(curve) if field.name not in parts]
        pairs = [(getattr(curve, name), getattr(restored[key], name)) for name in scalars]
        pieces = [(*one.pulled, *one.pieces) for one in (curve, restored[key])]
        for old, new in zip(*pieces, strict=True):
            known = [f.name for f in fields(old) if f.name != "states"]
            pairs += [(getattr(old, name), getattr(new, name)) for name in known]
            pairs += [(values, new.states.columns[n]) for n, values in old.states.columns.items()]
        for old, new in pairs:
            old, new = np.asarray(old), np.asarray(new)
            assert (old.dtype, old.tobytes()) == (new.dtype, new.tobytes())
        if curve.status is Status.SOLVED:
            x0 = np.linspace(0, curve.x0_end, 7)
            state, again = curve.state(x0).matrix(), restored[key].state(x0).matrix()
            assert np.array_equal(state, again, equal_nan=True)


def test_points_of_several_curves_come_in_tables_of_a_row_group(monkeypatch):
    monkeypatch.setattr("vibrissa.tables.points.LEAST_ROW_GROUP", 5)
    curves = [("2", collocation()), ("3", FAILED), ("2", collocation())]
    read = []
    for theta, curve in curves:
        grids = {"g": grid((theta,), ("0.1", "0.2", "9"))}
        ((_, points),) = points_on_curves([decode_key([theta, "0.85"])], grids)
        read.append((points, curve))
    several = list(points_tables(iter(read), "a"))
    assert [len(table) for table in several] == [6, 3]
    monkeypatch.setattr("vibrissa.tables.points.CURVES_AT_ONCE", 1)
    assert [len(table) for table in points_tables(iter(read), "a")] == [3, 3, 3]
    alone = [table for one in read for table in points_tables([one], "a")]
    assert pa.concat_tables(several).equals(pa.concat_tables(alone))


def rows(kind, status):
    """Rows of a status, and the columns that hold nothing in each of them."""
    found = [row for row in tables()[kind].to_pylist() if row["status"] == status]
    assert found
    return found, [{name for name, value in row.items() if value is None} for row in found]


def states(suffix):
    return [f"{column.name}{suffix}" for column in STATE]


def nullable(schema):
    return {field.name for field in schema if field.nullable}


@pytest.mark.parametrize(
    ("kind", "status", "nothing"),
    [
        ("curves", "failed", nullable(CURVES)),
        (
            "stiction",
            "slip",
            {"ends_by", "x0_end", *states("_end"), "x0_trail", *states("_trail"), *YOUNGER},
        ),
        (
            "stiction",
            "lock",
            {"x0_slip", "x0_max", "n_steps", *states("_last"), *states("_slip"), *YOUNGER},
        ),
        ("stiction", "failed", nullable(STICTION)),
        ("scans", "slip", {"curvature_powers"}),
        ("scans", "lock", {"curvature_powers"}),
        ("scans", "failed", nullable(SCANS)),
        ("states", "solved", set()),
        ("states", "failed", nullable(STATES)),
    ],
)
def test_what_does_not_exist_is_null_and_nothing_else(kind, status, nothing):
    found, nulls = rows(kind, status)
    assert nulls == [nothing] * len(found)
    assert not any(
        isinstance(value, float) and np.isnan(value) for row in found for value in row.values()
    )


def test_a_lock_has_no_onset():
    _, (nulls,) = rows("stiction", "lock")
    ends = {name for name in STICTION.names if name.endswith(("_last", "_slip"))}
    assert nulls == ends | {"x0_slip", "x0_max", "n_steps", *YOUNGER}


def test_a_polynomial_curvature_is_a_number_and_a_text():
    key = ["2", "0.85", "curvature=-0.05, 0, 0.1"]
    grids = {"g": replace(grid(), curvature=(decode_key(key).curvature,))}
    row = stiction_table(curved(), key, grids).to_pylist()[0]
    assert (row["curvature"], row["curvature_powers"]) == (-0.05, "0, 0.1")
    (point, _) = grids["g"].points()
    scan = stick_slip(curved(), 0.1, 0.01, 1)
    row = records.scan_table("runs", point, scan, study="a", method="collocation").to_pylist()[0]
    assert (row["curvature"], row["curvature_powers"]) == (-0.05, "0, 0.1")


@pytest.mark.slow
def test_a_table_from_before_there_were_polynomials_is_read(path):
    old = tables()["stiction"].drop_columns(list(YOUNGER))
    store.write(old, path)
    assert store.read(path, STICTION).equals(tables()["stiction"])
    rows = query.rows(query.opened(path, STICTION), STICTION.names)
    assert rows.equals(tables()["stiction"])
    order = ("theta", "curvature_powers", "mu0", "dx0")
    merged = pa.concat_tables(collect([path], STICTION, order).parts)
    assert merged["curvature_powers"].null_count == len(merged) == len(old)
    # What has always been there must be there.
    store.write(tables()["stiction"].drop_columns(["x0_trail"]), path)
    with pytest.raises(DamagedTableError, match="has other columns than its schema says"):
        store.read(path, STICTION)


@pytest.mark.parametrize("kind", ["scans", "states"])
def test_what_failed_has_no_shape(kind):
    (row,), _ = rows(kind, "failed")
    assert [row[f"shape_{axis}"] for axis in ("s", "x", "y", "phi")] == [[]] * 4


def test_sticking_that_ends_before_the_curve_does_has_its_own_end():
    curve = solve_curve(1.5, 0.5, contact="line", section="planar")
    mu0 = Decimal(str(round(curve.mu_lock + 0.001, 4)))
    table = stiction_table(curve, ("1.5", "0.5"), {"g": grid(["1.5"], [str(mu0)], ["0.5"])})
    (row,) = table.to_pylist()
    _, ended = curve.motion_end(float(mu0))
    assert (row["status"], row["ends_by"]) == ("lock", "slips_back")
    assert row["x0_end"] == ended.x0[0] < curve.x0_end - 1e-3
    assert row["f_end"] == pytest.approx(ended.f[0], rel=1e-12)


def test_a_failed_curve_says_why():
    (row,), _ = rows("curves", "failed")
    assert (row["theta"], row["eta"], row["message"]) == ("3", "0.85", "no luck; try less")


def test_a_point_names_its_grids():
    found, _ = rows("stiction", "slip")
    assert [(row["mu0"], row["grids"]) for row in found] == [
        (0.2, ["main"]),
        (0.3, ["more"]),
        (0.4, ["main", "more"]),
    ]


def test_the_columns_of_a_scan_are_the_scan():
    scan = stick_slip(collocation(), Decimal("0.3"), Decimal("0.01"), 2)
    found, _ = rows("scans", "slip")
    assert [row["shape_x"] for row in found] == scan.x.tolist()
    assert [row["shape_phi"] for row in found] == scan.phi.tolist()
    assert [row["shape_s"] for row in found] == [scan.s.tolist()] * len(found)
    for name in ("footpoint", "x1", "step", "cycle", "residual", "phase"):
        assert [row[name] for row in found] == list(getattr(scan, name))
    for name in ("x0", "f", "alpha", "reaction_m"):
        assert [row[name] for row in found] == getattr(scan.state, name).tolist()


def test_the_columns_of_a_state_are_the_state():
    state = solve_state(1, 0.55, 0.15)
    (row,), _ = rows("states", "solved")
    for name in ("theta", "eta", "x1", "f", "alpha", "phi1", "reaction_fx", "penetrates"):
        assert row[name] == getattr(state, name)
    x, y, phi = state.shape(np.array(row["shape_s"]))
    assert [row["shape_x"], row["shape_y"], row["shape_phi"]] == [
        *map(np.ndarray.tolist, (x, y, phi))
    ]


def test_a_file_tells_where_it_is_from(path):
    store.write(tables()["states"], path, study_file="study: paper\n")
    metadata = store.read(path, STATES).schema.metadata
    assert metadata[b"vibrissa.table"] == b"states"
    assert metadata[b"vibrissa.version"] == __version__.encode()
    assert metadata[b"vibrissa.commit"] == commit().encode()
    assert metadata[b"vibrissa.study"] == b"study: paper\n"


def test_an_empty_place_where_none_may_be_is_refused(path):
    """Whether this program is asked to write it, or another one wrote it."""
    table = tables()["states"]
    nothing = pa.nulls(len(table), pa.string())
    place = table.column_names.index("status")
    asked = pa.Table.from_arrays(
        [*table.columns[:place], nothing, *table.columns[place + 1 :]], schema=table.schema
    )
    with pytest.raises(TableError, match="column status must not be empty anywhere"):
        store.write(asked, path)
    empty = table.set_column(place, "status", nothing)
    pq.write_table(empty.replace_schema_metadata(table.schema.metadata), path)
    with pytest.raises(TableError, match="has other columns than its schema says"):
        store.read(path, STATES)


def test_a_missing_file_is_refused(path):
    with pytest.raises(TableError, match=f"{path} cannot be read .*; see why, and run again"):
        store.read(path, CURVES)


def test_a_file_cut_short_anywhere_is_refused(path):
    store.write(tables()["curves"], path)
    data = path.read_bytes()
    for length in [*range(0, len(data), 97), len(data) - 1]:
        path.write_bytes(data[:length])
        with pytest.raises(TableError, match=f"{path} cannot be read .*{AGAIN}"):
            store.read(path, CURVES)


def flipped(data, position, bits):
    return data[:position] + bytes([data[position] ^ bits]) + data[position + 1 :]


@pytest.mark.slow
@pytest.mark.parametrize(("start", "bits"), [(0, 1), (3, 16), (6, 128), (9, 255)])
def test_a_changed_byte_never_changes_the_table_silently(path, start, bits):
    store.write(tables()["curves"], path)
    data = path.read_bytes()
    refused = 0
    for position in range(start, len(data), 41):
        path.write_bytes(flipped(data, position, bits))
        try:
            table = store.read(path, CURVES)
        except TableError as error:
            assert str(path) in str(error) and str(error).endswith(AGAIN)
            refused += 1
        else:
            # The name of the digest was hit.
            assert digests.DIGEST not in pq.read_metadata(path).metadata
            assert table.equals(tables()["curves"]), position
    assert refused > len(data) / 41 / 2


@pytest.mark.parametrize(
    ("key", "words"), [(store.TABLE, "holds the table"), (store.VERSION, "has version")]
)
@pytest.mark.parametrize("value", [b"", b"9", b"\xb3", b"\x00"])
def test_another_kind_or_version_of_table_is_refused_however_it_is_spelled(path, key, words, value):
    table = tables()["curves"]
    store.write(table.replace_schema_metadata({**table.schema.metadata, key: value}), path)
    with pytest.raises(TableError, match=f"{path} {words} "):
        store.read(path, CURVES)


def test_a_table_of_another_version_says_what_to_do(path):
    table = tables()["states"]
    older = table.replace_schema_metadata({**table.schema.metadata, store.VERSION: b"4"})
    store.write(older, path)
    with pytest.raises(TableError) as caught:
        store.read(path, STATES)
    assert str(caught.value) == (
        f"{path} has version 4 of the columns, and this program reads version "
        f"{schemas.SCHEMA_VERSION}; run its study again, or read it with the program that wrote it "
        f"(version {__version__}, commit {commit()})"
    )


def test_every_row_says_where_it_is_from():
    for name in ("stiction", "scans", "states", "comparisons"):
        rows = tables()[name].select(["study", "method"]).to_pylist()
        assert rows == [{"study": "a", "method": "collocation"}] * len(tables()[name])
    (curve,) = curves_of("shooting").values()
    ((_, points),) = points_on_curves(curves_of("shooting"), {"g": grid()})
    (table,) = points_tables([(points, curve)], "b")
    assert set(table["method"].to_pylist()) == {"shooting"}
    scan = stick_slip(collocation(), Decimal("0.3"), Decimal("0.01"), 1)
    (point,) = grid(mu0=("0.3",), dx0=("0.01",)).points()
    table = records.scan_table("runs", point, scan, study="b", method=Solver.SHOOTING)
    assert set(table["method"].to_pylist()) == {"shooting"}
    # No table is without the two.
    for schema in schemas.TABLES.values():
        assert "method" in schema.names
        assert schema is CURVES or "study" in schema.names


def test_a_table_of_another_kind_is_refused(path):
    store.write(tables()["states"], path)
    with pytest.raises(TableError, match=r"holds the table states where scans is needed"):
        store.read(path, SCANS)


def test_a_file_of_another_program_is_refused(path):
    pq.write_table(pa.table({"x": [1]}), path)
    with pytest.raises(
        TableError, match=f"{path} holds the table none where curves is needed; {AGAIN}"
    ):
        store.read(path, CURVES)


@pytest.mark.parametrize(
    "change",
    [
        lambda table: table.drop_columns(["residual"]),
        lambda table: table.append_column("more", pa.array([1] * len(table))),
        lambda table: pa.table(
            table.columns, [*table.column_names[:-1], "x0_land"], metadata=table.schema.metadata
        ),
        lambda table: table.select(table.column_names[::-1]),
        lambda table: table.set_column(8, "x1_init", pa.array([1] * len(table))),
    ],
    ids=["missing", "more", "names", "order", "type"],
)
def test_other_columns_are_refused(path, change):
    store.write(change(tables()["curves"]), path)
    with pytest.raises(TableError, match=f"{path} has other columns .*{AGAIN}"):
        store.read(path, CURVES)


@pytest.mark.parametrize("column", ["status", "eta"])
def test_a_gap_in_a_required_column_is_refused(path, column):
    table = tables()["states"]
    index = STATES.get_field_index(column)
    gap = pa.array([None, *table.column(column).to_pylist()[1:]], STATES.field(index).type)
    with pytest.raises(TableError, match=f"{path}: column {column} must not be empty"):
        store.write(table.set_column(index, STATES.field(index), gap), path)
    assert not path.exists()


def test_a_failed_write_leaves_the_old_table(path, monkeypatch):
    store.write(tables()["states"], path)
    before = path.read_bytes()

    def full_disk(writer, table):
        Path(writer.where).write_bytes(b"half")
        raise OSError("No space left on device")

    monkeypatch.setattr(pq.ParquetWriter, "write_table", full_disk)
    with pytest.raises(OSError, match="No space left"):
        store.write(tables()["states"], path)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_statuses_are_counted():
    table = tables()["stiction"]
    assert store.status_counts([table]) == {"failed": 2, "lock": 1, "slip": 3}
    assert store.status_counts([table.slice(0, 2), table.slice(2)]) == {
        "failed": 2,
        "lock": 1,
        "slip": 3,
    }
    assert store.status_counts([]) == {}


def test_longer_tables_have_larger_row_groups():
    sizes = [store.row_group_size(10**n) for n in range(10)]
    assert sizes == sorted(sizes) and sizes[0] == sizes[6] == 2**14
    # The end of the file stays a small part of it.
    assert all(10**n / size * 8_000 < 1e8 for n, size in enumerate(sizes))
