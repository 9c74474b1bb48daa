"""What the page's moving rod is set to, of grid points and of scans: no value changes unnoticed."""

import pandas as pd
import pyarrow.compute as pc
import pytest

from known import Known
from small_study import scans, stiction, tables
from vibrissa.report import facts
from vibrissa.report import motion as motions
from vibrissa.report.tables import key_rows

KNOWN = Known(__file__)


@pytest.mark.parametrize("most", [12_000, 7])
def test_a_scan_moves_as_its_table_says(most, monkeypatch):
    """With fewer readings than rows the first and the last are kept, and others between."""
    assert motions.MOST_ROWS == 12_000
    monkeypatch.setattr(motions, "MOST_ROWS", most)
    KNOWN.check(f"scans in {most} rows", motions.of_scans(scans()), 1e-5)


def test_of_many_scans_the_first_are_shown(monkeypatch):
    assert motions.MOST_SCANS == 60
    monkeypatch.setattr(motions, "MOST_SCANS", 1)
    found = motions.of_scans(scans())
    assert len(found.presets) == 1 and found.notes == ("These are the first 1 of 2 scans.",)


@pytest.mark.parametrize(("axes", "middle"), [(1, True), (3, True), (4, False)])
def test_of_many_axes_the_ends_alone_are_shown(axes, middle):
    """27 rows are read; 81 are not."""
    names = [f"axis{n}" for n in range(axes)]
    rows = pd.MultiIndex.from_product([range(5)] * axes, names=names).to_frame(index=False)
    shown = key_rows(rows, names)
    assert len(shown) == (3 if middle else 2) ** axes
    assert sorted(set(shown[names[-1]])) == ([0, 2, 4] if middle else [0, 4])


def test_points_move_to_their_last_sticking_state():
    points = stiction()
    KNOWN.check("points", motions.of_points(points))
    one = points.filter(pc.field("mu0") == 0.9)
    KNOWN.check("points that lock", motions.of_points(one))


def test_what_a_study_has_is_summed_up():
    KNOWN.check("summary", [facts.summary(tables()), facts.troubles(tables())])
    origins = [vars(facts.origin(name, table)) for name, table in tables().items()]
    assert [one["rows"] for one in origins] == [len(table) for table in tables().values()]
