"""Reference tables: what moved is found and said, and what did not is left alone."""

import importlib.util
import json
import re
from pathlib import Path

import mutations
import pandas as pd
import pytest

from vibrissa.checking.condensing import condense
from vibrissa.checking.differences import compare
from vibrissa.checking.layouts import Layout, Tolerance, parse_layouts
from vibrissa.checking.reference import blessed_table
from vibrissa.checking.texts import as_text, read
from vibrissa.errors import ComparisonError
from vibrissa.tables import schemas, store

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/regression.md").read_text("utf-8")
spec = importlib.util.spec_from_file_location("check", ROOT / "workflow/check.py")
check = importlib.util.module_from_spec(spec)
spec.loader.exec_module(check)

LAYOUTS = parse_layouts((ROOT / "workflow/regression.yaml").read_text("utf-8"), "regression.yaml")
LAYOUT = Layout(("theta", "mu0"), {"status": None, "n": None, "x": Tolerance(1e-9, 1e-6)})
TABLE = pd.DataFrame(
    {
        "theta": [1.0, 1.0, 2.0, 2.0],
        "mu0": [0.2, 0.9, 0.2, 0.4],
        "status": ["slip", "lock", "slip", "slip"],
        "n": pd.array([4, None, 13, 52], dtype="Int64"),
        "x": [0.004625, float("nan"), 0.0132, 0.0],
    }
)
REFERENCE = as_text(TABLE, LAYOUT, "points")


def against(**columns):
    """What is said where some columns are other ones."""
    return compare(REFERENCE, as_text(TABLE.assign(**columns), LAYOUT, "points"), LAYOUT, "points")


def texts(differences):
    return list(map(str, differences))


def x(*values):
    return {"x": list(values)}


def test_a_table_as_text():
    assert REFERENCE.to_numpy().tolist() == [
        ["1", "0.2", "slip", "4", "0.004625"],
        ["1", "0.9", "lock", "", ""],
        ["2", "0.2", "slip", "13", "0.0132"],
        ["2", "0.4", "slip", "52", "0"],
    ]


def test_nothing_moved():
    assert against() == []
    assert compare(REFERENCE, REFERENCE.iloc[::-1], LAYOUT, "points") == []


@pytest.mark.parametrize(
    "values",
    [
        x(0.004625 * (1 + 0.9e-6), float("nan"), 0.0132, 0.0),
        x(0.004625, float("nan"), 0.0132 * (1 - 0.9e-6), 0.9e-9),
        x(0.004625, float("nan"), 0.0132, -0.0),
    ],
)
def test_what_moves_within_its_tolerance_does_not_move(values):
    assert against(**values) == []


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        (
            x(0.004725, float("nan"), 0.0142, 0.0),
            "points.x: 2 of 4 rows moved; by up to 0.001 at theta 2, mu0 0.2 (0.0132 -> 0.0142), "
            "relative 0.07",
        ),
        (
            x(0.002, float("nan"), 0.0232, 0.0),
            "points.x: 2 of 4 rows moved; by up to 0.01 at theta 2, mu0 0.2 (0.0132 -> 0.0232), "
            "relative 0.57 at theta 1, mu0 0.2 (0.004625 -> 0.002)",
        ),
        (
            x(0.004625, float("nan"), 0.0132, 1.1e-9),
            "points.x: 1 of 4 rows moved; by up to 1.1e-09 at theta 2, mu0 0.4 (0 -> 1.1e-09), "
            "relative 1",
        ),
        (
            x(0.004625, 0.1, 0.0132, 0.0),
            "points.x: 1 of 4 rows moved; at theta 1, mu0 0.9 (nothing -> 0.1)",
        ),
        (
            x(0.005625, float("nan"), float("nan"), 0.0),
            "points.x: 2 of 4 rows moved; by up to 0.001 at theta 1, mu0 0.2 (0.004625 -> 0.005625)"
            ", relative 0.18; 1 of them to or from nothing, such as at theta 2, mu0 0.2 (0.0132 -> "
            "nothing)",
        ),
        (
            {"status": ["slip", "slip", "slip", "failed"]},
            "points.status: 2 of 4 rows moved; at theta 1, mu0 0.9 (lock -> slip)",
        ),
        (
            {"n": pd.array([4, None, 13, 53], dtype="Int64")},
            "points.n: 1 of 4 rows moved; by up to 1 at theta 2, mu0 0.4 (52 -> 53), "
            "relative 0.019",
        ),
    ],
)
def test_what_moved_is_said(columns, line):
    assert texts(against(**columns)) == [line]


@pytest.mark.parametrize("value", [float("inf"), 0.004625])
def test_infinity_is_near_to_itself_alone(value):
    # As mu_lock is where the tip lifts off.
    at_infinity = as_text(TABLE.assign(**x(float("inf"), 0, 0.0132, 0)), LAYOUT, "points")
    found = as_text(TABLE.assign(**x(value, 0, 0.0132, 0)), LAYOUT, "points")
    lines = compare(at_infinity, found, LAYOUT, "points")
    assert len(lines) == (0 if value == float("inf") else 1)


def test_rows_that_are_missing_extra_or_doubled_are_said():
    found = pd.concat([REFERENCE.iloc[[0, 0, 1]], REFERENCE.iloc[[2]].assign(theta="3")])
    assert texts(compare(REFERENCE, found, LAYOUT, "points")) == [
        "points: 1 rows stand twice in the results: theta 1, mu0 0.2",
        "points: 2 rows are missing: theta 2, mu0 0.2; theta 2, mu0 0.4",
        "points: 1 rows are extra: theta 3, mu0 0.2",
    ]


def test_other_columns_are_said():
    lines = compare(REFERENCE.rename(columns={"n": "m"}), REFERENCE, LAYOUT, "points")
    assert texts(lines) == ["points: other columns than the reference: new n, gone m"]
    lines = compare(REFERENCE.drop(columns="theta"), REFERENCE, LAYOUT, "points")
    assert texts(lines) == ["points: other columns than the reference: new theta, gone none"]


def test_blessing_keeps_the_digits_of_what_did_not_move():
    moved = TABLE.assign(x=[0.004625 * (1 + 1e-7), 0.3, 0.0142, 0.0], theta=[1.0, 1.0, 2.0, 3.0])
    found = as_text(moved, LAYOUT, "points")
    result = blessed_table(REFERENCE, found, LAYOUT)
    assert result["x"].tolist() == ["0.004625", "0.3", "0.0142", "0"]
    assert result["theta"].tolist() == ["1", "1", "2", "3"]
    assert compare(result, found, LAYOUT, "points") == []
    assert blessed_table(None, found, LAYOUT).equals(found)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "points: [",
        "points: {keys: [theta]}",
        "points: {keys: [theta], columns: {x: about}}",
        "points: {keys: [theta], columns: {x: {absolute: 1}}}",
        "points: {keys: [theta], columns: {x: {absolute: -1, relative: 0}}}",
        "points: {keys: [theta], columns: {x: {absolute: 1, relative: 0, more: 1}}}",
        "points: {keys: [theta], columns: {x: {absolute: .nan, relative: 0}}}",
    ],
)
def test_a_layout_that_says_nothing_is_refused(text):
    with pytest.raises(ComparisonError, match=r"^my\.yaml does not say what to compare"):
        parse_layouts(text, "my.yaml")


def test_a_column_that_is_not_there_is_named():
    with pytest.raises(ComparisonError, match="points has no column y; it has theta, "):
        as_text(TABLE, Layout(("theta",), {"y": None}), "points")


@pytest.fixture(scope="module")
def frames(study_tables):
    return {
        name: as_text(frame, LAYOUTS[name], name) for name, frame in condense(study_tables).items()
    }


@pytest.mark.parametrize("name", LAYOUTS)
def test_the_papers_study_is_what_it_was(frames, name):
    reference = read(ROOT / f"tests/regression/paper/{name}.csv")
    assert compare(reference, frames[name], LAYOUTS[name], name) == []


def test_the_cycles_of_the_paper(frames):
    scans = frames["scans"]
    assert len(scans) == 6 * 9
    assert set(scans["slips"]) == {"1"}
    assert scans.groupby(["theta", "mu0"])["steps"].nunique().eq(1).all()


def test_a_curve_that_disagrees_with_itself_is_found(study_tables):
    rows = study_tables["stiction"].to_pylist()
    rows[3]["mu_lock"] += 1e-6
    doctored = study_tables["stiction"].from_pylist(rows, schema=schemas.STICTION)
    curves = as_text(condense({"stiction": doctored})["curves"], LAYOUTS["curves"], "curves")
    reference = read(ROOT / "tests/regression/paper/curves.csv")
    (line, *_) = compare(reference, curves, LAYOUTS["curves"], "curves")
    assert "1 rows stand twice in the results" in line.text


def test_the_example_of_the_documentation(frames):
    reference = read(ROOT / "tests/regression/paper/stiction.csv")
    found = reference.copy()
    at = (found["theta"] == "2") & (found["mu0"] == "0.4")
    found.loc[at, "x0_slip"] = f"{float(found.loc[at, 'x0_slip'].iloc[0]) + 1e-6:.12g}"
    found = found[~((found["theta"] == "3") & (found["mu0"] == "0.4"))]
    (example,) = re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)
    lines = compare(reference, found, LAYOUTS["stiction"], "stiction")
    assert sorted(example.splitlines()[:-1]) == sorted(texts(lines))


@pytest.fixture
def folder(study_tables, tmp_path, monkeypatch):
    """A results folder of a study of somebody's own, without scans."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "results/mine/tables"
    path.mkdir(parents=True)
    for name in ("stiction", "states"):
        store.write(study_tables[name], path / f"{name}.parquet")
    axes = "{theta: [1], mu0: [0.1], eta: [0.85], dx0: [0.001]}"
    (tmp_path / "my.yaml").write_text(f"study: mine\ngrids: {{own: {axes}}}\n")
    return tmp_path


MINE = ["--configfile", "my.yaml", "--results", "results/mine"]


@pytest.mark.slow
def test_blessed_results_pass_until_they_change(folder, study_tables, capsys):
    assert check.main([*MINE, "--bless"]) == 0
    reference = folder / "tests/regression/mine"
    assert sorted(p.name for p in reference.iterdir()) == [
        "curves.csv",
        "states.csv",
        "stiction.csv",
    ]
    before = {path: path.read_bytes() for path in reference.iterdir()}
    assert check.main(MINE) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("Nothing moved: results/mine has")

    shorter = study_tables["stiction"].slice(1)
    store.write(shorter, folder / "results/mine/tables/stiction.parquet")
    assert check.main(MINE) == 1
    assert "stiction: 1 rows are missing" in capsys.readouterr().out
    assert {path: path.read_bytes() for path in reference.iterdir()} == before

    assert check.main([*MINE, "--bless"]) == 0
    assert check.main(MINE) == 0


@pytest.mark.slow
def test_tables_that_appear_or_vanish_are_differences(folder, study_tables, capsys):
    assert check.main([*MINE, "--reference", "kept", "--bless"]) == 0
    store.write(study_tables["scans"], folder / "results/mine/tables/scans.parquet")
    (folder / "results/mine/tables/states.parquet").unlink()
    assert check.main([*MINE, "--reference", "kept"]) == 1
    assert capsys.readouterr().out.splitlines()[-3:] == [
        "states: the whole table is missing",
        "scans: a new table of 54 rows",
        "2 differences between results/mine and kept",
    ]
    assert check.main([*MINE, "--reference", "kept", "--bless"]) == 0
    assert not (folder / "kept/states.csv").exists()
    assert check.main([*MINE, "--reference", "kept"]) == 0


def test_the_reference_folder_may_have_a_layout_of_its_own(folder):
    (folder / "kept").mkdir()
    (folder / "kept/regression.yaml").write_text(
        "curves: {keys: [theta], columns: {mu_lock: {absolute: 1, relative: 0}}}\n"
    )
    assert check.main([*MINE, "--reference", "kept", "--bless"]) == 0
    assert sorted(p.name for p in (folder / "kept").iterdir()) == ["curves.csv", "regression.yaml"]
    assert read(folder / "kept/curves.csv").columns.tolist() == ["theta", "mu_lock"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            MINE,
            "tests/regression/mine has no reference tables; make them with: make bless, and the "
            "same STUDY and REFERENCE",
        ),
        ([*MINE, "--results", "none"], "none has no tables/stiction.parquet; run the study first"),
    ],
)
def test_nothing_to_compare_is_said(folder, capsys, arguments, message):
    assert check.main(arguments) == 2
    assert capsys.readouterr().err == f"error: {message}\n"


@pytest.mark.parametrize("damage", [b"", b"a,b\n1,2,3\n1\n1,2,3,4\n", b"\xff\xfe\n"])
def test_a_damaged_reference_table_is_named(folder, capsys, damage):
    assert check.main([*MINE, "--bless"]) == 0
    (folder / "tests/regression/mine/curves.csv").write_bytes(damage)
    assert check.main(MINE) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: tests/regression/mine/curves.csv is not a table (")
    assert error.count("\n") == 1


def test_a_study_file_that_is_not_there_is_named(folder):
    with pytest.raises(SystemExit, match=r"No such study file: no\.yaml"):
        check.main(["--configfile", "no.yaml"])


@pytest.mark.parametrize("mutation", mutations.MUTATIONS, ids=lambda m: f"{m.module}-{m.what}")
def test_a_mutation_breaks_what_it_says_and_the_page_lists_it(mutation):
    text = (ROOT / f"src/vibrissa/{mutation.module}.py").read_text("utf-8")
    assert text.count(mutation.old) == 1
    assert mutation.old != mutation.new
    (row,) = [line for line in PAGE.splitlines() if f"| {mutation.what} |" in line]
    assert f"| `{mutation.module}` |" in row
    assert "| red: " in row


def test_ci_gets_a_summary_a_json_file_annotations_and_a_diff(folder, monkeypatch, capsys):
    summary = folder / "summary.md"
    summary.write_text("# Before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    output = ["--reference", "kept", "--output", "out"]
    assert check.main([*MINE, *output, "--bless"]) == 0
    assert check.main([*MINE, *output]) == 0
    assert json.loads((folder / "out/check.json").read_text())["passed"] is True
    assert (folder / "out/reference.diff").read_text() == ""
    assert "::error" not in capsys.readouterr().out

    states = folder / "kept/states.csv"
    states.write_text(states.read_text().replace(",solved,", ",failed,"))
    assert check.main([*MINE, *output]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == (
        "::error file=kept/states.csv,title=Reference table::states.status: 1 of 1 rows moved; "
        "at state penetrating (failed -> solved)"
    )
    assert "+paper,collocation" not in (folder / "out/reference.diff").read_text()
    assert "+penetrating,paper,collocation,solved" in (folder / "out/reference.diff").read_text()
    text = summary.read_text("utf-8")
    assert text.startswith("# Before\n## ✅ Study mine") and "## ❌ Study mine" in text
    assert (folder / "out/check.md").read_text("utf-8") in text


def test_an_error_is_shown_in_ci_too(folder, monkeypatch, capsys):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    assert check.main(MINE) == 2
    out = capsys.readouterr().out
    assert out.startswith("::error title=make check::tests/regression/mine has no reference tables")
