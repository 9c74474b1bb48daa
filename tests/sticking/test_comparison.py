"""Both contact models side by side."""

import numpy as np
import pytest

from vibrissa import Status, solve_curve, solve_onset
from vibrissa.sticking.comparison import compare

THETA, MU0, ETA = [1.0, 4.0, 8.0], [0.2, 0.3, 0.45], [0.85]


@pytest.fixture(scope="module")
def both():
    return compare(THETA, MU0, ETA)


@pytest.mark.slow
def test_every_combination_is_solved_as_by_itself(both):
    points = list(zip(*(both[axis] for axis in ("theta", "mu0", "eta")), strict=True))
    assert points == [(t, m, e) for e in ETA for t in THETA for m in MU0]
    for model in ("point", "line"):
        result = {name.removesuffix(f"_{model}"): values for name, values in both.items()}
        for i, point in enumerate(points):
            alone = solve_onset(*point, contact=model)
            assert result["status"][i] is alone.status
            assert result["mu_lock"][i] == pytest.approx(alone.mu_lock, abs=1e-12)
            assert result["x0_slip"][i] == pytest.approx(alone.x0_slip, abs=1e-11, nan_ok=True)
            assert result["f_slip"][i] == pytest.approx(float(alone.slip.f), abs=1e-9, nan_ok=True)
            assert (result["status"][i] is Status.LOCK) == np.isnan(result["reaction_m_slip"][i])


def test_the_models_differ_where_the_point_model_penetrates_and_only_there(both):
    point, line, penetrates = (both[n] for n in ("x0_slip_point", "x0_slip_line", "penetrates"))
    slip = np.isfinite(point) & np.isfinite(line)
    differ = np.abs(point / line - 1) > 1e-9
    assert (differ[slip] == penetrates[slip]).all()
    assert penetrates.any() and not penetrates.all()


def test_a_locking_tip_penetrates_where_its_slope_vanishes_before_the_lock():
    found = compare([1.0, 4.0], [0.9], [0.85])
    assert found["status_point"] == [Status.LOCK, Status.LOCK]
    curves = [solve_curve(theta, 0.85) for theta in found["theta"]]
    assert list(found["penetrates"]) == [curve.x0_touch < curve.x0_lock for curve in curves]
    assert list(found["penetrates"]) == [False, True]


@pytest.mark.slow
def test_what_cannot_be_solved_is_named():
    result = compare([1000.0], [5.0], [0.05])
    assert result["status_point"] == [Status.FAILED]
    assert np.isnan([result["x0_slip_point"][0], result["mu_lock_point"][0]]).all()
