"""Rods that are tried: how they are solved quickly, and the steps from one to the next."""

from dataclasses import replace

import numpy as np
import pytest

from vibrissa.mechanics.mounting import Mounting
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.adjusting.adjustment import _range, _step_to
from vibrissa.sensor.identification.adjusting.properties import PROPERTIES, Bench, components_of
from vibrissa.sensor.identification.adjusting.solving import Solver
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.response.branch import Branch

GIVEN = Whisker(theta=2.0, eta=0.85)
SOLVER = Solver(clamp=np.array([0.0, 0.3]), backward=False, pulled=False)


def inclined(angle):
    return replace(GIVEN, mounting=Mounting(stage_angle=angle))


def test_a_branch_goes_on_smoothly_to_where_the_tip_is_pulled_a_little():
    (quick,) = SOLVER.quick(GIVEN)
    exact = GIVEN.pulled
    x0 = np.linspace(-0.05 * exact.x0_lock, 0.0, 50)
    assert quick.bounds[0] == pytest.approx(-0.05 * exact.x0_lock)
    assert quick(x0) == pytest.approx(exact(x0), abs=2e-5)
    near = 0.2 * x0
    assert quick(near) == pytest.approx(exact(near), abs=4e-8)
    assert quick(0.5 * exact.x0_lock) == pytest.approx(exact(0.5 * exact.x0_lock), abs=1e-9)
    (pulled,) = replace(SOLVER, pulled=True).quick(GIVEN)
    assert (pulled(x0) == exact(x0)).all()
    assert SOLVER.quick() == []


def test_a_level_stage_is_solved_at_its_height_and_an_oblique_one_where_it_comes():
    assert SOLVER._heights(GIVEN).tolist() == [[0.85]]
    fall = 0.3 * np.sin(0.1)
    for angle, least, most in ((0.1, 0.85 - fall, 0.85), (-0.1, 0.85, 0.85 + fall)):
        heights = SOLVER._heights(inclined(angle))
        # A little farther than it comes, in parts of three tenths of the gap, with four nodes each.
        low, high = least - 0.03 * (1.0 - most), most + 0.03 * (1.0 - most)
        parts = int(np.ceil((high - low) / (0.3 * (1.0 - high))))
        assert heights.shape == (parts, 4)
        edges = np.linspace(low, high, parts + 1)
        nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(4) / 3.0)
        expected = edges[:-1, None] + np.diff(edges)[:, None] * nodes
        assert np.sort(heights) == pytest.approx(expected)
    far = replace(SOLVER, clamp=np.array([0.0, 9.9]))
    assert far._heights(inclined(-0.1)).max() < 1.0 and far._heights(inclined(0.1)).min() > 0.0


def test_stages_are_solved_beside_rods_and_in_their_order():
    taper = replace(GIVEN, theta=2.1)
    short = replace(SOLVER, clamp=np.array([0.0, 0.02]))
    first, stage, last = short.quick(GIVEN, inclined(0.02), taper)
    assert isinstance(first, Branch) and isinstance(last, Branch)
    assert first(0.1) == pytest.approx(GIVEN.pushed(0.1), abs=1e-9)
    assert last(0.1) == pytest.approx(taper.pushed(0.1), abs=1e-9)
    assert stage.eta == 0.85 and stage.angle == 0.02
    states, _ = stage.above(np.array([0.0, 0.01]))
    low = Whisker(theta=2.0, eta=0.85 - 0.01 * np.sin(0.02)).pushed
    assert states(np.array([0.1, 0.1])) == pytest.approx(
        np.stack([GIVEN.pushed(0.1), low(0.1)]), abs=1e-6
    )


def test_a_step_is_the_best_within_its_bounds():
    information, gradient = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([4.0, 7.0])
    free = np.full(2, np.inf)
    # 2a + b = 4 and a + 3b = 7: a = 1, b = 2.
    assert _step_to(information, gradient, (-free, free)) == pytest.approx([1.0, 2.0])
    at = np.array([1.0, 2.0])
    assert _step_to(information, gradient, (at, at)) == pytest.approx([1.0, 2.0])
    # With b held at 1 the least is where 2a + 1 = 4.
    bound = _step_to(information, gradient, (-free, np.array([np.inf, 1.0])))
    assert bound == pytest.approx([1.5, 1.0])
    # With both beyond their bounds each is at its bound: less of one would not help the other.
    corner = np.array([0.5, 1.0])
    assert _step_to(information, gradient, (-free, corner)) == pytest.approx(corner)
    assert _step_to(information, -gradient, (-corner, free)) == pytest.approx(-corner)
    bound = _step_to(information, -gradient, (np.array([-np.inf, -1.0]), free))
    assert bound == pytest.approx([-1.5, -1.0])
    # Where it stands beyond a bound it may stay.
    bound = _step_to(information, gradient, (-free, np.array([np.inf, -1.0])))
    assert bound == pytest.approx([2.0, 0.0], abs=1e-9)


def test_no_property_leaves_its_range():
    yielding = replace(GIVEN, mounting=Mounting(clamp_compliance=0.1))
    assert _range(GIVEN, "theta") == (-1.0, np.inf)
    assert _range(yielding, "clamp_compliance") == (-0.1, np.inf)
    assert _range(GIVEN, "clamp_angle") == (-np.inf, np.inf)
    low, high = _range(GIVEN, "eta")
    assert 0.0 < 0.85 + low < 0.1 and 0.99 < 0.85 + high < 1.0


def test_a_bench_has_full_scale_and_a_time_from_nought_to_one():
    readings = np.array([[1.0, np.nan, 0.0], [-3.0, 2.0, 0.0], [2.0, -4.0, 0.0]])
    recording = Recording(clamp=np.arange(3.0), readings=readings, line=np.array([5, 6, 9]))
    bench = Bench.of(recording, None, np.ones(3))
    assert bench.full_scale.tolist() == [3.0, 4.0, 1.0]
    assert bench.part(recording).tolist() == [0.0, 0.25, 1.0]
    one = recording.take(slice(0, 1))
    assert Bench.of(one, None, np.ones(3)).part(one).tolist() == [0.0]


def undone(name, readings, size, number=0):
    recording = Recording(
        clamp=np.arange(1.0, len(readings) + 1.0),
        readings=np.array(readings, dtype=float),
        line=np.arange(len(readings)),
    )
    bench = Bench.of(recording, None, np.ones(3))
    one = components_of(name, bench)[number]
    return one, one.property.recording(recording, size)


@pytest.mark.parametrize(
    ("name", "size", "true", "read"),
    [
        ("modulus", 0.1, [1.0, 2.0, 3.0], [1.1, 2.2, 3.3]),
        ("diameter", 0.1, [1.0, 2.0, 3.0], [1.4, 2.8, 4.2]),
        ("zero_force_x", 0.1, [1.0, 2.0, 3.0], [1.1, 2.0, 3.0]),
        ("zero_force_y", 0.1, [1.0, 2.0, 3.0], [1.0, 2.1, 3.0]),
        ("zero_moment_z", 0.1, [1.0, 2.0, 3.0], [1.0, 2.0, 3.1]),
        ("transducer_angle", 0.1, [1.0, 2.0, 3.0], [1.2, 1.9, 3.0]),
        ("moment_origin_x", 0.1, [1.0, 2.0, 3.0], [1.0, 2.0, 2.8]),
        ("moment_origin_y", 0.1, [1.0, 2.0, 3.0], [1.0, 2.0, 3.1]),
    ],
)
def test_an_error_of_the_readings_is_taken_off(name, size, true, read):
    _, found = undone(name, [read], size)
    assert found.readings[0] == pytest.approx(true)


def test_a_longer_rod_has_smaller_units_and_a_stage_a_scale():
    found = PROPERTIES["length"].recording(
        Recording(clamp=np.array([1.1]), readings=np.ones((1, 3)), line=np.array([2])), 0.1
    )
    assert found.clamp == pytest.approx([1.0])
    assert found.readings[0] == pytest.approx([1.21, 1.21, 1.1])
    assert PROPERTIES["length"].whisker(GIVEN, 0.1).eta == pytest.approx(0.85 / 1.1)
    assert undone("stage_scale", [[1.0, 1.0, 1.0]], 0.1)[1].clamp == pytest.approx([1.1])
    bent = replace(GIVEN, mounting=Mounting(curvature=(0.1, 0.2)))
    assert PROPERTIES["curvature"].whisker(bent, 0.05).mounting.curvature == (
        pytest.approx(0.15),
        0.2,
    )


def test_crosstalk_is_a_part_of_full_scale_of_each_other_channel():
    readings = [[1.0, 2.0, 4.0], [1.0, 2.0, 4.0]]
    names = [undone("crosstalk", readings, 0.1, number)[0].name for number in range(6)]
    channels = ("force_x", "force_y", "moment_z")
    assert names == [
        f"crosstalk of {source} in {to}" for to in channels for source in channels if source != to
    ]
    # A tenth of the full scale of the moment, 4, where force_y is at its own: 2.
    _, found = undone("crosstalk", readings, 0.1, names.index("crosstalk of force_y in moment_z"))
    assert found.readings[0] == pytest.approx([1.0, 2.0, 3.6])


def test_a_zero_drifts_as_a_line_and_waves_that_fall_with_their_number():
    readings = np.zeros((5, 3))
    components = components_of("drift_force_y", Bench(full_scale=np.ones(3), first=0, last=4))
    assert [one.wave for one in components] == list(range(9))
    assert [one.name for one in components][:3] == [
        "drift_force_y",
        "drift_force_y, wave 1",
        "drift_force_y, wave 2",
    ]
    time = np.linspace(0.0, 1.0, 5)
    for number in (0, 1, 3):
        one, found = undone("drift_force_y", readings, 2.0, number)
        shape = time if number == 0 else np.sin(number * np.pi * time)
        assert found.readings[:, 1] == pytest.approx(-2.0 * shape, abs=1e-15)
        assert not found.readings[:, [0, 2]].any()
        assert one.weight == pytest.approx(np.sqrt(2.0) / (np.pi * number) if number else 1.0)
    # Together the line and all waves have the variance of a Wiener process: that of the time.
    shapes = np.sin(np.pi * np.arange(1, 9)[:, None] * time)
    weights = np.array([one.weight for one in components[1:]])
    assert time**2 + (weights**2) @ shapes**2 == pytest.approx(time, abs=0.03)
