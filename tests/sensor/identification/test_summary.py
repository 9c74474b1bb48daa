"""The mean friction of a recording: what averages out, what does not, and what it says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from steel import ROD, SENSOR
from straight import periods_of
from vibrissa.sensor import Whisker, identify, scan, surfaces
from vibrissa.sensor.identification.friction import PeriodStatus
from vibrissa.sensor.identification.misfit.doubts import Grade
from vibrissa.sensor.identification.misfit.goodness import Goodness
from vibrissa.sensor.identification.summary import (
    FrictionSummary,
    Source,
    _scatter,
    if_exact,
    summary_of,
)

WHISKER = Whisker(theta=2.0, eta=0.85, rod=ROD)
UNITS = ("N", "N", "N*m")


def test_noise_averages_out_by_the_weights_of_a_weighted_mean():
    noise = np.array([0.001, 0.002, 0.004, 0.003])
    mu0 = np.array([0.3, 0.301, 0.299, 0.3])
    found = summary_of(periods_of(mu0, noise, 0.0))
    assert found.mean == pytest.approx(np.average(mu0, weights=noise**-2.0), abs=1e-12)
    assert found.random == pytest.approx((noise**-2.0).sum() ** -0.5)
    assert found.common == 0.0 and found.alike == () and not found.varies
    assert found.chi2 == pytest.approx((((mu0 - found.mean) / noise) ** 2).sum())
    assert found.chance == pytest.approx(stats.chi2.sf(found.chi2, 3))


@pytest.mark.parametrize(
    ("status", "low", "grade", "said"),
    [
        (["open"], [0.23456], [""], ["no slip was recorded", "mu0 is at least 0.235 at one"]),
        (["open", "open"], [0.2, np.nan], ["", ""], ["no slip was recorded", "at least 0.2 at"]),
        (["open", "lock"], [0.1, 0.47], ["", ""], ["mu0 is at least 0.47 at one place or more"]),
        (["unsure", "open"], [0.3, 0.2], ["wrong", ""], ["mu0 is at least 0.2 at"]),
        (["beyond"], [np.nan], [""], []),
    ],
)
def test_without_a_mean_the_largest_lower_bound_is_said(status, low, grade, said):
    periods = periods_of(np.full(len(status), np.nan), 0.1, 0.0)
    found = summary_of(
        replace(periods, status=np.array(status), low=np.array(low), grade=np.array(grade))
    )
    lines = str(found).splitlines()[1:]
    assert len(lines) == len(said)
    assert all(part in line for part, line in zip(said, lines, strict=True))


def test_what_all_periods_share_does_not_average_out():
    # The first unknown moves all alike, the second one half of them the other way.
    shifts = np.stack([np.full(100, 0.003), 0.004 * (-1.0) ** np.arange(100)], axis=1)
    mu0 = 0.3 + 0.002 * stats.norm.ppf((np.arange(100) + 0.5) / 100)
    found = summary_of(periods_of(mu0, 0.002, 0.0, shifts), ("eta", "zero"))
    assert found.common == pytest.approx(0.003)
    assert found.random == pytest.approx(0.0002)
    assert found.deviation == pytest.approx(np.hypot(0.003, 0.0002))
    assert found.alike == ("eta", "zero")
    assert found.single == pytest.approx(np.sqrt(0.002**2 + 0.003**2 + 0.004**2))
    assert found.sources == pytest.approx({Source.COMMON: 25 / 29, Source.READINGS: 4 / 29})


def test_the_error_of_the_step_averages_out_only_where_the_frictions_scatter():
    even = (np.arange(50) + 0.5) / 50 - 0.5
    alike = summary_of(periods_of(np.full(50, 0.3), 1e-6, 0.001))
    assert alike.common == pytest.approx(0.001, rel=1e-3) and alike.random < 1e-6
    assert alike.alike == (Source.STEP,)
    varied = summary_of(periods_of(0.3 + 0.1 * even, 1e-6, 0.001))
    assert varied.common == 0.0 and varied.random == pytest.approx(0.001 / np.sqrt(50), rel=1e-3)
    assert varied.varies and varied.variation == pytest.approx(0.1 / np.sqrt(12), rel=0.03)


@pytest.mark.filterwarnings("error")
def test_periods_that_share_all_their_errors_have_the_same_weight():
    # What noise leaves of the variance is nothing, or what rounding makes of it.
    for shared in (0.01, 0.0):
        some = periods_of([0.2, 0.3, 0.31], 0.0, 0.0, np.full((3, 1), shared))
        found = summary_of(some, ["clamp_angle"])
        assert found.mean == pytest.approx(0.27)
        assert found.common == pytest.approx(shared)


def test_one_period_is_its_own_mean():
    found = summary_of(periods_of([0.31], 0.001, 0.002))
    assert found.mean == 0.31 and found.deviation == pytest.approx(np.sqrt(5e-6))
    assert found.degrees == 0 and "place to place" not in str(found)
    assert _scatter(np.array([0.31]), np.array([1e-6])) == (0.0, 0.0)


def test_wrong_periods_are_left_out_unless_most_are_wrong():
    periods = periods_of([0.3, 0.301, 0.299, 0.5], 0.001, 0.0)
    periods.grade[3] = Grade.WRONG
    periods.grade[2] = Grade.DOUBTFUL
    found = summary_of(periods)
    assert found.mean == pytest.approx(0.3) and found.used == 3
    assert found.left == {"wrong": 1} and "mean of 3 of 4 periods (left out: 1 wrong)" in str(found)
    assert "1 of them is in doubt" in str(found)
    periods.grade[:3] = Grade.WRONG
    found = summary_of(periods)
    assert found.used == 4 and "do not rely on it" in str(found)


def test_without_a_friction_there_is_no_mean():
    periods = periods_of([np.nan, np.nan], 0.001, 0.0)
    periods.status[:] = PeriodStatus.OPEN
    found = summary_of(replace(periods, goodness=Goodness(chi2=9.0, degrees=9, noise_degrees=9.0)))
    assert np.isnan(found.mean) and found.left == {"open": 2}
    assert str(found).startswith("no mean of mu0, from 0 of 2 periods (left out: 2 open)")


@pytest.mark.slow
def test_the_mean_of_a_surface_is_as_far_off_as_it_says():
    errors = {}
    for kind in ("constant", "random"):
        errors[kind] = []
        for seed, mu0 in enumerate(np.linspace(0.27, 0.33, 7)):
            surface = surfaces.constant(mu0)
            if kind == "random":
                surface = surfaces.random(seed, mu0, 0.03, 0.02)
            signals = scan(
                WHISKER, surface, step="50 um", to=["40 mm"], transducer=SENSOR, seed=seed
            )
            found = identify(
                WHISKER, signals.to_pandas(), transducer=SENSOR, method="model", assume=False
            )
            places = found.periods.contact[found.periods.status == PeriodStatus.SLIP]
            summary = found.summary()
            assert summary.varies == (kind == "random")
            errors[kind].append((summary.mean - surface(places).mean()) / summary.deviation)
    # The root mean square of seven normal values is in this range but for one case in 1000. The
    # error by the step is uniform, so that it is at most 1.73 standard deviations.
    for values in errors.values():
        assert 0.2 < np.sqrt(np.mean(np.square(values))) < 1.9


@pytest.mark.slow
def test_a_recording_that_does_not_fit_says_so_and_why():
    given = Whisker(theta=2.05, eta=0.85, rod=ROD)
    signals = scan(
        WHISKER, surfaces.constant(0.3), step="50 um", to=["30 mm"], transducer=SENSOR, seed=2
    )
    found = identify(given, signals.to_pandas(), transducer=SENSOR, method="model", assume=False)
    text = str(found.summary())
    assert repr(found) == text
    assert "The recording does not fit what was given" in text and "theta smaller by 0.05" in text
    assert "do not rely on it" in text


def said_of(**change):
    """What a recording of the whisker says of one that is given otherwise."""
    signals = scan(
        WHISKER, surfaces.constant(0.3), step="50 um", to=["20 mm"], transducer=SENSOR, seed=2
    )
    noise = np.array(SENSOR.deviation) * change.pop("noise", 1.0)
    text = ", ".join(f"{size:.9g} {unit}" for size, unit in zip(noise, UNITS, strict=True))
    given = replace(WHISKER, **change).tolerating({"eta": 0.001, "theta": 0.01})
    return identify(given, signals.to_pandas(), noise=text, assume=False).summary()


@pytest.mark.slow
def test_a_recording_fits_only_with_a_height_that_is_far_from_the_given_one():
    found = said_of(eta=WHISKER.eta + 0.01)
    lines = str(found).splitlines()
    assert found.goodness.fits
    (line,) = (line for line in lines if "fits only" in line)
    assert line.startswith("The recording fits only with eta smaller by ")
    assert line.endswith("standard deviations): measure it again, or give it a wider tolerance")
    assert "fit" not in str(said_of())


@pytest.mark.slow
def test_noise_that_was_stated_too_small_is_named_and_not_causes_that_explain_nothing():
    found = said_of(noise=0.5)
    text = str(found)
    assert not found.goodness.fits and found.causes == ()
    assert "No single thing that is other explains it." in text
    for name in ("force_x", "force_y", "moment_z"):
        assert found.goodness.noisier[name] == pytest.approx(2.0, rel=0.15)
        assert f"{name} scatters" in text
    assert not said_of(noise=1.0).goodness.noisier
    assert "By the recording is" not in text
    assert "By the recording is eta smaller by" in str(said_of(noise=0.5, eta=WHISKER.eta + 0.01))


TOLERANCES = {"theta": 0.02, "eta": 0.001, "clamp_angle": 0.005, "transducer_angle": 0.005}


@pytest.mark.slow
def test_what_remains_if_one_tolerance_were_exact_is_what_remains_if_it_is():
    signals = scan(
        WHISKER, surfaces.constant(0.3), step="50 um", to=["20 mm"], transducer=SENSOR, seed=2
    )
    table = signals.to_pandas()

    def summary(sizes):
        given = WHISKER.tolerating(sizes)
        found = identify(given, table, method="model", transducer=SENSOR, assume=False)
        return found.summary()

    whole = summary(TOLERANCES)
    assert list(whole.if_exact.values()) == sorted(whole.if_exact.values())
    assert min(whole.if_exact.values()) < 0.9 * whole.deviation
    for name in TOLERANCES:
        left = summary({one: size for one, size in TOLERANCES.items() if one != name}).deviation
        assert whole.if_exact[name] == pytest.approx(left, rel=0.03)
    first, then = next(iter(whole.if_exact.items()))
    assert f"measure first: {first} (then ± {then:.2g})" in str(whole)


def test_parts_of_one_tolerance_become_exact_together():
    covariance = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, 2.0], [0.0, 2.0, 1.0]])
    effect = np.array([1.0, 0.5, -1.0])
    deviation = np.sqrt(effect @ covariance @ effect + 0.25)
    left = if_exact(effect, covariance, ("a", "b", "a"), deviation)
    # What remains of b where both parts of a are known, and the other way.
    b = 9.0 - np.array([1.0, 2.0]) @ np.diag([0.25, 1.0]) @ [1.0, 2.0]
    assert left["a"] == pytest.approx(np.sqrt(0.25 * b + 0.25))
    column = np.array([1.0, 2.0])
    rest = np.diag([4.0, 1.0]) - np.outer(column, column) / 9.0
    assert left["b"] == pytest.approx(np.sqrt(effect[[0, 2]] @ rest @ effect[[0, 2]] + 0.25))


def test_nothing_is_said_of_no_period():
    nothing = FrictionSummary()
    assert str(nothing) == "no mean of mu0, from 0 of 0 periods"
    unknown = {"mean", "random", "common", "variation", "single", "least"}
    assert {name for name, value in vars(nothing).items() if value != value} == unknown
    known = {name: value for name, value in vars(nothing).items() if name not in unknown}
    assert known == {
        "alike": (),
        "if_exact": {},
        "chi2": 0.0,
        "chance": 1.0,
        "degrees": 0,
        "sources": {},
        "periods": 0,
        "used": 0,
        "left": {},
        "doubtful": 0,
        "wrong": 0,
        "goodness": None,
        "causes": (),
        "beside": None,
        "far": (),
    }


def weighed(mu0, noise, step, shifts):
    """The formulas of the module's docstring, one after the other."""
    v, degrees = np.var(mu0, ddof=1), len(mu0) - 1
    beyond = max(0.0, v - np.mean(noise**2))
    lower = v * degrees / stats.chi2.ppf(0.975, degrees)
    surely = max(0.0, lower - np.mean(noise**2))
    same = np.sqrt(np.maximum(0.0, step**2 - surely))
    w = 1.0 / (noise**2 + beyond + same**2)
    w /= w.sum()
    r2 = noise**2 + step**2
    q = np.sum((mu0 - np.average(mu0, weights=1.0 / r2)) ** 2 / r2)
    return {
        "mean": w @ mu0,
        "random": np.sqrt(w**2 @ (noise**2 + step**2 - same**2)),
        "common": np.sqrt((w @ same) ** 2 + np.sum((w @ shifts) ** 2)),
        "variation": np.sqrt(max(0.0, beyond - np.mean(step**2))),
        "chi2": q,
        "chance": stats.chi2.sf(q, degrees),
        "degrees": degrees,
        "single": np.sqrt(w @ (r2 + np.sum(shifts**2, axis=1))),
    }


@pytest.mark.parametrize("scatter", [0.0005, 0.002, 0.004, 0.05])
@pytest.mark.parametrize("size", [2, 3, 8])
def test_the_summary_is_that_of_its_formulas(scatter, size):
    rng = np.random.default_rng(size)
    mu0 = 0.3 + scatter * rng.standard_normal(size)
    noise, step = rng.uniform(0.0005, 0.003, (2, size))
    shifts = rng.normal(0.0, 0.002, (size, 2))
    found = summary_of(periods_of(mu0, noise, step, shifts), ("eta",))
    expected = weighed(mu0, noise, step, shifts)
    assert {name: getattr(found, name) for name in expected} == pytest.approx(expected)
    # The larger of the two parts that all share is named first.
    assert set(found.alike) <= {Source.STEP, "eta"} and "eta" in found.alike


def test_what_all_periods_share_most_is_named_first():
    alike = np.full(9, 0.3)
    for shift, first in ((0.001, Source.STEP), (0.01, "eta")):
        found = summary_of(periods_of(alike, 1e-5, 0.005, np.full((9, 1), shift)), ("eta",))
        assert found.alike[0] == first and len(found.alike) == 2
        largest = Source.STEP if first is Source.STEP else Source.COMMON
        assert next(iter(found.sources)) == largest
        assert sum(found.sources.values()) == pytest.approx(1.0)
    # What is 0 is not named.
    assert summary_of(periods_of(alike, 0.001, 0.0), ("eta",)).alike == ()


@pytest.mark.parametrize(("wrong", "used"), [(1, 3), (2, 2), (3, 4)])
def test_up_to_half_of_the_periods_are_left_out_as_wrong(wrong, used):
    periods = periods_of([0.3, 0.301, 0.299, 0.3, np.nan, np.nan], 0.001, 0.0)
    periods.status[4:] = PeriodStatus.OPEN
    periods.grade[:wrong] = Grade.WRONG
    periods.grade[4:] = Grade.WRONG  # those without a friction do not count
    found = summary_of(periods)
    assert found.used == used and found.periods == 6
    assert found.left == {"open": 2} | ({"wrong": wrong} if used < 4 else {})
    assert list(found.left) == sorted(found.left)
    assert (found.wrong, found.doubtful) == (wrong if used == 4 else 0, 0)


def test_what_would_be_exact_is_asked_where_tolerances_have_a_covariance():
    effects = np.array([[1.0, 2.0]] * 4)
    periods = periods_of([0.3] * 4, 0.001, 0.0, effects * 0.01, effects)
    covariance = np.diag([1e-4, 1e-4])
    found = summary_of(periods, ("curve",), ("a", "b"), covariance)
    deviation = found.deviation
    # Of the same variances along both axes: one part of five is by a.
    assert deviation == pytest.approx(np.sqrt(5e-4 + 1e-6 / 4.0))
    assert found.if_exact["a"] == pytest.approx(np.sqrt(deviation**2 - 1e-4))
    assert found.if_exact["b"] == pytest.approx(np.sqrt(deviation**2 - 4e-4))
    assert list(found.if_exact) == ["b", "a"] and found.alike == ("tolerances", "curve")
    for nothing in (
        summary_of(periods, ("curve",), (), covariance),
        summary_of(periods, ("curve",), ("a", "b"), None),
    ):
        assert nothing.if_exact == {} and nothing.alike == ("curve",)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (0.0, "0.312345679"),
        (np.nan, "0.312345679"),
        (0.5, "0.31"),
        (0.05, "0.312"),
        (0.099, "0.312"),
        (0.00123, "0.3123"),
        (1e-12, "0.312345679"),
        (3.0, "0.3"),
        (30.0, "0"),
        (300.0, "0"),
    ],
)
def test_a_mean_is_told_to_two_digits_of_its_error(error, said):
    found = FrictionSummary(mean=0.3123456789, random=error, common=0.0, periods=1, used=1)
    assert str(found).startswith(f"mu0 = {said} ± {error:.2g}, mean of 1 of 1 period\n")


def test_a_recording_without_degrees_of_freedom_says_nothing_of_its_fit():
    known = {"mean": 0.3, "random": 0.01, "common": 0.0, "periods": 1, "used": 1}
    for degrees, said in ((0, False), (1, True)):
        fit = Goodness(chi2=99.0, degrees=degrees, noise_degrees=np.inf)
        assert ("degree of freedom" in str(FrictionSummary(**known, goodness=fit))) == said
