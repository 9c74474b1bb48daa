"""The derivatives of the adjustment, against differences of what it does with a recording."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from steel import NOISE, measured, recording_of
from vibrissa import Mounting
from vibrissa.sensor import Whisker, identify, surfaces
from vibrissa.sensor.given.tolerances import TOLERABLE, assumed_tolerances
from vibrissa.sensor.identification.adjusting import adjustment
from vibrissa.sensor.identification.adjusting.properties import WAVES, Bench, components_of
from vibrissa.sensor.identification.adjusting.solving import Solver
from vibrissa.sensor.identification.periods import Channels
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.simulation.scanning import path, simulate

GIVEN = Whisker(theta=2.0, eta=0.85)


@pytest.fixture(scope="module")
def recorded():
    truth = simulate(GIVEN.pushed, surfaces.random(1, 0.3, 0.04, 0.02), path("0.0005", ["0.4"]))
    return truth, recording_of(truth.clamp, measured(truth.reactions, [1, 2]))


def fit_to(recording, tolerances):
    bench = Bench.of(recording, None, np.ones(3))
    return adjustment._Fit(
        whisker=GIVEN,
        recording=recording,
        channels=Channels.recorded(recording, NOISE),
        components=[one for name in tolerances for one in components_of(name, bench)],
        prior=adjustment.Prior(tolerances=tolerances),
        solver=Solver(clamp=recording.clamp, backward=False, pulled=False),
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in TOLERABLE if name != "surface_slope"])
def test_a_derivative_is_that_of_the_residuals(recorded, name):
    _, recording = recorded
    tolerances = {name: assumed_tolerances(Units(), NOISE)[name]}
    if name != "clamp_angle":
        tolerances["clamp_angle"] = 0.005
    fit = fit_to(recording, tolerances)
    scores = np.full(len(fit.components), 0.4)

    def seen(scores, changes=None):
        (branch,) = fit.solver.quick(fit._rod(scores))
        changes = fit._changes(fit._rod(scores), branch) if changes is None else changes
        undone = fit._undone(scores, branch, changes)
        return adjustment._seen(branch, undone, fit.channels), changes

    here, changes = seen(scores)
    for number, one in enumerate(fit.components[:3]):
        told = here.effect_of(changes[number]).ravel() * fit.sigma[number]
        moved = scores.copy()
        moved[number] += 0.05
        there, _ = seen(moved, changes)
        assert len(there.samples) == len(here.samples)
        change = (here.residuals - there.residuals).ravel() / 0.05
        # What is left is of second order, and differs most where the effect itself is small.
        assert np.linalg.norm(told - change) < 0.1 * np.linalg.norm(change) + 3.0, one.name


def test_steps_that_do_not_settle_are_halved_and_given_up_and_derivatives_told_anew(
    recorded, monkeypatch
):
    _, recording = recorded
    fit = fit_to(recording.take(slice(0, 120)), {"zero_force_x": 0.01})
    tried, renewed = [], []
    undone, changes = adjustment._Fit._undone, adjustment._Fit._changes

    def noted(self, scores, branch, changes):
        tried.append(float(scores[0]))
        return undone(self, scores, branch, changes)

    def told_anew(self, rod, branch):
        renewed.append(len(tried))
        return changes(self, rod, branch)

    monkeypatch.setattr(adjustment._Fit, "_undone", noted)
    monkeypatch.setattr(adjustment._Fit, "_changes", told_anew)
    monkeypatch.setattr(adjustment, "_step_to", lambda *_: np.ones(1))
    assert fit.settled() is None
    assert tried == [0, 1, 2, 3, 4, 5, 6, 6.5, 7, 7.5, 8, 8.5] and renewed == [0, 3, 6, 9]


def test_a_drift_is_a_wiener_process():
    line = np.arange(401)
    recording = Recording(clamp=0.0 * line, readings=np.zeros((401, 3)), line=line)
    bench = Bench.of(recording, None, np.ones(3))
    parts = components_of("drift_force_y", bench)
    assert len(parts) == WAVES + 1
    shapes = np.array(
        [-one.weight * one.property.recording(recording, 1.0).readings[:, 1] for one in parts]
    )
    covariance = shapes.T @ shapes
    part = line / 400.0
    # That of a Wiener process is the lesser of both times; the waves left out are in its diagonal.
    error = np.minimum.outer(part, part) - covariance
    assert np.abs(error).max() < 0.03
    assert np.diag(error).min() > -1e-9


def test_crosstalk_is_of_full_scale():
    readings = np.array([[1.0, 2.0, 0.5]])
    recording = Recording(clamp=np.zeros(1), readings=readings, line=np.array([2]))
    bench = Bench(full_scale=np.array([4.0, 8.0, 2.0]), first=2, last=3)
    one = next(
        one
        for one in components_of("crosstalk", bench)
        if one.name == "crosstalk of moment_z in force_x"
    )
    undone = one.property.recording(recording, 0.01).readings[0]
    assert undone == pytest.approx([1.0 - 0.01 * 0.5 * 4.0 / 2.0, 2.0, 0.5])


@pytest.mark.slow
def test_far_from_what_was_given_is_in_doubt(recorded):
    _, recording = recorded
    spoiled = replace(recording, readings=1.2 * recording.readings)
    found = identify(
        GIVEN, spoiled, noise=NOISE, method="model", tolerances={"modulus": "3 %"}, assume=False
    )
    assert (found.periods.grade == "doubtful").all()
    assert "modulus (6." in found.periods.doubt[0]


@pytest.mark.slow
def test_a_usual_mistake_is_in_the_intervals_or_said(recorded):
    for mounting in (Mounting(clamp_angle=np.deg2rad(0.5)), Mounting(curvature=-0.02)):
        rod = replace(GIVEN, mounting=mounting)
        truth = simulate(rod.pushed, surfaces.random(1, 0.3, 0.04, 0.02), path("0.0005", ["0.4"]))
        recording = recording_of(truth.clamp, measured(truth.reactions, [1, 2]))
        found = identify(GIVEN, recording, noise=NOISE).periods
        slip = found.status == "slip"
        true = truth.mu0[found.last][slip]
        assert ((found.low[slip] <= true) & (true <= found.high[slip])).mean() > 0.9
        assert (found.grade == "").all()


@pytest.mark.parametrize("share", [0.49, 0.51])
def test_a_chance_is_that_of_what_the_recording_tells_at_least_half_of(recorded, share):
    """Scores whose covariance was 1 before: afterwards 0.1 for one, 1 - share for the other."""
    _, recording = recorded
    given = fit_to(recording, {"theta": 0.1, "eta": 0.01})
    assert len(given.components) == 2
    covariance = np.diag([0.1, 1.0 - share])
    scores = np.array([1.2, 0.7])
    squares = 1.2**2 / 0.9 + (0.7**2 / share if share > 0.5 else 0.0)
    freedom = 2 if share > 0.5 else 1
    assert given._chance(scores, covariance) == pytest.approx(chi2.sf(squares, freedom))
    # Axes that are turned tell the same.
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = given._chance(turn @ scores, turn @ covariance @ turn.T)
    assert turned == pytest.approx(chi2.sf(squares, freedom))
