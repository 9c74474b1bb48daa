"""What is known of a period by what its tip has done; the ratio of frictions that slips tell."""

from types import SimpleNamespace

import numpy as np
import pytest

from vibrissa.errors import UndeterminedError
from vibrissa.sensor.identification.friction import _statuses, _where_known
from vibrissa.sensor.identification.periods import Partition
from vibrissa.sensor.identification.reading.kinetic import ratio_after_slips
from vibrissa.sensor.identification.reading.uncertainty import Summary
from vibrissa.sensor.identification.recording import Recording, Slipping


def seen(locked=(), pulled=(), least=None, size=4):
    """Periods of a rod with μ_lock of 0.5, of which the tip of some has locked or was pulled."""
    rows = np.arange(size)
    return SimpleNamespace(
        locked=np.isin(rows, locked),
        least=np.full(size, 0.2) if least is None else np.array(least),
        last=SimpleNamespace(sign=np.where(np.isin(rows, pulled), -1.0, 1.0)),
        ending=SimpleNamespace(mu_lock=np.full(size, 0.5)),
    )


def read(mean=(0.3,) * 4):
    mean = np.array(mean)
    return Summary(mean=mean, deviation=0.1 * mean, low=mean - 0.1, high=mean + 0.1)


NAN = np.nan


@pytest.mark.parametrize(
    ("periods", "told", "status"),
    [
        (seen(), {}, "slip slip slip open"),
        (seen(), {"from_slip": True}, "open slip slip open"),
        (seen(locked=[1]), {}, "slip lock slip open"),
        # Pulled back from past the lock a tip slips after all, but at the end it is not known.
        (seen(locked=[1, 3], pulled=[1, 3]), {}, "slip slip slip lock"),
        (seen(locked=[0], pulled=[0]), {"from_slip": True}, "lock slip slip open"),
        (seen(least=[0.2, NAN, 0.2, NAN]), {}, "slip beyond slip beyond"),
        (seen(locked=[1], least=[0.2, NAN, 0.2, 0.2]), {}, "slip beyond slip open"),
        # A tip that is pushed slips before it has stuck to more than the lock; pulled it may.
        (seen(least=[0.5, 0.51, 0.2, 0.51]), {}, "slip beyond slip open"),
        (seen(least=[0.2, 0.51, 0.2, 0.2], pulled=[1]), {}, "slip slip slip open"),
        (seen(least=[0.2, 0.51, 0.2, 0.2], locked=[1]), {}, "slip lock slip open"),
        (seen(), {"found": read([0.3, NAN, 0.3, NAN])}, "slip beyond slip open"),
        (seen(), {"unsure": [True] * 4}, "unsure unsure unsure open"),
        (seen(), {"found": read([NAN] * 4), "unsure": [True] * 4}, "beyond beyond beyond open"),
    ],
)
def test_what_is_known_of_a_period(periods, told, status):
    told = {"found": read(), "unsure": [False] * 4, "from_slip": False} | told
    found = _statuses(periods, told["found"], np.array(told["unsure"]), told["from_slip"])
    assert " ".join(found) == status


def test_a_status_leaves_a_distribution_bounds_or_nothing():
    status = np.array(["slip", "open", "lock", "unsure", "unsure", "beyond"])
    least, periods = np.array([0.2, 0.21, 0.6, 0.2, 0.2, 0.2]), seen(pulled=[4], size=6)
    nothing = [NAN] * 5
    for swung, bound in ((False, 0.5), (True, 0.6)):
        found = _where_known(read((0.3,) * 6), status, least, periods, swung)
        assert found.mean == pytest.approx([0.3, *nothing], nan_ok=True)
        assert found.deviation == pytest.approx([0.03, *nothing], nan_ok=True)
        assert found.low == pytest.approx([0.2, 0.21, bound, 0.2, 0.2, NAN], nan_ok=True)
        assert found.high == pytest.approx([0.4, NAN, NAN, 0.5, NAN, NAN], nan_ok=True)


def after_slips(kinetic, static, gap=0.01):
    """Periods of two samples of a rod whose demand is its displacement, in steps of `gap`."""
    x0 = np.column_stack([kinetic, np.array(static) - 0.5 * gap]).ravel()
    states = SimpleNamespace(
        demand=lambda x: np.asarray(x), demand_slope=np.ones_like, clip=lambda x: x
    )
    size, none = len(static), np.zeros(len(static))
    return SimpleNamespace(
        last=SimpleNamespace(travel=x0[1::2], gap=none + gap, base=none),
        ending=states,
        states=states,
        x0=x0,
        periods=Partition(begins=2 * np.arange(size), size=2 * size),
    )


def test_the_kinetic_ratio_is_the_median_of_what_is_needed_after_slips():
    kinetic, static = [0.9, 0.24, 0.3, 0.35, 0.9], [0.3, 0.4, 0.4, 0.5, 0.9]
    found = ratio_after_slips(after_slips(kinetic, static))
    ratios = np.array([0.6, 0.75, 0.7])
    assert found.value == pytest.approx(0.7)
    by_step = np.mean(0.01 / np.sqrt(12.0) * ratios / [0.4, 0.4, 0.5])
    scatter = ratios.std(ddof=1)
    assert by_step < scatter
    assert found.deviation == pytest.approx(np.sqrt(0.5 * np.pi / 3.0) * scatter)
    # Where the periods scatter by less than the step, what remains of it is that of all.
    same = ratio_after_slips(after_slips([0.1, 0.24, 0.3, 0.36, 0.1], [0.3, 0.4, 0.5, 0.6, 0.3]))
    assert same.value == pytest.approx(0.6)
    by_step = np.mean(0.01 / np.sqrt(12.0) * 0.6 / np.array([0.4, 0.5, 0.6]))
    assert same.deviation == pytest.approx(by_step)


@pytest.mark.parametrize(
    ("kinetic", "static"),
    [
        ([0.1, 0.2, 0.2, 0.1], [0.3, 0.4, 0.4, 0.3]),
        ([0.1, 0.2, NAN, 0.2, 0.1], [0.3, 0.4, 0.4, 0.4, 0.3]),
        ([0.1, 0.4, 0.4, 0.4, 0.1], [0.3, 0.4, 0.4, 0.4, 0.3]),
        ([0.1, 0.0, 0.0, 0.0, 0.1], [0.3, 0.4, 0.4, 0.4, 0.3]),
    ],
)
def test_few_slips_or_none_below_the_static_friction_do_not_tell_it(kinetic, static):
    with pytest.raises(UndeterminedError, match="does not tell the kinetic ratio"):
        ratio_after_slips(after_slips(kinetic, static))


def test_the_mirror_image_of_a_recording_has_other_signs():
    slipping = Slipping(
        way=np.array([1.0, NAN]), lag_low=np.array([0.0, 2.0]), lag_high=np.array([3.0, 4.0])
    )
    recording = Recording(
        clamp=np.array([1.0, -2.0]),
        readings=np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        line=np.array([2, 3]),
        slipping=slipping,
        excess=np.array([0.1, -0.2]),
    )
    found = recording.mirrored()
    assert found.clamp.tolist() == [-1.0, 2.0] and found.line.tolist() == [2, 3]
    assert found.readings.tolist() == [[-1.0, 2.0, -3.0], [-4.0, 5.0, -6.0]]
    assert found.slipping.way == pytest.approx([-1.0, NAN], nan_ok=True)
    assert found.slipping.lag_low.tolist() == [0.0, -2.0]
    assert found.slipping.lag_high.tolist() == [-3.0, -4.0]
    assert found.excess.tolist() == [-0.1, 0.2]
    assert found.mirrored().readings.tolist() == recording.readings.tolist()
