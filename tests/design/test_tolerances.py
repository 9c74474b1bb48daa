"""Which tolerance limits μ0, against closed forms and against halving it."""

import numpy as np
import pytest

from vibrissa import Rod
from vibrissa.design import design, read_requirements
from vibrissa.design.tolerances import tolerance_limits
from vibrissa.sensor import Whisker

ASKED = {
    "material": "music-wire",
    "transducer": "nano17-si-12-0.12",
    "step": "50 um",
    "mu0": "0.2 to 0.4",
    "theta": "1.2",
    "eta": "0.88",
    "diameter": "1.2 mm",
    "length": "180 mm",
}
WHISKER = Whisker(theta=1.2, eta=0.88, rod=Rod(200e9, 1.2e-3, 0.18))


def limits_of(whisker=WHISKER, **asked):
    found = tolerance_limits(read_requirements(**ASKED, **asked), whisker, 0.3, 0.002)
    return found, {one.name: one for one in found.parts}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["length", "transducer_angle", "zero_force_x"])
def test_half_a_tolerance_brings_what_was_promised(name):
    found, parts = limits_of()
    half = WHISKER.tolerating({name: parts[name].tolerance / 2})
    better, of = limits_of(half)
    assert of[name].stated and not parts[name].stated
    promised = 1.0 - np.hypot(0.002, better.common) / np.hypot(0.002, found.common)
    assert parts[name].halved == pytest.approx(promised, rel=0.05)


def test_without_tolerances_nothing_limits():
    found = tolerance_limits(read_requirements(**ASKED, assume=False), WHISKER, 0.3, 0.002)
    assert found.parts == () and found.common == 0.0 and "taken as exact" in str(found)


@pytest.mark.slow
def test_a_design_says_what_halving_brings():
    asked = ASKED | {"length": "180 ± 0.2 mm"}
    found = design(read_requirements(**asked, tolerances={"transducer_angle": "0.25 deg"}))
    head, common, titles, *rows = str(found.tolerances()).strip().splitlines()
    assert "which all periods share" in head and float(common.split()[0]) < 0.01
    assert titles.split() == ["tolerance", "alone", "halving", "it", "brings"]
    cells = {row.split()[0]: row.split()[1:] for row in rows}
    assert cells["transducer_angle"][:2] == ["0.25", "deg"]
    assert cells["length"][:2] == ["0.11", "%"] and cells["eta"][1] == "mm,"
    assert len(rows) < 15
    brings = [float(row.split()[-1].rstrip("%")) for row in rows]
    assert brings == sorted(brings, reverse=True) and brings[0] > 5.0
