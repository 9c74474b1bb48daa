"""The constraint that the rod is at rest before it slips again."""

import numpy as np
import pytest

from vibrissa.design import Requirements, design
from vibrissa.errors import ArgumentError
from vibrissa.sensor.ringing import ringing

ROD = {
    "theta": "2",
    "eta": "0.85",
    "diameter": "0.8 mm",
    "length": "100 mm",
    "mu0": "0.2 to 0.4",
    "step": "20 um",
    "transducer": "nano17-si-12-0.12",
}


def ringing_check(speed):
    found = design(Requirements.read(material="music-wire", speed=speed, **ROD))
    (check,) = (one for one in found.best.checks if one.name == "ringing")
    return check, found


@pytest.mark.slow
def test_a_rod_must_be_at_rest_before_it_slips_again():
    slow, found = ringing_check("1 mm/s")
    fast, _ = ringing_check("100 mm/s")
    assert float(fast.value) == pytest.approx(100 * float(slow.value))
    assert slow.use < 1.0 < fast.use
    whisker, material = found.best.whisker, found.best.requirements.material
    shortest = float(whisker.curve.onset(0.2))
    rings = ringing(whisker.curve, shortest).in_seconds(
        whisker.rod.frequency_unit(material.density)
    )
    assert float(slow.value) == pytest.approx(rings.lasts * 1e-3 / (shortest * 0.1), rel=1e-6)
    without = design(Requirements.read(material="music-wire", **ROD))
    assert "ringing" not in {one.name for one in without.best.checks}
    assert np.isfinite(float(slow.value))


def test_a_speed_needs_a_density():
    material = {"modulus": "210 GPa", "yield_strain": "0.002"}
    with pytest.raises(ArgumentError, match="with a speed, give the density"):
        Requirements.read(**material, speed="1 mm/s", **ROD)
