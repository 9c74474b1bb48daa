"""The integration encloses: closed forms, tangents, and boxes that are too small."""

import random

import pytest
from flint import arb

from validation.proof import NotProvedError
from validation.proof.flow import Load, Vicinity, at_clamp, box_on_step, holds, shoot, step

LOAD = Load(arb(-0.9), arb(-2.3), arb(-0.05))


@pytest.mark.parametrize("theta", [1, 2, 5])
def test_without_a_force_the_rod_bends_as_its_compliance_says(theta):
    m0 = arb(1) / 4
    tip = shoot(arb(theta), Load(arb(0), arb(0), m0), 40).tip[0]
    c = 1 - arb(1) / theta
    compliance = (arb(theta) ** 3 - 1) / (3 * c) if theta > 1 else arb(1)
    assert tip.phi.contains(arb.pi() / 2 + m0 * compliance)
    assert tip.phi.rad() < 1e-15
    assert tip.m.contains(m0)


def test_a_circle():
    m0 = arb(3) / 4
    tip = shoot(arb(1), Load(arb(0), arb(0), m0), 8).tip[0]
    assert tip.y.overlaps(m0.sin() / m0) and tip.x.overlaps((m0.cos() - 1) / m0)
    assert tip.y.rad() < 1e-15


def test_a_box_of_loads_holds_what_becomes_of_each():
    theta, width = arb(2), 1e-3
    whole_box = shoot(theta, Load(*(arb(v.mid(), width) for v in LOAD)), 16)
    wide, boxes = whole_box.tip[0], whole_box.passed
    draw = random.Random(1)
    for _ in range(3):
        load = Load(*(v + draw.uniform(-width, width) for v in LOAD))
        one = shoot(theta, load, 16)
        tip, passed = one.tip[0], one.passed
        assert all(whole.contains(part) for whole, part in zip(wide, tip, strict=True))
        assert all(
            whole.overlaps(part)
            for sections in zip(boxes, passed, strict=True)
            for whole, part in zip(*sections, strict=True)
        )


def test_a_vicinity_is_narrower_than_its_box_and_holds_its_loads():
    theta, length = arb(2), arb(2) ** -8
    middle = Load(*(v.mid() for v in LOAD))
    direction = Load(arb(1), arb(1.3), arb(-0.5))
    more = Load(arb(0), arb(0, 1e-5), arb(0, 1e-5))
    multiple = arb(0, length)
    parts = list(zip(middle, direction, more, strict=True))
    box = Load(*(m + d * multiple + e for m, d, e in parts))
    vicinity = Vicinity(shoot(theta, middle, 16), direction, multiple, more)
    narrow, wide = shoot(theta, box, 16, vicinity).tip[0], shoot(theta, box, 16).tip[0]
    assert narrow.m.rad() < wide.m.rad() / 2
    for share in (-1, 0.3, 1):
        load = Load(*(m + d * length * share + e.upper() * share for m, d, e in parts))
        tip = shoot(theta, load, 16).tip[0]
        assert all(whole.overlaps(part) for whole, part in zip(narrow, tip, strict=True))
        assert narrow.m.contains(tip.m) and narrow.y.contains(tip.y)


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
