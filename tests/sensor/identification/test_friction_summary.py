"""The mean friction of a recording: what averages out, what does not, and what it says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from steel import ROD, SENSOR, TRANSDUCER, identified
from vibrissa.quantities.units import Units
from vibrissa.scanning import surfaces
from vibrissa.sensor import Whisker, scan
from vibrissa.sensor.identification.findings import beside
from vibrissa.sensor.identification.goodness import Cause, Estimate, Goodness
from vibrissa.sensor.identification.parameters import Parameter
from vibrissa.sensor.identification.periods import Check, Grade, Periods, PeriodStatus
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slope import Slope

WHISKER = Whisker(theta=2.0, eta=0.85, rod=ROD)
EMPTY = {
    "recording": None,
    "periods": None,
    "units": Units(),
    "estimates": (),
    "covariance": np.zeros((0, 0)),
}
NONE = Identification(by_model=True, slope=Slope(), **EMPTY)
# Deviation of each friction by its own noise, where both methods are compared.
OWN = 0.001


def summary_of(periods, setting):
    """Summary of periods whose errors have this setting."""
    return replace(setting, periods=periods).summary()


def setting_of(covariance, *names):
    """Errors with a covariance, each of a tolerance."""
    parameters = [Parameter(name=name, of=name, deviation=1.0) for name in names]
    estimates = (Estimate(parameter=one, size=0.0, deviation=1.0, most=4.0) for one in parameters)
    return replace(NONE, estimates=tuple(estimates), covariance=np.array(covariance))


def periods_of(mu0, noise, step, effects=None, setting=NONE, **other):
    """Periods with such frictions and errors."""
    size = len(mu0)
    effects = np.zeros((size, 0)) if effects is None else np.array(effects)
    common = np.sqrt(np.einsum("ni,ij,nj->n", effects, setting.covariance, effects))
    row = np.arange(size)
    deviation = np.sqrt(np.square(noise) + step**2 + common**2)
    known = {
        "status": np.full(size, PeriodStatus.SLIP, dtype="U12"),
        "low": np.array(mu0) - 2.0 * deviation,
        "start": np.zeros(size),
    }
    return Periods(
        **{**known, **{name: np.array(value) for name, value in other.items()}},
        first=row,
        last=row,
        first_line=row,
        last_line=row,
        contact=row / 10.0,
        footpoint=row / 10.0,
        mu0=np.array(mu0, dtype=float),
        deviation=deviation,
        high=np.array(mu0) + 2.0 * deviation,
        common=common,
        by_step=np.full(size, float(step)),
        effects=effects,
    )


def test_noise_averages_out_by_the_weights_of_a_weighted_mean():
    noise = np.array([0.001, 0.002, 0.004, 0.003])
    mu0 = np.array([0.3, 0.301, 0.299, 0.3])
    found = summary_of(periods_of(mu0, noise, 0.0), NONE)
    assert found.mean == pytest.approx(np.average(mu0, weights=noise**-2.0), abs=1e-12)
    assert found.random == pytest.approx((noise**-2.0).sum() ** -0.5)
    assert found.common == 0.0 and found.variation == 0.0


@pytest.mark.parametrize(
    ("status", "low", "grade", "said"),
    [
        (["open"], [0.23456], [""], ["no slip was recorded", "mu0 is at least 0.235: see"]),
        (["open", "open"], [0.2, np.nan], ["", ""], ["no slip was recorded", "at least 0.2: see"]),
        (["open", "lock"], [0.1, 0.47], ["", ""], ["mu0 is at least 0.47: see"]),
        (["unsure", "open"], [0.3, 0.2], ["wrong", ""], ["mu0 is at least 0.2: see"]),
        (["beyond"], [np.nan], [""], []),
    ],
)
def test_without_a_mean_the_largest_lower_bound_is_said(status, low, grade, said):
    periods = periods_of(np.full(len(status), np.nan), 0.1, 0.0, status=status, low=low)
    wrong = Check(Grade.WRONG, np.array(grade) == "wrong", "off")
    found = summary_of(periods.doubted(wrong), NONE)
    lines = str(found).splitlines()[1:]
    assert len(lines) == len(said) and found.variation == 0.0
    assert all(part in line for part, line in zip(said, lines, strict=True))


ETA = Parameter(name="eta", of="eta", deviation=0.0)
CAUSE = Cause(parameter=ETA, size=0.01, deviation=0.001, explained=0.9)


@pytest.mark.parametrize(
    ("chi2", "causes", "said"),
    [
        (400.0, (), "(chi2 is 4 per degree of freedom). No single difference explains it."),
        (400.0, (CAUSE,), "Candidates, each taken alone:\n  eta larger by 0.01"),
        (100.0, (CAUSE,), "A stated value is off by far more than its tolerance."),
    ],
)
def test_a_misfit_is_said_with_its_causes(chi2, causes, said):
    setting = replace(NONE, goodness=Goodness(chi2=chi2, degrees=100), causes=causes)
    assert said in str(summary_of(periods_of([0.3], 0.01, 0.0), setting))
    fitting = replace(NONE, goodness=Goodness(chi2=100.0, degrees=100))
    assert len(str(summary_of(periods_of([0.3], 0.01, 0.0), fitting)).splitlines()) == 2


def test_what_all_periods_share_does_not_average_out():
    # The first error moves all alike, the second one half of them the other way.
    effects = np.stack([np.full(100, 0.003), 0.004 * (-1.0) ** np.arange(100)], axis=1)
    setting = setting_of(np.eye(2), "eta", "zero_force_x")
    mu0 = 0.3 + 0.002 * stats.norm.ppf((np.arange(100) + 0.5) / 100)
    found = summary_of(periods_of(mu0, 0.002, 0.0, effects, setting), setting)
    assert found.common == pytest.approx(0.003)
    assert found.random == pytest.approx(0.0002, rel=0.02)
    assert found.if_exact["eta"] == pytest.approx(found.random)
    assert found.if_exact["zero_force_x"] == pytest.approx(found.deviation)
    assert "measure first: eta (then ± 0.0002)" in str(found)


def test_what_is_known_by_another_need_not_be_measured():
    # Only the sum of both is uncertain by 0.01: either, if exact, makes the other so.
    setting = setting_of([[1e-4, 1e-4], [1e-4, 1e-4]], "eta", "length")
    periods = periods_of([0.3, 0.3], 1e-9, 0.0, np.ones((2, 2)), setting)
    found = summary_of(periods, setting)
    assert found.common == pytest.approx(0.02)
    assert found.if_exact == pytest.approx({"eta": 0.0, "length": 0.0}, abs=1e-6)


def test_the_error_of_the_step_averages_out_only_where_the_frictions_scatter():
    even = (np.arange(50) + 0.5) / 50 - 0.5
    alike = summary_of(periods_of(np.full(50, 0.3), 1e-6, 0.001), NONE)
    assert alike.common == pytest.approx(0.001, rel=1e-3) and alike.random < 1e-6
    varied = summary_of(periods_of(0.3 + 0.1 * even, 1e-6, 0.001), NONE)
    assert varied.common == 0.0 and varied.random == pytest.approx(0.001 / np.sqrt(50), rel=1e-3)
    assert varied.variation == pytest.approx(0.1 / np.sqrt(12), rel=0.03)
    # If little friction rises in a period, as after a kinetic slip, so does little of the scatter.
    mu0 = 0.3 + 0.1 * even
    kept = [summary_of(periods_of(mu0, 1e-6, 0.01, start=p * mu0), NONE).common for p in (0, 0.9)]
    assert kept == [0.0, pytest.approx(0.01, rel=0.05)]


def test_one_period_is_its_own_mean():
    found = summary_of(periods_of([0.31], 0.001, 0.002), NONE)
    assert found.mean == 0.31 and found.deviation == pytest.approx(np.sqrt(5e-6))
    assert "place to place" not in str(found)


def test_wrong_periods_are_left_out_unless_most_are_wrong():
    periods = periods_of([0.3, 0.301, 0.299, 0.5], 0.001, 0.0)
    rows = np.arange(4)
    far = Check(Grade.DOUBTFUL, rows == 2, "far")
    periods = periods.doubted(Check(Grade.WRONG, rows == 3, "off"), far)
    found = summary_of(periods, NONE)
    assert found.mean == pytest.approx(0.3) and found.used == 3
    assert found.left == {"wrong": 1} and "mean of 3 of 4 periods (left out: 1 wrong)" in str(found)
    assert "1 period in doubt" in str(found) and "(in doubt)" not in str(found)
    found = summary_of(periods.doubted(Check(Grade.WRONG, rows < 3, "off")), NONE)
    assert found.used == 4 and "do not rely on mu0" in str(found) and "(in doubt)," in str(found)


@pytest.mark.nightly
@pytest.mark.slow
def test_the_mean_of_a_surface_is_as_far_off_as_it_says():
    errors = {"constant": [], "random": []}
    for kind, of_kind in errors.items():
        for seed, mu0 in enumerate(np.linspace(0.27, 0.33, 7)):
            surface = surfaces.constant(mu0)
            if kind == "random":
                surface = surfaces.random(seed, mu0, 0.03, 0.02)
            signals = scan(WHISKER, surface, step="50 um", to=["40 mm"]).measured(SENSOR, seed)
            found = identified(WHISKER, signals.to_pandas(), transducer=TRANSDUCER, assume=False)
            places = found.periods.contact[found.periods.status == PeriodStatus.SLIP]
            summary = found.summary()
            assert (summary.variation > 0.0) == (kind == "random")
            of_kind.append((summary.mean - surface(places).mean()) / summary.deviation)
    # The root mean square of seven normal values is in this range but for one case in 1000. The
    # error by the step is uniform, so that it is at most 1.73 standard deviations.
    for values in errors.values():
        assert 0.2 < np.sqrt(np.mean(np.square(values))) < 1.9


@pytest.mark.slow
def test_coarse_sampling_says_so_and_nothing_of_diameters():
    signals = scan(WHISKER, surfaces.constant(0.3), step="1 mm", to=["80 mm"]).measured(SENSOR)
    found = identified(WHISKER, signals.to_pandas(), transducer=TRANSDUCER)
    lines = str(found).splitlines()
    assert sum("sample more finely" in line for line in lines) == 1 and len(lines) <= 5
    assert not any("diameter" in line for line in lines)


def compared(apart):
    """Compare frictions by the model, which are larger than those by the ratio by `apart`."""
    by_ratio = np.full(len(apart), 0.3)
    model, ratio = (
        replace(NONE, periods=periods_of(mu0, np.full(len(apart), OWN), 0.0))
        for mu0 in (by_ratio + apart, by_ratio)
    )
    return beside(model, ratio)


def test_methods_whose_means_differ_by_more_than_four_deviations_disagree_in_all_periods():
    spread = OWN * np.sqrt(2.0 / 16)
    near, far = compared(np.full(16, 3.9 * spread)), compared(np.full(16, 4.1 * spread))
    assert near.spread == far.spread == pytest.approx(spread)
    assert near.agrees and not near.off.any()
    assert not far.agrees and far.off.all()


def test_one_period_that_differs_by_more_than_six_deviations_disagrees_alone():
    apart = np.zeros(16)
    apart[5] = 6.1 * OWN * np.sqrt(2.0)
    found = compared(apart)
    assert np.flatnonzero(found.off).tolist() == [5]
    assert found.difference == 0.0 and found.number == 15
    apart[5] = 5.9 * OWN * np.sqrt(2.0)
    assert not compared(apart).off.any()


def test_the_means_of_two_periods_are_not_compared():
    assert np.isnan(compared(np.full(2, 0.004)).difference)
