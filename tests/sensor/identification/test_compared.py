"""Frictions that are read in two ways: how far apart they are, in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from straight import periods_of
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.friction import PeriodStatus
from vibrissa.sensor.identification.misfit.beside import Read, beside
from vibrissa.sensor.identification.misfit.doubts import Grade
from vibrissa.sensor.identification.misfit.law import apart

NAN = np.nan

# --- Travels beside last states ---


def test_travels_are_apart_by_the_mean_of_their_differences_and_its_errors():
    travels = periods_of([0.31, 0.33, NAN, 0.32, 9.0], 0.02, 0.03, [[0.1]] * 5, [[2.0, 1.0]] * 5)
    states = periods_of([0.3, 0.3, 0.3, 0.3, NAN], 0.01, 0.0, [[0.2]] * 5, [[0.5, 3.0]] * 5)
    found = apart(travels, states, None)
    assert found.size == pytest.approx(0.02)
    # Three periods are read by both. What is not common: noise and step.
    own = (0.02**2 + 0.03**2 + 0.01**2) / 3.0
    assert found.deviation == pytest.approx(np.sqrt(own + 1.5**2 + 2.0**2))
    assert found.half_step == pytest.approx(0.03 * np.sqrt(3.0))
    shared = np.array([[4.0, 1.0], [1.0, 1.0]])
    common = 1.5**2 * 4.0 + 2.0**2 - 2.0 * 1.5 * 2.0
    assert apart(travels, states, shared).deviation == pytest.approx(np.sqrt(own + common))


@pytest.mark.parametrize(("size", "told"), [(2, False), (3, True)])
def test_three_periods_are_the_fewest_that_test_a_law(size, told):
    some = periods_of(np.full(size, 0.3), 0.01, 0.01), periods_of(np.full(size, 0.2), 0.01, 0.0)
    found = apart(*some, None)
    assert np.isfinite(found.deviation) == told and found.off_law == told
    assert found.size == pytest.approx(0.1 if told else 0.0)
    assert found.half_step == pytest.approx(0.01 * np.sqrt(3.0) if told else 0.0)


# --- The model beside the ratio ---


def read(periods, covariance=(), names=""):
    told = [Tolerance(name=n, of=n, tolerance=1.0, adjusted=0.0, deviation=1.0) for n in names]
    size = len(told)
    return Read(
        periods=periods, tolerances=told, covariance=np.reshape(covariance, (size, size)) * 1.0
    )


def ratio_of(size, noise=0.0, by_step=0.0, mu0=0.3, curved=0.0, effects=None):
    """Of which the first shift is the error by how the forces curve."""
    shifts = np.column_stack([np.full(size, curved), np.zeros(size)])
    return periods_of(np.full(size, mu0), noise, by_step, shifts, effects)


def spread(difference, noise=0.0, by_step=0.0, ratio=None):
    difference = np.asarray(difference, dtype=float)
    model = periods_of(0.3 + difference, noise, by_step)
    found = beside(read(model), read(ratio or ratio_of(len(difference))))
    assert found.difference == pytest.approx(difference.mean())
    return found.spread


def test_independent_errors_average_out_and_those_of_the_curve_do_not():
    # Differences that scatter as much as they should, and no more.
    for size in (4, 9):
        assert spread([0.0] * size, 0.03) == pytest.approx(0.03 / np.sqrt(size))
        other = ratio_of(size, 0.04, curved=0.02)
        assert spread([0.0] * size, 0.03, ratio=other) == pytest.approx(
            np.hypot(0.05 / np.sqrt(size), 0.02)
        )


def test_a_step_that_makes_all_onsets_late_alike_does_not_average_out():
    # Both are late in the same step: only the difference counts, in each and in all of them.
    found = spread([0.001] * 4, 0.01, 0.05, ratio_of(4, 0.02, by_step=0.02))
    noise = 0.01**2 + 0.02**2
    assert found == pytest.approx(np.sqrt((noise + 0.03**2) / 4.0 + 0.03**2))
    other = spread([0.001] * 4, 0.02, 0.02, ratio_of(4, 0.01, by_step=0.05))
    assert other == pytest.approx(found)
    # What differences scatter beyond their noise is not alike.
    scattered = np.array([1.0, -1.0, 1.0, -1.0]) * 0.02
    found = spread(scattered, 0.01, 0.05)
    alike = 1.0 - (0.02**2 - 0.01**2) / 0.05**2
    assert found == pytest.approx(np.sqrt((0.01**2 + 0.05**2) / 4.0 + alike * 0.05**2))
    # Where they scatter more than a step does, nothing is.
    assert spread(10.0 * scattered, 0.01, 0.05) == pytest.approx(np.hypot(0.01, 0.05) / 2.0)
    # Differences along what a step does to each are alike.
    by_step = np.array([0.01, 0.02, 0.03, 0.06])
    found = spread(0.7 * by_step + 0.01, 0.0, by_step)
    assert found == pytest.approx(np.hypot(by_step.mean(), np.sqrt((by_step**2).mean() / 4.0)))


def test_one_error_of_both_and_one_of_each_make_the_variance():
    # The model knows a and c together; the ratio knows b, and a as it was before the adjustment.
    ones = np.ones((4, 1))
    model = periods_of([0.3] * 4, 0.0, 0.0, effects=ones * [2.0, 5.0])
    ratio = ratio_of(4, effects=ones * [7.0, 3.0])
    told = read(model, [[0.25, 0.1], [0.1, 4.0]], "ac"), read(ratio, [[9.0, 0.0], [0.0, 1.0]], "ba")
    of_model = 4.0 * 0.25 + 25.0 * 4.0 + 2.0 * 2.0 * 5.0 * 0.1
    of_ratio = 49.0 * 9.0 + 9.0 * 1.0
    of_both = 3.0 * (0.25 * 2.0 + 0.1 * 5.0)
    assert beside(*told).spread == pytest.approx(np.sqrt(of_model + of_ratio - 2.0 * of_both))
    # Rounding must not make it less than nothing.
    same = read(model, np.zeros((2, 2)), "ac"), read(ratio_of(4, effects=0.0 * ones), [[1.0]], "a")
    assert beside(*same).spread == 0.0


@pytest.mark.parametrize(("size", "compared"), [(2, False), (3, True)])
def test_three_periods_are_the_fewest_that_are_compared(size, compared):
    found = beside(read(periods_of([0.4] * size, 0.01, 0.0)), read(ratio_of(size)))
    assert found.number == size and found.compared == compared
    assert np.isfinite([found.difference, found.spread]).tolist() == [compared] * 2
    # Each of them disagrees by itself; without a mean nothing is said of all.
    assert found.off.all() and found.agrees == (not compared)


def test_periods_are_compared_that_end_in_the_same_line_and_slip_by_both():
    model, ratio = periods_of([0.3] * 7, 0.01, 0.0), ratio_of(7, 0.02)
    model.status[1], ratio.status[2] = PeriodStatus.OPEN, PeriodStatus.LOCK
    ratio.grade[3], ratio.grade[4] = Grade.WRONG, Grade.DOUBTFUL
    ratio = replace(ratio, last_line=np.array([9, 1, 2, 3, 4, 5, 6]), mu0=0.3 + np.arange(7) / 1e3)
    found = beside(read(model), read(ratio))
    assert found.number == 3 and found.difference == pytest.approx(-0.005)
    assert found.ratio == pytest.approx([NAN] * 4 + [0.304, 0.305, 0.306], nan_ok=True)
    assert found.deviation == pytest.approx([NAN] * 4 + [0.02] * 3, nan_ok=True)
    # Whatever the order.
    turned = beside(read(model), read(ratio.take(slice(None, None, -1))))
    assert turned.ratio == pytest.approx(found.ratio, nan_ok=True)


@pytest.mark.parametrize(("size", "off"), [(0.779, False), (0.781, True)])
def test_a_period_disagrees_from_six_deviations_on(size, off):
    # 6·√(0.02² + 0.01² + 0.04² + 0.02² + 0.12²): noise of both, step, how the forces curve, and
    # an error of the model alone.
    difference = np.zeros(5)
    difference[2] = size
    ones = np.ones((5, 1))
    # What is common by the deviations counts by the effects.
    model = periods_of(0.3 + difference, 0.02, 0.04, 0.5 * ones, ones)
    ratio = ratio_of(5, 0.01, curved=0.02, effects=0.5 * ones)
    for sign in (1.0, -1.0):
        turned = replace(model, mu0=0.3 + sign * difference)
        found = beside(read(turned, [[0.12**2]], "a"), read(ratio, [[0.0]], "b"))
        assert found.off.tolist() == [False, False, off, False, False]
        # The mean is of the others.
        assert found.difference == pytest.approx(0.0 if off else sign * size / 5.0)


@pytest.mark.parametrize(("off", "left_out"), [(1, True), (2, False), (3, False)])
def test_those_that_disagree_are_left_out_unless_half_of_all_do(off, left_out):
    difference = np.where(np.arange(4) < off, 0.1, 0.0)
    found = beside(read(periods_of(0.3 + difference, 0.01, 0.0)), read(ratio_of(4)))
    assert found.difference == pytest.approx(0.0 if left_out else 0.1 * off / 4.0)
