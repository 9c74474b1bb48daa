"""Slips that do not end where their law says are noticed."""

from functools import cache

import numpy as np
import pytest

from steel import NOISE, measured, recording_of
from vibrissa.sensor import path, respond, simulate, surfaces
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import find_periods
from vibrissa.sensor.identification.misfit.doubts import Doubt


@cache
def response():
    return respond(2.0, 0.85)


def read(law, ratio, given_law, given_ratio, method="spacing"):
    truth = simulate(
        response(), surfaces.random(1, 0.3, 0.02, 0.05), path("0.0002", ["0.15"]), law, ratio
    )
    recording = recording_of(truth.clamp, measured(truth.reactions, 1))
    return find_periods(
        known_setup(response()),
        recording,
        NOISE,
        method=method,
        law=given_law,
        kinetic_ratio=given_ratio,
    )


def doubted(found):
    return np.char.find(found.doubt, Doubt.LAW.why) >= 0


@pytest.mark.parametrize(
    ("law", "ratio", "given_law", "given_ratio", "part"),
    [
        ("kinetic", 0.75, "kinetic", 0.8, "0.75"),
        ("kinetic", 0.8, "kinetic", 0.75, "0.80"),
        ("kinetic", 0.8, "free", None, "0.80"),
        ("free", 0.8, "kinetic", 0.8, "0.00"),
    ],
)
def test_another_law_or_ratio_is_noticed_and_the_ratio_is_told(
    law, ratio, given_law, given_ratio, part
):
    found = read(law, ratio, given_law, given_ratio)
    assert doubted(found).all()
    (note,) = (note for note in found.notes if "after its slips" in note)
    assert f"needs {part}" in note


@pytest.mark.parametrize(
    ("law", "ratio"), [("kinetic", 0.8), ("kinetic", 0.6), ("free", 0.8), ("energy", 0.8)]
)
def test_the_law_by_which_slips_end_is_not_doubted(law, ratio):
    assert not doubted(read(law, ratio, law, ratio)).any()


def test_without_a_law_and_by_other_methods_nothing_is_asked_of_it():
    assert not doubted(read("kinetic", 0.8, None, None)).any()
    assert not doubted(read("kinetic", 0.75, "kinetic", 0.8, "moment")).any()
