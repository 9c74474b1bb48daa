"""All that is asked of states: no number of it changes unnoticed.

That it is right is tested elsewhere, against other methods.
"""

import numpy as np
import pytest

from known import Known
from vibrissa.mechanics import equations, newton
from vibrissa.mechanics.admissibility import clearances
from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.bending import measure, solve_and_measure, strains
from vibrissa.mechanics.buckling import buckled_states, buckling_mode, initial_states
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.mechanics.equations import Closure
from vibrissa.mechanics.mounting import IDEAL, Mounting, Mountings
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import Contact

KNOWN = Known(__file__)
MOUNTED = [
    Mounting(clamp_angle=0.1, clamp_compliance=0.3, curvature=(0.2, -0.5)),
    Mounting(curvature=(-0.4, 0.1)),
    Mounting(clamp_compliance=0.05),
]
THETA = np.array([1.0, 2.0, 5.0])
S = np.linspace(0.0, 1.0, 7)


def made_up(mounted, nodes=24, s_c=(1.0, 0.9, 0.7)):
    """Three states that satisfy no equation, but are bent as those that do."""
    tau = gauss_rule(nodes).nodes
    bend = np.array([[1.2], [0.9], [-0.4]])
    return RodStates(
        theta=THETA,
        phi=np.pi / 2 - bend * np.sin(1.3 * tau) - 0.1 * tau**2,
        fx=np.array([-0.3, 0.2, -0.9]),
        fy=np.array([-1.4, -0.8, -0.5]),
        s_c=np.array(s_c),
        mounting=Mountings.of(MOUNTED) if mounted else None,
    )


@pytest.mark.parametrize("mounted", [False, True])
def test_what_is_seen_of_states(mounted):
    states = made_up(mounted)
    x1 = np.array([0.5, 0.6, 0.7])
    result = {
        "ends": equations.ends(states)._asdict(),
        "place": equations.contact_position(states),
        "shape": equations.shape(states, S),
        "coordinates": equations.path_coordinates(x1, states, 2.0 * x1, x1 + 1.0),
        "moment": equations.bending_moment(states)[:, ::6],
        "decay": equations.coefficient_decay(made_up(mounted, 5)),
        "aside": stability_aside(states),
    }
    for contact in Contact:
        for slides in (False, True):
            name = f"stability in {contact} contact" + " sliding" * slides
            result[name] = stability(states, contact, slides=slides)
    KNOWN.check(f"seen of {'mounted' if mounted else 'ideal'} rods", result)


CLOSURES = {
    "offset": Closure.at_offset(np.array([0.5, 0.6, 0.7])),
    "offset lying": Closure.at_offset(np.array([0.5, 0.6, 0.7]), Contact.LINE),
    "inclination": Closure.at_inclination(np.array([0.0, -0.3, 0.4]), Contact.LINE),
    "advance": Closure.at_advance(
        np.full(3, 0.7), np.full((3, 4), 0.5), np.full(3, 0.5), np.arange(1.0, 4.0)
    ),
    "switch": Closure.at_switch(3),
}


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize("mounted", [False, True])
def test_by_how_much_states_miss_the_equations(name, mounted):
    states, closure = made_up(mounted, 12), CLOSURES[name]
    eta = np.array([0.7, 0.8, 0.6])
    result = {
        "residuals": equations.residuals(states, eta, closure)[:, ::2],
        "last residuals": equations.residuals(states, eta, closure)[:, -3:],
        "largest": equations.largest_residual(states, eta, closure),
    }
    who = "mounted" if mounted else "ideal"
    KNOWN.check(f"missed by {who} rods: {name}", result)
    # A Jacobian in single precision
    matrix = equations.jacobian(states, closure)[:, ::5, ::5]
    KNOWN.check(f"Jacobian of {who} rods: {name}", matrix, 1e-4)


@pytest.mark.parametrize("nodes", [12, 40, 200])
def test_how_often_states_are_corrected(nodes, monkeypatch):
    """More corrections, or inverses, than it takes are time that each curve loses."""
    theta, eta = np.array([1.0, 2.0, 4.0, 4.0]), np.array([0.9, 0.8, 0.6, 0.2])
    calls = {"corrected": [], "coarse_inverse": []}
    for name, seen in calls.items():
        function = getattr(newton, name)
        monkeypatch.setattr(
            newton, name, lambda *a, f=function, s=seen: s.append(len(a[0])) or f(*a)
        )
    guess = buckled_states(theta, eta, nodes)
    solved = newton.solve(guess, eta, Closure.at_inclination(np.zeros(4)), tolerance=1e-9)
    shown = {
        "converged": solved.converged,
        "force": solved.states.fy,
        "few nodes": solved.inverse.shape,
        **calls,
    }
    KNOWN.check(f"corrections on {nodes} nodes", shown)


def test_a_hopeless_guess_is_given_up_at_once(monkeypatch):
    """Numbers that have overflowed do not come back: to go on with them is lost time."""
    counts = []
    correct = newton.corrected
    monkeypatch.setattr(newton, "corrected", lambda *a: counts.append(len(a[0])) or correct(*a))
    theta, eta = np.array([1.0, 2.0]), np.array([0.9, 0.8])
    guess = buckled_states(theta, eta, 16)
    guess.phi[1] = np.nan
    solved = newton.solve(guess, eta, Closure.at_inclination(np.zeros(2)))
    assert solved.converged.tolist() == [True, False] and np.isnan(solved.states.fy[1])
    assert counts[0] == 2 and set(counts[1:]) == {1} and len(counts) < 15


@pytest.mark.parametrize("eta", [0.99, 0.8, 0.5, 0.2])
def test_where_sticking_begins(eta):
    theta = np.array([1.0, 1.7, 3.0, 6.0, 15.0])
    states, found = initial_states(theta, np.full(5, eta), 40)
    shown = {"found": found, "force": states.fy, "tip": states.phi[:, -1], "fx": states.fx}
    guess = buckled_states(theta, np.full(5, eta), 16)
    shown |= {"guess": guess.phi[:, ::5], "guessed force": guess.fy}
    shown["mode"] = buckling_mode(S, theta)
    KNOWN.check(f"begins at {eta:g}", shown)


def test_a_mirror_image_is_no_first_state(monkeypatch):
    """A rod that is bent away from +x is an equilibrium, too, but not that in which one begins."""
    theta, eta = np.array([1.0, 3.0]), np.array([0.9, 0.9])
    assert initial_states(theta, eta, 32)[1].all()

    def mirrored(theta, eta, nodes):
        guess = buckled_states(theta, eta, nodes)
        guess.phi[:] = np.pi - guess.phi
        return guess

    monkeypatch.setattr("vibrissa.mechanics.buckling.buckled_states", mirrored)
    assert not initial_states(theta, eta, 32)[1].any()


def rod(slope, nodes, theta=1.0):
    s = gauss_rule(nodes).nodes
    one = np.ones(1)
    return RodStates(theta=theta * one, phi=slope(s)[None], fx=0 * one, fy=-one, s_c=one)


SLOPES = {
    "hangs": lambda s, k: np.pi / 2 - (1.0 + k) * np.pi * s,
    "bows": lambda s, k: np.pi / 2 + (1.0 + k) * np.pi * s,
    "loops": lambda s, k: np.pi / 2 + (1.3 + k) * np.pi * (s - np.sin(2 * np.pi * s) / (2 * np.pi)),
    "waves": lambda s, k: np.pi / 2 + (2.4 + 1.5 * k) * np.sin(2 * np.pi * s) * s,
    "just levels out": lambda s, k: (
        np.pi / 2 + (1.54 + 0.1 * k) * np.exp(-(((s - 0.25) / 0.12) ** 2))
    ),
    "dips": lambda s, k: np.pi / 2 - (1.7 + k) * np.sin(1.4 * np.pi * s),
}


@pytest.mark.slow
@pytest.mark.parametrize("contact", Contact)
@pytest.mark.parametrize("name", SLOPES)
def test_how_near_shapes_are_to_what_they_may_not_be(name, contact):
    """Sizes, and what counts as far: that costs no time."""
    result = {}
    for nodes, theta in ((24, 1.0), (64, 3.0)):
        for k in np.linspace(0.0, 0.8, 9):
            states = rod(lambda s, k=k: SLOPES[name](s, k), nodes, theta)
            height = equations.contact_position(states)[1]
            for above in (0.0, 0.05):
                found = clearances(states, height + above, contact)
                sizes = np.concatenate([found.clamp, found.surface, found.itself])
                result[f"{nodes} nodes, {k:.1f}, {above:g}: {found.reasons(0)}"] = sizes
    KNOWN.check(f"{name}, {contact} contact", result)


def test_what_lies_beyond_the_contact_point_may_rise():
    """A whisker that is curved towards the surface would pass through it behind the contact."""
    curvatures = [-0.3, 0.0, 0.2, (0.0, -1.0), (-1.0, 1.5), (0.5, -1.0), (-0.2, 0.25)]
    for theta in (1.0, 4.0):
        states = made_up(False, s_c=(1.0, 0.9, 0.5)).take(np.full(len(curvatures), 2))
        states = RodStates(
            **{name: value for name, value in vars(states).items() if name != "mounting"},
            mounting=Mountings.of([Mounting(curvature=one) for one in curvatures]),
        )
        eta = np.full(len(curvatures), 0.9)
        found = [clearances(states, eta, contact).surface for contact in Contact]
        KNOWN.check(f"tails at theta = {theta:g}", found)


@pytest.mark.parametrize("mounting", [IDEAL, *MOUNTED])
@pytest.mark.parametrize("s_c", [1.0, 0.63])
def test_a_shape_is_a_path_along_its_own_slope(mounting, s_c):
    """Its tail has its natural curvature, and goes on from where the rod leaves the surface."""
    s = np.linspace(0.0, 1.0, 4001)
    x, y, phi = deformed_shape(2.0, 1.1, -0.3, 0.5, 0.8, s, s_c, mounting)
    middle = 0.5 * (phi[1:] + phi[:-1])
    assert np.diff(x) == pytest.approx(np.diff(s) * np.cos(middle), abs=1e-9)
    assert np.diff(y) == pytest.approx(np.diff(s) * np.sin(middle), abs=1e-9)
    natural = np.polynomial.Polynomial(mounting.coefficients)
    between = 0.5 * (s[1:] + s[:-1])
    free = between > s_c + 1e-3
    assert (np.diff(phi) / np.diff(s))[free] == pytest.approx(natural(between[free]), abs=1e-6)
    moment = -1.1 * (np.cos(-0.3) * (0.5 - (1 - s_c)) + np.sin(-0.3) * 0.8)
    turned = mounting.clamp_angle + mounting.clamp_compliance * moment
    assert phi[0] == pytest.approx(np.pi / 2 + turned, abs=1e-12)


def test_how_much_rods_are_bent():
    theta = np.array([1.0, 2.0, 3.0, 8.0])
    load = {
        "theta": theta,
        "f": np.array([2.7, 1.1, 0.6, 0.2]),
        "alpha": np.array([0.0, -0.3, 0.2, -0.4]),
    }
    place = np.array([0.4, 0.45, 0.5, 0.3]), np.array([0.85, 0.8, 0.8, 0.9])
    known = solve_and_measure(**load, x1=place[0], y1=place[1])
    rows = zip(*load.values(), *place, strict=True)
    s = np.linspace(0.0, 1.0, 21)
    x, y, phi = np.moveaxis(np.array([deformed_shape(*row, s) for row in rows]), 1, 0)
    by_shape = measure(**load, x1=place[0], y1=place[1], s=s, x=x, y=y, phi1=phi[:, -1])
    s_c = np.array([1.0, 0.9, 1.0, 0.7])
    mounting = Mountings.of([IDEAL, *MOUNTED])
    result = {
        "solved": known,
        "of shapes": by_shape,
        "strains": strains(**load, x_c=place[0], y_c=place[1], s_c=s_c),
        "mounted": strains(**load, x_c=place[0], y_c=place[1], s_c=s_c, mounting=mounting),
    }
    KNOWN.check("bending", result)
