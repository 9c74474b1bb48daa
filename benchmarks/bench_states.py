"""How fast equilibrium states are found, by several methods on the same curve, and how well.

Run by `python -m validation bench`, which prints the table. Each benchmark notes how many
states it finds in a round and how far their forces are from converged ones.
"""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from vibrissa import solve_state
from vibrissa.mechanics.equations import largest_residual
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving import shooting
from vibrissa.sticking.solving.beginning import begin
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.sticking.solving.cutting import cut, guessed
from vibrissa.sticking.solving.following import CLOSENESS, follow
from vibrissa.sticking.solving.refinement import STATES_ALONG_PART, StatesAlongParts

THETA, ETA, MU0, DX0 = 2.0, 0.85, 0.4, 0.001
# Steps of one period of sticking; the slow methods take every so manyth.
STEPS = 52
STRIDE = 4
RANDOM_CURVES = 256
# States at equal steps of x0 along each of the random curves, up to where −tan α has fallen.
STATES = 200
# Nodes along these rods, and Chebyshev points along their curves: so many as tell what inverses are
# needed, and as many as the states at the steps can be interpolated from.
NODES, FEW, ENOUGH = 40, STATES_ALONG_PART[0], 41


def has_locked(branches, knots):
    """Whether −tan α falls."""
    states, change = knots.states, knots.change
    return change[:, -3] * states.fy < states.fx * change[:, -2]


@pytest.fixture(scope="module")
def curve():
    return solve_curves(np.array([THETA]), np.array([ETA]))[0]


@pytest.fixture(scope="module")
def converged(curve):
    """Forces at the steps, each solved by itself on its own number of nodes."""
    x1 = [curve.x1_init - DX0 * k for k in range(STEPS + 1)]
    return np.array([solve_state(THETA, ETA, offset).f for offset in x1])


def note(benchmark, states, force, expected):
    benchmark.extra_info["states"] = states
    benchmark.extra_info["error"] = float(np.abs(np.array(force) / expected - 1.0).max())


def test_collocation_random_curves(benchmark):
    random = np.random.default_rng(1)
    theta, eta = random.uniform(1, 4, RANDOM_CURVES), random.uniform(0.7, 0.95, RANDOM_CURVES)
    curves = benchmark.pedantic(solve_curves, (theta, eta), rounds=5, warmup_rounds=1)
    force, expected = [], []
    for c in curves:
        x0 = 0.6 * c.x0_lock
        force.append(float(c.state(x0).f))
        expected.append(solve_state(c.theta, c.eta, c.x1_init - x0).f)
    note(benchmark, sum(curve.pieces.states.x0.size for curve in curves), force, expected)


def test_states_on_random_curves(benchmark):
    """States at steps along curves, interpolated from few of each, and the residual of each asked.

    What `solve_curves` does besides, locating lock and end and looking at stability and reach, is
    left out, as the other methods do not do it.
    """
    random = np.random.default_rng(1)
    theta, eta = random.uniform(1, 4, RANDOM_CURVES), random.uniform(0.7, 0.95, RANDOM_CURVES)
    position = np.linspace(0.0, 1.0, STATES)

    def run():
        rods = rod_columns(theta, [IDEAL] * RANDOM_CURVES)
        begun = begin(rods, eta, np.zeros(RANDOM_CURVES), CLOSENESS[0].nodes, Contact.POINT)
        branches, side = begun.branches, np.ones(RANDOM_CURVES)
        first = branches, begun.states, side
        followed = follow(*first, Contact.POINT, has_locked, CLOSENESS[0].longest)
        parts = cut(branches, followed, side)
        guess = guessed(parts, branches, followed.knots, FEW)
        path = StatesAlongParts(parts=parts, unknowns=guess).on_nodes(NODES)
        for count in (FEW, ENOUGH):
            path = path.with_states(count).solved()
        found = path.at(position).states
        return branches, parts, found, largest_residual(found, parts.closing_at(position))

    branches, parts, found, residual = benchmark.pedantic(run, rounds=5, warmup_rounds=1)
    good = residual <= 1e-12
    at = 120
    force = np.hypot(found.fx, found.fy).reshape(-1, STATES)[:, at]
    offset = branches.x1_init - position[at] * parts.length
    expected = [solve_state(*pair).f for pair in zip(theta, eta, offset, strict=True)]
    note(benchmark, int(good.sum()), force, expected)


def test_collocation_one_curve(benchmark, converged):
    def run():
        return solve_curves(np.array([THETA]), np.array([ETA]))[0]

    found = benchmark.pedantic(run, rounds=5, warmup_rounds=1)
    states = found.pieces.states.x0.size
    note(benchmark, states, found.state(DX0 * np.arange(STEPS + 1)).f, converged)


def test_solve_bvp(benchmark, curve, converged):
    """SciPy's collocation (tol 1e-8) along the period, each state from the one before."""
    s = np.linspace(0.0, 1.0, 21)

    def derivative(s, y, p):
        d = 1.0 - (1.0 - 1.0 / THETA) * s
        return np.stack(
            [np.cos(y[2]), np.sin(y[2]), y[3] / d**4, p[0] * np.sin(y[2]) - p[1] * np.cos(y[2])]
        )

    def run():
        force, first = [], solve_state(THETA, ETA, curve.x1_init)
        x, y, phi = first.shape(s)
        moment = np.gradient(phi, s) * (1.0 - (1.0 - 1.0 / THETA) * s) ** 4
        mesh, guess, load = s, np.stack([x, y, phi, moment]), [first.reaction_fx, first.reaction_fy]
        for k in range(0, STEPS + 1, STRIDE):
            offset = curve.x1_init - DX0 * k

            def ends(a, b, p, offset=offset):
                return np.array([a[0], a[1], a[2] - np.pi / 2, b[0] - offset, b[1] - ETA, b[3]])

            found = solve_bvp(derivative, ends, mesh, guess, p=load, tol=1e-8, max_nodes=20000)
            mesh, guess, load = found.x, found.y, found.p
            force.append(np.hypot(*found.p) if found.success else np.nan)
        return force

    force = benchmark.pedantic(run, rounds=3, warmup_rounds=0)
    note(benchmark, len(force), force, converged[::STRIDE])


def test_paper(benchmark, converged):
    """The paper's own method at MATLAB's default tolerances, one period of sticking."""

    def run():
        return shooting.walk(THETA, ETA, DX0, MU0, tolerances=shooting.PAPER)

    states = benchmark.pedantic(run, rounds=1, warmup_rounds=0)[: STEPS + 1]
    note(benchmark, len(states), [state.f for state in states], converged[: len(states)])


OCTAVE = """
theta = 2; eta = 0.85; dx0 = 0.001; steps = 52;
function [miss, state] = shot(f, alpha, x1, y1, x0, theta)
  rhs = @(s, z) [cos(z(3)); sin(z(3)); f * (cos(alpha) * (z(1) - x1) + sin(alpha) * (z(2) - y1)) ...
      / (1 - (1 - 1 / theta) * s)^4];
  [~, z] = ode45(rhs, [0 1], [x0; 0; pi / 2]);
  state = z(end, :); miss = hypot(state(1) - x1, state(2) - y1);
end
p = fminsearch(@(p) shot(p(1), 0, p(2), eta, 0, theta), [1.16 0.42]);
x1 = p(2); q = [p(1) 0]; printf("%.12g\\n", q(1));
for k = 1:steps
  q = fminsearch(@(q) shot(q(1), q(2), x1, eta, k * dx0, theta), q);
  printf("%.12g\\n", q(1));
end
"""


@pytest.mark.skipif(not shutil.which("octave-cli"), reason="octave-cli is not installed")
def test_octave(benchmark, converged):
    """The same in GNU Octave."""

    def run():
        command = ["octave-cli", "--quiet", "--eval", OCTAVE]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    force = [float(line) for line in benchmark.pedantic(run, rounds=1).split()]
    note(benchmark, len(force), force, converged[: len(force)])


@pytest.mark.skipif("AUTO_DIR" not in os.environ, reason="AUTO_DIR does not say where AUTO-07p is")
def test_auto(benchmark, curve, tmp_path):
    """AUTO-07p follows the whole planar curve; the time is that of its compiled program alone."""
    for source in Path(__file__).with_name("auto").iterdir():
        shutil.copy(source, tmp_path)
    command = [Path(os.environ["AUTO_DIR"], "bin", "auto"), "whisker.auto"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    # What the program reads: where the curve starts, and how it is to be followed.
    shutil.copy(tmp_path / "s.upright", tmp_path / "fort.3")
    shutil.copy(tmp_path / "c.curve", tmp_path / "fort.2")
    found = tmp_path / "fort.7"

    def run():
        found.unlink(missing_ok=True)
        subprocess.run([tmp_path / "whisker.exe"], cwd=tmp_path, capture_output=True, check=True)
        rows = [line.split() for line in found.read_text().splitlines()]
        # Points: rows that begin with the number of their branch; 4: offset, 11: size of force.
        return np.array([[row[4], row[11]] for row in rows if row[0] != "0"], dtype=float)

    offset, force = benchmark.pedantic(run, rounds=5, warmup_rounds=1).T
    # Up to where −tan α has its maximum: of the offsets beyond there are several states.
    few = np.flatnonzero(curve.x1_init - offset < curve.x0_lock)[::4]
    expected = [solve_state(THETA, ETA, value).f for value in offset[few]]
    note(benchmark, len(force), force[few], expected)
    benchmark.extra_info["states"] = len(force)
