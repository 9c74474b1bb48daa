"""How long a rod rings, and the warnings where its stage is too fast."""

import math

import numpy as np
import pytest

from vibrissa import solve_curve
from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, identify, scan, solve
from vibrissa.sensor.ringing import ringing, ringing_of

STEEL = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
TOO_FAST = "the stage is too fast"


def test_ringing_follows_from_the_frequencies():
    curve = solve_curve(2.0, 0.85)
    found = ringing(curve, 0.02, damping=0.05)
    first, second = curve.frequencies(0.02) / (2 * np.pi)
    assert found.frequencies == pytest.approx((first, second))
    # After ln(100)/(2π·ζ) periods the amplitude is 1 %.
    assert math.exp(-2 * math.pi * 0.05 * first * found.ring) == pytest.approx(0.01)
    assert found.lasts == found.slip + found.ring
    twice = found.in_seconds(2.0)
    assert twice.frequencies[0] == pytest.approx(4 * math.pi * first)
    assert twice.ring == pytest.approx(found.ring / (4 * math.pi))


def test_solve_has_frequencies_in_hertz_if_the_density_is_known():
    whisker = Setup.read(theta=2, eta="85 mm", **STEEL).whisker
    found = solve(whisker, 0.4, density=7850.0)
    assert "first natural frequency at the onset" in str(found)
    (first,) = found.columns()["frequency_1"].values
    omega = whisker.curve.frequencies(found.onset.x0_slip, 1)[0]
    assert first == pytest.approx(omega * whisker.rod.frequency_unit(7850.0))
    assert "frequency" not in str(solve(whisker, 0.4))
    assert "frequency" not in str(solve(whisker, 0.9, density=7850.0))
    assert ringing_of(Setup.read(theta=2, eta=0.85).whisker, 0.01, 7850.0) is None


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "warned"), [(0.2, True), (0.001, False)])
def test_identify_warns_if_the_rod_has_no_time_to_come_to_rest(speed, warned):
    whisker = Setup.read(theta=2, eta="85 mm", **STEEL).whisker
    table = scan(whisker, surfaces.constant(0.3), step="50 um", to=["20 mm"]).to_pandas()
    units = table.attrs["units"]
    table = table[["footpoint", "force_x", "force_y", "moment_z"]]
    table["time"] = 5e-5 / speed * np.arange(len(table))
    table.attrs["units"] = {name: units[name] for name in table.columns[:-1]} | {"time": "s"}
    rod = STEEL | {"noise": "1 mN, 1 mN, 0.1 N*mm", "assume": False}
    setup = Setup.read(theta=2, eta="85 mm", density="7850 kg/m^3", **rod)
    found = identify(setup, table)
    assert any(TOO_FAST in note for note in found.periods.notes) == warned
    unknown = identify(Setup.read(theta=2, eta="85 mm", **rod), table)
    assert not any(TOO_FAST in note for note in unknown.periods.notes)
