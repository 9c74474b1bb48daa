"""A design and a study of the sensor agree on which slips can be seen, at the border."""

from itertools import product

import numpy as np
import pytest

from vibrissa.design.candidate import CLEARLY, limits_of
from vibrissa.design.pairs import survey
from vibrissa.design.requirements import Requirements
from vibrissa.outcomes import Method, ReadingStatus
from vibrissa.readings.reading import Bench, generator_of, read_once
from vibrissa.scanning.surfaces import constant
from vibrissa.sensor import Setup

MU0, LENGTH, PERIODS = 0.3, 0.1, 12
STEPS = 24  # of a period
PAIRS = list(product((1.0, 1.5, 2.0, 3.0, 4.0), (0.8, 0.9)))
STATED = {"transducer": "nano17-si-12-0.12", "modulus": "200 GPa", "length": "100 mm"}


def diameter_of(pair, seen):
    """Diameter at which the fall of a slip is `seen` times the least that is taken for a slip."""
    at = 5e-4
    asked = {"mu0": f"{MU0}", "step": "1 um", "yield_strain": 1.0, **STATED}
    shape = {"theta": f"{pair.curve.theta}", "eta": f"{pair.curve.eta}", "diameter": "0.5 mm"}
    limits = limits_of(Requirements.read(**asked, **shape), pair, at, LENGTH)
    (found,) = (float(one.value) for one in limits if one.name == "slips")
    # Forces and moments grow with the fourth power of the diameter.
    return at * (seen / found) ** 0.25


def part_found(pair, seen):
    """Part of the slips of a recording that the model of the rod finds; 0 if it is refused."""
    theta, eta, x0 = pair.curve.theta, pair.curve.eta, pair.shortest
    diameter = f"{1e3 * diameter_of(pair, seen)!r} mm"
    setup = Setup.read(theta=theta, eta=eta, diameter=diameter, assume=False, **STATED)
    dx0 = x0 / STEPS
    bench = Bench(
        setup=setup,
        surface=constant(MU0),
        dx0=dx0,
        to=[PERIODS * x0],
        cycles=None,
        law={"law": "free"},
        tip_radius=0.0,
        errors={},
    )
    point = {"theta": theta, "eta": eta, "seen": seen}
    (found,) = read_once(bench, [Method.MODEL], generator_of(point, 1, 1))
    assert found.periods_true >= PERIODS - 2
    if found.status is not ReadingStatus.READ:
        return 0.0
    return found.periods_read / found.periods_true


@pytest.fixture(scope="module")
def pairs():
    theta, eta = np.array(PAIRS).T
    return survey(theta, eta, np.array([MU0]), "point")


def test_slips_of_ten_rods_at_the_border_are_found(pairs):
    found = [part_found(pair, CLEARLY) for pair in pairs]
    assert min(found) > 0.8 and np.mean(found) > 0.97


def test_slips_of_ten_rods_far_below_the_border_are_missed(pairs):
    found = [part_found(pair, CLEARLY / 4.0) for pair in pairs]
    assert max(found) < 0.8 and np.mean(found) < 0.3
