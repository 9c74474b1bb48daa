"""Rods, transducers and stages that are other than given: which, their mirror images, a slope."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from straight import SLOPES, Straight, sampled
from vibrissa import Mounting
from vibrissa.errors import NoResponseError
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.adjusting.properties import PROPERTIES
from vibrissa.sensor.identification.alternatives import (
    STEP,
    Alternative,
    alternatives_to,
    inclined,
    of_readings,
    step_in_height,
)
from vibrissa.sensor.response.branch import Branch, respond

SAMPLES = sampled(np.arange(5.0), np.linspace(-0.1, 0.4, 5), excess=np.linspace(0.0, 0.2, 5))
READINGS = {one.name: one for one in of_readings()}


@cache
def given():
    return respond(2.0, 0.85)


def same(one, other):
    """Whether samples are the same."""
    assert one.clamp == pytest.approx(other.clamp)
    assert one.readings == pytest.approx(other.readings)
    assert one.excess == pytest.approx(other.excess)


def test_all_that_changes_the_readings_is_tried_and_nothing_of_the_rod():
    assert list(READINGS) == [
        "modulus",
        "zero_force_x",
        "zero_force_y",
        "zero_moment_z",
        "transducer_angle",
        "moment_origin_x",
        "moment_origin_y",
        "stage_scale",
    ]
    for name, one in READINGS.items():
        assert one.step == STEP == 1e-3 and one.branch is None and one.base is None
        assert one.kinetic_ratio == 0.0 and one.before.undone(SAMPLES) is SAMPLES
        same(one.undone(SAMPLES), PROPERTIES[name].recording(SAMPLES, STEP))
        assert one.before.branch is None and one.before.step == one.step


@pytest.mark.parametrize("name", READINGS)
def test_an_error_of_the_mirrored_recording_is_the_mirror_image_of_the_error(name):
    one = READINGS[name]
    found = one.mirrored().undone(SAMPLES.mirrored())
    same(found, one.undone(SAMPLES).mirrored())
    with pytest.raises(AssertionError):
        same(found, SAMPLES.mirrored())
    # Turned twice it is the same again.
    same(one.mirrored().mirrored().undone(SAMPLES), one.undone(SAMPLES))


def test_a_rod_is_turned_with_the_recording_or_has_the_other_sign():
    rods = {"branch": given(), "base": given()}
    odd = Alternative(name="curvature", step=0.1, odd=True, **rods).mirrored()
    # A round rod is its own mirror image. What is not has the other sign there.
    assert odd.step == -0.1 and odd.branch is rods["branch"] and odd.base is rods["base"]
    even = Alternative(name="theta", step=0.1, **rods).mirrored()
    assert even.step == 0.1 and isinstance(even.branch, Branch) and isinstance(even.base, Branch)
    by = Alternative(
        name="stage_angle",
        step=0.1,
        odd=True,
        corrected=lambda samples, size: replace(samples, clamp=samples.clamp + size),
    )
    assert by.mirrored().undone(SAMPLES).clamp == pytest.approx(SAMPLES.clamp - 0.1)
    assert by.undone(SAMPLES).clamp == pytest.approx(SAMPLES.clamp + 0.1)


class Higher(Straight):
    """Another height: the loads are half as large, the place is another, and so is the demand."""

    x1_init = 1.5

    def __call__(self, x0):
        return 0.5 * super().__call__(x0)

    def demand(self, x0):
        return 3.0 * np.asarray(x0)


@pytest.mark.parametrize("excess", [None, np.full(5, 0.25)])
def test_a_stage_that_is_inclined_comes_nearer_along_the_scan(excess):
    samples = sampled([0.0, 0.1, 0.2, 0.3, 1.0], [0.0, 0.1, 0.2, 0.9, 0.4], excess=excess)
    one = inclined(Straight(), Higher(), -0.01)
    assert one.name == "stage_angle" and one.step == STEP and one.odd and one.branch is None
    found = one.corrected(samples, 0.02)
    # The height falls by the angle times the way, in units of the step: −size·clamp/step.
    height = 2.0 * samples.clamp
    inside = np.minimum(samples.x0, 0.8)
    assert found.clamp == pytest.approx(samples.clamp + 0.5 * height)
    before = 0.0 if excess is None else excess
    assert found.excess == pytest.approx(before + height * inside)
    change = -0.5 * (np.multiply.outer(inside, SLOPES) + np.array([0.0, -1.0, 0.0]))
    assert found.readings == pytest.approx(samples.readings - height[:, None] * change)


def test_the_height_is_changed_by_a_part_of_what_is_left_to_the_length():
    assert step_in_height(Whisker(theta=2.0, eta=0.85)) == pytest.approx(-0.0015)
    assert step_in_height(Whisker(theta=2.0, eta=0.2)) == pytest.approx(-0.008)


def test_each_property_of_a_rod_is_a_little_larger_than_it_was_given():
    whisker = Whisker(theta=2.0, eta=0.85)
    asked = []

    def solved(other):
        asked.append(other)
        if other.mounting.curvature != whisker.mounting.curvature:
            raise NoResponseError("no such rod")
        return given()

    found = list(alternatives_to(whisker, solved))
    assert asked[0] is whisker
    names = [one.name for one in found]
    # One of which there is no response is left out. On a level stage its angle is told by heights.
    rod = ["theta", "eta", "stage_angle", "clamp_angle", "clamp_compliance", "length"]
    assert names == [*READINGS, *rod]
    each = dict(zip(names, found, strict=True))
    assert each["theta"].step == each["length"].step == STEP
    assert each["eta"].step == pytest.approx(-0.0015)
    for name in ("theta", "eta", "clamp_angle", "length"):
        assert each[name].branch is given() and each[name].base is given()
        assert each[name].odd == (name == "clamp_angle")
    heights = [other.eta for other in asked if other.eta != whisker.eta]
    assert heights == pytest.approx([0.8485, 0.85 / 1.001])
    assert [other.theta for other in asked if other.theta != 2.0] == [pytest.approx(2.001)]


def test_on_an_oblique_stage_its_angle_is_another_rod():
    whisker = Whisker(theta=2.0, eta=0.85, mounting=Mounting(stage_angle=0.02))
    stage = object()
    names = [one.name for one in alternatives_to(whisker, lambda other: stage)]
    assert names.count("stage_angle") == 1 and names.index("stage_angle") > names.index("curvature")
