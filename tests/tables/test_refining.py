"""Points that are added to grids: where the definition says so, whatever is solved beside."""

from dataclasses import replace
from decimal import Decimal
from functools import cache
from itertools import pairwise

import numpy as np
import pyarrow.compute as pc
import pytest

from vibrissa import solve_curve
from vibrissa.numerics.halving import Halved
from vibrissa.sticking.curve import failed_curve
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.sticking.stiction import read_curve
from vibrissa.study.codec import decode_grid, decode_key
from vibrissa.study.grid import Refinement, points_on_curves
from vibrissa.tables import schemas, store
from vibrissa.tables.points import points_tables
from vibrissa.tables.refining import (
    Line,
    all_added,
    curve_lines,
    refined_lines,
    refined_points,
    with_added,
)

MU0 = ("0.1", "0.2", "0.3", "0.4", "0.5", "0.6")
CLOSEST = Decimal("0.002")
FINE = Refinement(column="x0_slip", tolerance=Decimal("0.001"), closest={"mu0": CLOSEST})


def grid(mu0=MU0, dx0=("0.001",), theta=("2",)):
    return decode_grid({"theta": theta, "mu0": mu0, "eta": ("0.85",), "dx0": dx0})


@cache
def curve():
    return solve_curve(2.0, 0.85)


def own_points(grids):
    ((_, points),) = points_on_curves([decode_key(["2", "0.85"])], grids)
    return points


def refined(grids, refinements, of=None):
    of = of or curve()
    points = own_points(grids)
    return with_added(points, list(refined_lines(of, points, refinements)))


def frictions(points, name):
    return [mu0 for mu0, names in zip(points.mu0, points.grids, strict=True) if name in names]


def test_the_onset_is_known_between_the_points_to_the_tolerance():
    """By onsets that are computed anew, at the places that quarter each interval."""
    (line,) = refined_lines(curve(), own_points({"main": grid()}), {"main": FINE})
    points = refined({"main": grid()}, {"main": FINE})
    assert line.halved.unmet == ()
    ((locked, _), *more) = [ends for ends in line.halved.switches]
    assert not more
    for start, stop in pairwise(frictions(points, "main")):
        assert stop - start >= CLOSEST
        places = np.linspace(float(start), float(stop), 5)
        onsets = np.array([curve().onset(np.array([mu0]))[0] for mu0 in places])
        if start == locked:
            assert np.isfinite(onsets[0]) and np.isnan(onsets[-1])
            assert stop - start < 2 * CLOSEST
        elif np.isfinite(onsets).all():
            line_between = np.interp(places, places[[0, -1]], onsets[[0, -1]])
            assert np.abs(onsets - line_between).max() <= 0.001
        else:
            assert np.isnan(onsets).all()


def test_no_point_is_added_without_need():
    """The interval in whose middle it lies is not met, or holds the lock."""
    points = refined({"main": grid()}, {"main": FINE})
    own = set(grid().mu0)
    places = frictions(points, "main")
    for mu0 in set(places) - own:
        width = Decimal("0.1")
        start = Decimal(int(mu0 * 10)) / 10
        while start + width / 2 != mu0:
            width /= 2
            start = start if mu0 < start + width else start + width
        ends = np.linspace(float(start), float(start + width), 5)
        onsets = curve().onset(ends)
        off = np.abs(onsets - np.interp(ends, ends[[0, -1]], onsets[[0, -1]]))
        assert np.isnan(onsets).any() or off.max() > 0.001


def test_the_points_of_the_axes_stay_and_the_others_are_marked():
    points = refined({"main": grid()}, {"main": FINE})
    marked = dict(zip(points.mu0, points.added_to, strict=True))
    assert {mu0 for mu0, added in marked.items() if added is None} == set(grid().mu0)
    assert {tuple(added) for added in marked.values() if added} == {("main",)}
    assert len(marked) > 12
    assert list(points.mu0) == sorted(points.mu0)


def test_without_refine_nothing_changes():
    points = own_points({"main": grid()})
    assert list(refined_lines(curve(), points, {})) == []
    assert with_added(points, []) is points
    assert points.added_to == [None] * 6
    coarse = {"main": replace(FINE, tolerance=Decimal(1), closest={"mu0": Decimal("0.06")})}
    assert refined({"main": grid()}, coarse).added_to == [None] * 6


def test_each_step_has_its_own_points():
    """The last sticking state depends on the step, and the onset does not."""
    grids = {"main": grid(dx0=("0.001", "0.03"))}
    for column, same in (("x0_slip", True), ("x0_max", False)):
        points = refined(grids, {"main": replace(FINE, column=column)})
        of_step = {
            step: [mu0 for mu0, dx0 in zip(points.mu0, points.dx0, strict=True) if dx0 == step]
            for step in grids["main"].dx0
        }
        assert len(of_step) == 2
        first, second = of_step.values()
        assert (first == second) == same


def test_grids_that_share_points_keep_their_own():
    """A point of one grid's axes can be one that is added to another."""
    other = grid(mu0=("0.3", "0.45", "0.46"))
    grids = {"main": grid(), "other": other}
    alone = refined({"main": grid()}, {"main": FINE})
    points = refined(grids, {"main": FINE})
    assert frictions(points, "main") == frictions(alone, "main")
    assert frictions(points, "other") == list(other.mu0)
    rows = dict(zip(points.mu0, zip(points.grids, points.added_to, strict=True), strict=True))
    assert rows[Decimal("0.45")] == (["main", "other"], ["main"])
    assert rows[Decimal("0.46")] == (["other"], None)
    assert rows[Decimal("0.3")] == (["main", "other"], None)
    both = refined(grids, {"main": FINE, "other": FINE})
    assert frictions(both, "main") == frictions(alone, "main")
    assert ["other"] in both.added_to and ["main"] in both.added_to


def table(of, refinements):
    points = own_points({"main": grid()})
    points = with_added(points, list(refined_lines(of, points, refinements)))
    parts = points_tables([(points, of)], "a")
    return store.joined(list(parts), schemas.STICTION)


def test_the_points_do_not_depend_on_what_is_solved_beside():
    """Curves that are solved together differ by rounding, and the points not at all."""
    alone = table(curve(), {"main": FINE})
    (_, beside, _) = solve_curves([1.0, 2.0, 7.0], [0.85] * 3)
    other = table(beside, {"main": FINE})
    for name in ("mu0", "dx0", "grids", "added_to", "status", "n_steps"):
        assert other[name].equals(alone[name])
    onsets = [np.array(found["x0_slip"].to_numpy(), dtype=float) for found in (alone, other)]
    assert onsets[0] == pytest.approx(onsets[1], abs=1e-13, nan_ok=True)


def test_rows_of_the_axes_are_bit_for_bit_those_without_refine():
    own = table(curve(), {"main": FINE})
    own = own.filter(pc.is_null(own["added_to"]))
    assert own.equals(table(curve(), {}))


def test_a_curve_without_states_has_no_more_points():
    failed = failed_curve(theta=2.0, eta=0.85, method="collocation", message="no luck")
    assert len(refined({"main": grid()}, {"main": FINE}, failed)) == 6


def test_the_log_says_what_was_added_and_what_is_left():
    points = own_points({"main": grid(dx0=("0.01",))})
    (line,) = refined_lines(curve(), points, {"main": FINE})
    count = len(line.halved.added)
    assert str(line) == f"dx0 0.01: {count} values of mu0 added to main; 1 change of kind closed in"
    rough = replace(FINE, tolerance=Decimal("1e-6"), closest={"mu0": Decimal("0.05")})
    (line,) = refined_lines(curve(), points, {"main": rough})
    assert "not within the tolerance at closest: mu0 0.1 to 0.45" in str(line)


def curve_refinement(column="x0_slip", tolerance="0.001"):
    closest = {"theta": Decimal("0.05"), "eta": Decimal("0.005")}
    return Refinement(column=column, tolerance=Decimal(tolerance), closest=closest)


@cache
def solved(key):
    return solve_curve(float(key.theta), float(key.eta))


def lines_of(grid, refinement, gaps):
    return list(curve_lines("main", grid, gaps, refinement, solved))


@pytest.mark.slow
def test_curves_are_added_until_the_onset_is_known_between_them():
    """For each friction, by onsets that are computed anew."""
    mu0 = ("0.3", "0.45")
    theta = ("1", "2", "4")
    whole = grid(mu0=mu0, theta=theta)
    gaps = {"theta": list(pairwise(whole.theta))}
    ((line, keys),) = lines_of(replace(whole, theta=whole.theta[:2]), curve_refinement(), gaps)
    assert [key.theta for key in keys] == list(line.halved.added)
    assert {(key.eta, key.dx0) for key in keys} == {(Decimal("0.85"), None)}
    assert str(line).startswith(f"eta 0.85: {len(keys)} values of theta added to main")
    values = sorted([*whole.theta, *line.halved.added])
    assert len(values) > 5 and not line.halved.switches
    for start, stop in pairwise(values):
        places = np.linspace(float(start), float(stop), 5)
        onsets = np.array([solve_curve(x, 0.85).onset(np.array([0.3, 0.45])) for x in places])
        between = onsets[0] + np.linspace(0, 1, 5)[:, None] * (onsets[-1] - onsets[0])
        assert np.abs(onsets - between).max() <= 0.001 + 1e-12


def test_a_change_along_eta_is_closed_in():
    """The tip locks where the clamp is so far away that mu_lock falls below 0.45."""
    whole = replace(grid(mu0=("0.45",)), eta=(Decimal("0.8"), Decimal("0.9")))
    gaps = {"eta": list(pairwise(whole.eta))}
    ((line, keys),) = lines_of(whole, curve_refinement(tolerance="1"), gaps)
    assert {key.theta for key in keys} == {Decimal(2)} and line.axis == "eta"
    ((start, stop),) = line.halved.switches
    assert stop - start < Decimal("0.01")
    locks = [solve_curve(2.0, float(eta)).mu_lock for eta in (start, stop)]
    assert locks[0] > 0.45 > locks[1]


@pytest.mark.slow
def test_each_line_of_a_grid_is_refined_by_itself():
    whole = replace(grid(theta=("1", "2")), eta=(Decimal("0.8"), Decimal("0.85")))
    gaps = {"theta": [whole.theta], "eta": [whole.eta]}
    found = [(line.axis, line.at) for line, _ in lines_of(whole, curve_refinement(), gaps)]
    assert found == [("theta", at) for at in whole.eta] + [("eta", at) for at in whole.theta]


@pytest.mark.slow
def test_the_log_says_how_the_rods_of_a_line_are_mounted():
    whole = replace(grid(theta=("1", "2")), clamp_angle=(Decimal(0), Decimal("0.1")))
    found = lines_of(whole, curve_refinement(tolerance="1"), {"theta": [whole.theta]})
    assert [str(line).partition(": ")[0] for line, _ in found] == [
        "eta 0.85",
        "eta 0.85 clamp_angle=0.1",
    ]


@pytest.mark.slow
def test_numbers_of_a_curve_as_a_whole_are_known_between_curves():
    whole = grid(mu0=("0.3",), theta=("1", "4"))
    refinement = curve_refinement("mu_lock", "0.01")
    ((line, _),) = lines_of(whole, refinement, {"theta": [whole.theta]})
    assert line.halved.added
    places = np.array(sorted([*whole.theta, *line.halved.added]), dtype=float)
    fine = np.linspace(1, 4, 31)
    locks = np.interp(fine, places, [solve_curve(theta, 0.85).mu_lock for theta in places])
    exact = np.array([solve_curve(theta, 0.85).mu_lock for theta in fine])
    # Between the quarters, too, as mu_lock is smooth.
    assert np.abs(locks - exact).max() <= 0.011


def test_all_points_of_an_added_curve_are_added():
    grids = {"main": grid(), "other": grid(mu0=("0.3",))}
    points = all_added(own_points(grids))
    assert points.added_to == points.grids
    assert [
        mu0 for mu0, names in zip(points.mu0, points.grids, strict=True) if len(names) == 2
    ] == [Decimal("0.3")]


def test_a_change_of_contact_is_closed_in():
    """Between a rod that lies on the surface and one that stands on its tip."""
    lying = solve_curve(3.0, 0.85, contact="line")
    points = own_points({"main": grid(mu0=("0.1", "0.5"))})
    rough = replace(FINE, tolerance=Decimal(1))
    (line,) = refined_lines(lying, points, {"main": rough})
    changes = []
    for start, stop in line.halved.switches:
        read = read_curve(lying, [start, stop], [Decimal("0.001")] * 2)
        changes.append((read.status[0] == read.status[1], len(set(read.contact))))
    assert sorted(changes)[-1] == (True, 2)
    assert len(changes) == 2 and line.halved.unmet == ()


def test_what_is_left_over_is_told_in_stretches():
    """As long as the gaps together, of which those that touch are one stretch."""
    ends = ("0.1", "0.15", "0.2"), ("0.4", "0.45", "0.5")
    unmet = [tuple(map(Decimal, gap)) for some in ends for gap in pairwise(some)]
    halved = Halved(added=(Decimal("0.15"),), switches=(), unmet=tuple(unmet))
    line = Line(grid="main", axis="mu0", at=Decimal("0.01"), halved=halved)
    assert line.left_over == Decimal("0.2")
    assert str(line) == (
        "dx0 0.01: 1 value of mu0 added to main; "
        "not within the tolerance at closest: mu0 0.1 to 0.2, 0.4 to 0.5"
    )


def test_points_of_a_block_come_with_what_was_added_along_each_line():
    """On the curves of the grid, then on those that were added; with what is left over."""
    grids = {"main": grid(mu0=("0.3", "0.5"), theta=("1", "3"))}
    key = decode_key(["1", "0.85"])
    closest = {"theta": Decimal("0.9"), "mu0": Decimal("0.09")}
    refinement = Refinement(column="x0_slip", tolerance=Decimal("0.004"), closest=closest)
    gaps = {"main": {"theta": [(Decimal(1), Decimal(3))]}}
    found = refined_points({key: solved(key)}, grids, {"main": refinement}, gaps, solved)
    (own, added) = found.points
    assert (own[0], own[2]) == (key, solved(key))
    assert own[1].mu0 == tuple(map(Decimal, ("0.3", "0.4", "0.5")))
    assert own[1].added_to == [None, ["main"], None]
    assert added[0] == decode_key(["2", "0.85"]) and added[2].theta == 2
    assert set(added[1].mu0) > {Decimal("0.3"), Decimal("0.5")}
    assert added[1].added_to == [["main"]] * len(added[1])
    assert [(curve, line.axis) for curve, line in found.lines] == [
        ("1 0.85", "mu0"),
        ("", "theta"),
        ("2 0.85", "mu0"),
    ]
    (_, across, _) = (line for _, line in found.lines)
    assert across.halved.switches
    # Of the cylinder from 0.4 to 0.5, and nowhere else.
    assert found.left_over == [("main", "mu0", Decimal("0.1"))]
