"""The model of the rod and the ratio of the forces, each beside the other."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from steel import NOISE, measured, recording_of
from vibrissa.errors import NoResponseError, WrongRodError
from vibrissa.sensor import Whisker, identify, path, simulate, surfaces
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.both import model_beside_ratio
from vibrissa.sensor.identification.misfit.beside import Read, beside
from vibrissa.sensor.identification.misfit.doubts import Doubt, Doubted, with_reason
from vibrissa.sensor.response.branch import respond

WHISKER = Whisker(theta=2.0, eta=0.85)
ANGLE = np.deg2rad(1.0)
TURNED = np.array(
    [[np.cos(ANGLE), np.sin(ANGLE), 0], [-np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]]
)


@cache
def recorded(seed=1):
    truth = simulate(
        respond(2.0, 0.85),
        surfaces.random(seed, 0.3, 0.02, 0.05),
        path("0.0002", ["0.15"]),
        "kinetic",
        0.8,
    )
    return recording_of(truth.clamp, measured(truth.reactions, seed)), truth


def read(method, recording=None, whisker=WHISKER, **asked):
    recording = recorded()[0] if recording is None else recording
    return identify(whisker, recording, method=method, noise=NOISE, **{"assume": False} | asked)


def turned():
    """The same recording by a transducer that is turned by a degree."""
    return recorded()[0].mixed(TURNED)


@pytest.mark.parametrize("method", ["model", "ratio"])
def test_where_all_is_as_given_they_agree(method):
    law = {"law": "kinetic", "kinetic_ratio": 0.8} if method == "spacing" else {}
    found = read(method, **law)
    assert found.beside.compared and found.beside.agrees
    assert abs(found.beside.difference) < 4.0 * found.beside.spread < 0.003
    assert not (found.periods.grade == "doubtful").any()
    assert "and the ratio of the forces differ by" in str(found.summary())
    assert "they agree" in str(found.summary())


def test_the_table_has_the_friction_by_both():
    found = read("model")
    table = found.to_pandas()
    alone = read("ratio", whisker=None).to_pandas()
    (ratio,) = (name for name in table.columns if name.startswith("mu0_ratio"))
    (deviation,) = (name for name in table.columns if name.startswith("deviation_ratio"))
    (mu0,) = (name for name in alone.columns if name.split()[0] == "mu0")
    known = table[ratio].notna()
    assert known.sum() == found.beside.number > 10
    assert table[ratio][known].tolist() == pytest.approx(alone[mu0].dropna().tolist())
    assert (alone[mu0].dropna() == alone[ratio].dropna()).all()
    assert (table[deviation][known] > 0.0).all() and table[deviation][~known].isna().all()


@pytest.mark.slow
def test_a_transducer_that_is_turned_is_doubted_by_both():
    # The moment does not change, the ratio by δ·(1 + μ²).
    for method in ("model", "ratio"):
        found = read(method, turned())
        assert found.beside.difference == pytest.approx(-ANGLE * 1.09, abs=1e-3)
        assert not found.beside.agrees and np.isin(found.periods.grade, ["doubtful", "wrong"]).all()
        assert (np.char.find(found.periods.doubt, Doubt.BESIDE.why) >= 0).all()
        assert np.char.find(found.periods.doubt, "by -0.019 ± 0.0").min() >= 0
        assert "they disagree: one of them is wrong" in str(found.summary())
        assert any(Doubt.BESIDE.why in note for note in found.periods.notes)


def test_a_tolerance_that_allows_for_it_is_allowed_for():
    found = read("model", turned(), tolerances={"transducer_angle": "1 deg"})
    assert found.beside.agrees and abs(found.beside.difference) > 0.015
    assert found.beside.spread == pytest.approx(ANGLE * 1.09, rel=0.1)


def test_the_ratio_says_what_the_recording_tells_of_its_errors():
    found = read("ratio", turned(), tolerances={"transducer_angle": "0.1 deg"})
    assert (np.char.find(found.periods.doubt, Doubt.FAR.why) >= 0).all()
    assert (np.char.find(found.periods.doubt, "transducer_angle (") >= 0).all()


@pytest.mark.slow
def test_a_wrong_rod_does_not_change_the_ratio_but_is_told():
    alone = read("ratio", whisker=None)
    other = read("ratio", whisker=Whisker(theta=2.3, eta=0.85))
    assert other.periods.mu0 == pytest.approx(alone.periods.mu0, nan_ok=True)
    assert not other.beside.agrees and (other.periods.grade == "doubtful").sum() > 10
    # One whose readings these cannot be is not compared.
    readings = recorded()[0].readings * np.array([1.0, 1.0, np.nan])
    forces = recording_of(recorded()[0].clamp, readings)
    found = read("ratio", forces, whisker=Whisker(theta=1.0, eta=0.5))
    assert found.periods.mu0 == pytest.approx(alone.periods.mu0, nan_ok=True)
    assert found.beside is None and not (found.periods.grade == "doubtful").any()
    (note,) = (note for note in found.periods.notes if "not compared with the model" in note)
    assert "no state of this rod" in note


@pytest.mark.slow
def test_a_model_that_cannot_be_read_offers_the_ratio():
    offer = "--method ratio reads the forces without a rod"
    with pytest.raises(WrongRodError, match=offer):
        read("model", whisker=Whisker(theta=1.0, eta=0.5))


@pytest.mark.parametrize("possible", [True, False])
def test_the_ratio_is_offered_where_both_forces_were_recorded(possible):
    def read():
        raise NoResponseError("no response")

    model, ratio = SimpleNamespace(read=read), SimpleNamespace(possible=possible)
    with pytest.raises(NoResponseError) as raised:
        model_beside_ratio(model, ratio)
    assert str(raised.value).startswith("no response")
    assert ("--method ratio" in str(raised.value)) == possible


def test_without_forces_nothing_is_compared():
    alone = recorded()[0].readings.copy()
    alone[:, 0] = np.nan
    found = read("model", recording_of(recorded()[0].clamp, alone))
    assert found.beside is None and "ratio of the forces" not in str(found.summary())
    assert found.to_pandas().filter(like="mu0_ratio").isna().all().all()


def made(model, ratio, covariance, tolerance=1.0):
    """Read the same periods twice, with one common error."""
    found = read("model")
    one, other = found.periods, read("ratio", whisker=None).periods
    one = model(one.take(np.isfinite(one.mu0)))
    other = ratio(other.take(np.isin(other.last_line, one.last_line)))
    told = [Tolerance(name="a", of="a", tolerance=tolerance, adjusted=0.0, deviation=tolerance)]
    return (
        Read(periods=one, tolerances=told, covariance=np.array([[covariance]])),
        Read(periods=other, tolerances=told, covariance=np.array([[tolerance**2]])),
    )


def with_effect(size, shift=0.0):
    from dataclasses import replace

    def changed(periods):
        effects = np.full((len(periods), 1), size)
        shifts = np.zeros((len(periods), 2))
        return replace(periods, mu0=periods.mu0 + shift, effects=effects, shifts=shifts)

    return changed


@pytest.mark.parametrize(
    ("of_model", "of_ratio", "covariance", "variance"),
    [
        # Not adjusted: both have the same error, and only the difference of the effects counts.
        (2.0, 2.0, 1.0, 0.0),
        (2.0, 3.0, 1.0, 1.0),
        # Adjusted: R²·Σ + M²·C − 2·R·C·M.
        (2.0, 3.0, 0.25, 9.0 + 1.0 - 3.0),
        (0.0, 3.0, 0.25, 9.0),
    ],
)
def test_what_both_share_does_not_count(of_model, of_ratio, covariance, variance):
    plain = beside(*made(with_effect(0.0), with_effect(0.0), 1.0))
    found = beside(*made(with_effect(of_model), with_effect(of_ratio), covariance))
    assert found.spread**2 - plain.spread**2 == pytest.approx(variance, abs=1e-9)
    assert found.number == plain.number and found.difference == plain.difference


def test_one_period_that_disagrees_is_doubted_alone():
    plain = beside(*made(with_effect(0.0), with_effect(0.0), 1.0))
    one = np.zeros(plain.off.shape)
    one[3] = 0.02
    found = beside(*made(with_effect(0.0, one), with_effect(0.0), 1.0))
    assert found.off.tolist() == (one > 0.0).tolist() and found.agrees
    assert not plain.off.any()
    every = beside(*made(with_effect(0.0, 0.02), with_effect(0.0), 1.0))
    assert every.off.all() and not every.agrees
    assert every.difference == pytest.approx(plain.difference + 0.02)


def test_few_periods_are_not_compared():
    short = recorded()[0].take(slice(0, 120))
    found = read("model", short)
    assert found.beside.number < 3 and not found.beside.compared
    assert np.isnan(found.beside.difference) and found.beside.agrees
    assert "differ" not in str(found.summary())


def test_a_reason_is_added_to_others_and_the_worst_grade_stays():
    grade, words = np.array(["", "wrong", "information", ""]), np.array(["", "bad", "note", ""])
    on = np.array([True, True, True, False])
    graded, said = with_reason(
        grade, words, Doubted(doubt=Doubt.BESIDE, channel="by 1", periods=on)
    )
    assert graded.tolist() == ["doubtful", "wrong", "doubtful", ""]
    why = f"by 1 {Doubt.BESIDE.why}"
    assert said.tolist() == [why, f"bad; {why}", f"note; {why}", ""]
