"""What each tolerance adds to the uncertainty of μ0, against closed forms."""

import numpy as np
import pytest

from vibrissa import Rod
from vibrissa.design import design, read_requirements
from vibrissa.design.tolerances import lines, tolerance_parts
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


def parts_of(method):
    asked = read_requirements(**ASKED, method=method)
    return {one.name: one for one in tolerance_parts(asked, WHISKER, 0.3, 0.002)}


def test_the_ratio_of_forces_is_wrong_by_turned_axes_and_zeros():
    found = parts_of("forces")
    # fx/fy of axes that are turned by γ: (1 + μ²)·γ; a zero of fx adds itself over fy.
    turned = found["transducer_angle"]
    assert turned.part == pytest.approx((1 + 0.3**2) * turned.tolerance, rel=0.02)
    force_y = solve(WHISKER, 0.3).columns()["force_y"].values[0] / WHISKER.rod.force_unit
    zero = found["zero_force_x"]
    assert zero.part == pytest.approx(zero.tolerance / abs(force_y), rel=0.02)
    assert found["zero_moment_z"].part == 0.0
    # Sorted, and what halving brings is by the quadratic sum.
    assert next(iter(found)) == "transducer_angle"
    total = 0.002**2 + sum(one.part**2 for one in found.values())
    less = total - turned.part**2 + (turned.part / 2) ** 2
    assert turned.halved == pytest.approx(1 - np.sqrt(less / total))


@pytest.mark.slow
def test_the_moment_is_wrong_by_the_stiffness_of_the_rod():
    found = parts_of("moment")
    # The moment goes with E·d0⁴: equal parts of both are one to four.
    modulus, diameter = found["modulus"], found["diameter"]
    assert diameter.part / diameter.tolerance == pytest.approx(
        4 * modulus.part / modulus.tolerance, rel=0.02
    )
    assert found["zero_force_x"].part == found["transducer_angle"].part == 0.0


def test_a_design_says_what_halving_brings():
    found = design(read_requirements(**ASKED))
    text = list(lines(found.tolerances(), found.units))
    assert text[1].split()[:3] == ["transducer_angle", "0.5", "deg"]
    assert "halving it brings" in text[1] and len(text) < 10


def test_with_very_low_noise_sensitivities_are_the_same():
    asked = {name: text for name, text in ASKED.items() if name != "transducer"}
    asked = read_requirements(**asked, noise="1 nN, 1 nN, 0.01 nN*m")
    found = {one.name: one for one in tolerance_parts(asked, WHISKER, 0.3, 0.002)}
    turned = found["transducer_angle"]
    assert turned.part == pytest.approx((1 + 0.3**2) * turned.tolerance, rel=0.02)
