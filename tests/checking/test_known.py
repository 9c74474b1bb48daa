"""Two studies that differ in many ways: the whole of what is said about it, and what is drawn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest

from known import Known
from looks import figure_described
from small_study import scans, states, stiction
from vibrissa.checking import ci, enclosures
from vibrissa.checking.layouts import parse_layouts
from vibrissa.checking.reference import bless, compare_folders
from vibrissa.checking.side_by_side import side_by_side
from vibrissa.checking.side_by_side_page import draw, lines, markdown
from vibrissa.figures import style
from vibrissa.tables import store

ROOT = Path(__file__).parents[2]
LAYOUTS = parse_layouts((ROOT / "workflow/regression.yaml").read_text(), "regression.yaml")
KNOWN = Known(__file__)
STUDY = "study: small\ngrids: {main: {theta: [1, 3, 9], mu0: [0.2]}}\n"
OTHER = "study: small\ngrids: {main: {theta: [1, 3]}}\ncontact: line\n"


def with_column(table, name, change):
    at = table.schema.get_field_index(name)
    values = [change(n, value) for n, value in enumerate(table.column(name).to_pylist())]
    return table.set_column(at, table.schema.field(at), pa.array(values, table.schema.types[at]))


def rounded(table):
    """Round a table: its numbers are the same text on every machine."""

    def shorter(value):
        if isinstance(value, list):
            return [shorter(one) for one in value]
        return round(value, 6) + 0.0 if isinstance(value, float) else value

    for name in table.schema.names:
        table = with_column(table, name, lambda _, value: shorter(value))
    return table


def moved(table, *names):
    """Move numbers of some columns, each row by another share."""
    for place, name in enumerate(names, start=1):
        shares = 1e-3 * place * (1.0 + np.arange(len(table)) ** 2.0)
        table = with_column(
            table, name, lambda n, value, s=shares: None if value is None else value * (1.0 + s[n])
        )
    return table


def written(name, study, **tables):
    path = Path("results", name)
    (path / "tables").mkdir(parents=True)
    for table, rows in tables.items():
        store.write(rows, path / f"tables/{table}.parquet", study)
    return path


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Two results folders: other numbers and outcomes, rows and a table in one alone."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(store, "commit", lambda: "0123456")
    monkeypatch.setattr(store, "writer", lambda metadata: "version 1, commit 0123456")
    points = moved(stiction(), "x0_slip", "mu_lock", "reaction_m_slip")
    points = with_column(points, "status", lambda n, value: "lock" if n in (1, 2) else value)
    points = points.filter(pc.field("mu0") != 0.2)
    steps = moved(scans(), "f", "x1").filter(pc.field("cycle") == 1)
    whole = {"stiction": stiction(), "scans": scans(), "states": states()}
    a = written("a", STUDY, **{name: rounded(table) for name, table in whole.items()})
    return a, written("b", OTHER, stiction=rounded(points), scans=rounded(steps))


def test_all_that_is_said_of_two_studies(folders):
    found = side_by_side(*folders, LAYOUTS)
    shown = {
        "changes of the study file": found.study_changes,
        "rows": found.rows,
        "moved": [
            {**vars(one), "worst": [vars(change) for change in one.worst]} for one in found.moved
        ],
        "worst": [f"{one.table}.{one.column} {change.size:.6g}" for one, change in found.worst()],
        "screen": list(lines(found)),
        "page": markdown(found).splitlines(),
    }
    KNOWN.check("side by side", shown)


def test_how_changes_are_drawn(folders, monkeypatch):
    kept = []
    monkeypatch.setattr(style, "save", lambda figure, paths: kept.append((figure, paths)))
    numbers = [one for one in side_by_side(*folders, LAYOUTS).moved if one.numbers]
    draw(numbers, [Path("a.svg")])
    ((figure, paths),) = kept
    assert paths == [Path("a.svg")]
    KNOWN.check("figure", figure_described(figure, most=99))


@pytest.fixture
def compared(folders):
    """Results beside the reference of others, of which some numbers are proved."""
    a, b = folders
    bless(compare_folders(a, Path("kept"), LAYOUTS))
    onset = rounded(stiction()).column("x0_slip").to_pylist()
    rows = [
        f"stiction,{theta},{mu0},0.85,0.01,x0_slip,{value!r},1E-15,"
        for theta, mu0, value in zip(
            ["1"] * 4 + ["3"] * 4, ["0.2", "0.3", "0.45", "0.9"] * 2, onset, strict=False
        )
        if value is not None
    ]
    head = "table,theta,mu0,eta,dx0,quantity,midpoint,radius,note"
    Path("kept/enclosures.csv").write_text("\n".join([head, *rows]) + "\n")
    return compare_folders(b, Path("kept"), LAYOUTS)


def test_all_that_is_said_of_results_beside_their_reference(compared):
    shown = {
        "verdict": compared.verdict,
        "rows": compared.rows,
        "summary": ci.markdown(compared).splitlines(),
        "machines": ci.json_text(compared).splitlines(),
        "notes": list(ci.annotations(compared)),
        "patch": compared.diff().splitlines(),
        "proofs": enclosures.verdict(compared.enclosed),
        "ulps": enclosures.histogram(compared.enclosed),
    }
    KNOWN.check("beside the reference", shown)


def test_of_many_differences_ten_are_noted_and_thirty_are_shown(compared):
    """GitHub shows no more than ten beside the files of a step."""
    many = replace(compared, differences=list(compared.differences)[:1] * 33)
    assert len(list(ci.annotations(many))) == 10
    text = ci.markdown(many)
    assert text.count(f"\n| {many.differences[0].table} ") == 30 and "And 3 more;" in text
    shortest = replace(compared, differences=list(compared.differences)[:1] * 30)
    assert "more; check.json" not in ci.markdown(shortest)
