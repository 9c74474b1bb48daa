"""Accuracy of friction that was read: bias, errors and coverage by their definitions."""

import numpy as np
import pandas as pd
import pytest

from figure_rows import readings
from vibrissa.tables.accuracy import accuracy, sentences

N = 400


def rows(bias=0.0, **columns):
    error = 0.01 * np.random.default_rng(3).standard_normal(N) + bias
    found = {
        "readings": "tapers",
        "read_by": "model",
        "status": "read",
        "grade": None,
        "mu0_true": 0.3,
        "mu0_read": 0.3 + error,
        "mu0_deviation": 0.01,
        "mu0_random": 0.006,
        "mu0_common": 0.008,
        "inside": np.abs(error) <= 0.0196,
        "period_error": 0.02,
        "period_deviation": 0.03,
        "predicted": np.nan,
        "way": 0.05,
    }
    return pd.DataFrame(found | columns, index=range(N))


def test_errors_that_are_as_stated_are_covered():
    (one,) = accuracy(rows(), ("readings",)).to_dict("records")
    assert one["recordings"] == one["estimates"] == N
    assert one["refused"] == one["doubted"] == 0.0
    assert one["rms"] == pytest.approx(0.01, rel=0.1) and one["stated"] == pytest.approx(0.01)
    assert one["rms_error"] == pytest.approx(one["rms"] / np.sqrt(2 * N))
    assert abs(one["bias"]) < 3.0 * one["bias_error"]
    assert one["bias_error"] == pytest.approx(0.01 / np.sqrt(N), rel=0.1)
    assert abs(one["coverage"] - 0.95) < 3.0 * one["coverage_error"]
    assert one["coverage_error"] == pytest.approx(np.sqrt(0.95 * 0.05 / N))
    assert (one["random"], one["common"]) == (pytest.approx(0.006), pytest.approx(0.008))
    assert (one["period_error"], one["period_stated"]) == (pytest.approx(0.02), pytest.approx(0.03))
    assert np.isnan(one["predicted"])


def test_a_bias_is_one():
    (one,) = accuracy(rows(bias=0.02), ("readings",)).to_dict("records")
    assert one["bias"] == pytest.approx(0.02, abs=0.002)
    assert one["rms"] == pytest.approx(np.hypot(0.01, 0.02), rel=0.05)
    assert one["coverage"] < 0.6


def test_recordings_without_an_estimate_are_left_out_and_counted():
    half = np.arange(N) % 2 == 0
    known = rows()
    other = known.assign(
        status=np.where(half, "refused", "read"),
        grade=np.where(np.arange(N) % 4 == 1, "doubtful", None),
        mu0_read=known["mu0_read"].where(~half),
        inside=[None if one else True for one in half],
    )
    (one,) = accuracy(other, ("readings",)).to_dict("records")
    assert (one["estimates"], one["refused"], one["doubted"]) == (N / 2, 0.5, 0.25)
    assert one["coverage"] == 1.0
    assert one["rms"] == pytest.approx(0.01, rel=0.15)
    assert sentences(other) == [
        "tapers, by model: 400 recordings, 50% without an estimate, 25% in doubt; error of mu0 "
        f"{one['rms']:.2g} (rms), stated 0.01, bias {one['bias']:+.1g}; 100.0% ± 1.5% of the 95 % "
        "intervals hold the truth"
    ]
    none = other.assign(status="refused", mu0_read=np.nan, inside=None)
    assert sentences(none) == [
        "tapers, by model: 400 recordings, 100% without an estimate, 0% in doubt"
    ]


def test_points_are_told_apart():
    found = accuracy(readings(3), ("theta", "eta"))
    assert len(found) == 9 and found["recordings"].eq(4).all()
