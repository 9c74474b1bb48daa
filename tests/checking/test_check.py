"""`make check`: what moved is found, in words that say where, and nothing else is."""

import json
import math
import runpy
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest

import made_tables
import small_study
from vibrissa.checking import reference
from vibrissa.checking.condensing import condensed_parts
from vibrissa.checking.differences import moved
from vibrissa.checking.reference import as_text, bless, compare_folders
from vibrissa.checking.tolerances import Tolerance, read_layouts
from vibrissa.computing.comparisons import comparison_table
from vibrissa.errors import ComparisonError
from vibrissa.sticking.comparison import compare
from vibrissa.study.reading import read_study
from vibrissa.tables import query, store

ROOT = Path(__file__).parents[2]
LAYOUTS = read_layouts(ROOT / "workflow/regression.yaml")
STUDY = """study: a
grids: {g: {theta: [2], mu0: [0.2, 0.4], eta: [0.85], dx0: [0.001], clamp_angle: [0, 0.05]}}
"""
AXES = made_tables.grid(clamp_angle=(0.0, 0.05))


@pytest.fixture(scope="module")
def stiction():
    return made_tables.points("g", AXES, study="a")


def with_results(root, name, table, **more):
    """Folder of results with some tables."""
    folder = root / "results" / name
    (folder / "tables").mkdir(parents=True, exist_ok=True)
    for kind, one in ({"stiction": table} | more).items():
        store.write(one, folder / f"tables/{kind}.parquet", f"study: {name}\n")
    return folder


def condensed(folder):
    """Condensed tables, each with all of its parts."""
    return {name: pd.concat(parts) for name, parts in condensed_parts(folder).items()}


def changed(table, column, row, value):
    """Return a table with another value in one place."""
    values = table[column].to_pylist()
    values[row] = value
    place = table.schema.get_field_index(column)
    kind = table.schema.field(column)
    return table.set_column(place, kind, pa.array(values, kind.type))


@pytest.fixture
def blessed(tmp_path, stiction):
    """Folders of results and of its reference tables."""
    results, folder = with_results(tmp_path, "a", stiction), tmp_path / "reference"
    bless(results, folder, LAYOUTS)
    return results, folder


def compared(blessed):
    return compare_folders(*blessed, LAYOUTS)


def told(blessed):
    return [one.text for one in compared(blessed).differences]


def test_what_was_blessed_is_unchanged(blessed):
    found = compared(blessed)
    assert not found.differences and found.rows == 4 + 2
    assert found.verdict.startswith("Unchanged: all 6 rows of ")
    assert sorted(path.name for path in blessed[1].iterdir()) == ["curves.csv", "stiction.csv"]


def test_keys_that_differ_in_the_last_digit_stay_two_rows(tmp_path):
    values = (0.3, 0.30000000000000004)
    results = with_results(tmp_path, "c", made_tables.points("g", made_tables.grid(mu0=values)))
    bless(results, tmp_path / "reference", LAYOUTS)
    assert not compare_folders(results, tmp_path / "reference", LAYOUTS).differences
    rows = pd.read_csv(tmp_path / "reference/stiction.csv", dtype=str)
    assert rows["mu0"].tolist() == ["0.3", "0.30000000000000004"]


def test_two_clamp_angles_are_two_rows_and_a_point_of_two_grids_has_two(tmp_path):
    parts = [made_tables.points(name, AXES) for name in ("g", "h")]
    results = with_results(tmp_path, "b", pa.concat_tables(parts))
    found = condensed(results)
    assert (len(found["stiction"]), len(found["curves"])) == (8, 2)
    bless(results, tmp_path / "r", LAYOUTS)
    assert told((results, tmp_path / "r")) == []


def test_scans_of_two_mountings_are_two(tmp_path, stiction):
    study = tmp_path / "s.yaml"
    scan = "{theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.02], cycles: 2, curvature: [0, [0, 0.1]]}"
    study.write_text(STUDY + f"scans: {{s: {scan}}}\n")
    scans = made_tables.scans("s", read_study(study).scans["s"])
    results = with_results(tmp_path, "a", stiction, scans=scans.steps, periods=scans.periods)
    assert len(condensed(results)["scans"]) == 4
    bless(results, tmp_path / "r", LAYOUTS)
    assert told((results, tmp_path / "r")) == []


@pytest.mark.parametrize(
    ("column", "by", "moves"),
    [
        ("x0_slip", 1e-10, False),
        ("x0_slip", 1e-7, True),
        ("n_steps", 1, True),
        ("f_last", 1e-8, True),
        ("study", "b", False),
        ("method", "shooting", False),
        ("status", "failed", True),
    ],
)
def test_a_value_moves_by_more_than_its_tolerance_or_not(tmp_path, stiction, column, by, moves):
    results = with_results(tmp_path, "a", stiction)
    bless(results, tmp_path / "r", LAYOUTS)
    value = by if isinstance(by, str) else stiction[column][3].as_py() + by
    other = with_results(tmp_path, "other", changed(stiction, column, 3, value))
    lines = told((other, tmp_path / "r"))
    assert bool(lines) == moves
    if moves:
        (line,) = lines
        assert line.startswith(f"stiction.{column}: 1 of 4 rows moved ")
        assert "grid g, theta 2, mu0 0.4, eta 0.85, dx0 0.001, clamp_angle 0.05" in line
        if not isinstance(by, str):
            assert f"by up to {by:.2g} (relative " in line


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_relative_tolerance_is_of_the_size_of_the_reference_and_the_other_is_zero(sign):
    before, after = (pd.Series([sign * 100.0] * 2), pd.Series([sign * 100.0005, sign * 100.002]))
    for tolerance in (Tolerance(relative=1e-5), Tolerance(absolute=1e-3)):
        assert moved(before, after, tolerance).tolist() == [False, True]


def test_steps_are_condensed_a_part_at_a_time(tmp_path, stiction, monkeypatch):
    """The parts of a file divide cycles, and the scan without states has no cycle."""
    tables = {name: table for name, table in small_study.tables().items() if name != "stiction"}
    whole = condensed(with_results(tmp_path, "whole", stiction, **tables))
    monkeypatch.setattr(store, "ROW_GROUP", 3)
    parts = condensed(with_results(tmp_path, "parts", stiction, **tables))
    assert len(whole["scans"]) == 2 + 2 + 1
    for name, table in whole.items():
        one, other = (as_text(frame, LAYOUTS[name]) for frame in (parts[name], table))
        pd.testing.assert_frame_equal(one, other)


def test_differences_do_not_depend_on_how_many_rows_are_compared_together(
    tmp_path, stiction, monkeypatch
):
    tables = small_study.tables()
    results = with_results(tmp_path, "one", **{"table": tables.pop("stiction"), **tables})
    tables = small_study.tables()
    moved, less = tables["periods"], tables["stiction"].slice(2)
    other = changed(changed(moved, "travel", 0, 0.5), "travel", 1, 0.7)
    more = {"scans": tables["scans"], "states": tables["states"], "periods": other}
    other = with_results(tmp_path, "other", pa.concat_tables([less, less.slice(0, 1)]), **more)

    def found():
        """What differs; the rows that are named as examples may be others."""
        differences = compare_folders(results, other, LAYOUTS).differences
        return [(one.problem, one.column, one.rows, one.absolute) for one in differences]

    together = found()
    assert len(together) == 3 and ("moved", "travel", 2, pytest.approx(0.69, abs=0.01)) in together
    monkeypatch.setattr(reference, "AT_ONCE", 10)
    assert sorted(found()) == sorted(together)
    bless(results, tmp_path / "r", LAYOUTS)
    assert told((results, tmp_path / "r")) == []


@pytest.mark.slow
def test_rows_and_tables_that_come_and_go_are_told(tmp_path, blessed, stiction):
    _, folder = blessed
    fewer = with_results(tmp_path, "fewer", stiction.slice(1))
    (line,) = told((fewer, folder))
    assert line == "stiction: 1 row missing: grid g, theta 2, mu0 0.2, eta 0.85, dx0 0.001"
    states = small_study.states()
    more = with_results(tmp_path, "more", stiction, states=states)
    assert told((more, folder)) == [f"states: a new table of {len(states)} rows"]
    compared = comparison_table("c", compare([2.0], [0.2, 0.4], [0.85]), "a")
    one = with_results(tmp_path, "one", stiction, comparisons=compared)
    bless(one, tmp_path / "r", LAYOUTS)
    other = changed(compared, "x0_slip_line", 1, 0.1)
    (line,) = told((with_results(tmp_path, "other", stiction, comparisons=other), tmp_path / "r"))
    assert line.startswith("comparisons.x0_slip_line: 1 of 2 rows moved ")
    twice = pa.concat_tables([stiction, stiction.slice(0, 1)])
    first = told((with_results(tmp_path, "twice", twice), folder))[0]
    assert "1 row twice in the results: grid g" in first
    (folder / "scans.csv").write_text("scan\nx\n")
    assert "scans: the whole table is missing" in told(blessed)
    bless(*blessed, LAYOUTS)
    assert not (folder / "scans.csv").exists()


def test_nothing_in_the_place_of_a_number_is_a_change(tmp_path, blessed, stiction):
    lost = with_results(tmp_path, "lost", changed(stiction, "x0_slip", 0, None))
    (line,) = told((lost, blessed[1]))
    assert "x0_slip: 1 of 4 rows moved at grid g" in line and line.endswith("-> nothing)")


def test_a_reference_from_before_there_were_keys_says_what_to_do(blessed):
    path = blessed[1] / "stiction.csv"
    pd.read_csv(path, dtype=str).drop(columns=["grid"]).to_csv(path, index=False)
    (one,) = compared(blessed).differences
    assert "new grid, gone none; its rows cannot be identified" in one.text and one.rows == 0
    assert one.text.endswith("then make bless")


def test_two_studies_are_compared(tmp_path, blessed, stiction):
    other = with_results(tmp_path, "other", changed(stiction, "x0_slip", 0, 0.5))
    found = compare_folders(blessed[0], other, LAYOUTS)
    assert [one.column for one in found.differences] == ["x0_slip"]
    assert found.verdict == f"CHANGED: 1 difference between {blessed[0]} and {other}."


def test_proofs_refute_numbers_and_agree_with_others(tmp_path, blessed, stiction):
    _, folder = blessed
    true = stiction["x0_slip"][0].as_py()
    head = "table,eta,theta,mu0,dx0,state,scan,cycle,quantity,midpoint,radius,on_path,note\n"
    line = "stiction,0.85,2,0.2,0.001,,,,x0_slip,{!r},1e-30,yes,\n"
    parts = [made_tables.points(name, made_tables.grid()) for name in ("g", "h")]
    both = with_results(tmp_path, "both", pa.concat_tables(parts))
    for value, refuted in ((true, 0), (true + 1e-6, 2)):
        (folder / "enclosures.csv").write_text(head + line.format(value))
        found = compare_folders(both, folder, LAYOUTS)
        assert len(found.proved) == 2  # the point stands in two grids
        lines = [one.text for one in found.differences if one.problem == "refuted"]
        assert bool(lines) == bool(refuted)
        assert all("2 of 2 numbers are outside of their proved intervals" in one for one in lines)
    (folder / "enclosures.csv").write_text(head + line.format(true).replace(",0.85,", ",0.8,"))
    assert not compared(blessed).differences
    (folder / "enclosures.csv").write_text("x\n1\n")
    with pytest.raises(Exception, match="is no table of proved intervals"):
        compared(blessed)


def test_a_layout_that_says_nothing_is_refused(blessed, tmp_path):
    path = tmp_path / "my.yaml"
    near, unknown = "states: {keys: [b], columns: {c: near}}", "state: {keys: [b], columns: {}}"
    for text in ("stiction: 3", near, unknown, "a: ["):
        path.write_text(text)
        with pytest.raises(ComparisonError, match=r"my\.yaml cannot be used"):
            read_layouts(path)
    for damaged in (b"\xff\xfe\x00", b"study,grid\na,b,c\n"):
        (blessed[1] / "stiction.csv").write_bytes(damaged)
        with pytest.raises(ComparisonError, match=r"is not a table .*; restore it"):
            compared(blessed)
    with pytest.raises(ComparisonError, match="is a folder of results"):
        bless(blessed[0], blessed[0], LAYOUTS)
    with pytest.raises(ComparisonError, match=r"has no tables; run the study first"):
        condensed(blessed[1])


@pytest.fixture
def check(tmp_path, monkeypatch, capsys):
    """The command in the folder of a study: its exit status, and what stands on the screen."""
    monkeypatch.chdir(tmp_path)
    main = runpy.run_path(str(ROOT / "workflow/check.py"))["main"]

    def check(*arguments):
        status = main(["--configfile", "a.yaml", *arguments])
        screen = capsys.readouterr()
        return status, screen.out + screen.err

    return check


@pytest.mark.slow
def test_the_command_tells_a_person_and_ci(tmp_path, stiction, check, monkeypatch):
    (tmp_path / "a.yaml").write_text(STUDY)
    with_results(tmp_path, "a", stiction)
    known = ("--results", "results/a", "--reference", "my reference")
    command = [sys.executable, ROOT / "workflow/check.py", "--configfile", "a.yaml", *known]
    refused = subprocess.run(command, capture_output=True, text=True)
    assert refused.returncode == 2
    assert refused.stderr.startswith("error: my reference has no reference tables; w")
    written = "my reference is written: review it with git diff\n"
    assert check(*known, "--bless") == (0, written)
    with_results(tmp_path, "a", changed(stiction, "n_steps", 1, 7))
    summary = tmp_path / "summary.md"
    with monkeypatch.context() as github:
        github.setenv("GITHUB_STEP_SUMMARY", str(summary))
        github.setenv("GITHUB_ACTIONS", "true")
        status, screen = check(*known, "--output", "out")
    assert status == 1
    assert screen.splitlines()[-1].startswith("CHANGED: 1 difference between results/a and my ref")
    assert "::error file=my reference/stiction.csv::stiction.n_steps: 1 of 4 rows" in screen
    assert summary.read_text() == (tmp_path / "out/check.md").read_text()
    assert "❌ Study a" in summary.read_text() and "| n_steps | moved | 1 |" in summary.read_text()
    content = json.loads((tmp_path / "out/check.json").read_text())
    assert not content["passed"] and content["differences"][0]["column"] == "n_steps"
    # The tables that `make bless` would write can take the place of the others.
    again = ("--results", "results/a", "--reference", "out/reference")
    assert check(*again)[0] == 0
    # Tables that this study file did not make, or not yet, and a mistake in it, are refused before.
    status, screen = check()
    assert status == 2 and "stiction.parquet was made from another study file" in screen
    (tmp_path / "results/a/tables/stiction.parquet").unlink()
    missing = "has no file tables/stiction.parquet; run make study STUDY=a.yaml first\n"
    assert check()[1].endswith(missing)
    (tmp_path / "a.yaml").write_text(STUDY.replace("[2]", "[0]"))
    status, screen = check()
    assert status == 2 and screen.startswith("error: a.yaml:2: grids.g.theta[0]: 0 is not allowed")


def test_infinite_numbers_are_null_in_json(tmp_path, blessed, stiction):
    other = with_results(tmp_path, "other", changed(stiction, "x0_slip", 0, math.inf))
    found = compare_folders(other, blessed[1], LAYOUTS)
    assert json.loads(found.json())["differences"][0]["absolute"] is None


def test_a_reference_is_written_a_part_at_a_time(blessed, monkeypatch):
    results, folder = blessed
    whole = {path.name: path.read_text() for path in folder.glob("*.csv")}
    monkeypatch.setattr(reference, "AT_ONCE", 4)
    monkeypatch.setattr(query, "ROWS", 1)
    bless(results, folder, LAYOUTS)
    for name, text in whole.items():
        lines = (folder / name).read_text().splitlines()
        assert lines[0] == text.splitlines()[0] and sorted(lines) == sorted(text.splitlines())
    assert not compare_folders(results, folder, LAYOUTS).differences
