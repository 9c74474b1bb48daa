"""Rods of changing modulus, and tubes: set-ups, tolerances, yield and design."""

import numpy as np
import pytest

from vibrissa import Mounting
from vibrissa.design import Requirements, design
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.bending import measure
from vibrissa.mechanics.rod import Rod
from vibrissa.sensor import Setup
from vibrissa.sensor.identification.derivatives import moved
from vibrissa.sensor.tolerances import TOLERABLE
from vibrissa.sensor.whisker import Whisker

SIZES = {"modulus": "3 GPa", "diameter": "1 mm", "length": "50 mm"}


@pytest.mark.parametrize("written", ["0.3 ± 0.1, -0.1", ["0.3 ± 0.1", -0.1]])
def test_a_set_up_has_the_coefficients_and_the_tolerance_of_the_first(written):
    setup = Setup.read(theta=2, eta=0.85, stiffening=written)
    assert setup.whisker.mounting == Mounting(stiffening=(0.3, -0.1))
    assert setup.whisker.tolerances == {"stiffening": 0.1}
    again = Setup.read(**setup.stated())
    assert again.whisker == setup.whisker


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("stiffening", "-1.5", "is -0.5 at s = 1 L, got -1.5"),
        ("stiffening", "0.1, soft", "stiffening must be a number, got 'soft'"),
        ("stiffening", "0.1, 0.2 ± 0.1", "only c1 may have a tolerance"),
        ("stiffening", "0.1 mm", "stiffening must be a number, got '0.1 mm'"),
        ("bore", "0.6", r"1/theta = 0.5 d0, got 0.6"),
        ("bore", "0.2 mm", "bore must be a number, got '0.2 mm'"),
    ],
)
def test_what_no_rod_has_is_refused(key, value, said):
    with pytest.raises(ArgumentError) as error:
        Setup.read(theta=2, eta=0.85, **{key: value}).whisker  # noqa: B018
    assert said in str(error.value)


def test_a_bore_changes_the_units_of_a_rod():
    whisker = Setup.read(theta=2, eta=0.85, bore=0.4, **SIZES).whisker
    assert whisker.rod.bore == whisker.mounting.bore == 0.4
    second_moment = np.pi / 64 * (1e-3**4 - 0.4e-3**4)
    assert whisker.rod.force_unit == pytest.approx(3e9 * second_moment / 0.05**2)
    with pytest.raises(ArgumentError, match=r"of the rod is 0\.0, that of the mounting 0\.4"):
        Whisker(theta=2, eta=0.85, rod=Rod(3e9, 1e-3, 0.05), mounting=Mounting(bore=0.4))


def test_a_trial_set_up_keeps_the_stiffness_and_shifts_its_first_coefficient():
    given = Setup.read(theta=2, eta=0.85, stiffening="0.3, -0.1", bore=0.2).whisker
    trial = moved(given, dict.fromkeys(TOLERABLE, 0.0) | {"stiffening": 0.05})
    assert trial.mounting == Mounting(stiffening=(0.35, -0.1), bore=0.2)


def test_stress_is_modulus_times_strain():
    """At the base E(0) holds; a rod that is softer than there is strained more, not stressed."""
    one = np.ones(1)
    load = {"theta": one, "f": 1e-3 * one, "alpha": -0.5 * np.pi * one}
    place = {"x_c": 0.0 * one, "y_c": one}
    tapered = measure(**(load | {"theta": 3.0 * one}), **place)
    soft = measure(**(load | {"theta": 3.0 * one}), **place, mounting=Mounting(stiffening=-0.6))
    assert tapered.stress == pytest.approx(tapered.strain, rel=1e-15)
    assert soft.strain > 1.2 * tapered.strain
    assert soft.stress < soft.strain
    # Bending moment and diameter alone determine the stress: m/(2·d³).
    assert soft.stress == pytest.approx(tapered.stress, rel=2e-3)


def checked(**asked):
    return design(Requirements.read(**asked))


@pytest.mark.slow
def test_a_tube_is_designed_with_the_stress_and_the_weight_of_a_tube():
    asked = {
        "mu0": "0.2 to 0.3",
        "step": "20 um",
        "material": "music-wire",
        "transducer": "nano17-si-12-0.12",
        **{"theta": "1.5", "eta": "0.85", "diameter": "0.5 mm", "length": "100 mm"},
    }
    solid, tube = (
        {one.name: float(one.value) for one in found.best.checks}
        for found in (checked(**asked), checked(**asked, bore=0.6))
    )
    assert tube["force_y"] < 0.95 * solid["force_y"]
    assert tube["strain"] != solid["strain"]
    with pytest.raises(ArgumentError, match="below the diameter of the tip"):
        design(Requirements.read(**asked, bore=0.7))
