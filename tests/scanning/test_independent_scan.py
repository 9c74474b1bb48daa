"""Scans over random patches and stripes against a scan that shares no code with the package."""

from functools import cache

import numpy as np
import pytest

import independent_scan
from responses import by_law, respond
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate

# θ, η; φ1 and force near those at α = 0; a range of x0 from beyond the end of pulling to beyond
# the lock.
RODS = ((2.0, 0.85, (0.55, 1.16), -0.0268, 0.16), (1.0, 0.8, (0.66, 2.75), -0.0116, 0.125))


@cache
def rods(number):
    theta, eta, *rest = RODS[number]
    return respond(theta, eta), independent_scan.Rod.solved(theta, eta, *rest)


def surface(random, x1_init):
    """Edges and friction of random patches, with stripes of all widths upon them."""
    edges = x1_init + np.cumsum(random.uniform(0.002, 0.08, 12))
    mu0 = random.uniform(0.05, 0.42, 13)
    for begin in random.uniform(edges[0], edges[-1], random.integers(0, 5)):
        stop = begin + 10.0 ** random.uniform(-7.0, -2.0)
        if np.searchsorted(edges, begin) == np.searchsorted(edges, stop):
            at = int(np.searchsorted(edges, begin))
            # Sometimes a stripe holds the tip until it locks.
            rough = random.uniform(0.05, 0.45) if random.random() < 0.8 else random.uniform(0.5, 2)
            edges = np.insert(edges, at, [begin, stop])
            mu0 = np.insert(mu0, at + 1, [rough, mu0[at]])
    return edges, mu0


def path(random):
    step = random.uniform(0.001, 0.005)
    turn = random.uniform(0.15, 0.3)
    forth = np.arange(0.0, turn, step)
    if random.random() < 0.5:
        return forth
    return np.append(forth, np.arange(forth[-1] - step, forth[-1] - 0.1, -step))


def compared(seed, number):
    """Run both scans with one rod; how far apart they are, and how many slips there were."""
    random = np.random.default_rng(seed)
    response, rod = rods(number)
    edges, mu0 = surface(random, rod.x1_init)
    positions = path(random)
    law = ("kinetic", "energy", "free")[int(random.choice(3, p=[0.4, 0.5, 0.1]))]
    ratio = random.uniform(0.4, 0.95)
    zeta = 0.0
    if law == "energy" and seed % 3:
        law, zeta = "damped", 0.4 * random.random() ** 2
    expected = independent_scan.scan(rod, edges, mu0, positions, law, ratio, zeta)
    patched = surfaces.patches([rod.x1_init - 1.0, *edges], mu0)
    found = simulate(response, patched, positions, by_law(law, ratio, zeta))
    n = len(expected.contact)
    assert found.outcome == expected.outcome or expected.outcome == "lock", seed
    # A locked tip sticks on beyond the states that are known here.
    assert len(found) == n or (expected.outcome == "lock" and len(found) > n), seed
    assert (found.period[:n] == expected.period).all(), seed
    check_periods(found.periods, expected, rod, law)
    return np.abs(found.contact[:n] - expected.contact).max(), int(expected.period[-1]) - 1


def check_periods(periods, expected, rod, law):
    """Compare the columns of the periods that end with a slip."""
    n = len(expected.slips)
    periods = periods.take(slice(n))
    _, clamp, x0, x0_rest, mu = expected.slips.T
    assert (periods.ends_by == "slip").all() and (periods.slip == clamp).all()
    steps = np.bincount(expected.period)[1 : n + 1]
    assert (periods.steps == steps - 1).all()
    assert periods.mu0 == pytest.approx(mu, abs=1e-12)
    assert periods.x0_rest == pytest.approx(x0_rest, abs=1e-9)
    assert periods.slip_length == pytest.approx(np.abs(x0 - x0_rest), abs=1e-9)
    pushed = np.flatnonzero(x0 > rod.pull)
    onsets = [independent_scan.onset(rod, *row) for row in expected.slips[pushed][:, [0, 2, 4]]]
    assert periods.x0_onset[pushed] == pytest.approx(onsets, abs=1e-10)
    assert periods.onset[pushed] == pytest.approx(clamp[pushed] + onsets - x0[pushed], abs=1e-10)
    assert periods.apparent_friction[pushed] == pytest.approx(mu[pushed], abs=1e-9)
    q, p = rod.q(x0_rest), rod.p(x0_rest)
    assert periods.loads_rest[:, :2] == pytest.approx(np.stack([-q, -p], axis=1), abs=1e-8)
    work = rod.q.integ()
    released = work(np.maximum(x0, rod.pull)) - work(x0_rest)
    assert periods.released == pytest.approx(released, abs=1e-10)
    if law == "energy":
        assert periods.dissipated == pytest.approx(periods.released, abs=1e-9)
    if law == "damped":
        assert (periods.dissipated <= periods.released + 1e-9).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seeds", "least"),
    [(range(100, 104), 100), pytest.param(range(104, 112), 200, marks=pytest.mark.nightly)],
)
def test_random_scans_are_those_of_an_independent_scan(seeds, least):
    error, slips = zip(*(compared(seed, seed % len(RODS)) for seed in seeds), strict=True)
    assert max(error) < 1e-6
    assert sum(slips) > least
