"""Conversion to SI."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa import Rod

positive = st.floats(1e-6, 1e12)


@given(positive, st.floats(1e-6, 1.0), st.floats(1e-3, 10.0))
def test_units_scale_as_the_beam_equation_says(modulus, diameter, length):
    rod = Rod(modulus, diameter, length)
    assert rod.moment_unit == pytest.approx(rod.force_unit * length)
    twice = Rod(modulus, 2 * diameter, length)
    assert twice.force_unit == pytest.approx(16 * rod.force_unit)
    longer = Rod(modulus, diameter, 3 * length)
    assert longer.force_unit == pytest.approx(rod.force_unit / 9)
    assert rod.second_moment == pytest.approx(math.pi * diameter**4 / 64)


@pytest.mark.parametrize(
    ("name", "told", "unit"),
    [
        ("youngs_modulus", "modulus", "Pa"),
        ("base_diameter", "diameter", "m"),
        ("length", "length", "m"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_impossible_rods_are_refused(name, told, unit, value):
    properties = {"youngs_modulus": 1.0, "base_diameter": 1.0, "length": 1.0, name: value}
    allowed = f"the {told} of a rod must lie between 1e-30 and 1e30 {unit}, got {value:g}$"
    with pytest.raises(ValueError, match=allowed):
        Rod(**properties)
