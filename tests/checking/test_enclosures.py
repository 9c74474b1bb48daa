"""Results beside proofs: what is inside, how far beside, and what is refuted."""

import math
from decimal import Decimal
from pathlib import Path

import pandas as pd
import pytest

from vibrissa.checking.enclosures import enclosed, histogram, refuted, verdict
from vibrissa.checking.layouts import Layout, Tolerance, parse_layouts
from vibrissa.checking.texts import read
from vibrissa.errors import TableError

ROOT = Path(__file__).parents[2]
LAYOUTS = parse_layouts((ROOT / "workflow/regression.yaml").read_text(), "regression.yaml")
LAYOUT = Layout(("theta", "mu0"), {"n": None, "x": Tolerance(1e-9, 0.0)})
TRUE = "0.052838042795739907694995"
NEAREST = float(TRUE)
FILE = f"""table,theta,mu0,quantity,midpoint,radius,note
points,2,0.40,x,{TRUE},1E-24,
points,2,0.40,n,52,0,
points,2,0.5,,,,self-locking
points,7,0.4,x,1,0,
others,2,0.4,x,1,0,
points,2,0.40,unknown,1,0,
"""


def numbers(folder, x, n=52, text=FILE):
    (folder / "enclosures.csv").write_text(text)
    frame = pd.DataFrame({"theta": [2.0], "mu0": [0.4], "x": [x], "n": [n]})
    return enclosed({"points": frame}, folder, {"points": LAYOUT})


@pytest.mark.parametrize("steps", [0, 1, -1, 7])
def test_numbers_are_compared_in_units_in_the_last_place(tmp_path, steps):
    found, whole = numbers(tmp_path, NEAREST + steps * math.ulp(NEAREST))
    assert found.ulps == pytest.approx(abs(steps), abs=0.5)
    assert not found.refuted
    assert whole.ulps == 0.0


def test_a_number_inside_its_enclosure_is_not_off(tmp_path):
    found, _ = numbers(tmp_path, NEAREST, text=FILE.replace("1E-24", "1E-17"))
    assert found.ulps == 0.0
    assert abs(Decimal(found.value) - found.midpoint) > 0


def test_what_is_further_off_than_it_may_move_is_refuted(tmp_path):
    assert refuted(numbers(tmp_path, NEAREST + 0.9e-9)) == []
    (difference,) = refuted(numbers(tmp_path, NEAREST + 1.1e-9))
    assert str(difference).startswith(
        "points.x: 1 of 1 numbers are refuted by their proofs, by up to 1.1e-9: "
        "points.x at theta 2, mu0 0.40, computed 0.0528380438"
    )
    # Whole numbers do not move at all.
    (difference,) = refuted(numbers(tmp_path, NEAREST, n=53))
    assert difference.column == "n"


@pytest.mark.parametrize("value", [math.nan, math.inf, pd.NA])
def test_no_number_is_refuted(tmp_path, value):
    (difference,) = refuted(numbers(tmp_path, value))
    assert difference.column == "x"


def test_a_line_says_how_far_the_numbers_are_off(tmp_path):
    found = numbers(tmp_path, NEAREST + 7 * math.ulp(NEAREST))
    assert histogram(found) == {
        "at most 0.5": 1,
        "at most 1": 0,
        "at most 10": 1,
        "at most 100": 0,
        "at most 1000": 0,
        "more than 1000": 0,
    }
    assert verdict(found).startswith("2 numbers beside their proofs")
    assert "Worst: 6.792, " in verdict(found) and "points.x at theta 2, mu0 0.40" in verdict(found)
    assert verdict([]) == ""


def test_without_a_file_there_is_nothing_beside_the_results(tmp_path):
    assert enclosed({"points": pd.DataFrame()}, tmp_path, {"points": LAYOUT}) == []


@pytest.mark.parametrize(
    "text", ["a,b\n1,2\n", FILE.replace("1E-24", "little"), "table,quantity\npoints,x\n"]
)
def test_a_damaged_file_is_named(tmp_path, text):
    with pytest.raises(TableError, match=r"has no enclosures.*make proof"):
        numbers(tmp_path, NEAREST, text=text)


def test_the_reference_tables_of_the_paper_are_proved():
    """The digits of the reference tables are those of the enclosures, in every row that slips."""
    folder = ROOT / "tests/regression/paper"
    frames = {name: read(folder / f"{name}.csv") for name in LAYOUTS}
    found = enclosed(frames, folder, LAYOUTS)
    assert refuted(found) == []
    rows = {(one.table, tuple(one.row.values())) for one in found}
    slips = int((frames["stiction"]["status"] == "slip").sum())
    assert len(rows) == slips + len(frames["curves"]) + len(frames["scans"]) + 1
    assert sum(one.column == "mu_lock" for one in found) == len(frames["curves"])
    for one in found:
        assert one.radius <= Decimal("1e-18") * abs(one.midpoint), str(one)
    assert {one.column for one in found if one.table == "stiction"} >= {"n_steps", "x0_max"}
