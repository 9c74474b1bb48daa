"""What a comparison tells a CI system."""

import json
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest

from vibrissa.checking import ci, texts
from vibrissa.checking.differences import Difference, Problem, compare
from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.checking.reference import Comparison

LAYOUT = Layout(("theta",), {"x": Tolerance(1e-9, 0.0), "status": None})
OLD = pd.DataFrame(
    {"theta": ["1", "2", "3"], "x": ["0.1", "0.2", ""], "status": ["slip", "slip", "lock"]}
)
NEW = pd.DataFrame(
    {"theta": ["1", "2", "4"], "x": ["0.1", "0.25", "inf"], "status": ["slip", "lock", "slip"]}
)


def comparison(found=NEW, stored=OLD):
    return Comparison(
        results=Path("results/mine"),
        reference=Path("kept"),
        layouts={"points": LAYOUT},
        stored={"points": stored},
        found={"points": found},
        differences=compare(stored, found, LAYOUT, "points"),
    )


def test_a_summary_names_what_moved_how_far_and_where():
    lines = ci.markdown(comparison()).splitlines()
    assert lines[0] == "## ❌ Study mine: reference tables"
    assert lines[2] == "4 differences between results/mine and kept"
    assert lines[6:] == [
        "| points | – | rows missing | 1 | – | – | 1 rows are missing: theta 3 |",
        "| points | – | rows extra | 1 | – | – | 1 rows are extra: theta 4 |",
        "| points | x | moved | 1 of 2 | 0.05 | 0.2 | at theta 2 (0.2 -> 0.25) |",
        "| points | status | moved | 1 of 2 | – | – | 1 of 2 rows moved; at theta 2 (slip -> lock)"
        " |",
    ]


def test_a_summary_of_what_did_not_move_is_short():
    assert ci.markdown(comparison(OLD)).splitlines() == [
        "## ✅ Study mine: reference tables",
        "",
        "Nothing moved: results/mine has the 3 rows of kept.",
    ]


def test_a_long_summary_says_how_many_are_left_out():
    columns = [f"c{i}" for i in range(40)]
    layout = Layout(("theta",), dict.fromkeys(columns))
    old = pd.DataFrame({"theta": ["1"]} | {name: ["a"] for name in columns})
    differences = compare(old, old.replace("a", "b"), layout, "points")
    found = Comparison(
        results=Path("r"),
        reference=Path("k"),
        layouts={"points": layout},
        stored={"points": old},
        found={"points": old},
        differences=differences,
    )
    assert ci.markdown(found).splitlines()[-1] == "And 10 more; check.json has all of them."
    assert len(list(ci.annotations(found))) == ci.MOST_NOTES


def test_json_has_every_difference_and_only_finite_numbers():
    text = ci.json_text(comparison())
    assert text.startswith('{\n  "passed": false,\n') and text.endswith("}\n")
    content = json.loads(text, parse_constant=pytest.fail)
    assert content["passed"] is False and content["rows"] == 3
    assert [one["problem"] for one in content["differences"]] == [
        *("rows missing", "rows extra", "moved", "moved")
    ]
    moved = content["differences"][2]
    assert (moved["table"], moved["column"], moved["rows"], moved["of"]) == ("points", "x", 1, 2)
    assert moved["absolute"] == {
        "row": {"theta": "2"},
        "before": "0.2",
        "after": "0.25",
        "size": pytest.approx(0.05),
    }
    assert content["differences"][0]["examples"] == [{"theta": "3"}]
    infinite = comparison(OLD.assign(x=["inf", "0.2", ""]))
    ((one,),) = [json.loads(ci.json_text(infinite))["differences"]]
    assert one["absolute"] is None and "(0.1 -> inf)" in one["text"]


def test_annotations_point_to_the_reference_table():
    assert next(ci.annotations(comparison())) == (
        "::error file=kept/points.csv,title=Reference table::points: 1 rows are missing: theta 3"
    )


def test_annotations_cannot_be_broken_by_names():
    line = ci.command("error", "100%\nof it", file="a,b:c")
    assert line == "::error file=a%2Cb%3Ac::100%25%0Aof it"


@pytest.mark.skipif(not shutil.which("git"), reason="needs git")
@pytest.mark.parametrize("gone", [False, True])
def test_the_diff_makes_the_reference_what_the_results_are(tmp_path, gone):
    found = comparison()
    if gone:
        found = Comparison(**{**vars(found), "found": {}})
    path = tmp_path / "kept/points.csv"
    path.parent.mkdir()
    texts.write(OLD, path)
    (tmp_path / "a.diff").write_text(found.diff())
    subprocess.run(["git", "apply", "--unidiff-zero", "a.diff"], cwd=tmp_path, check=True)
    assert not path.exists() if gone else texts.read(path).equals(NEW)


def test_what_did_not_move_has_no_diff():
    assert comparison(OLD.assign(x=["0.1000000000001", "0.2", ""])).diff() == ""


def test_problems_are_words_for_people():
    difference = Difference(table="a", problem=Problem.NEW, text="a: a new table of 3 rows")
    assert str(difference) == "a: a new table of 3 rows"
