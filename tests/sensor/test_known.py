"""Whole responses, heights and scans, as they were: every column of every kind of rod and law."""

from functools import cache

import numpy as np
import pytest

from known import Known, some_rows
from vibrissa import Mounting
from vibrissa.sensor import surfaces
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.response.height_range import respond_over
from vibrissa.sensor.response.heights import respond_between
from vibrissa.sensor.simulation.oblique import ObliqueStage, simulate_oblique
from vibrissa.sensor.simulation.scanning import path, simulate
from vibrissa.sensor.simulation.slips import SlipLaw, Slips

KNOWN = Known(__file__)
TILTED = Mounting(clamp_angle=0.035, clamp_compliance=0.1, curvature=-0.1)
ROUND = (2.0, 0.85)
RODS = {
    "a round rod": lambda: respond(*ROUND),
    "a strip": lambda: respond(*ROUND, section="planar"),
    "a rod that is not pulled": lambda: respond(*ROUND, pull=False),
    "a rod in a tilted clamp": lambda: respond(*ROUND, mounting=TILTED),
    "a rod that lies on the surface": lambda: respond(2.0, 0.6, "line"),
    "a cylinder": lambda: respond(1.0, 0.9),
    "a thin tip that peels off": lambda: respond(8.0, 0.7, "line"),
}
SURFACES = {
    "one friction": surfaces.constant(0.3),
    "patches": surfaces.patches([0.0, 0.45, 0.4503, 0.5], [0.3, 0.6, 0.2, 0.35]),
    "a profile": surfaces.profile([-1.0, 0.4, 0.5, 2.0], [0.25, 0.25, 0.4, 0.2]),
    "random friction": surfaces.random(3, 0.3, 0.05, 0.02),
    "a friction that locks": surfaces.constant(0.7),
    "ice": surfaces.patches([0.0, 0.4174], [0.47, 0.01]),
}
PATHS = {"forth": ["0.12"], "forth and back": ["0.08", "-0.05", "0.01"], "far": ["1.1"]}


@cache
def rod(name):
    return RODS[name]()


@cache
def heights():
    return respond_over(*ROUND, 0.838, 0.862)


def states_of(branch, x0):
    return {
        "reactions": branch(x0),
        "slope": branch.slope(x0),
        "demand": branch.demand(x0),
        "demand_slope": branch.demand_slope(x0),
        "energy": branch.energy(x0),
    }


def whole(branch):
    """What a branch says of itself, and at places that are no knots."""
    names = ("x0_pull", "x0_lock", "x0_end", "mu_lock", "x1_init", "bounds", "swings")
    x0 = np.concatenate([np.linspace(0.97 * branch.x0_pull, 0.99 * branch.x0_lock, 9), [0.003]])
    return {
        **{name: getattr(branch, name) for name in names},
        **states_of(branch, x0),
        "normal_path": branch.normal_path(x0),
        "clip": branch.clip(np.array([-9.0, 0.01, 9.0])),
        "contact": [branch.contact(0.1, 0.02, side) for side in (1, -1)],
    }


@pytest.mark.parametrize("name", RODS)
def test_a_response_has_the_same_numbers_everywhere(name):
    response = rod(name)
    limits = {
        str(mu0): [*response.push_limit(mu0), response.pull_limit(mu0)]
        for mu0 in (0.01, 0.2, 0.45, 1.5)
    }
    KNOWN.check(name, {**whole(response), "limits": limits})


def test_progress_over_heights_goes_on_to_all_of_them():
    told = []
    respond_over(*ROUND, 0.838, 0.862, pull=False, progress=told.append)
    assert told == sorted(told) and 0.0 < told[0] < 1.0 and told[-1] == pytest.approx(1.0)


def test_a_rod_between_two_heights_is_the_same():
    found = respond_between(1.5, 0.9, pull=False)
    eta = np.array([0.885, 0.9, 0.91])
    x0 = np.array([0.001, 0.02, 0.05])
    one = found.at(0.893)
    KNOWN.check(
        "heights near one",
        {
            "ends": [found.low, found.high],
            "lock": found.lock,
            "landmarks": found.landmarks(eta),
            "reactions": found.reactions(x0, eta),
            "slopes": found.reactions(x0, eta, 1),
            "branch": whole(one),
        },
    )


@pytest.mark.slow
def test_a_rod_at_all_heights_of_a_range_is_the_same():
    found = heights()
    eta = np.array([[0.8385, 0.845], [0.851, 0.8615]])
    states = found.states(eta)
    marks = ("x0_pull", "x0_lock", "x0_end", "x1_init", "mu_lock")
    x0 = np.array([[0.002, -0.02], [0.04, 0.01]])
    KNOWN.check(
        "heights of a range",
        {
            "parts": [[part.low, part.high] for part in found.parts],
            "said": [found.below, found.above],
            "swings": found.swings,
            "part_of": found.part_of(eta),
            **{name: getattr(states, name) for name in marks},
            **states_of(states, x0),
            "clip": states.clip(np.full((2, 2), 9.0)),
            "out of it": found.states(np.array([0.1, 0.99])).eta,
        },
    )


def scanned(found):
    names = ("clamp", "contact", "x0", "reactions", "mu0", "period", "phase", "side")
    columns = {name: getattr(found, name) for name in names}
    return {
        "outcome": found.outcome,
        "message": found.message,
        "steps": len(found.clamp),
        **some_rows(columns),
    }


SCANS = [
    *(
        ("a round rod", surface, "forth and back", law, 0.7)
        for surface in SURFACES
        for law in SlipLaw
        if surface != "ice"
    ),
    ("a round rod", "ice", "far", SlipLaw.ENERGY, 0.5),
    ("a round rod", "a friction that locks", "far", SlipLaw.ENERGY, 0.8),
    ("a strip", "a friction that locks", "far", SlipLaw.FREE, 0.8),
    ("a rod that is not pulled", "patches", "forth", SlipLaw.KINETIC, 0.9),
    ("a rod that is not pulled", "a friction that locks", "far", SlipLaw.FREE, 0.8),
    ("a rod in a tilted clamp", "random friction", "forth and back", SlipLaw.ENERGY, 0.8),
    ("a rod in a tilted clamp", "a friction that locks", "far", SlipLaw.FREE, 0.8),
    ("a rod that lies on the surface", "a profile", "forth and back", SlipLaw.KINETIC, 0.5),
    ("a cylinder", "one friction", "forth and back", SlipLaw.ENERGY, 0.6),
]


@pytest.mark.parametrize("case", SCANS, ids=lambda case: ", ".join(map(str, case)))
def test_a_scan_has_the_same_columns(case):
    name, surface, way, law, ratio = case
    told = []
    found = simulate(
        rod(name), SURFACES[surface], path("0.001", PATHS[way]), law, ratio, told.append
    )
    KNOWN.check(", ".join(map(str, case)), {**scanned(found), "told": told[:3]})


OBLIQUE = [
    (0.1, "random friction", "forth and back", SlipLaw.FREE),
    (-0.1, "random friction", "forth and back", SlipLaw.KINETIC),
    (0.08, "patches", "forth and back", SlipLaw.ENERGY),
    (0.02, "ice", "far", SlipLaw.ENERGY),
    (0.2, "one friction", "forth", SlipLaw.FREE),
    (-0.2, "one friction", "forth", SlipLaw.FREE),
    (0.005, "a friction that locks", "far", SlipLaw.FREE),
    (-0.005, "a friction that locks", "far", SlipLaw.ENERGY),
]


@pytest.mark.slow
@pytest.mark.parametrize("case", OBLIQUE, ids=lambda case: ", ".join(map(str, case)))
def test_a_scan_of_an_oblique_stage_has_the_same_columns(case):
    angle, surface, way, law = case
    stage, told = ObliqueStage(heights=heights(), eta=0.85, angle=angle), []
    found = simulate_oblique(
        stage, SURFACES[surface], path("0.001", PATHS[way]), law, 0.75, told.append
    )
    KNOWN.check(", ".join(map(str, case)), {**scanned(found), "told": told[:3]})


@pytest.mark.parametrize("law", list(SlipLaw))
def test_a_slip_ends_at_the_same_place(law):
    response = rod("a round rod")
    ends = {
        surface: [
            Slips(response=response, surface=SURFACES[surface], law=law, ratio=ratio).rest(
                clamp, x0, side
            )
            for ratio in (0.4, 0.95)
            for clamp, x0, side in ((0.03, 0.03, 1), (0.06, -0.03, 1), (0.8, -0.05, -1))
        ]
        for surface in ("one friction", "patches", "a profile", "random friction")
    }
    KNOWN.check(f"rest, {law}", ends)
