"""Height and zeros from the recording: interpolated rods, least squares, what cannot be told."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from steel import NANO, NOISE, SI, measured, recording_of
from straight import ALL, Straight, sampled
from vibrissa.cli.app import app
from vibrissa.errors import NoResponseError, UndeterminedError
from vibrissa.mechanics.rod import Rod
from vibrissa.sensor import surfaces
from vibrissa.sensor.identification import calibration
from vibrissa.sensor.identification.calibration import (
    Unknown,
    calibrate,
    known_setup,
    principal_axes,
)
from vibrissa.sensor.identification.friction import PeriodStatus, find_periods
from vibrissa.sensor.identification.periods import Channels
from vibrissa.sensor.identification.recording import Method
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.response.heights import respond_between
from vibrissa.sensor.simulation.scanning import path, simulate
from vibrissa.sensor.transducer import CHANNELS

OFFSET = np.array([0.1, -0.15, 0.02])
BOTH = [Unknown.ETA, Unknown.OFFSET]


@pytest.fixture(scope="module")
def heights():
    # What is looked for, 0.85, is not in the middle, where a rod is solved.
    return respond_between(2.0, 0.865)


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


def recorded(response, seed=0, offset=OFFSET, stop="0.8", law="free"):
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    truth = simulate(response, surface, path("0.0005", [stop]), law)
    return truth, recording_of(truth.clamp, measured(truth.reactions + offset, [seed, 2]))


def calibrated(heights, recording, unknown, eta=0.865):
    return calibrate(heights, eta, recording, NOISE, unknown)


@pytest.mark.slow
@pytest.mark.parametrize("eta", [0.833, 0.85, 0.881])
def test_between_heights_the_branch_is_that_of_a_rod_solved_there(heights, eta):
    between, solved = heights.at(eta), respond(2.0, eta)
    x = np.linspace(0.999 * solved.x0_pull, solved.x0_lock, 301)
    assert between(x) == pytest.approx(solved(x), abs=1e-7)
    assert between.x0_lock == pytest.approx(solved.x0_lock, abs=1e-7)
    assert between.x1_init == pytest.approx(solved.x1_init, abs=1e-7)
    assert between.mu_lock == pytest.approx(solved.curve.mu_lock, abs=1e-7)
    past = np.linspace(solved.x0_lock, 0.99 * solved.x0_end, 301)
    assert between(past) == pytest.approx(solved(past), abs=1e-3)


@pytest.mark.slow
def test_heights_beyond_the_range_are_refused(heights):
    with pytest.raises(ValueError, match="eta must lie in"):
        heights.at(0.95)
    with pytest.raises(ValueError, match="between 0 and 1"):
        respond_between(2.0, 1.0)
    with pytest.raises(NoResponseError):
        respond_between(3.0, 0.85, "line")


@pytest.mark.slow
@pytest.mark.parametrize("unknown", [[Unknown.ETA], [Unknown.OFFSET], BOTH])
def test_errors_of_the_estimates_are_of_the_size_they_say(heights, response, unknown):
    offset = OFFSET if Unknown.OFFSET in unknown else np.zeros(3)
    scores = []
    for seed in range(8):
        _, recording = recorded(response, seed, offset, "0.4")
        setup = calibrated(heights, recording, unknown, 0.865 if "eta" in unknown else 0.85)
        error = np.append(setup.eta - 0.85, setup.offset - offset)
        free = setup.deviation > 0.0
        assert free.tolist() == [Unknown.ETA in unknown, *[Unknown.OFFSET in unknown] * 3]
        assert (error[~free] == 0.0).all()
        scores.append(
            error[free] @ np.linalg.solve(setup.covariance[np.ix_(free, free)], error[free])
        )
    # Sums of squares: chi squared of as many degrees as there are unknowns, times scans.
    degrees = 8 * int(free.sum())
    assert abs(np.sum(scores) - degrees) < 4.0 * np.sqrt(2.0 * degrees)


def test_the_setup_adds_to_the_uncertainty_what_all_periods_share(heights, response):
    truth, recording = recorded(response, 1, stop="0.1")
    setup = calibrated(heights, recording, BOTH)
    still = recording.without(OFFSET)
    for method in (Method.FORCES, Method.MOMENT):
        periods = find_periods(setup, recording, NOISE, method=method)
        known = find_periods(known_setup(response), still, NOISE, method=method)
        assert len(periods.status) == len(known.status) == truth.period[-1]
        assert (known.common == 0.0).all()
        ok = periods.status == PeriodStatus.SLIP
        assert (periods.common[ok] > 1e-5).all()
        total = np.hypot(known.deviation, periods.common)[ok]
        assert periods.deviation[ok] == pytest.approx(total, rel=0.05)
        error = periods.mu0[ok] - truth.mu0[periods.last[ok]]
        assert np.abs(error / periods.deviation[ok]).max() < 4.5


@pytest.mark.slow
def test_intervals_cover_what_they_say_with_an_estimated_setup(heights, response):
    inside = {Method.FORCES: [], Method.MOMENT: []}
    for seed in range(40, 56):
        truth, recording = recorded(response, seed, stop="0.3", law="kinetic")
        setup = calibrated(heights, recording, BOTH)
        for method, covered in inside.items():
            periods = find_periods(setup, recording, NOISE, method=method)
            ok = periods.status == PeriodStatus.SLIP
            mu0 = truth.mu0[periods.last]
            covered += list(((periods.low <= mu0) & (mu0 <= periods.high))[ok])
    for covered in inside.values():
        assert len(covered) > 400
        assert 0.93 <= np.mean(covered) <= 0.97


def test_what_a_recording_does_not_tell_is_said(heights, response):
    _, recording = recorded(response)
    with pytest.raises(UndeterminedError, match="too few"):
        calibrated(heights, recording.take(slice(3)), BOTH)
    some = recording.take(slice(15))
    alone = recording_of(some.clamp, np.where([False, False, True], some.readings, np.nan))
    with pytest.raises(UndeterminedError, match=r"does not tell eta and offset: .*record more"):
        calibrated(heights, alone, BOTH)
    # Two centimetres off, with a rod of 100 mm: no offset makes up for that.
    with pytest.raises(UndeterminedError, match="do not match the recording"):
        calibrated(heights, recording, ["offset"], 0.83)


@pytest.mark.slow
def test_a_height_out_of_range_is_said(response):
    _, recording = recorded(response, offset=np.zeros(3))
    far = respond_between(2.0, 0.78)
    with pytest.raises(UndeterminedError, match=r"looked for from 0.73|do not match"):
        calibrated(far, recording, [Unknown.ETA], 0.78)


@pytest.mark.parametrize(
    ("units", "said"),
    [
        (Units(), "eta would be 0.85 L with a standard deviation of 0.02 L, and is looked for "),
        (Units(Rod(2.1e11, 1e-3, 0.1), {Kind.LENGTH: "mm"}), "from 83.123 mm to 86.877 mm"),
    ],
)
def test_an_uncertain_height_is_told_in_the_units_of_the_rod(units, said):
    values, covariance = np.array([0.85, 0.0, 0.0, 0.0]), np.diag([4e-4, 0.0, 0.0, 0.0])
    near = SimpleNamespace(low=0.831232, high=0.868768)
    with pytest.raises(UndeterminedError, match=said):
        calibration._check_range(near, values, covariance, [0, 1], units)


class Level:
    """Up to the lock each of the channels changes by 1."""

    x0_lock = 1.0

    def __call__(self, x0):
        return np.stack([x0, x0, x0], axis=-1)


NEAR = SimpleNamespace(low=0.8, high=0.9, at=lambda eta: SimpleNamespace(level=Level()))


@pytest.mark.parametrize(("deviation", "known"), [(0.16, True), (0.17, False), (0.4, False)])
@pytest.mark.parametrize("channel", [0, 2])
def test_an_offset_is_known_to_half_of_what_its_channel_changes(deviation, known, channel):
    """Within three standard deviations."""
    covariance, values = np.zeros((4, 4)), np.array([0.85, 0.0, 0.0, 0.0])
    covariance[1 + channel, 1 + channel] = deviation**2
    said = rf"the offset of {CHANNELS[channel]} would have a standard deviation of {deviation:.0%} "
    with nullcontext() if known else pytest.raises(UndeterminedError, match=said):
        calibration._check_range(NEAR, values, covariance, [0, 2], Units())
    # A channel that is not used does not matter.
    calibration._check_range(NEAR, values, covariance, [1], Units())


def fit_of(jacobian, misfit=1.0):
    """Of zeros of force_x and moment_z, whose residuals have this mean square."""
    jacobian = np.array(jacobian, dtype=float)
    residuals = np.sqrt(misfit) * (-1.0) ** np.arange(len(jacobian))
    return SimpleNamespace(
        free=[1, 3], residuals=lambda values: residuals, jacobian=lambda values: jacobian
    )


def test_the_covariance_is_the_inverse_of_the_information():
    found = calibration._covariance(fit_of([[2.0, 0.0], [1.0, 1.0], [0.0, 2.0]]), np.zeros(4))
    # JᵀJ is ((5, 1), (1, 5)).
    expected = np.zeros((4, 4))
    expected[np.ix_([1, 3], [1, 3])] = np.array([[5.0, -1.0], [-1.0, 5.0]]) / 24.0
    assert found == pytest.approx(expected)


@pytest.mark.parametrize(
    ("jacobian", "misfit", "said"),
    [
        ([[1.0, 0.0], [0.0, 1.0]], 2.0001, "that remain are 2 times those of the noise: the rod"),
        ([[1.0, 1.0], [1.0, 1.0]], 1.0, "would fit as well with other values; record more"),
        ([[1.0, 0.0], [1.0, 0.0]], 1.0, "would fit as well with other values; record more"),
        # Units do not matter: this is known as well as the first.
        ([[1e9, 0.0], [0.0, 1e-9]], 1.0, None),
        ([[1.0, 0.0], [0.0, 1.0]], 1.9999, None),
    ],
)
def test_what_does_not_fit_or_cannot_be_told_apart_is_refused(jacobian, misfit, said):
    fit = fit_of(jacobian, misfit)
    with nullcontext() if said is None else pytest.raises(UndeterminedError, match=said):
        calibration._covariance(fit, np.zeros(4))


@pytest.mark.parametrize(
    ("eta", "deviation", "known"),
    [
        # Three standard deviations are within the range of 0.8 to 0.9, on both sides.
        (0.84, 0.0133, True),
        (0.84, 0.0134, False),
        (0.87, 0.0099, True),
        (0.87, 0.0101, False),
        (0.8, 0.0, False),
        (0.9, 0.0, False),
        (0.8001, 0.0, True),
    ],
)
def test_a_height_is_known_to_a_third_of_its_way_to_the_end_of_the_range(eta, deviation, known):
    covariance, values = np.diag([deviation**2, 0.0, 0.0, 0.0]), np.array([eta, 0.0, 0.0, 0.0])
    with nullcontext() if known else pytest.raises(UndeterminedError, match="is looked for from"):
        calibration._check_range(NEAR, values, covariance, [0, 1, 2], Units())


@pytest.mark.parametrize(("rows", "said"), [(2, "2 usable rows in 1 periods"), (3, "as well")])
def test_a_contact_and_each_unknown_use_up_two_readings(rows, said):
    """Of loads that grow evenly a shift of the contact is an offset."""
    clamp = 0.1 * np.arange(rows)
    recording = recording_of(clamp, Straight()(clamp))
    even = SimpleNamespace(low=0.8, high=0.9, at=lambda eta: Straight())
    with pytest.raises(UndeterminedError, match=f"does not tell offset: .*{said}") as raised:
        calibrate(even, 0.85, recording, ALL.noise, ["offset"])
    assert str(raised.value).endswith("or give eta and tare the transducer")


class Curved(Straight):
    """Its loads are curved, and in proportion to the height."""

    def __init__(self, eta):
        self.eta = eta

    @property
    def level(self):
        return self

    def __call__(self, x0):
        bent = np.multiply.outer(np.square(x0), [1.0, -3.0, 2.0])
        return self.eta * (super().__call__(x0) + bent)

    def slope(self, x0):
        bent = np.multiply.outer(2.0 * np.asarray(x0), [1.0, -3.0, 2.0])
        return self.eta * (super().slope(x0) + bent)


@pytest.mark.parametrize(
    ("unknown", "free"),
    [(["eta"], [0]), (["offset"], [1, 2, 3]), (["offset", "eta"], [0, 1, 2, 3])],
)
def test_what_is_estimated_of_exact_readings_is_exact_and_moves_by_its_deviations(unknown, free):
    near = SimpleNamespace(low=0.7, high=1.0, at=Curved)
    true = np.where(np.isin(np.arange(4), free), [0.86, 0.1, -0.2, 0.05], [0.85, 0.0, 0.0, 0.0])
    clamp = np.concatenate([one + np.linspace(0.0, 0.45, 20) for one in (0.0, 0.7, 1.4)])
    x0 = np.tile(np.linspace(0.0, 0.45, 20), 3)
    recording = recording_of(clamp, Curved(true[0])(x0) + true[1:])
    noise = 1e-3 * ALL.noise
    setup = calibrate(near, 0.85, recording, noise, unknown)
    assert setup.eta == pytest.approx(true[0], abs=1e-6)
    assert setup.offset == pytest.approx(true[1:], abs=1e-6)
    assert setup.fitted == len(free) and setup.branch.eta == setup.eta
    assert (setup.deviation > 0.0).tolist() == np.isin(np.arange(4), free).tolist()
    # In full: one place for each period, and all unknowns.
    columns = np.zeros((60, 3, 4 + 3))
    columns[:, :, 0] = Curved(1.0)(x0)
    for channel in range(3):
        columns[:, channel, 1 + channel] = 1.0
        columns[20 * channel : 20 * (channel + 1), :, 4 + channel] = -Curved(true[0]).slope(x0[:20])
    kept = [*free, 4, 5, 6]
    whole = (columns / noise[:, None])[:, :, kept].reshape(-1, len(kept))
    expected = np.linalg.inv(whole.T @ whole)[: len(free), : len(free)]
    assert setup.covariance[np.ix_(free, free)] == pytest.approx(expected, rel=1e-3)
    # The squares of what is displaced add up to the covariance.
    moved = []
    for one in setup.displaced:
        samples = sampled(clamp, x0)
        shift = samples.readings[0] - one.undone(samples).readings[0]
        moved.append([one.branch.eta - setup.eta, *shift])
        assert one.step == 1.0 and one.name == "calibration"
    assert len(moved) == len(free)
    assert np.transpose(moved) @ moved == pytest.approx(setup.covariance, abs=1e-12)


def test_derivatives_are_those_of_residuals_with_the_best_contacts(heights, response):
    """Where the recording fits: then they are exact."""
    truth = simulate(response, surfaces.constant(0.3), path("0.002", ["0.1"]))
    recording = recording_of(truth.clamp, truth.reactions)
    channels = Channels(used=[0, 1, 2], noise=NOISE)
    values = np.array([0.85, 0.0, 0.0, 0.0])
    samples, periods = calibration._usual_samples(heights.at(0.85), values, recording, channels)
    assert len(periods) > 2
    fit = calibration._Fit(
        heights=heights,
        samples=samples,
        channels=channels,
        periods=periods,
        free=[0, 1, 3],
        start=values,
    )
    at = values[fit.free]
    assert np.abs(fit.residuals(at)).max() < 1e-2
    each = [1e-6, 1e-5, 1e-5] * np.eye(3)
    found = [(fit.residuals(at + h) - fit.residuals(at - h)) / (2.0 * h.max()) for h in each]
    jacobian = fit.jacobian(at)
    scale = np.abs(jacobian).max(axis=0)
    assert jacobian / scale == pytest.approx(np.transpose(found) / scale, abs=2e-3)


def test_nothing_unknown_is_the_given_setup(heights, response):
    _, recording = recorded(response)
    setup = calibrated(heights, recording, [], 0.85)
    assert setup.eta == 0.85 and not setup.covariance.any() and setup.displaced == ()


@given(st.lists(st.floats(-2, 2), min_size=16, max_size=16), st.integers(0, 3))
def test_squares_of_the_principal_axes_add_up_to_the_covariance(entries, known):
    root = np.reshape(entries, (4, 4)) * [1e-4, 1e-2, 1.0, 10.0]
    root[:, :known] = 0.0
    covariance = root.T @ root
    axes = principal_axes(covariance)
    scale = np.sqrt(np.diag(covariance)) + 1e-100
    relative = (axes.T @ axes - covariance) / np.outer(scale, scale)
    assert np.abs(relative).max() < 1e-10


def test_a_principal_axis_begins_with_what_is_larger():
    for vector in ([0.0, 3.0, -4.0], [0.0, -3.0, 4.0]):
        (axis,) = principal_axes(np.outer(vector, vector))
        assert axis == pytest.approx([0.0, 3.0, -4.0])
    # A part that is hardly there, as by rounding, does not turn it; one that counts does.
    covariance = np.array([[1.0, 0.05], [0.05, 1.0]])
    for axes in (principal_axes(covariance), principal_axes(covariance * [[1.0, -1], [-1, 1]])):
        assert (axes[:, 0] > 0.0).all() and len(axes) == 2
    assert principal_axes(np.zeros((3, 3))).shape == (0, 3)
    # Independent deviations of different units: an axis each.
    found = np.abs(principal_axes(np.diag([4e-8, 9.0, 0.0])))
    assert np.sort(found.sum(axis=0)) == pytest.approx([0.0, 2e-4, 3.0])


@pytest.mark.slow
def test_estimates_on_the_command_line(tmp_path):
    scanned, found = tmp_path / "s.csv", tmp_path / "f.csv"
    whisker = ["--theta", "2", *SI, *NANO]

    def run(*arguments):
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    way = ["--step", "50 um", "--to", "30 mm", "--mu0", "0.3", "-o", scanned]
    assert run("scan", *whisker, "--eta", "85 mm", *way).exit_code == 0
    asked = ["--eta", "86 mm", "--estimate", "eta", "--estimate", "offset", "-o", found]
    asked += ["--tolerance", "exact"]
    result = run("identify", scanned, *whisker, *asked)
    assert result.exit_code == 0, result.output
    assert "eta = 85.0" in result.output and "correlation of eta and moment_z" in result.output
    assert "common [1]" in found.read_text().partition("\n")[0]
    found.unlink()
    scanned.write_text("".join(scanned.read_text().splitlines(keepends=True)[:4]))
    result = run("identify", scanned, *whisker, *asked)
    assert result.exit_code == 1 and "record more periods" in result.output
    assert not found.exists()
