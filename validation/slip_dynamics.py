"""Slips of a rod with mass and damping, compared with the laws of slip.

A chain of links with masses at their ends slips from the onset, with its clamp at rest, until its
tip sticks for good. Springs join the links; dampers beside the springs have the same ratio to them
everywhere. Kinetic friction κ·μ0 acts on the tip while it slides. A tip whose velocity vanishes
sticks if |T/N| ≤ μ0. The damping ratio ζ is that of the first mode at α = 0 with a tip that slides
without friction. The mass sets the unit of time alone, √(ρA0·L⁴/(E·I0)).

Positions and velocities follow by the midpoint rule. The energy of the springs and the lengths of
the links are quadratic in the positions, so that without friction and damping the rule keeps the
energy to rounding. The chain shares no code with the package, whose laws are beside it.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from validation.plane_chain import chain_state
from validation.records import write_record
from vibrissa import solve_curve, solve_state
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning.cycles import steady_travel
from vibrissa.scanning.response import responses
from vibrissa.scanning.rods import MountedRod
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.wording import markdown_table

THETAS, FRICTIONS, ETA = (1.0, 2.0, 4.0), (0.2, 0.3, 0.4), 0.85
RATIOS, DAMPINGS = (0.5, 0.7, 0.9), (0.0, 0.02, 0.1)
# Figure of the page of slip laws.
FIGURE = Path(__file__).parents[1] / "docs/slip_laws.png"
# Links, and step of time. The convergence is shown for one slip.
LINKS, STEP = 40, 5e-3
FINER_LINKS, FINER_STEPS = (20, 40, 80), (1e-2, 5e-3, 2.5e-3)
# A tip that has stuck for so long sticks for good: three periods of the slowest rod of the table.
REST, LONGEST = 1.0, 20.0
# End of Newton's iteration (L), and largest number of corrections.
CORRECTION, MOST_CORRECTIONS = 1e-11, 40
# Number of steps of time without friction and damping.
FREE_STEPS = 400
# Largest change of the energy without friction and damping, relative to the energy that the slip
# releases.
CONSERVED = 1e-6


@dataclass(frozen=True, kw_only=True)
class Motion:
    """State of a chain: positions and velocities of its points, and forces that hold them.

    Attributes
    ----------
    place, velocity : ndarray, shape (2, links)
        Ends of the links relative to the clamp, x in the first row.
    tension : ndarray, shape (links,)
        Forces in the links, divided by their length.
    tip : tuple of float
        Force of the surface on the tip: T towards +x, and N away from the surface.
    """

    place: np.ndarray
    velocity: np.ndarray
    tension: np.ndarray
    tip: tuple[float, float]


class SlipChain:
    """Chain of point masses, clamped upright, with its tip on the line y = eta.

    The energy of the springs is Σ k·(1 − cos of the turn), which is quadratic in the positions.
    """

    def __init__(self, theta, eta, links, damping=0.0):
        """Set up constant matrices; `damping` is the ratio of dampers to springs."""
        self.links, self.eta, self.h = links, eta, 1.0 / links
        d = 1 - (1 - 1 / theta) * self.h * np.arange(links + 1)
        spring = d[:-1] ** 4 / self.h
        # Half a link separates the clamp from the middle of the first link.
        spring[0] *= 2
        mass = self.h * d[1:] ** 2
        mass[-1] /= 2
        self.spring, self.mass = spring, np.tile(mass, 2)
        # Differences of neighbours: of positions along a link, and of the angles at a joint.
        self.difference = np.eye(links) - np.eye(links, k=-1)
        neighbours = np.diag(spring[1:], -1)
        elastic = -self.difference.T @ (neighbours + neighbours.T) @ self.difference / self.h**2
        self.elastic = np.kron(np.eye(2), elastic)
        self.clamp = np.zeros(2 * links)
        self.clamp[links] = spring[0] / self.h
        self.damping = damping * self.difference.T @ (spring[:, None] * self.difference)

    def energy(self, motion):
        """Energy of springs and masses (E·I0/L)."""
        place, velocity = motion.place.ravel(), motion.velocity.ravel()
        springs = self.spring.sum() + 0.5 * place @ self.elastic @ place - self.clamp @ place
        return springs + 0.5 * velocity @ (self.mass * velocity)

    def along(self, place):
        """Vectors along the links, shape (2, links)."""
        return place.reshape(2, -1) @ self.difference.T

    def by_place(self, x, y):
        """Matrix of the sums of x and y times the changes of the vectors along the links."""
        return np.hstack([x[:, None] * self.difference, y[:, None] * self.difference])

    def moved(self, motion, step, ratio):
        """Advance by one step of time; an infinite step gives the equilibrium.

        The tip slides with the friction T = −ratio·N, or is held if `ratio` is None.
        """
        n, still = self.links, np.isinf(step)
        before, speed = motion.place.ravel(), motion.velocity.ravel()
        inertia, share = (0 * self.mass, 1.0) if still else (2 * self.mass / step**2, 0.5)
        drift = 0 * speed if still else step * speed
        after = before + drift
        after[-1] = self.eta
        tension, (along, normal) = motion.tension, motion.tip
        x_tip, y_tip, lengths, laws = n - 1, 2 * n - 1, slice(2 * n, 3 * n), slice(3 * n, 3 * n + 2)
        for _ in range(MOST_CORRECTIONS):
            middle = share * after + (1 - share) * before
            x, y = self.along(middle)
            pull, turn = self.by_place(x, y), self.by_place(-y, x) / self.h**2
            resistance = 0 * self.elastic if still else turn.T @ self.damping @ turn / step
            force = self.clamp - self.elastic @ middle - tension @ pull
            force -= resistance @ (after - before)
            force[[x_tip, y_tip]] += along, -normal
            x, y = self.along(after)
            by_tension = self.difference.T @ (tension[:, None] * self.difference)
            matrix = np.zeros((3 * n + 2, 3 * n + 2))
            matrix[: 2 * n, : 2 * n] = (
                np.diag(inertia)
                + resistance
                + share * (self.elastic + np.kron(np.eye(2), by_tension))
            )
            matrix[: 2 * n, lengths] = pull.T
            matrix[[x_tip, y_tip], laws] = (-1.0, 0.0), (0.0, 1.0)
            matrix[lengths, : 2 * n] = self.by_place(x, y)
            matrix[-1, y_tip] = 1.0
            if ratio is None:
                matrix[-2, x_tip] = 1.0
                law = after[x_tip] - before[x_tip]
            else:
                matrix[-2, laws] = 1.0, ratio
                law = along + ratio * normal
            stretch = 0.5 * (x**2 + y**2 - self.h**2)
            balance = inertia * (after - before - drift) - force
            change = np.linalg.solve(
                matrix, np.concatenate([balance, stretch, [law, after[y_tip] - self.eta]])
            )
            after, tension = after - change[: 2 * n], tension - change[lengths]
            along, normal = along - change[-2], normal - change[-1]
            if np.abs(change[: 2 * n]).max() < CORRECTION:
                velocity = drift if still else 2 * (after - before) / step - speed
                return Motion(
                    place=after.reshape(2, n),
                    velocity=velocity.reshape(2, n),
                    tension=tension,
                    tip=(float(along), float(normal)),
                )
        raise RuntimeError("a step of time did not converge")


@dataclass(frozen=True, kw_only=True)
class Slip:
    """A slip of a chain.

    Attributes
    ----------
    onset, first, rest : float
        x0 at the onset, where the tip stops for the first time, and where it sticks for good (L);
        NaN if the tip lifts off.
    time : float
        Time from the onset to the last moment at which the tip slides.
    slides : int
        Number of slides in one direction.
    history : ndarray, shape (steps, 5)
        Time, x0 (L), T, N (E·I0/L²) and energy (E·I0/L) after each step.
    """

    onset: float
    first: float
    rest: float
    time: float
    slides: int
    history: np.ndarray

    @property
    def travel(self):
        """Distance from the onset to the place of rest, in units of x0 at the onset."""
        return 1 - self.rest / self.onset


@dataclass(frozen=True, kw_only=True)
class Case:
    """A slip to compute: rod, friction, its kinetic ratio κ, and damping ratio ζ."""

    theta: float
    mu0: float
    kappa: float
    zeta: float
    eta: float = ETA
    links: int = LINKS
    step: float = STEP


@cache
def slide_frequency(theta, eta, links):
    """First natural frequency of a chain at α = 0 with a tip that slides without friction."""
    curve = solve_curve(theta, eta)
    state = solve_state(theta, eta, curve.x1_init)

    def guess(s):
        return state.shape(s)[2], np.array([0.0, state.reaction_fy])

    chain, phi, load = chain_state(theta, links, curve.x1_init, eta, guess)
    return float(chain.frequencies(phi, load, 1, slides=True)[0])


def resting(chain, theta, eta, x0, ratio):
    """Return the equilibrium of a chain with fully mobilised friction, near a rod's state."""
    state = solve_state(theta, eta, solve_curve(theta, eta).x1_init - x0)
    x, y, _ = state.shape((np.arange(chain.links) + 1) / chain.links)
    begin = Motion(
        place=np.stack([x, y]),
        velocity=np.zeros((2, chain.links)),
        tension=np.zeros(chain.links),
        tip=(state.reaction_fx, -state.reaction_fy),
    )
    return chain.moved(begin, np.inf, ratio)


def stopped(chain, motion, longest, ratio):
    """Return the step within `longest` after which the tip of a sliding chain has no velocity."""

    def velocity(step):
        return chain.moved(motion, step, ratio).velocity[0, -1]

    shortest = 1e-6 * longest
    # A tip that starts to slide from rest may be pushed back at once.
    if velocity(shortest) * velocity(longest) > 0.0:
        return shortest
    return brentq(velocity, shortest, longest, xtol=1e-12)


def slip(case):
    """Let a chain slip from the onset until its tip sticks for good."""
    damping = 2 * case.zeta / slide_frequency(case.theta, case.eta, case.links)
    chain = SlipChain(case.theta, case.eta, case.links, damping)
    x0 = float(solve_curve(case.theta, case.eta).onset(case.mu0))
    motion = resting(chain, case.theta, case.eta, x0, case.mu0)
    unloaded = resting(chain, case.theta, case.eta, 0.0, 0.0).place[0, -1]
    # The tip slides towards +x or −x, or sticks: 1, −1, 0.
    time, last, way, stops = 0.0, 0.0, 1.0, []
    history = [(0.0, unloaded - motion.place[0, -1], *motion.tip, chain.energy(motion))]
    while time - last < REST and time < LONGEST:
        step, ratio = case.step, way * case.kappa * case.mu0 if way else None
        after = chain.moved(motion, step, ratio)
        if not way and abs(after.tip[0]) > case.mu0 * after.tip[1] > 0.0:
            way = -np.sign(after.tip[0])
            continue
        if after.velocity[0, -1] * way < 0.0:
            step = stopped(chain, motion, step, ratio)
            after = chain.moved(motion, step, ratio)
            stops.append(unloaded - after.place[0, -1])
            last, way = time + step, 0.0
        if after.tip[1] <= 0.0:
            stops = [np.nan]
            break
        motion, time = after, time + step
        last = time if way else last
        history.append((time, unloaded - motion.place[0, -1], *motion.tip, chain.energy(motion)))
    return Slip(
        onset=history[0][1],
        first=stops[0],
        rest=stops[-1],
        time=last,
        slides=len(stops),
        history=np.array(history),
    )


def travels_by_law(case):
    """Return the travel of a slip by each law, in units of x0 at the onset; NaN if it is lost."""
    response = response_of(case.theta, case.eta)
    onset = float(response.curve.onset(case.mu0))
    found = {}
    for law in SlipLaw:
        damping = case.zeta if law is SlipLaw.DAMPED else None
        model = SlipModel.of(law, case.kappa, damping)
        found[law.value] = steady_travel(response, case.mu0, model) / onset
    return found


@cache
def response_of(theta, eta):
    """Response of a rod."""
    (response,) = responses([MountedRod(theta=theta, eta=eta)])
    return response


def convergence():
    """Make a table of the travel of one slip over links and steps of time."""
    case = Case(theta=2.0, mu0=0.3, kappa=0.7, zeta=0.02)
    finer = [replace(case, links=links) for links in FINER_LINKS]
    finer += [replace(case, step=step) for step in FINER_STEPS]
    found = [(one.links, one.step, slip(one)) for one in finer]
    rows = [
        [str(links), f"{step:g}", f"{one.travel:.6f}", f"{one.time:.5f}"]
        for links, step, one in found
    ]
    return markdown_table(["links", "step of time", "travel / x0,slip", "time"], rows)


def largest_energy_error():
    """Return the largest relative change of the energy without friction and damping."""
    theta, mu0 = 2.0, 0.3
    curve = solve_curve(theta, ETA)
    onset = float(curve.onset(mu0))
    chain = SlipChain(theta, ETA, LINKS)
    motion = resting(chain, theta, ETA, onset, mu0)
    start, error = chain.energy(motion), 0.0
    for _ in range(FREE_STEPS):
        motion = chain.moved(motion, STEP, 0.0)
        error = max(error, abs(chain.energy(motion) - start))
    released = quad(lambda x: -float(curve.state(x).reaction_fx), 0.0, onset)[0]
    return error / released


def errors(rows, name):
    """Format mean and largest error of a law among the slips for which it has a result."""
    off = np.array([travels[name] - one.travel for _, one, travels in rows])
    off = np.abs(off[np.isfinite(off)])
    return f"{off.mean():.3f}, {off.max():.3f}" if len(off) else "–"


def report(rows):
    """Yield tables of the errors of the laws by κ and ζ, and of all slips."""
    yield "## Errors of the laws"
    yield (
        "Mean and largest error of the travel, in units of x0,slip, over θ and μ0. The law "
        "`damped` uses up all but e^(−2πζ) of the kinetic energy at the fastest moment."
    )
    head = ["κ", "ζ", *SlipLaw]
    groups = []
    for kappa, zeta in product(RATIOS, DAMPINGS):
        group = [one for one in rows if (one[0].kappa, one[0].zeta) == (kappa, zeta)]
        groups.append([f"{kappa:g}", f"{zeta:g}", *(errors(group, name) for name in SlipLaw)])
    yield markdown_table(head, [*groups, ["all", "all", *(errors(rows, name) for name in SlipLaw)]])
    yield "## All slips"
    yield (
        "Travel in units of x0,slip; time to the last slide in √(ρA0·L⁴/(E·I0)); number of slides."
    )
    head = ["θ", "μ0", "κ", "ζ", "dynamic", "time", "slides", *SlipLaw]
    yield markdown_table(
        head,
        [
            [*(f"{value:g}" for value in (case.theta, case.mu0, case.kappa, case.zeta))]
            + [f"{one.travel:.4f}", f"{one.time:.3f}", str(one.slides)]
            + [f"{travels[name]:.4f}" for name in SlipLaw]
            for case, one, travels in rows
        ],
    )


def draw(path):
    """Draw travel over κ, by dynamics and by the laws, and x0 over time in two slips."""
    plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(7, 2.9), layout="constrained")
    ratios = np.linspace(0.4, 0.95, 12)
    cases = [Case(theta=2.0, mu0=0.3, kappa=kappa, zeta=0.0) for kappa in ratios]
    for name, look in {"free": "k:", "kinetic": "C1-", "energy": "C0-"}.items():
        left.plot(ratios, [travels_by_law(case)[name] for case in cases], look, label=name)
    for zeta, color in ((0.0, "C0"), (0.1, "C2")):
        damped = [replace(case, zeta=zeta) for case in cases]
        label = f"dynamics, ζ = {zeta:g}"
        left.plot(ratios, [slip(one).travel for one in damped], "o", ms=3, color=color, label=label)
        if zeta:
            curve = [travels_by_law(one)["damped"] for one in damped]
            left.plot(ratios, curve, color=color, label=f"damped, ζ = {zeta:g}")
    left.set(xlabel="kinetic over static friction κ", ylabel="travel of a slip / $x_{0,slip}$")
    left.legend(frameon=False, fontsize=7)
    for kappa, color in ((0.8, "C0"), (0.4, "C1")):
        one = slip(Case(theta=2.0, mu0=0.3, kappa=kappa, zeta=0.02))
        time, x0 = one.history[:, 0], one.history[:, 1] / one.onset
        right.plot(time, x0, color=color, label=f"κ = {kappa:g}")
    right.axhline(0.0, color="k", lw=0.5, ls=":")
    right.set(
        xlabel="time / $\\sqrt{\\rho A_0 L^4/(E I_0)}$", ylabel="$x_0/x_{0,slip}$", xlim=(0, 1.5)
    )
    right.legend(frameon=False, fontsize=7)
    figure.savefig(path, dpi=160)


def main():
    """Let chains slip over θ, μ0, κ and ζ; write the record and the figure of the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--figure", action="store_true", help="draw the figure of the page")
    options = parser.parse_args()
    cases = [
        Case(theta=theta, mu0=mu0, kappa=kappa, zeta=zeta)
        for theta, mu0, kappa, zeta in product(THETAS, FRICTIONS, RATIOS, DAMPINGS)
    ]
    with ProcessPoolExecutor(options.jobs) as pool:
        slips, travels = pool.map(slip, cases), pool.map(travels_by_law, cases)
        rows = list(zip(cases, slips, travels, strict=True))
    error = largest_energy_error()
    kept = f"Without friction and damping the energy changes by {error:.1e} of the released energy."
    parts = ["## Convergence", convergence(), kept, *report(rows)]
    write_record("slip-dynamics", __doc__, "\n\n".join(parts))
    if options.figure:
        draw(FIGURE)
    print(parts[5])
    if not error < CONSERVED:
        sys.exit(f"energy changes by {error:.1e}; allowed: {CONSERVED:g}")
