"""A recording that is read by several methods at once has the results of `identify` by each."""

import pytest

from vibrissa.errors import VibrissaError
from vibrissa.outcomes import Method
from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, scan
from vibrissa.sensor.identification.identify import identify, identify_by

STEEL = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
SENSOR = "nano17-si-12-0.12"
METHODS = [Method.MODEL, Method.RATIO]


@pytest.fixture(scope="module")
def frame():
    whisker = Setup.read(theta=1, eta="85 mm", **STEEL).whisker
    signals = scan(whisker, surfaces.constant(0.3), step="0.2 mm", to=["8 mm"])
    return signals.measured(SENSOR, seed=1).to_pandas()


def told(result):
    """All that a result says, or why there is none."""
    if isinstance(result, VibrissaError):
        return type(result), str(result)
    columns = {name: one.values.tolist() for name, one in result.columns().items()}
    return str(result.summary()), str(columns), result.periods.notes, result.recording.notes


def alone(setup, frame, method):
    try:
        return identify(setup, frame, method=method)
    except VibrissaError as error:
        return error


def without_a_moment(frame):
    """The model leaves out rows without a moment; the ratio leaves out the moment."""
    lost = frame.copy()
    lost.loc[::20, "moment_z"] = float("nan")
    return lost


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "rod"),
    [
        pytest.param(lambda frame: frame, {}, marks=pytest.mark.nightly),
        (without_a_moment, {}),
        pytest.param(lambda frame: frame, {"diameter": "1.6 mm"}, marks=pytest.mark.nightly),
        (lambda frame: frame.drop(columns="force_x"), {}),
    ],
    ids=["as it is", "rows without a moment", "another rod", "one force"],
)
def test_several_methods_have_the_results_of_each(frame, change, rod):
    known = {"transducer": SENSOR, "tolerances": {"eta": "0.1 mm"}, "assume": False}
    setup = Setup.read(theta=1, eta="85 mm", **known, **STEEL | rod)
    recording = change(frame)
    found = identify_by(setup, recording, METHODS)
    assert list(map(told, found)) == [told(alone(setup, recording, one)) for one in METHODS]
