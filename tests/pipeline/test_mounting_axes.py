"""Axes of the mounting in a study file: optional, and nothing moves without them."""

from decimal import Decimal

import pytest

from vibrissa.errors import StudyError
from vibrissa.pipeline.blocks import block_name, grids_of_blocks, partition
from vibrissa.study.grid import CurveKey, keys_of, points_on_curves, study_points
from vibrissa.study.parsing import parse_study

PLAIN = {
    "study": "tilted",
    "grids": {"main": {"theta": [1, 2], "mu0": [0.2, 0.3], "eta": [0.85], "dx0": [0.001]}},
}
TILTED = {**PLAIN["grids"]["main"], "clamp_angle": [0, 0.02], "curvature": [-0.1]}


def study(**sections):
    return parse_study({**PLAIN, **sections})


def refusal(**sections):
    with pytest.raises(StudyError) as error:
        study(**sections)
    return "\n".join(error.value.mistakes)


def test_each_combination_is_a_curve_and_serves_all_frictions():
    tilted = study(grids={"main": TILTED})
    keys = tilted.curve_keys
    assert len(keys) == 4 and len(set(keys)) == 4
    assert {key.mounting for key in keys} == {
        (Decimal(angle), 0, Decimal("-0.1"), 0) for angle in ("0", "0.02")
    }
    points = list(study_points(tilted.point_grids))
    assert [key for key, _ in points] == keys
    assert all(len(some) == 2 for _, some in points)
    (point, *_) = tilted.point_grids["main"].points()
    assert point.curve_key(by_step=False) in keys


def test_a_study_without_them_has_the_keys_and_blocks_that_it_had():
    plain = study()
    assert plain.curve_keys == [CurveKey(Decimal(theta), Decimal("0.85")) for theta in (1, 2)]
    # Named by the plain form of its keys, which has no word of a mounting.
    (box,) = plain.curves
    assert block_name(box) == "78b228af3325"


def test_a_study_that_gets_tilted_rods_keeps_its_blocks():
    plain, more = study(), study(grids={**PLAIN["grids"], "tilted": TILTED})
    known = partition(plain.curves, 8, {})
    blocks = partition(more.curves, 8, known)
    (old,) = known
    assert list(blocks) == [old, *list(blocks)[1:]] and blocks[old] == known[old]
    new = [key for name, box in blocks.items() if name != old for key in keys_of(box)]
    assert sorted(new) == sorted(set(more.curve_keys) - set(plain.curve_keys))
    # The points of each block are those of its own mountings.
    parts = grids_of_blocks(more.point_grids)(blocks[old])
    assert parts == {"main": more.point_grids["main"]}
    found = dict(points_on_curves(new, more.point_grids))
    assert all(some.grids[0] == ["tilted"] for some in found.values()) and len(found) == 4


def test_axes_are_ranges_too_and_have_bounds():
    section = {**TILTED, "clamp_angle": {"start": -0.1, "stop": 0.1, "step": 0.05}}
    assert len(study(grids={"main": section}).curve_keys) == 10
    said = refusal(grids={"main": {**TILTED, "clamp_compliance": [-0.1]}})
    assert "grids.main.clamp_compliance" in said and "-0.1" in said and ">= 0" in said


def test_a_curvature_may_be_a_polynomial():
    written = [0.1, [-0.05, 0.1], [0.1, 0.0], -0.05, [-0.05, -0.3]]
    curved = study(grids={"main": {**TILTED, "clamp_angle": [0], "curvature": written}})
    constant, rising, falling = Decimal("-0.05"), Decimal("0.1"), Decimal("-0.3")
    expected = [constant, (constant, falling), (constant, rising), rising]
    assert curved.point_grids["main"].curvature == tuple(expected)
    assert [key.curvature for key in curved.curve_keys] == expected * 2
    # The plan of blocks has one text for each.
    blocks = partition(curved.curves, 3, {})
    assert partition(curved.curves, 3, blocks) == blocks


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ([[0.1, "x"]], "curvature[0][1]: 'x' is not allowed; allowed: coefficient of the"),
        (
            [0, []],
            "curvature[1]: [] is not allowed; allowed: one or more coefficients",
        ),
        ([[20, 0.1]], "curvature[0][0]: 20 is not allowed"),
        ([[0.1, [0.2]]], "curvature[0][1]: [0.2] is not allowed"),
        (["1e-3"], "curvature[0]: '1e-3' is not allowed (YAML reads this as text"),
        ([20], "curvature[0]: 20 is not allowed; allowed: natural curvature of the rod in 1/L: a"),
        ({"start": [0, 1], "stop": 1, "step": 1}, "curvature.start: [0, 1] is not allowed"),
    ],
)
def test_what_is_no_polynomial_is_refused(written, said):
    assert said in refusal(grids={"main": {**TILTED, "curvature": written}})


def test_figures_show_a_polynomial_and_do_not_go_over_it():
    grids = {"main": {**TILTED, "curvature": [0, -0.05, [-0.05, 0.1]]}}
    over = {"kind": "mounting", "grid": "main", "over": "clamp_angle", "mu0": 0.2}
    said = refusal(grids=grids, figures={"f": {**over, "curvature": [-0.05, 0.2]}})
    assert "figures.f.curvature: -0.05, 0.2 is not allowed; the data has -0.05, [-0.05" in said
    shown = study(grids=grids, figures={"f": {**over, "curvature": [-0.05, 0.1]}}).figures["f"]
    assert shown.selection()["curvature"] == "-0.05, 0.1"
    said = refusal(grids=grids, figures={"f": {**over, "over": "curvature", "clamp_angle": 0}})
    assert "figures.f.over: curvature has polynomials (-0.05, 0.1); allowed: numbers" in said


def test_a_swing_is_drawn_in_the_ideal_mounting_alone():
    scan = {**PLAIN["grids"]["main"], "cycles": 1}
    figure = {"kind": "swing", "scan": "run", "theta": 1, "mu0": 0.2}
    assert study(scans={"run": scan}, figures={"f": figure}).figures["f"].kind == "swing"
    said = refusal(scans={"run": {**scan, "clamp_angle": [0.02]}}, figures={"f": figure})
    assert "figures.f.scan: 'run' has a clamp_angle; a swing is followed in the ideal" in said


def test_what_the_method_does_not_allow_is_refused():
    said = refusal(grids={"main": TILTED}, method="shooting")
    assert "grids.main.clamp_angle: is not allowed with method: shooting" in said
    scan = {**PLAIN["grids"]["main"], "stage_angle": [0.01], "cycles": 3}
    assert study(scans={"run": scan}).scans["run"].cycles == 3


def test_figures_show_one_mounting_or_go_over_one():
    grids = {"main": {**TILTED, "curvature": [-0.1, 0]}}
    figure = {"kind": "taper", "grid": "main"}
    said = refusal(grids=grids, figures={"f": figure})
    assert "'main' has several values of clamp_angle" in said and "of curvature" in said
    over = {"kind": "mounting", "grid": "main", "over": "clamp_angle", "mu0": 0.2}
    assert "missing 'curvature'" in refusal(grids=grids, figures={"f": over})
    drawn = study(grids=grids, figures={"f": {**over, "curvature": 0}}).figures["f"]
    assert drawn.selection() == {"grid": "main", "mu0": 0.2, "curvature": 0.0}
    change = {"kind": "change", "grid": "main", "over": "stage_angle", "mu0": 0.2}
    said = refusal(grids=grids, figures={"f": {**change, "clamp_angle": 0, "curvature": 0}})
    assert "stage_angle has 0; allowed: two values, one of them 0" in said
