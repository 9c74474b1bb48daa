"""Friction read from simulated recordings: rows, statuses, and independence of the chunks."""

import numpy as np
import pyarrow as pa
import pytest

from vibrissa import Mounting, solve_curve
from vibrissa.outcomes import ReadingStatus
from vibrissa.readings.rows import read_chunk
from vibrissa.sensor.onset import largest_strain
from vibrissa.study.reading import read_study

pytestmark = pytest.mark.slow
STUDY = """
study: demo
scans:
  runs: {theta: 1, eta: 0.85, dx0: 0.001, mu0: 0.3, to: 0.06}
readings:
  tapers:
    scan: runs
    transducer: nano17-si-12-0.12
    rod: {modulus: 210 GPa, diameter: 0.8 mm, length: 100 mm}
    errors: {eta: 0.1 mm, zero_force_x: 5 mN}
    tolerances: {eta: 100 um, zero_force_x: 5.0 mN, others: exact}
    recordings: 2
"""


@pytest.fixture
def tables(tmp_path):
    """Tables of friction by chunk."""

    def tables(*changes):
        text = STUDY
        for old, new in changes:
            assert text.count(old) == 1
            text = text.replace(old, new)
        path = tmp_path / "my.yaml"
        path.write_text(text)
        study = read_study(path)
        return [
            pa.concat_tables(read_chunk(**chunk.params, study=study.name, **study.reading_settings))
            for chunk in study.reading_chunks.values()
        ]

    return tables


def one(tables, *changes):
    (table,) = tables(*changes, ("recordings: 2", "recordings: 1"))
    (row,) = table.to_pylist()
    return row


def test_chunks_do_not_change_the_rows(tables):
    (whole,) = tables()
    parts = tables(("study: demo", "study: demo\nchunk: {recordings: 1}"))
    assert len(parts) == 2
    assert pa.concat_tables(parts[::-1]).sort_by("recording").equals(whole)


def test_a_row_has_the_friction_beside_the_truth(tables):
    (table,) = tables(("    recordings: 2", "    method: [model, ratio]\n    recordings: 2"))
    rows = table.to_pylist()
    assert [(row["recording"], row["read_by"]) for row in rows] == [
        (1, "model"),
        (1, "ratio"),
        (2, "model"),
        (2, "ratio"),
    ]
    for row in rows:
        assert row["status"] == ReadingStatus.READ and row["grade"] is None
        assert row["mu0_true"] == 0.3 and row["periods_true"] == row["periods_read"] > 3
        total = np.hypot(row["mu0_random"], row["mu0_common"])
        assert row["mu0_deviation"] == pytest.approx(total)
        assert row["inside"] == (row["mu0_low"] <= 0.3 <= row["mu0_high"])
        assert abs(row["mu0_read"] - 0.3) < 5.0 * row["mu0_deviation"] < 0.05
        known = {"model": {"eta", "zero_force_x"}, "ratio": {"zero_force_x"}}
        assert set(row["limit_name"]) == known[row["read_by"]]
        assert all(0.0 <= share <= 1.0 for share in row["limit_share"])
        assert row["way"] == pytest.approx(0.006)
    # Both methods read the same recording; another one has other noise.
    assert rows[0]["strain"] == rows[1]["strain"]
    assert rows[0]["mu0_read"] != rows[2]["mu0_read"]
    # A zero is an error of the ratio of the forces, and less so of the model.
    assert rows[1]["mu0_common"] > rows[0]["mu0_common"]
    assert rows[0]["predicted"] == pytest.approx(rows[0]["period_deviation"], rel=0.2)


def test_the_truth_is_that_of_the_place_where_the_tip_slips(tables):
    patches = "surfaces:\n  two: {patches: [[0, 0.2], [0.47, 0.3]]}\nscans:"
    surface = (("scans:", patches), ("mu0: 0.3", "surface: two"))
    row = one(tables, *surface, ("to: 0.06", "to: 0.05"))
    assert 0.2 < row["mu0_true"] < 0.3
    assert row["period_error"] < 3.0 * row["period_deviation"] < 0.03
    assert row["predicted"] is None


def test_where_the_modulus_changes_the_stress_decides_what_yields(tables):
    rod = (
        ("theta: 1,", "theta: 4, stiffening: 1,"),
        ("{eta: 0.1 mm, zero_force_x: 5 mN}", "exact"),
    )
    row = one(tables, *rod, ("to: 0.06", "to: 0.1"))
    mounting = Mounting(stiffening=1.0)
    curve = solve_curve(4.0, 0.85, mounting=mounting)
    worst = largest_strain(curve, float(curve.onset(0.3)))
    stress, strain = (0.008 * float(size[0]) for size in (worst.stress, worst.strain))
    assert stress > 1.1 * strain
    assert row["strain"] == pytest.approx(stress, rel=0.02)


def test_what_gives_no_friction_is_a_status(tables):
    thick = ("0.8 mm", "3 mm")
    saturated = one(tables, thick)
    assert saturated["status"] == ReadingStatus.SATURATED and saturated["saturated"] > 0.5
    assert saturated["mu0_read"] is None and saturated["inside"] is None
    assert saturated["limit_name"] == []
    steel = ("length: 100 mm", "length: 100 mm, yield_strain: 0.001")
    yielded = one(tables, steel)
    assert yielded["status"] == ReadingStatus.YIELDED and yielded["strain"] > 0.001
    assert yielded["message"].endswith("the yield strain is 0.10%")
    locked = one(tables, ("mu0: 0.3", "mu0: 0.8"), ("to: 0.06", "to: 0.2"))
    assert locked["status"] == ReadingStatus.LOCK and "locks" in locked["message"]
    assert locked["mu0_true"] is None and locked["periods_true"] == 0
    short = one(tables, ("to: 0.06", "to: 0.008"))
    assert short["status"] == ReadingStatus.NO_SLIP and short["periods_used"] == 0
    away = one(tables, ("to: 0.06", "to: 0.2, stage_angle: -1.2"))
    assert away["status"] == ReadingStatus.OUT_OF_REACH and away["way"] is None
