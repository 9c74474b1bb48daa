"""What is asked of an identification, and when model and ratio are read beside each other."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from steel import NOISE, ROD, SCALE, SENSOR, recording_of
from straight import Straight, periods_of
from vibrissa.errors import (
    ArgumentError,
    MixedColumnsError,
    NoResponseError,
    RecordingError,
    UndeterminedError,
    WrongRodError,
)
from vibrissa.sensor import Units, Whisker, identify
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.adjusting.priors import Asked
from vibrissa.sensor.identification.adjusting.properties import Bench
from vibrissa.sensor.identification.both import (
    WithoutRod,
    WithRod,
    _with_kinetic,
    model_beside_ratio,
    ratio_beside_model,
)
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.identify import _noise, _told, _tolerant, _units
from vibrissa.sensor.identification.misfit.doubts import Doubt
from vibrissa.sensor.identification.preparing.settling import Told
from vibrissa.sensor.identification.reading.carried import Carried
from vibrissa.sensor.identification.reading.kinetic import KineticRatio
from vibrissa.sensor.identification.recording import Method
from vibrissa.sensor.identification.result import Identification

STEEL, PLAIN = Whisker(theta=2.0, eta=0.85, rod=ROD), Whisker(theta=2.0, eta=0.85)
NAN = np.nan

# --- Arguments ---


def test_noise_is_told_by_a_text_by_numbers_or_by_the_transducer():
    units = Units(ROD)
    assert _noise("1 N, 2 N, 3 N*m", None, units) == pytest.approx(np.array([1, 2, 3]) / SCALE)
    assert _noise([1, 2, 3], None, units).tolist() == [1.0, 2.0, 3.0]
    assert _noise(None, SENSOR, units) == pytest.approx(NOISE)
    assert _noise(None, None, units) is None
    for noise in ([1.0, 2.0], [[1.0, 2.0, 3.0]], 1.0, [1.0] * 4):
        with pytest.raises(ArgumentError, match="noise needs three values, got "):
            _noise(noise, None, units)
    with pytest.raises(ArgumentError, match="give the noise or the transducer, not both"):
        _noise([1.0, 2.0, 3.0], SENSOR, units)


def test_times_are_told_in_samples():
    recording = replace(recording_of(np.zeros(4), np.zeros((4, 3))), interval=0.5)
    assert _told(recording, "1 s", None) == Told(slip=2.0, delay=None)
    assert _told(recording, None, "250 ms") == Told(slip=None, delay=0.5)
    assert _told(recording, "0 s", "0 s") == Told(slip=0.0, delay=0.0)
    assert _told(recording, None, None) == Told()
    for what, times in {"slip_time": ("-1 s", "1 s"), "delay": ("1 s", "-1 s")}.items():
        with pytest.raises(ArgumentError, match=f"{what} must not be negative, got '-1 s'"):
            _told(recording, *times)
    # Without times only what is not asked for is known.
    timeless = replace(recording, interval=NAN)
    assert _told(timeless, None, None) == Told()
    with pytest.raises(ArgumentError, match="slip_time needs a column 'time"):
        _told(timeless, "0 s", None)


@pytest.mark.parametrize(
    ("ratio", "stated", "value", "tolerances"),
    [
        (None, {"theta": "2 %"}, None, {"theta": 0.04}),
        (0.8, {}, 0.8, {}),
        ("0.8 ± 0.03", {"eta": 0.01}, 0.8, {"kinetic_ratio": 0.03, "eta": 0.01}),
        (0.5, {"kinetic_ratio": "2 %"}, 0.5, {"kinetic_ratio": 0.01}),
        # What is stated apart holds.
        ("0.8 ± 0.03", {"kinetic_ratio": 0.02}, 0.8, {"kinetic_ratio": 0.02}),
    ],
)
def test_the_ratio_of_the_frictions_may_come_with_its_tolerance(ratio, stated, value, tolerances):
    found, whisker = _tolerant(PLAIN, ratio, stated)
    assert found == value and dict(whisker.tolerances) == pytest.approx(tolerances)
    assert not PLAIN.tolerances


def test_units_are_those_of_the_rod_or_of_the_recording_where_none_is_needed():
    from pandas import DataFrame

    frame = DataFrame({"footpoint [mm]": [0.0, 1.0]})
    recording = recording_of(np.zeros(4), np.zeros((4, 3)))
    for method in Method:
        assert _units(STEEL, frame, method) == STEEL.units
        plain = _units(PLAIN, frame, method)
        assert plain.si == (method is Method.RATIO) and plain.rod is None
        assert _units(PLAIN, recording, method) == Units()
    assert _units(None, frame, Method.RATIO).si and not _units(None, recording, Method.RATIO).si


@pytest.mark.parametrize(
    ("whisker", "asked", "said"),
    [
        (PLAIN, {"method": "ratio", "estimate": ["eta"]}, "the method ratio cannot estimate any"),
        (None, {"method": "moment"}, "the method moment needs the rod: give theta and eta, or use"),
        (None, {}, "the method forces needs the rod"),
        (None, {"method": "smell"}, "method must be one of"),
    ],
)
def test_what_a_method_cannot_do_is_said(whisker, asked, said):
    with pytest.raises(ArgumentError, match=said):
        identify(whisker, recording_of(np.zeros(0), np.zeros((0, 3))), **asked)


# --- The model and the ratio ---


def identification(size=4, mu0=0.3, setup=True, **more):
    effects = np.zeros((size, len(more.get("tolerances", ()))))
    shifts = np.zeros((size, 1 + effects.shape[1]))
    periods = periods_of(np.full(size, mu0), 0.001, 0.0, shifts, effects)
    covariance = np.diag([one.deviation**2 for one in more.get("tolerances", ())])
    known = {"periods": periods, "units": Units(), "covariance": covariance}
    setup = known_setup(Straight()) if setup else None
    return Identification(**known | {"setup": setup} | more)


def without_rod(found=None, forces=True, moment=True, sizes=None, stated=()):
    readings = np.ones((9, 3)) * [1.0 if forces else NAN, 1.0, 1.0 if moment else NAN]
    recording = recording_of(np.arange(9.0), readings)

    @dataclass(frozen=True, eq=False, kw_only=True)
    class Ratio(WithoutRod):
        def read(self):
            if isinstance(found, Exception):
                raise found
            return found if found is not None else super().read()

    return Ratio(
        recording=recording,
        noise=NOISE,
        errors=Carried.of(sizes or {}, Bench.of(recording, None, np.ones(3))),
        stated=frozenset(stated),
        units=Units(),
    )


def with_rod(found, estimate=()):
    """A model of which the method is noted by which it is read."""
    methods = []

    @dataclass(frozen=True, eq=False, kw_only=True)
    class Model(WithRod):
        def read(self):
            methods.append(self.asked.method)
            if isinstance(found, Exception):
                raise found
            return found

    names = "whisker recording noise transducer kinetic_ratio step told units progress".split()
    asked = Asked(method=Method.RATIO, law=None, estimate=estimate, assume=False)
    return Model(asked=asked, **dict.fromkeys(names)), methods


def test_the_ratio_can_be_read_where_both_forces_were_recorded():
    assert without_rod().possible and without_rod(moment=False).possible
    assert not without_rod(forces=False).possible


@pytest.mark.parametrize("error", [NoResponseError, UndeterminedError, WrongRodError])
def test_a_model_that_cannot_be_read_offers_the_ratio_by_its_own_error(error):
    model, _ = with_rod(error("it is not"))
    with pytest.raises(error) as raised:
        model_beside_ratio(model, without_rod())
    assert str(raised.value) == "it is not; --method ratio reads the forces without a rod"
    with pytest.raises(error) as raised:
        model_beside_ratio(model, without_rod(forces=False))
    assert str(raised.value) == "it is not"
    # Other errors are of the recording, which the ratio needs, too.
    for other in (RecordingError, MixedColumnsError):
        model, _ = with_rod(other("no"))
        with pytest.raises(other, match=r"^no$"):
            model_beside_ratio(model, without_rod())


def test_the_model_is_compared_with_the_ratio_unless_the_forces_are_estimated():
    found, ratio = identification(), without_rod(identification(mu0=0.5, setup=False))
    compared = model_beside_ratio(with_rod(found)[0], ratio)
    assert compared.beside.difference == pytest.approx(-0.2)
    said = f"by -0.2 ± 0.0007 {Doubt.BESIDE.why}"
    assert compared.periods.doubt.tolist() == [said] * 4
    assert compared.periods.grade.tolist() == ["doubtful"] * 4
    assert compared.periods.notes == (f"doubtful: {said}: 4 of 4 periods, line 0-0, 1-1, 2-2, ...",)
    # One that disagrees alone is told without the means, which agree.
    one = replace(found, periods=replace(found.periods, mu0=np.array([0.5, 0.3, 0.3, 0.3])))
    same = without_rod(identification(setup=False))
    alone = model_beside_ratio(with_rod(one)[0], same)
    assert alone.periods.doubt.tolist() == [Doubt.BESIDE.why, "", "", ""]
    for estimate, beside in (("transducer_angle", False), ("offset", False), ("eta", True)):
        other = model_beside_ratio(with_rod(found, (estimate,))[0], same)
        assert (other.beside is not None) == beside
    assert model_beside_ratio(with_rod(found)[0], without_rod(forces=False)) is found
    refused = model_beside_ratio(with_rod(found)[0], without_rod(RecordingError("too short")))
    assert refused.periods.notes == ("not compared with the ratio of the forces: too short",)
    assert refused.beside is None


@pytest.mark.parametrize(("moment", "method"), [(True, Method.MOMENT), (False, Method.FORCES)])
def test_the_ratio_is_compared_with_the_model_by_the_moment_where_there_is_one(moment, method):
    ratio = without_rod(identification(setup=False), moment=moment)
    model, methods = with_rod(identification(mu0=0.4))
    found = ratio_beside_model(ratio, model)
    assert methods == [method]
    assert found.beside.difference == pytest.approx(0.1) and found.setup is None
    assert (found.periods.grade == "doubtful").all() and found.periods.mu0[0] == 0.3
    for error in (NoResponseError("no rod"), RecordingError("no rod"), WrongRodError("no rod")):
        found = ratio_beside_model(ratio, with_rod(error)[0])
        assert found.periods.notes == ("not compared with the model of the rod: no rod",)
    with pytest.raises(MixedColumnsError):
        ratio_beside_model(ratio, with_rod(MixedColumnsError("mixed up"))[0])


def test_periods_of_the_ratio_are_doubted_where_those_of_the_model_that_end_there_are():
    ratio = identification(size=5, setup=False)
    ratio = replace(ratio, periods=replace(ratio.periods, last_line=np.array([0, 1, 9, 2, 3])))
    model = identification()
    model = replace(model, periods=replace(model.periods, mu0=np.array([0.3, 0.3, 0.5, 0.3])))
    found = ratio_beside_model(without_rod(ratio), with_rod(model)[0])
    assert (found.periods.doubt != "").tolist() == [False, False, False, True, False]


def adjusted(name, score, **more):
    """By so many standard deviations, of which the recording tells 3/4 of the variance."""
    surprise = score * np.sqrt(0.75)
    return Tolerance(name=name, of=name, tolerance=1.0, adjusted=surprise, deviation=0.5, **more)


def test_what_the_model_tells_of_the_forces_is_told_from_three_deviations_on():
    tolerances = (
        adjusted("zero_force_x", 2.99),
        adjusted("zero_force_y", -3.01),
        adjusted("drift_force_x", 9.0, wave=1),
        adjusted("eta", 9.0),
        adjusted("crosstalk", 4.25),
    )
    model = identification(tolerances=tolerances)
    found = ratio_beside_model(without_rod(identification(setup=False)), with_rod(model)[0])
    assert [one.name for one in found.far] == ["zero_force_y", "crosstalk"]
    why = [f"zero_force_y (3.0 standard deviations) {Doubt.FAR.why}"]
    why += [f"crosstalk (4.2 standard deviations) {Doubt.FAR.why}"]
    assert found.periods.doubt.tolist() == ["; ".join(why)] * 4


def test_errors_of_the_readings_are_told_as_they_were_given():
    sizes = {"zero_force_x": 0.02, "drift_force_y": 0.03, "theta": 0.5}
    teeth = -0.3 * (1.0 + np.arange(60.0) % 15) / 15.0
    ratio = without_rod(sizes=sizes, stated=["zero_force_x"])
    readings = np.column_stack([teeth, np.full(60, -1.0), np.full(60, NAN)])
    ratio = replace(ratio, recording=recording_of(0.01 * np.arange(60.0), readings))
    found = ratio.read()
    assert found.setup is None and len(found.periods) == 4
    first, *drifts = found.tolerances
    assert (first.name, first.tolerance, first.deviation) == ("zero_force_x", 0.02, 0.02)
    assert first.adjusted == 0.0 and first.stated and first.wave == 0
    assert {one.of for one in drifts} == {"drift_force_y"} and not any(o.stated for o in drifts)
    assert {one.wave for one in drifts} != {0}
    sizes = [one.tolerance for one in found.tolerances]
    assert np.diag(found.covariance) == pytest.approx(np.square(sizes))
    assert np.count_nonzero(found.covariance) == len(sizes)


def test_a_ratio_that_the_slips_have_told_stands_among_the_tolerances():
    found = identification(tolerances=(adjusted("eta", 1.0),))
    assert _with_kinetic(found) is found
    kinetic = KineticRatio(value=0.7, deviation=0.02)
    told = _with_kinetic(replace(found, periods=replace(found.periods, kinetic=kinetic)))
    assert [one.name for one in told.tolerances] == ["eta", "kinetic_ratio"]
    assert told.covariance == pytest.approx(np.diag([0.25, 0.0004]))
    last = told.tolerances[-1]
    assert (last.of, last.tolerance, last.adjusted, last.deviation) == (
        "kinetic_ratio",
        0.02,
        0.0,
        0.02,
    )
