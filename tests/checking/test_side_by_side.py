"""Two results folders side by side: study files, rows, columns, worst places, bad input."""

import importlib.util
import shutil
from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from made_up import all_points, grid, point_table
from vibrissa.checking.layouts import parse_layouts
from vibrissa.checking.side_by_side import side_by_side
from vibrissa.checking.side_by_side_page import lines, markdown
from vibrissa.errors import ComparisonError, TableError
from vibrissa.tables import query, schemas, store

ROOT = Path(__file__).parents[2]
spec = importlib.util.spec_from_file_location("compare", ROOT / "workflow/compare.py")
script = importlib.util.module_from_spec(spec)
spec.loader.exec_module(script)

LAYOUTS = parse_layouts((ROOT / "workflow/regression.yaml").read_text(), "regression.yaml")
STUDY = "study: one\ngrids: {main: {theta: [0.1, 0.2], mu0: [0.1, 0.2]}}\n"
# θ = 0.1, 0.2 and μ0 = 0.1, 0.2, in this order.
POINTS = point_table(all_points({"main": grid(theta=2, mu0=2, eta=1, dx0=1)}))
ONSETS = [0.1, 0.2, 0.3, 0.4]


def with_column(table, name, values):
    at = table.schema.get_field_index(name)
    return table.set_column(
        at, table.schema.field(at), pa.array(values, table.schema.field(at).type)
    )


TABLE = with_column(with_column(POINTS, "x0_slip", ONSETS), "mu_lock", [0.5, 0.5, 0.6, 0.6])


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def results(name, table=TABLE, study=STUDY):
    """Write a results folder with one table."""
    path = Path("results", name)
    (path / "tables").mkdir(parents=True)
    store.write(table, path / "tables/stiction.parquet", study)
    return path


def found(**second):
    return side_by_side(results("a"), results("b", **second), LAYOUTS)


def said(**second):
    return list(lines(found(**second)))


def test_equal_studies():
    assert said() == ["Nothing differs between results/a and results/b."]


def test_a_name_alone_is_one_difference_and_not_one_of_each_row():
    other = with_column(TABLE, "study", ["two"] * 4)
    line, verdict = said(table=other, study=STUDY.replace("one", "two"))
    assert line == "study file: study: one -> two"
    assert "1 key of the study file differs, 0 rows in one alone, 0 columns moved" in verdict


def test_the_study_file_by_its_keys():
    other = "study: one\ncontact: line\ngrids: {main: {theta: [0.1, 0.3]}}\n"
    assert found(study=other).study_changes == {
        "grids.main.theta": ("[0.1, 0.2]", "[0.1, 0.3]"),
        "grids.main.mu0": ("[0.1, 0.2]", ""),
        "contact": ("", "line"),
    }


def test_a_column_that_moved_and_where_it_moved_most():
    moved = found(table=with_column(TABLE, "x0_slip", [0.2, 0.2, 0.3, 0.55]))
    (column,) = moved.differences
    assert (column.column, column.rows, column.of) == ("x0_slip", 2, 4)
    assert column.absolute.size == pytest.approx(0.15)
    assert column.relative.size == pytest.approx(0.5)
    assert column.relative.row == {"theta": "0.1", "mu0": "0.1", "eta": "0.1", "dx0": "0.1"}
    worst = [(change.row["theta"], change.row["mu0"], change.size) for _, change in moved.worst()]
    assert worst == [
        ("0.1", "0.1", pytest.approx(0.5)),
        ("0.2", "0.2", pytest.approx(0.15 / 0.55)),
    ]


def test_a_row_is_among_the_worst_once_with_the_column_that_changed_most():
    table = with_column(TABLE, "x0_slip", [0.11, 0.2, 0.3, 0.4])
    table = with_column(table, "x0_end", [0.5] * 4)
    before = with_column(TABLE, "x0_end", [1.0, 0.5, 0.5, 0.5])
    moved = side_by_side(results("a", before), results("b", table), LAYOUTS)
    ((one, change),) = moved.worst()
    assert (one.column, change.size) == ("x0_end", 0.5)


def test_what_moves_within_the_tolerance_of_the_reference_tables_has_not_moved():
    near = with_column(TABLE, "x0_slip", [value + 0.9e-9 for value in ONSETS])
    assert found(table=near).moved == []


def test_of_a_long_table_no_more_is_held_than_a_column(monkeypatch):
    asked = []
    rows = query.rows

    def noted(table, columns, where=None):
        asked.append(list(columns))
        return rows(table, columns, where)

    monkeypatch.setattr(query, "rows", noted)
    assert len(found(table=with_column(TABLE, "x0_slip", [0.2, 0.2, 0.3, 0.55])).moved) == 1
    compared = {*LAYOUTS["stiction"].keys, *LAYOUTS["stiction"].columns} - {"study"}
    assert sorted(asked) == sorted([column] for column in compared for _ in "ab")


def test_outcomes_are_counted():
    table = with_column(TABLE, "status", ["lock", "slip", "lock", "failed"])
    (column,) = found(table=table).moved
    assert column.outcomes == ["slip -> lock (2)", "slip -> failed (1)"]
    row = "| stiction.status | 3 of 4 | slip -> lock (2); slip -> failed (1) | – |"
    assert row in markdown(found_again())


def found_again():
    return side_by_side(Path("results/a"), Path("results/b"), LAYOUTS)


def test_rows_in_one_alone():
    (point, names), *_ = all_points({"main": grid(theta=1, mu0=1, eta=1, dx0=1)})
    more = point_table([((Decimal("0.7"), *point[1:]), names)])
    text = said(table=pa.concat_tables([TABLE.slice(1), more]))
    assert "stiction: 1 row in A alone: theta 0.1, mu0 0.1, eta 0.1, dx0 0.1" in text
    assert "stiction: 1 row in B alone: theta 0.7, mu0 0.1, eta 0.1, dx0 0.1" in text
    assert "curves: 1 row in B alone: theta 0.7, eta 0.1" in text


def test_rows_that_stand_twice():
    text = said(table=pa.concat_tables([TABLE, TABLE.slice(0, 1)]))
    assert "stiction: 1 rows stand twice in B: theta 0.1, mu0 0.1, eta 0.1, dx0 0.1" in text


def test_a_table_in_one_alone():
    a, b = results("a"), results("b")
    state = schemas.STATES.empty_table()
    row = {
        field.name: None if field.nullable else "s" if field.type == pa.string() else 1.0
        for field in state.schema
    } | {field.name: [0.0] for field in state.schema if pa.types.is_list(field.type)}
    state = pa.Table.from_pylist([row], schema=schemas.STATES)
    store.write(state, b / "tables/states.parquet", STUDY)
    assert list(lines(side_by_side(a, b, LAYOUTS))) == [
        "states: the table is in B alone, 1 row",
        "results/a (A) and results/b (B): 0 keys of the study file differ, 0 rows in one alone, "
        "0 columns moved, 1 table in one alone",
    ]


@pytest.mark.slow
def test_the_page_and_the_figure(capsys):
    rows = np.multiply(ONSETS, 1 + 1e-3)
    results("a"), results("b", with_column(TABLE, "x0_slip", rows), STUDY.replace("0.2", "0.3"))
    assert script.main(["results/a", "results/b/"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "results/compare/a-b/comparison.md"
    page = Path("results/compare/a-b/comparison.md").read_text()
    assert "| stiction.x0_slip | 4 of 4 | 0.0004 at theta 0.2, mu0 0.2" in page
    assert "| grids.main.theta | [0.1, 0.2] | [0.1, 0.3] |" in page
    assert "(changes.png)" in page
    figures = [Path("results/compare/a-b", f"changes.{kind}") for kind in ("png", "svg")]
    assert all(path.stat().st_size > 1000 for path in figures)

    shutil.copytree("results/a", "results/other/b")
    assert script.main(["results/a", "results/other/b", "--output", "results/compare/a-b"]) == 0
    assert not any(path.exists() for path in figures)


def test_a_folder_of_another_version_is_refused():
    schema = TABLE.schema.metadata | {store.VERSION: b"3"}
    results("old", TABLE.replace_schema_metadata(schema))
    with pytest.raises(TableError, match="has version 3 of the columns, and this program reads"):
        side_by_side(results("new"), Path("results/old"), LAYOUTS)


def test_one_study_at_two_commits(monkeypatch):
    results("a")
    monkeypatch.setattr(store, "commit", lambda: "0123456")
    results("b")
    found = found_again()
    assert "commit 0123456 |" in markdown(found)
    made_by, verdict = lines(found)
    before, now = (origin.programs["stiction"] for origin in found.origins)
    assert made_by == f"made by: {before} -> {now}"
    assert now.endswith("commit 0123456") and not before.endswith("commit 0123456")
    assert verdict.startswith("Nothing differs")


def test_the_screen_shows_the_first_keys_and_the_page_all():
    many = STUDY + "".join(f"x{i}: {i}\n" for i in range(12))
    found = side_by_side(results("a"), results("b", study=many), LAYOUTS)
    text = list(lines(found))
    assert text[9:11] == [
        "study file: x9: nothing -> 9",
        "study file: 2 more keys; comparison.md has all of them",
    ]
    assert "| x11 | – | 11 |" in markdown(found)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["", "results/a"], "say which results: make compare A=results/a B=results/b"),
        (["results/a", "none"], "none is no folder; allowed: results/<study>"),
        (["results/a", "."], ". has no tables/stiction.parquet; run the study first"),
        (["results/a", "results/../results/a"], "A and B are the same folder, results/a; give two"),
        (["results/a", "damaged"], "damaged/tables/stiction.parquet cannot be read"),
    ],
)
def test_bad_input_is_one_line(arguments, message, capsys):
    results("a")
    Path("damaged/tables").mkdir(parents=True)
    Path("damaged/tables/stiction.parquet").write_bytes(b"PAR1 no")
    assert script.main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {message}")
    assert not Path("results/compare").exists()


def test_no_folder_is_a_comparison_error():
    with pytest.raises(ComparisonError):
        side_by_side(Path("a"), Path("b"), LAYOUTS)
