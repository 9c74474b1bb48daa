"""Which tolerance limits μ0, against closed forms and against halving it."""

import numpy as np
import pytest

from vibrissa import Rod
from vibrissa.design import design, read_requirements
from vibrissa.design.tolerances import tolerance_limits
from vibrissa.sensor import Whisker, solve

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
def test_the_ratio_of_forces_is_wrong_by_turned_axes_and_zeros():
    found, parts = limits_of(method="forces")
    # fx/fy of axes that are turned by γ: (1 + μ²)·γ; a zero of fx adds itself over fy.
    turned = parts["transducer_angle"]
    assert turned.alone == pytest.approx((1 + 0.3**2) * turned.tolerance, rel=0.02)
    force_y = solve(WHISKER, 0.3).columns()["force_y"].values[0] / WHISKER.rod.force_unit
    zero = parts["zero_force_x"]
    assert zero.alone == pytest.approx(zero.tolerance / abs(force_y), rel=0.02)
    assert parts["zero_moment_z"].alone == 0.0
    # A surface that is inclined by γ turns both forces, and the tolerance is shared by six numbers.
    assert {"stage_angle", "crosstalk", "drift_force_x"} <= parts.keys()
    assert found.parts[0].halved == max(one.halved for one in found.parts) > 0.05
    assert found.common < 0.01 and found.periods >= 29


@pytest.mark.slow
def test_the_moment_is_wrong_by_the_stiffness_of_the_rod():
    _, parts = limits_of(method="moment")
    # The moment goes with E·d0⁴: equal parts of both are one to four.
    modulus, diameter = parts["modulus"], parts["diameter"]
    assert diameter.alone / diameter.tolerance == pytest.approx(
        4 * modulus.alone / modulus.tolerance, rel=0.02
    )
    assert parts["zero_force_x"].alone == parts["transducer_angle"].alone == 0.0


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


@pytest.mark.slow
def test_with_very_low_noise_turned_axes_cost_the_same():
    asked = {name: text for name, text in ASKED.items() if name != "transducer"}
    asked = read_requirements(**asked, noise="1 uN, 1 uN, 0.01 uN*m")
    found = tolerance_limits(asked, WHISKER, 0.3, 0.002)
    turned = next(one for one in found.parts if one.name == "transducer_angle")
    assert turned.alone == pytest.approx((1 + 0.3**2) * turned.tolerance, rel=0.02)
