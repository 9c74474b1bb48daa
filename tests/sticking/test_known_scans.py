"""Whole scans, onsets and single states: no number of them changes unnoticed.

That they are right is tested elsewhere, against other methods.
"""

from decimal import Decimal
from functools import cache

import numpy as np
import pytest

from known import Known
from vibrissa import Mounting, solve_curve, solve_onset, stick_slip
from vibrissa.sticking.api import solve_states
from vibrissa.sticking.solving import shooting
from vibrissa.sticking.solving.shooting import PAPER, PRECISE, Tolerances, initial_state, walk
from vibrissa.sticking.stiction import read_curve

KNOWN = Known(__file__)
TOGETHER = Mounting(clamp_angle=-0.05, clamp_compliance=0.1, curvature=(-0.1, -0.2))
TILTED = Mounting(clamp_angle=0.05, stage_angle=0.02)

RODS = {
    "paper": {"theta": 2.0, "eta": 0.85},
    "lies down": {"theta": 3.0, "eta": 0.8, "contact": "line"},
    "planar": {"theta": 3.0, "eta": 0.85, "section": "planar"},
    "mounted": {"theta": 3.0, "eta": 0.75, "contact": "line", "mounting": TOGETHER},
    "oblique": {"theta": 2.0, "eta": 0.85, "mounting": TILTED},
    "dips": {"theta": 1.0, "eta": 0.3, "section": "planar"},
    "nowhere": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(curvature=-2.0)},
}


@cache
def curve(name):
    return solve_curve(**RODS[name])


@pytest.mark.parametrize(
    ("name", "mu0", "dx0", "cycles"),
    [
        ("paper", "0.3", "0.01", 3),
        ("paper", "0.9", "0.2", 3),
        ("lies down", "0.3", "0.02", 2),
        ("planar", "0.9", "0.2", 2),
        ("mounted", "0.4", "0.03", 1),
        ("oblique", "0.3", "0.01", 3),
        ("nowhere", "0.3", "0.01", 3),
    ],
)
def test_a_scan_is_the_known_one(name, mu0, dx0, cycles):
    contact = RODS[name].get("contact", "point")
    scan = stick_slip(curve(name), Decimal(mu0), Decimal(dx0), cycles, 5, contact)
    # What lies beyond the contact point may be curved.
    assert not (scan.residual[scan.state.s_c == 1.0] > 1e-9).any()
    shown = {key: value for key, value in vars(scan).items() if key != "residual"}
    KNOWN.check(f"scan, {name}, mu0 = {mu0}", shown)


@pytest.mark.parametrize("name", RODS)
def test_what_is_read_off_a_curve_is_known(name):
    mu0 = [Decimal(one) for one in ("0.1", "0.3", "0.3", "0.45", "0.6", "2")]
    dx0 = [Decimal(one) for one in ("0.001", "0.001", "0.04", "0.01", "0.01", "0.001")]
    KNOWN.check(f"points, {name}", read_curve(curve(name), mu0, dx0))


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("mu0", [0.3, 1.5])
def test_an_onset_is_told_as_it_was(name, mu0):
    shown = dict(vars(solve_onset(mu0=mu0, dx0=0.004, **RODS[name])))
    assert not shown.pop("residual") > 1e-11
    KNOWN.check(f"onset, {name}, mu0 = {mu0}", shown)


@pytest.mark.parametrize(
    ("theta", "eta", "contact", "mounting"),
    [
        (1.0, 0.55, "point", Mounting()),
        (3.0, 0.75, "point", Mounting()),
        (3.0, 0.75, "line", Mounting()),
        (3.0, 0.75, "line", TOGETHER),
        (2.5, 0.3042, "point", Mounting()),
        (2.0, 0.85, "point", Mounting(curvature=-2.0)),
    ],
)
def test_single_states_are_the_known_ones(theta, eta, contact, mounting):
    place = np.sqrt(1.0 - eta**2)
    states = solve_states(
        theta, eta, (place * np.array([-0.9, -0.5, 0.0, 0.3, 0.9])).tolist(), contact, mounting
    )
    shown = []
    for state in states:
        one = {key: value for key, value in vars(state).items() if key[0] != "_"}
        solved = not np.isnan(state.f)
        if solved:
            assert one.pop("residual") < 1e-11
            one |= {"penetrates": state.penetrates, "shape": state.shape(np.array([0.3, 0.95]))}
        else:
            one.pop("residual")
        shown.append(one)
    name = f"states, {theta:g} {eta:g} {contact} {mounting.coefficients}"
    KNOWN.check(name, shown)


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "eta"), [(1.0, 0.85), (3.0, 0.97), (2.0, 0.99)])
def test_the_papers_procedure_takes_the_steps_that_it_took(theta, eta):
    """A search with MATLAB's tolerances ends where its steps lead, not at the exact state."""
    states = walk(theta, eta, 0.004, mu0=0.5, tolerances=PAPER)
    KNOWN.check(f"shots, {theta:g} {eta:g}", [vars(state) for state in states], 1e-6)
    assert [states[0].f, states[0].x1] == pytest.approx(
        [(exact := initial_state(theta, eta)).f, exact.x1], rel=0.03
    )


@pytest.mark.parametrize(
    ("tolerances", "known"), [(PRECISE, 137), (PAPER, 43)], ids=["precise", "as in MATLAB"]
)
def test_a_search_takes_as_many_integrations_as_it_did(tolerances, known, monkeypatch):
    """Each is a rod integrated from end to end: a search that cannot end takes hundreds."""
    calls = []
    integrate = shooting.shoot
    monkeypatch.setattr(shooting, "shoot", lambda *rod: calls.append(rod) or integrate(*rod))
    state = initial_state(1.0, 0.98, tolerances)
    assert len(calls) == pytest.approx(known, rel=0.15)
    assert state.searches == 1 and state.miss <= tolerances.miss


def test_a_walk_ends_where_a_search_has_missed(monkeypatch):
    """From a state that is none each further search would miss, too, and take its time."""
    search = shooting.minimize

    def hasty(*arguments, options, **others):
        return search(*arguments, options=options | {"maxiter": 3}, **others)

    start = initial_state(1.0, 0.98)
    monkeypatch.setattr(shooting, "minimize", hasty)
    once = Tolerances(restarts=0)
    states = walk(1.0, 0.98, 0.004, tolerances=once, start=start)
    assert len(states) == 2 and states[0] is start and states[1].miss > once.miss
