"""The integration encloses: closed forms, tangents, and boxes that are too small."""

import random

import pytest
from flint import arb

from vibrissa.errors import ArgumentError, NotProvedError
from vibrissa.proof.flow import Effort, Load, at_clamp, box_on_step, holds, shoot, step

QUICK = Effort(bits=96, order=16, steps=16)
LOAD = Load(arb(-0.9), arb(-2.3), arb(-0.05))


@pytest.fixture(autouse=True)
def _precision():
    with QUICK.spent():
        yield


@pytest.mark.parametrize("theta", [1, 2, 5])
def test_without_a_force_the_rod_bends_as_its_compliance_says(theta):
    m0 = arb(1) / 4
    (tip, *_), _ = shoot(arb(theta), Load(arb(0), arb(0), m0), 40)
    c = 1 - arb(1) / theta
    compliance = (arb(theta) ** 3 - 1) / (3 * c) if theta > 1 else arb(1)
    assert tip.phi.contains(arb.pi() / 2 + m0 * compliance)
    assert tip.phi.rad() < 1e-15
    assert tip.m.contains(m0)


def test_a_circle():
    m0 = arb(3) / 4
    (tip, *_), _ = shoot(arb(1), Load(arb(0), arb(0), m0), 8)
    assert tip.y.overlaps(m0.sin() / m0) and tip.x.overlaps((m0.cos() - 1) / m0)
    assert tip.y.rad() < 1e-15


def test_a_box_of_loads_holds_what_becomes_of_each():
    theta, width = arb(2), 1e-3
    (wide, *_), boxes = shoot(theta, Load(*(arb(v.mid(), width) for v in LOAD)), 16)
    draw = random.Random(1)
    for _ in range(3):
        load = Load(*(v + draw.uniform(-width, width) for v in LOAD))
        (tip, *_), passed = shoot(theta, load, 16)
        assert all(whole.contains(part) for whole, part in zip(wide, tip, strict=True))
        assert all(
            whole.overlaps(part)
            for sections in zip(boxes, passed, strict=True)
            for whole, part in zip(*sections, strict=True)
        )


@pytest.mark.parametrize("which", [0, 1, 2])
def test_tangents_are_derivatives(which):
    """By the mean value theorem a difference quotient is a derivative between its two places."""
    theta, width = arb(2), arb(2) ** -20
    other = LOAD._replace(**{Load._fields[which]: LOAD[which] + width})
    between = LOAD._replace(**{Load._fields[which]: LOAD[which].union(other[which])})
    first, second, all_ = (shoot(theta, load, 16).tip for load in (LOAD, other, between))
    for a, b, tangent in zip(first[0], second[0], all_[which + 1], strict=True):
        quotient = (b - a) / width
        assert quotient.overlaps(tangent)
        assert tangent.rad() < 1e-3 and quotient.rad() < 1e-6


def test_less_is_left_open_with_more_steps():
    coarse, fine = (shoot(arb(3), LOAD, steps).tip[0] for steps in (8, 24))
    for rough, exact in zip(coarse, fine, strict=True):
        assert rough.overlaps(exact) and exact.rad() < rough.rad() / 100


def shrunken(sections, share):
    """Draw the boxes of φ and m in, keeping their middles."""
    first, *others = sections
    narrow = {name: arb(b.mid(), b.rad() * share) for name, b in first._asdict().items()}
    return first._replace(phi=narrow["phi"], m=narrow["m"]), *others


def test_a_box_that_is_too_small_is_caught():
    start, h = at_clamp(LOAD.m0), arb(1) / 16
    thickness = 1 - (arb(0).union(h)) / 2
    box = box_on_step(start, LOAD, thickness, h)
    assert holds(start, box, LOAD, thickness, h)
    assert not holds(start, shrunken(box, 0.5), LOAD, thickness, h)
    assert not holds(start, start, LOAD, thickness, h)
    # A box of a shorter step, too.
    short = box_on_step(start, LOAD, thickness, h / 4)
    assert not holds(start, short, LOAD, thickness, h)


def test_a_step_that_is_too_long_is_refused():
    with pytest.raises(NotProvedError, match="more steps"):
        step(arb(2), Load(arb(-40), arb(-60), arb(-20)), at_clamp(arb(-20)), arb(0), arb(1))


@pytest.mark.parametrize("wrong", [{"bits": 8}, {"order": 1}, {"steps": 0}])
def test_what_is_no_effort_is_refused(wrong):
    with pytest.raises(ArgumentError, match="at least 32 bits"):
        Effort(**wrong)
