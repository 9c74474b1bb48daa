"""Stick-slip scans."""

from decimal import Decimal
from itertools import pairwise

import numpy as np
import pytest

from responses import by_law
from vibrissa import Mounting, Status, solve_curve, solve_onset, stick_slip
from vibrissa.errors import NoResponseError
from vibrissa.outcomes import End, SlipLaw
from vibrissa.scanning.cycles import longest_scan, move, stage_maker
from vibrissa.scanning.scan import Outcome, Scan
from vibrissa.scanning.surfaces import constant
from vibrissa.sticking.curve import failed_curve

D = Decimal


@pytest.fixture(scope="module")
def curve():
    return solve_curve(2.0, 0.85)


@pytest.fixture(scope="module")
def scan(curve):
    return stick_slip(curve, D("0.4"), D("0.004"), cycles=3)


def test_one_row_for_each_footpoint_position(scan):
    # x0_slip = 0.0528: 13 sticking steps of 0.004, the slip at the 14th.
    assert len(scan.clamp) == 3 * 14 + 1
    assert scan.clamp == pytest.approx(0.004 * np.arange(43), abs=1e-15)
    assert scan.cycle.tolist() == [1] * 15 + [2] * 14 + [3] * 14
    assert scan.step.tolist() == [0, *range(1, 15), *range(1, 15), *range(1, 15)]
    assert [i for i, phase in enumerate(scan.phase) if phase == "slip"] == [14, 28, 42]


def test_shapes_run_from_clamp_to_contact_point(scan):
    shapes = scan.shapes()
    assert shapes.x[:, 0] == pytest.approx(scan.clamp, abs=1e-15)
    assert shapes.x[:, -1] == pytest.approx(scan.contact, abs=1e-12)
    assert shapes.y[:, -1] == pytest.approx(0.85, abs=1e-12)
    assert shapes.phi[:, 0] == pytest.approx(np.pi / 2)
    assert shapes.phi[:, -1] == pytest.approx(scan.state.phi1, abs=1e-11)
    assert shapes.residual.max() < 1e-12
    length = np.hypot(np.diff(shapes.x), np.diff(shapes.y)).sum(axis=1)
    assert length == pytest.approx(1.0, abs=2e-4)  # 50 chords


def test_locked_scan_of_a_planar_rod_is_one_period_on_past_the_lock():
    curve = solve_curve(2.0, 0.85, section="planar")
    scan = stick_slip(curve, D("0.5"), D("0.01"), cycles=9)
    assert scan.status is Status.LOCK
    assert set(scan.phase) == {"stick", "lock"} and set(scan.cycle) == {1}
    end, ended = curve.motion_end(0.5)
    assert end is End.SNAPS
    assert curve.x0_lock < ended.x0 - 0.01 < scan.clamp[-1] <= ended.x0
    assert f"it sticks until the clamp is at {scan.clamp[-1]:.6g} L" in scan.message
    assert scan.shapes().residual.max() < 1e-11


@pytest.fixture(scope="module")
def flipped():
    curve = solve_curve(4.0, 0.6)
    return curve, stick_slip(curve, D("0.9"), D("0.004"), cycles=3)


@pytest.mark.slow
def test_a_round_rod_that_locks_swings_aside_and_is_dragged(flipped):
    curve, scan = flipped
    slips = [i for i, phase in enumerate(scan.phase) if phase == "slip"]
    trail = float(curve.trailing_end(0.9).x0)
    # The trailing tip slips at the first step past the last sticking state.
    assert scan.clamp[slips[0]] - 0.004 <= trail < scan.clamp[slips[0]]
    period = int((trail - 2 * curve.x1_init) / 0.004) + 1
    assert np.diff(slips).tolist() == [period, period]
    assert scan.status is Status.LOCK and scan.cycle[-1] == 3
    assert scan.step[slips].tolist() == [slips[0], period, period]


@pytest.mark.slow
def test_a_rod_that_has_swung_aside_is_in_equilibrium_with_its_mirrored_loads(flipped):
    _, scan = flipped
    behind = scan.contact < scan.clamp
    assert behind.any() and not behind.all()
    shapes = scan.shapes()
    assert shapes.residual.max() < 1e-11
    assert shapes.x[:, -1] == pytest.approx(scan.contact, abs=1e-11)
    assert shapes.phi[:, 0] == pytest.approx(np.pi / 2, abs=1e-12)
    assert shapes.phi[:, -1] == pytest.approx(scan.state.phi1, abs=1e-10)
    state, arm = scan.state, (scan.contact - scan.clamp)
    moment = state.reaction_fx * 0.6 - state.reaction_fy * arm
    assert -moment == pytest.approx(state.reaction_m, abs=1e-9)
    assert (np.abs(np.tan(state.alpha)) <= 0.9).all() and (state.stability_aside > 0).all()


def test_a_scan_says_why_it_has_fewer_cycles():
    planar = stick_slip(solve_curve(2.0, 0.85, section="planar"), 0.6, 0.2, 3)
    assert planar.cycle.max() == 1 and "the tip locks at x = 0.417" in planar.message
    assert planar.status is Status.LOCK
    assert not stick_slip(solve_curve(2.0, 0.85), 0.3, 0.01, 2).message


def test_step_longer_than_the_period_slips_every_time(curve):
    scan = stick_slip(curve, D("0.1"), D("0.01"), cycles=2)
    assert scan.phase.tolist() == ["stick", "slip", "slip"]
    assert scan.cycle.tolist() == [1, 1, 2]


def test_cycles_by_each_law_are_those_of_a_path(curve):
    ends = {}
    for law in SlipLaw:
        model = by_law(law, 0.7)
        cycles = stick_slip(curve, 0.3, 0.002, 3, law, 0.7, model.damping)
        to = [float(cycles.clamp[-1])]
        path = move(stage_maker(curve), constant(0.3), 0.002, to=to, model=model)
        assert cycles.contact.tolist() == path.contact.tolist()
        ends[law] = cycles.periods.contact_rest[0]
    assert ends["kinetic"] < ends["damped"] < ends["energy"]


def test_failed_curve_gives_an_empty_failed_scan():
    failed = failed_curve(theta=1.0, eta=0.5, method="collocation", message="why")
    scan = stick_slip(failed, D("0.3"), D("0.01"), 2)
    assert scan.status is Status.FAILED
    assert len(scan.step) == len(scan.state) == len(scan.reactions) == 0
    assert scan.shapes().x.shape == (0, 101) and scan.message == "why"


@pytest.mark.parametrize(
    ("argument", "value"),
    [("cycles", 0), ("cycles", 1.5), ("mu0", -0.1), ("dx0", np.nan), ("kinetic_ratio", 0.0)],
)
def test_impossible_arguments_are_refused(curve, argument, value):
    arguments = {"mu0": 0.3, "dx0": 0.01, "cycles": 1, argument: value}
    with pytest.raises(ValueError, match=argument):
        stick_slip(curve, **arguments)


@pytest.mark.parametrize("points", [1, 2.5])
def test_a_shape_has_two_points_and_more(scan, points):
    with pytest.raises(ValueError, match="points must be a whole number, at least 2"):
        scan.shapes(points)


def test_a_shape_of_two_points_has_both_ends(curve):
    scan = stick_slip(curve, D("0.3"), D("0.01"), cycles=1)
    few, many = scan.shapes(2), scan.shapes(5)
    assert few.x.shape == (len(scan), 2)
    for name in ("x", "y"):
        assert getattr(few, name) == pytest.approx(getattr(many, name)[:, [0, -1]], abs=1e-15)


def test_a_tip_that_slips_on_a_second_rise_of_its_demand_stops_at_the_foot_of_this_rise():
    mounting = Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=0.042)
    whole = solve_curve(1.77, 0.9665, mounting=mounting, section="planar")
    scan = stick_slip(whole, 0.3, 0.005, 2)
    slips = np.flatnonzero(scan.phase == "slip")
    # 0.457759 + 3·0.005 < 0.474486: four steps from slip to slip.
    assert slips.tolist() == [95, 99]
    assert scan.state.x0[slips] == pytest.approx([0.457759] * 2, abs=1e-6)
    assert scan.state.alpha[slips] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert np.ptp(scan.clamp - scan.contact - scan.state.x0) < 1e-12
    assert scan.shapes().residual.max() < 1e-11


@pytest.mark.parametrize("stage_angle", [0.0, 0.02])
def test_a_scan_whose_rod_passes_through_the_surface_is_marked(stage_angle):
    """As its onset is; on an oblique stage the rod is at other heights."""
    mounting = Mounting(stage_angle=stage_angle)
    through, lying = (
        stick_slip(solve_curve(5.0, 0.85, mounting=mounting, contact=contact), 0.3, 0.001, 1)
        for contact in ("point", "line")
    )
    assert solve_onset(5.0, 0.3, 0.85, 0.001, mounting=mounting).penetrates
    assert through.penetrates and "warning      the rod passes through the surf" in repr(through)
    assert not lying.penetrates and "warning" not in repr(lying)
    short = stick_slip(solve_curve(2.0, 0.85), 0.3, 0.01, 2)
    assert not short.penetrates
    assert repr(short) == "outcome      complete: 7 rows, 2 slips"


def length_of(turns):
    return sum(abs(b - a) for a, b in pairwise([D(0), *turns]))


@pytest.mark.parametrize(
    ("reach", "turns"),
    [
        ("0.1", ["0.1"]),
        ("0.3", ["0.3"]),
        ("0.55", ["0.3", "0.1"]),
        ("0.95", ["0.3", "0.1", "0.5"]),
        ("1.3", ["0.3", "0.1", "0.5", "0.1"]),
    ],
)
def test_a_path_is_followed_as_far_as_the_rod_has_states(reach, turns):
    asked = []

    def scan(turns):
        asked.append(turns)
        if length_of(turns) > D(reach):
            raise NoResponseError("shorten the path")
        return Scan.without_rows(Outcome.COMPLETE, "")

    found = longest_scan(scan, "0.1", ["0.3", "0.1", "0.5", "0"])
    assert found.outcome is Outcome.OUT_OF_REACH and found.message == "shorten the path"
    fits = [turns for turns in asked if length_of(turns) <= D(reach)]
    assert max(fits, key=length_of) == list(map(D, turns)) and len(asked) <= 6


def test_a_rod_without_states_after_one_step_has_no_scan():
    def scan(turns):
        raise NoResponseError("shorten the path")

    with pytest.raises(NoResponseError):
        longest_scan(scan, 0.1, [0.4])
