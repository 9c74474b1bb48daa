"""What `vibrissa identify` says beside its table, of findings that are made up."""

from itertools import product
from types import SimpleNamespace

import numpy as np

from known import Known
from vibrissa.cli.identify import _estimated, _tolerated
from vibrissa.sensor.identification.adjusting.adjustment import FAR
from vibrissa.sensor.quantities import Units, read_rod

KNOWN = Known(__file__)


def tolerance(name, **told):
    usual = {"stated": False, "estimated": False, "wave": False, "surprise": 0.0}
    return SimpleNamespace(of=name, spelled=lambda units: f"{name} told in {units}", **usual | told)


def tolerated(*tolerances, kinetic=None):
    found = SimpleNamespace(
        tolerances=tolerances,
        periods=SimpleNamespace(kinetic=kinetic),
        summary=lambda: SimpleNamespace(if_exact={"eta": 0.01234}),
        units="units",
    )
    return list(_tolerated(found))


def test_tolerances_are_told_that_are_stated_estimated_or_far_from_what_the_recording_says():
    told = {}
    for stated, estimated, wave, far in product((False, True), repeat=4):
        given = {"stated": stated, "estimated": estimated, "wave": wave}
        name = ", ".join([word for word, holds in given.items() if holds] + ["far"] * far)
        surprise = np.nextafter(FAR, np.inf) if far else FAR
        told[name or "assumed"] = tolerated(tolerance("theta", **given, surprise=surprise))
    KNOWN.check("one tolerance", told)


def test_what_is_assumed_is_named_once_and_what_matters_has_its_part_of_the_error():
    others = (tolerance("eta", stated=True), tolerance("clamp_angle"), tolerance("clamp_angle"))
    kinetic = tolerance("kinetic_ratio", stated=True)
    for name, ratio in (("", None), (", the kinetic ratio in a note", 0.8)):
        told = tolerated(tolerance("theta"), kinetic, *others, kinetic=ratio)
        KNOWN.check(f"several tolerances{name}", told)


def test_what_is_estimated_has_its_unit_its_error_and_its_correlations():
    assert list(_estimated(SimpleNamespace(setup=None, units=None))) == []
    order = np.arange(4)
    setup = SimpleNamespace(
        eta=0.85,
        offset=(0.1, -0.2, 0.3),
        deviation=[0.0123, 0.0, 0.0456, 0.0789],
        correlation=(order[:, None] - 2 * order) / 10,
    )
    for name, rod in (("", None), (", in SI units", read_rod("210 GPa", "1 mm", "100 mm"))):
        found = SimpleNamespace(setup=setup, units=Units(rod))
        KNOWN.check(f"estimates{name}", list(_estimated(found)))
