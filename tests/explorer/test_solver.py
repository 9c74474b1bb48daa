"""The solver of the explorer's page, in Node.js: against Python's solver and closed forms."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from scipy.special import ellipe, ellipk

from validation import explorer_agreement as agreement
from validation.node import node
from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.outcomes import Contact

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page():
    with node() as scripts:
        agreement.open_solver(scripts)
        yield scripts


def solved(page, expression, **rod):
    """Value of an expression of a path."""
    rod = {"contact": "point", "round": True} | rod
    return page.evaluate(
        f"(() => {{ const {{ path, message }} = solvedPath({json.dumps(rod)});"
        f"return {expression}; }})()"
    )


@pytest.mark.parametrize("contact", Contact)
@pytest.mark.parametrize("mounted", [False, True])
def test_both_solvers_agree(page, contact, mounted):
    rows = agreement.compared(agreement.points(10, 2, contact, mounted=mounted), page)
    assert len(rows) == 10 and any("x0_slip" in row for row in rows)
    assert any("x0_end" in row for row in rows)
    assert max(max(row.values(), default=0.0) for row in rows) < agreement.TOLERATED


@pytest.mark.parametrize(("contact", "mounted"), [("point", True), ("line", False)])
def test_both_solvers_agree_on_rods_of_any_stiffness(page, contact, mounted):
    points = agreement.points(10, 5, Contact(contact), mounted=mounted, stiffened=True)
    rows = agreement.compared(points, page)
    assert any("x0_slip" in row for row in rows) and any("x0_end" in row for row in rows)
    assert max(max(row.values(), default=0.0) for row in rows) < agreement.TOLERATED


def test_a_bore_as_wide_as_the_tip_is_told(page):
    making = {"powers": [0], "bore": 0.5}
    mounting = {"angle": 0, "compliance": 0, "curvature": [0], "stage": 0, "making": making}
    said = solved(page, "path ? '' : message", theta=2, eta=0.8, mounting=mounting)
    assert "wider than the tip" in said


@pytest.mark.parametrize(("theta", "eta"), [(5.2071883, 0.5663943), (3.7000854, 0.6262328)])
def test_the_lock_is_a_landmark_even_where_a_state_beside_it_looks_steeper(page, theta, eta):
    found = solved(page, "path.muLock", theta=theta, eta=eta, contact="line")
    assert found == pytest.approx(solve_curve(theta, eta, contact="line").mu_lock, abs=1e-9)


def test_a_short_contact_along_a_line_is_not_stepped_over(page):
    rod = {"theta": 1.3691250036358575, "eta": 0.7726408562873879, "contact": "line"}
    assert solved(page, "path.pushed.end", **rod) == "swings"


@pytest.mark.parametrize(
    ("mounting", "said"),
    [
        ({"angle": 0.6}, "springs to the other side"),
        ({"angle": -0.6}, "does not press on the surface"),
        ({"curvature": [2.5, 0]}, ""),
    ],
)
def test_a_mounting_in_which_no_period_begins_is_told(page, mounting, said):
    ideal = {"angle": 0, "compliance": 0, "curvature": [0], "stage": 0}
    found = solved(
        page, "path ? '' : message", theta=1, eta=0.95, mounting=ideal | mounting, round=True
    )
    assert said in found and found


@pytest.mark.parametrize(
    ("eta", "contact", "bent", "stage"),
    [(0.8, "point", 0, 0), (0.5, "line", 0, 0), (0.8, "point", 0.1, 0), (0.8, "point", 0.1, 0.1)],
)
def test_the_work_of_the_stage_is_the_gain_of_energy(page, eta, contact, bent, stage):
    curvature = [-2 * bent, bent]
    states = solved(
        page,
        "Array.from({ length: 201 }, (_, k) => stateAt(path, 0.0005 * k))"
        ".map((s) => [s.fx, s.fy, path.branch.rod.energyOf(s.unknowns)])",
        theta=3,
        eta=eta,
        contact=contact,
        mounting={"angle": bent, "compliance": bent, "curvature": curvature, "stage": stage},
    )
    load = [fx * math.cos(stage) + fy * math.sin(stage) for fx, fy, _ in states]
    # Simpson's rule
    work = -0.0005 / 3 * (load[0] + load[-1] + 4 * sum(load[1:-1:2]) + 2 * sum(load[2:-1:2]))
    assert work == pytest.approx(states[-1][2] - states[0][2], rel=1e-7)


@pytest.mark.parametrize(
    ("theta", "eta", "contact", "mounting", "why"),
    [
        (1, 0.85, "point", Mounting(), "snaps"),
        (
            1.974378,
            0.827829,
            "line",
            Mounting(clamp_angle=-0.0582, curvature=0.3229),
            "inadmissible",
        ),
        # The rod comes down to its clamp: deep, for a short way, and at the clamp itself.
        (1, 0.15, "line", Mounting(), "inadmissible"),
        (1, 0.25, "point", Mounting(), "inadmissible"),
        (1, 0.312745, "point", Mounting(), "inadmissible"),
        (
            1.72,
            0.446,
            "point",
            Mounting(
                clamp_angle=-0.0339, clamp_compliance=0.929, curvature=(2.95, -5.26, 7.71, -1.2)
            ),
            "inadmissible",
        ),
        # The rod is above the surface on a part of the path.
        (
            2.7468,
            0.6336,
            "point",
            Mounting(clamp_angle=0.2345, curvature=(0.499, 0.195), stage_angle=0.0366),
            "snaps",
        ),
        # The demand rises twice.
        (
            1.77,
            0.9665,
            "point",
            Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=0.042),
            "lifts",
        ),
        # The tail comes down to the clamp.
        pytest.param(
            *(2, 0.15, "line", Mounting(curvature=-0.5), "inadmissible"), marks=pytest.mark.nightly
        ),
        # The tip reaches the rod.
        pytest.param(
            *(7.867, 0.469, "point", Mounting(), "inadmissible"), marks=pytest.mark.nightly
        ),
        # The last states before a limit point are hard to solve.
        (3.3602803308520244, 0.42442439855267744, "line", Mounting(), "snaps"),
        (5.2854503687975205, 0.5221863609842756, "line", Mounting(), "snaps"),
        # An arch of a hundred-thousandth of the rod, next to the tip.
        (
            7.798879431123622,
            0.9303323160251017,
            "line",
            Mounting(
                clamp_angle=0.020427692343165604,
                clamp_compliance=0.14573767788217507,
                curvature=(-0.36369298638468817, 0.37546240650501495),
                stage_angle=0.0054587409340891985,
            ),
            "inadmissible",
        ),
        # An arch where the tip is nearly parallel to the surface.
        (
            2.6091380808913547,
            0.5859093093085025,
            "line",
            Mounting(
                clamp_angle=-0.026344082578788314,
                clamp_compliance=0.2648335987496727,
                curvature=(-0.21835113990822672, 0.2258908237761429),
                stage_angle=-0.09127105194231117,
            ),
            "inadmissible",
        ),
    ],
)
def test_a_planar_path_ends_at_the_same_place(page, theta, eta, contact, mounting, why):
    point = agreement.Point(theta, eta, 0.3, Contact(contact), mounting).asked()
    end = solved(page, "[path.pushed.end, path.x0End]", **point | {"round": False})
    curve = solve_curve(theta, eta, contact=contact, mounting=mounting, section="planar")
    assert end == [why, pytest.approx(curve.x0_end, abs=1e-9)]


def test_a_rod_ends_where_its_tip_reaches_it(page):
    theta, eta = 7.0375, 0.4416
    found = solved(
        page,
        "[path.x0End, path.pushed.why, ...[0, -1].map((at) => path.pushed.knots.at(at).state)"
        ".map(({ phi1, fx, fy }) => [phi1, fx, fy])]",
        theta=theta,
        eta=eta,
        round=False,
    )
    x0_end, why, first, last = found
    assert why == "the rod crosses itself"
    assert x0_end == pytest.approx(tip_reaches_rod(theta, eta, first, last), abs=1e-9)


def tip_reaches_rod(theta, eta, first, last):
    """Displacement at which the tip of a planar rod touches it, by shooting from the tip.

    `first` and `last` are guesses of φ1, fx and fy with α = 0 and where the tip touches the rod.
    """

    def rod(unknowns, length):
        """Position relative to the tip, and slope, at a distance along the rod from it."""
        phi1, fx, fy = unknowns

        def change(s, z):
            _, _, phi, m = z
            b = (1.0 - (1.0 - 1.0 / theta) * (1.0 - s)) ** 4
            return [-np.cos(phi), -np.sin(phi), -m / b, fy * np.cos(phi) - fx * np.sin(phi)]

        tip = [0.0, 0.0, phi1, 0.0]
        return solve_ivp(change, [0.0, length], tip, "DOP853", rtol=1e-12, atol=1e-13).y[:3, -1]

    def clamped(x, y, phi):
        return [y + eta, phi - math.pi / 2]

    def touches(v):
        return [*clamped(*rod(v[:3], 1.0)), *rod(v[:3], v[3])[:2]]

    def starts(v):
        return clamped(*rod([v[0], 0.0, v[1]], 1.0))

    phi1, fy = fsolve(starts, first[::2], xtol=1e-12)
    lengths = np.linspace(0.2, 0.8, 61)
    near = min(lengths, key=lambda length: np.hypot(*rod(last, length)[:2]))
    touching = fsolve(touches, [*last, near], xtol=1e-12)
    assert np.abs(touches(touching)).max() < 1e-11
    return rod(touching[:3], 1.0)[0] - rod([phi1, 0.0, fy], 1.0)[0]


def test_a_state_that_only_one_solver_finds_counts():
    assert agreement.differences({"mu_lock": 0.5}, {"message": "lost"})["mu_lock"] == float("inf")
    assert agreement.differences({}, {"x0_slip": 0.1})["x0_slip"] == float("inf")


@pytest.mark.parametrize("eta", [0.5, 0.85, 0.96])
def test_a_cylinder_begins_as_elliptic_integrals_say(page, eta):
    # 2E/K − 1 = η, f = K², x1 = 2k/K
    m = brentq(lambda m: 2 * ellipe(m) / ellipk(m) - 1 - eta, 1e-9, 0.99)
    found = solved(page, "[path.branch.force, path.branch.x1]", theta=1, eta=eta)
    assert found == pytest.approx([ellipk(m) ** 2, 2 * m**0.5 / ellipk(m)], abs=1e-10)


def test_a_lying_cylinder_locks_at_45_degrees(page):
    found = solved(page, "path.muLock", theta=1, eta=0.5, contact="line")
    assert found == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("contact", ["point", "line"])
@pytest.mark.parametrize("x0", [-0.01, 0.05, 0.2, 0.3])
def test_states_between_are_those_of_python(page, contact, x0):
    rod = {"theta": 2.5, "eta": 0.75}
    x1 = solved(page, "path.branch.x1", contact=contact, **rod)
    seen = "(({ fx, fy, m, sc, phi1 }) => [fx, fy, m, sc, phi1])"
    found = solved(page, f"{seen}(stateAt(path, {x0}))", contact=contact, **rod)
    state = solve_state(**rod, x1=x1 - x0, contact=contact)
    expected = [state.reaction_fx, state.reaction_fy, state.reaction_m, state.s_c, state.phi1]
    assert found == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("contact", ["point", "line"])
def test_curves_that_are_drawn_pass_through_solved_states(page, contact):
    mounting = {"angle": 0.1, "compliance": 0.2, "curvature": [-0.2, 0.1], "stage": 0.05}
    rows = solved(
        page,
        "(({ x0, fx, fy, m, energy }) => x0.map((at, i) => {"
        "  const s = stateAt(path, at);"
        "  return s && [[fx[i], fy[i], m[i], energy[i]],"
        "    [s.fx, s.fy, s.m, path.branch.rod.energyOf(s.unknowns)]];"
        "}))(sampled(path, 4))",
        theta=3,
        eta=0.75,
        contact=contact,
        mounting=mounting,
    )
    known = [row for row in rows[4:-4] if row]
    assert len(known) > 60
    for drawn, exact in known:
        assert drawn == pytest.approx(exact, abs=2e-4)


def test_what_is_not_found_is_said(page):
    # Far beyond the fields of the page.
    said = solved(page, "path ? '' : message", theta=400, eta=0.05)
    assert "try" in said
