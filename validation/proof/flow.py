"""Integration of the rod's equations from clamp to tip, with every error enclosed.

A rod leaves its clamp with the moment m0 and carries the contact force (fx, fy):

    φ' = m/B(s),   m' = fx·sin φ − fy·cos φ,   x' = cos φ,   y' = sin φ,
    φ(0) = π/2,   m(0) = m0,   x(0) = y(0) = 0,   B(s) = d(s)⁴,   d(s) = 1 − (1 − 1/θ)·s.

All numbers are balls of Arb, a midpoint and a radius: an operation on balls returns a ball that
contains the result for all numbers in these balls. A step from s to s + h has three parts [1]_:

1. Find a box that the solution does not leave on the step (`box_on_step`). Picard's theorem is the
   proof: the operator of the integrated equations maps the box into itself.
2. Take Taylor's polynomial of degree N − 1 at s. The same operator, applied to power series, gives
   its coefficients (`taylor`).
3. Add the remainder: h^N times the N-th coefficient at some place on the step. This coefficient
   lies in the N-th coefficient of the series that begins at the box of part 1.

The derivatives with respect to fx, fy and m0 obey the variational equations. They are integrated
along with the solution, in the same three parts. So are the second derivatives, if requested.

References
----------
.. [1] W. Tucker, *Validated Numerics: A Short Introduction to Rigorous Computations*, Princeton
   University Press, 2011.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations_with_replacement, pairwise
from typing import Any, NamedTuple

from flint import arb, arb_series, ctx

from validation.proof import NotProvedError

# Factor by which the box of a step is enlarged, and largest number of enlargements.
GROWTH, ATTEMPTS = 1.25, 40


@dataclass(frozen=True)
class Effort:
    """Accuracy of the integration, which affects only the radii of the results.

    Attributes
    ----------
    bits : int
        Precision of midpoints.
    order : int
        Order N of Taylor's method.
    steps : int
        Number of steps from the clamp to the tip.
    """

    bits: int = 128
    order: int = 32
    steps: int = 16

    @contextmanager
    def spent(self) -> Iterator[None]:
        """Set precision and length of power series, and restore them afterwards."""
        cap = ctx.cap
        ctx.cap = self.order + 1
        try:
            with ctx.workprec(self.bits):
                yield
        finally:
            ctx.cap = cap


class Section(NamedTuple):
    """Slope, moment and position of a cross-section; or the derivatives of these four.

    Each is a ball, or a power series in the arc length whose coefficients are balls.
    """

    phi: Any
    m: Any
    x: Any
    y: Any


# A section and its derivatives with respect to fx, fy and m0, in this order; then, if requested,
# its second derivatives with respect to `PAIRS` of these.
Sections = tuple[Section, ...]
Integral = Callable[[Any], Any]
PAIRS = tuple(combinations_with_replacement(range(3), 2))


class Load(NamedTuple):
    """Contact force and moment at the clamp."""

    fx: arb
    fy: arb
    m0: arb


class Shot(NamedTuple):
    """The integrated rod with a given load.

    Attributes
    ----------
    tip : Sections
    passed : list of Section
        For each step, a box that contains all sections on it.
    ends : list of Section
        For each step, the section at its end.
    """

    tip: Sections
    passed: list[Section]
    ends: list[Section]


class Vicinity(NamedTuple):
    """Loads near a central load: central load + multiple·direction + more.

    Attributes
    ----------
    shot : Shot
        The rod with the central load.
    direction : Load
    multiple : arb
        Ball of all multiples.
    more : Load
        Balls of all further deviations.
    """

    shot: Shot
    direction: Load
    multiple: arb
    more: Load


def shoot(
    theta: arb, load: Load, steps: int, vicinity: Vicinity | None = None, second: bool = False
) -> Shot:
    """Integrate a rod from its clamp to its tip.

    Parameters
    ----------
    theta : arb
        Taper factor.
    load : Load
        A load, or a box of them.
    steps : int
        Number of steps.
    vicinity : Vicinity, optional
        Loads of the box to which the result is restricted, which makes it narrower.
    second : bool, optional
        Whether to integrate the second derivatives, too.

    Returns
    -------
    Shot

    Raises
    ------
    NotProvedError
        If a step is too long.
    """
    inner = (place(theta, arb(k) / steps).mid() for k in range(steps))
    grid = [*inner, arb(1)]
    sections = at_clamp(load.m0, second)
    passed, ends = [], []
    for number, (s, next_s) in enumerate(pairwise(grid)):
        sections, box = step(theta, load, sections, s, next_s - s)
        if vicinity is not None:
            sections = narrowed(sections, vicinity.shot.ends[number], vicinity)
        passed.append(box[0])
        ends.append(sections[0])
    return Shot(tip=sections, passed=passed, ends=ends)


def narrowed(sections: Sections, middle: Section, vicinity: Vicinity) -> Sections:
    """Narrow sections with the mean value theorem.

    Parameters
    ----------
    sections : Sections
        Sections for a box of loads, with derivatives that hold everywhere in the box.
    middle : Section
        Section at the same place for the central load of the vicinity.
    vicinity : Vicinity

    Returns
    -------
    Sections
    """
    first, of_fx, of_fy, of_m0, *_ = sections
    changes = (
        sum((d * t for d, t in zip(of_load, vicinity.direction, strict=True)), arb(0))
        * vicinity.multiple
        + sum((d * m for d, m in zip(of_load, vicinity.more, strict=True)), arb(0))
        for of_load in zip(of_fx, of_fy, of_m0, strict=True)
    )
    known = zip(first, middle, changes, strict=True)
    narrow = Section(*(wide.intersection(value + change) for wide, value, change in known))
    return narrow, *sections[1:]


def diameter(theta: arb, s: arb) -> arb:
    """Return the diameter at an arc length, in units of that at the clamp."""
    return 1 - (1 - 1 / theta) * s


def place(theta: arb, share: arb) -> arb:
    """Return the arc length after a share of the steps, which are equal steps of 1/√d.

    So steps are shorter towards the thin end, which bends more. A proof may use any steps; these
    had the smallest errors.
    """
    root = theta.sqrt()
    inverse = 1 + (root - 1) * share
    return theta * share * (inverse + 1) / ((root + 1) * inverse**2)


def at_clamp(m0: arb, second: bool = False) -> Sections:
    """Return the section at the clamp, of which only the moment varies, and its derivatives."""
    zero, one = arb(0), arb(1)
    fixed = Section(zero, zero, zero, zero)
    first = Section(arb.pi() / 2, m0, zero, zero), fixed, fixed, fixed._replace(m=one)
    return first + len(PAIRS) * (fixed,) if second else first


def step(theta: arb, load: Load, start: Sections, s: arb, h: arb) -> tuple[Sections, Sections]:
    """Integrate over one step.

    Parameters
    ----------
    theta : arb
    load : Load
    start : Sections
        Sections at the start of the step.
    s, h : arb
        Arc length at the start of the step, and length of the step.

    Returns
    -------
    end, box : Sections
        Sections at the end of the step, and a box for the whole step.

    Raises
    ------
    NotProvedError
        If the step is too long.
    """
    slope = 1 - 1 / theta
    thickness, thickness_on_step = diameter(theta, s), diameter(theta, s + arb(0).union(h))
    box = box_on_step(start, load, thickness_on_step, h)
    known = taylor(start, load, thickness, slope)
    rest = taylor(box, load, thickness_on_step, slope)
    return _each(lambda series, last: _sum(series, last, h), known, rest), box


def _sum(known: arb_series, rest: arb_series, h: arb) -> arb:
    """Sum Taylor's polynomial of `known` and the term of order N of `rest`."""
    order = ctx.cap - 1
    value = rest[order]
    for k in reversed(range(order)):
        value = value * h + known[k]
    return value


def _each(function: Callable[..., Any], *sections: Sections) -> Sections:
    """Apply a function to each number of sections."""
    return tuple(Section(*map(function, *parts)) for parts in zip(*sections, strict=True))


def picard(
    start: Sections, guess: Sections, load: Load, compliance: Any, integral: Integral
) -> Sections:
    """Apply Picard's operator: integrate the equations once, with a guess on the right-hand sides.

    The solution is the only fixed point. The new m is used for φ at once, so that a power series of
    φ gains two terms each time.

    Parameters
    ----------
    start : Sections
        Sections at the start of the step.
    guess : Sections
        Power series, or boxes for the whole step.
    load : Load
    compliance : arb_series or arb
        1/B, of the same kind as the guess.
    integral : callable
        Maps a power series, or a box, to its integral from the start of the step.

    Returns
    -------
    Sections
    """
    found = []
    for begin, rate in zip(start, rates(guess, load), strict=True):
        moment = begin.m + integral(rate.m)
        found.append(
            Section(
                phi=begin.phi + integral(compliance * moment),
                m=moment,
                x=begin.x + integral(rate.x),
                y=begin.y + integral(rate.y),
            )
        )
    return tuple(found)


def rates(sections: Sections, load: Load) -> Sections:
    """Evaluate the right-hand sides of the equations, and of the variational equations.

    With P = fx·sin φ − fy·cos φ and H = ∂P/∂φ = fx·cos φ + fy·sin φ, and with indices i and j for
    derivatives with respect to components of the load,

        P_i  = H·φ_i + d_i,                                    d = (sin φ, −cos φ, 0),
        P_ij = H·φ_ij − P·φ_i·φ_j + e_i·φ_j + e_j·φ_i,         e = (cos φ, sin φ, 0).

    Parameters
    ----------
    sections : Sections
        Power series or boxes.
    load : Load

    Returns
    -------
    Sections
        Their derivatives with respect to the arc length, with B·φ' = m in the place of φ'.
    """
    (phi, m, _, _), *others = sections
    tangents, curvatures = others[:3], others[3:]
    fx, fy, _ = load
    sin, cos = phi.sin_cos()
    pull, hold = fx * sin - fy * cos, fx * cos + fy * sin
    found = [Section(m, pull, cos, sin)]
    # The force appears in m' itself; the clamp moment only in the section at the clamp.
    for tangent, direct in zip(tangents, (sin, -cos, 0), strict=True):
        found.append(
            Section(
                phi=tangent.m,
                m=hold * tangent.phi + direct,
                x=-(sin * tangent.phi),
                y=cos * tangent.phi,
            )
        )
    # Without second derivatives there are no curvatures.
    turned = cos, sin, 0
    for curvature, (i, j) in zip(curvatures, PAIRS, strict=False):
        one, other = tangents[i].phi, tangents[j].phi
        both = one * other
        found.append(
            Section(
                phi=curvature.m,
                m=hold * curvature.phi - pull * both + turned[i] * other + turned[j] * one,
                x=-(sin * curvature.phi) - cos * both,
                y=cos * curvature.phi - sin * both,
            )
        )
    return tuple(found)


def taylor(start: Sections, load: Load, thickness: arb, slope: arb) -> Sections:
    """Find the power series of the solution, up to the order N (`Effort.order`).

    Parameters
    ----------
    start : Sections
    load : Load
    thickness, slope : arb
        Diameter at the start of the series, in units of the diameter at the clamp, and its decrease
        per arc length.

    Returns
    -------
    Sections
        Sections of power series.
    """
    root = arb_series([thickness, -slope]).inv()
    square = root * root
    compliance = square * square
    guess = _each(lambda value: arb_series([value], prec=1), start)
    # `prec` is the number of known terms of a series; x and y are the last to be complete.
    while guess[0].x.prec < ctx.cap:
        guess = picard(start, guess, load, compliance, arb_series.integral)
    return guess


def box_on_step(start: Sections, load: Load, thickness: arb, h: arb) -> Sections:
    """Find a box that contains the solution on a whole step.

    Parameters
    ----------
    start : Sections
    load : Load
    thickness : arb
        Diameters on the step, in units of the diameter at the clamp.
    h : arb
        Length of the step.

    Returns
    -------
    Sections
        A box for which `holds` is true.

    Raises
    ------
    NotProvedError
        If no such box is found.
    """
    box = start
    for _ in range(ATTEMPTS):
        box = _each(_larger, integrated_once(start, box, load, thickness, h))
        if holds(start, box, load, thickness, h):
            return box
    raise NotProvedError("no box contains the rod on a step; more steps are needed")


def holds(start: Sections, box: Sections, load: Load, thickness: arb, h: arb) -> bool:
    """Whether Picard's operator maps a box into itself: then the box contains the solution."""
    inside = integrated_once(start, box, load, thickness, h)
    return all(
        whole.contains(part)
        for wholes, parts in zip(box, inside, strict=True)
        for whole, part in zip(wholes, parts, strict=True)
    )


def integrated_once(start: Sections, box: Sections, load: Load, thickness: arb, h: arb) -> Sections:
    """Apply Picard's operator to a box: an integral is a length up to h times a value in it."""
    lengths = arb(0).union(h)
    return picard(start, box, load, thickness**-4, lambda values: lengths * values)


def _larger(ball: arb) -> arb:
    return arb(ball.mid(), ball.rad() * GROWTH)
