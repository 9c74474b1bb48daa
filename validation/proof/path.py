"""Equilibrium paths from the state α = 0 on, proved: which onset of slip is the first.

Along the path the horizontal force fx falls from 0, and each fx has one equilibrium. So the path is
covered by tubes, each for an interval of fx: the load lies near a straight line,

    (fx, fy, m0) = centre + (fx − centre.fx)·(1, a, b) + a little more,

and Krawczyk's test proves, for all fx of the interval at once, that exactly one load in the tube is
an equilibrium. Where two tubes meet, their equilibria at a common fx are the same: a small box that
holds that of the one lies in the other. On a tube the derivatives along the path are enclosed, and
their signs tell whether the clamp advances, and whether −tan α rises. Where −tan α has its maximum,
and the sign of its derivative is open, the next derivative tells that it has no other one there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from flint import arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.critical import turning
from validation.proof.equilibrium import Equilibrium, Rod
from validation.proof.flow import Load, Shot, Vicinity, shoot
from validation.proof.krawczyk import inside, middle_inverse, operator

# A tube is made so many times as wide as what was found in it.
SLACK = 2
# Attempts at a tube's width.
ATTEMPTS = 4
# Length of the first tube, of the shortest, and of the shortest that is sought where it is open
# whether −tan α rises; relative to the force at α = 0.
FIRST, SHORTEST, OPEN = 2.0**-6, 2.0**-20, 2.0**-12
# How much longer the next tube may be, and how far two of them overlap.
LONGER, OVERLAP = 1.25, 2.0**-6
# How often Krawczyk's operator is applied to narrow a tube.
REPEATED = 4
# Newton's corrections of a centre.
CORRECTIONS = 6
# Nothing to be added to a load.
NOTHING = Load(arb(0), arb(0), arb(0))


class Line(NamedTuple):
    """A straight line in the space of loads; its direction has 1 for fx.

    Attributes
    ----------
    centre, direction : Load
    """

    centre: Load
    direction: Load

    def at(self, way: arb, more: Load = NOTHING) -> Load:
        """Return the loads whose fx is that of the centre and `way`; and what may be added."""
        return Load(*(c + d * way + m for c, d, m in zip(*self, more, strict=True)))


@dataclass(frozen=True, kw_only=True)
class Tube:
    """A part of an equilibrium path: for each fx in it exactly one equilibrium.

    Attributes
    ----------
    line : Line
    reach : arb
        How far fx may be from that of the centre.
    more : Load
        Balls around zero: how far loads of the tube may be from the line.
    last : Load
        Enclosure of the equilibrium where the tube ends, at the fx farthest from α = 0.
    mu : arb
        −tan α of the equilibria.
    rise, advance : arb
        Derivatives of −tan α and of x0 with respect to −fx.
    bend : arb or None
        Where the sign of `rise` is open: derivative of `turning` with respect to fx.
    """

    line: Line
    reach: arb
    more: Load
    last: Load
    mu: arb
    rise: arb
    advance: arb
    bend: arb | None

    def on_line(self, fx: arb) -> Load:
        """Return the load of an fx on the line."""
        return self.line.at(fx - self.line.centre.fx)

    def holds(self, load: Load) -> bool:
        """Whether all loads of a box lie in the tube: proved, if true."""
        if not abs(load.fx - self.line.centre.fx) <= self.reach:
            return False
        _, fy, m0 = self.on_line(load.fx)
        return self.more.fy.contains(load.fy - fy) and self.more.m0.contains(load.m0 - m0)

    def meets(self, other: "Tube") -> bool:
        """Whether the other tube goes on where this one ends: proved, if true."""
        return other.holds(self.last)


@dataclass(frozen=True, kw_only=True)
class Path:
    """An equilibrium path from the state α = 0 on.

    Attributes
    ----------
    tubes : list of Tube
        In order; neighbours meet.
    """

    tubes: list[Tube]

    def slips_first(self, slip: Equilibrium) -> bool:
        """Whether a state is on the path, and the first with its −tan α: proved, if true."""
        for tube in self.tubes:
            if not (tube.rise > 0 and tube.advance > 0):
                return False
            if tube.holds(slip.load):
                return True
        return False

    def locks(self, mu0: arb) -> bool:
        """Whether −tan α stays below μ0 up to its maximum: proved, if true."""
        for tube in self.tubes:
            if tube.rise < 0:
                return True
            if not (tube.mu < mu0 and tube.advance > 0):
                return False
        return False

    def peaks_first(self, critical: Equilibrium) -> bool:
        """Whether −tan α rises up to a critical state, and falls behind: proved, if true."""
        bends: list[arb] = []
        passed = False
        for tube in self.tubes:
            if tube.rise < 0:
                # `turning` is monotone where it may vanish, and differs in sign at both ends.
                return passed and (all(b > 0 for b in bends) or all(b < 0 for b in bends))
            if not tube.advance > 0:
                return False
            if tube.bend is not None:
                bends.append(tube.bend)
                passed = passed or tube.holds(critical.load)
        return False


def follow(rod: Rod, init: Equilibrium, beyond: arb | None = None) -> Path:
    """Cover the path from the state α = 0 on with tubes, until −tan α falls.

    Parameters
    ----------
    rod : Rod
    init : Equilibrium
        The state α = 0.
    beyond : arb, optional
        −tan α up to which tubes are so short that it rises in each.

    Returns
    -------
    Path

    Raises
    ------
    NotProvedError
        If the path cannot be followed, at the displacement that the message tells.
    """
    scale = abs(init.load.fy).mid()
    tubes: list[Tube] = []
    reach = scale * FIRST
    while not (tubes and tubes[-1].rise < 0):
        if reach < scale * SHORTEST:
            raise NotProvedError(f"the path could not be followed beyond fx = {_end(tubes)}")
        try:
            tube = next_tube(rod, init, tubes, reach)
        except NotProvedError:
            reach = reach / 2
            continue
        short = reach < scale * OPEN or _decided(tube, beyond)
        if not (short and tube.advance > 0):
            reach = reach / 2
            continue
        tubes.append(tube)
        reach = (reach * LONGER).mid()
    return Path(tubes=tubes)


def _decided(tube: Tube, beyond: arb | None) -> bool:
    """Whether it is known where on a tube −tan α rises: up to `beyond`, everywhere."""
    if tube.bend is None:
        return True
    past = beyond is None or bool(tube.mu > beyond)
    return past and bool(tube.bend > 0 or tube.bend < 0)


def _end(tubes: list[Tube]) -> arb:
    return tubes[-1].last.fx if tubes else arb(0)


def next_tube(rod: Rod, init: Equilibrium, tubes: list[Tube], reach: arb) -> Tube:
    """Prove a tube that goes on where the others end.

    Raises
    ------
    NotProvedError
        If it is none, or does not meet the one before.
    """
    fx = (_end(tubes) - reach * (1 - OVERLAP)).mid()
    _, fy, m0 = tubes[-1].on_line(fx) if tubes else init.load
    tube = proved_tube(rod, Load(fx, fy.mid(), m0.mid()), reach, reach / 8)
    joined = tubes[-1].meets(tube) if tubes else tube.holds(init.load)
    if not joined:
        raise NotProvedError("two tubes do not meet")
    return tube


def proved_tube(rod: Rod, near: Load, reach: arb, width: arb) -> Tube:
    """Prove that each fx of an interval has exactly one equilibrium near a straight line.

    Parameters
    ----------
    rod : Rod
    near : Load
        Near the middle of the line; its fx is kept.
    reach : arb
        How far fx goes from there, to both sides.
    width : arb
        How far the loads of the tube may be from the line, at first.

    Returns
    -------
    Tube

    Raises
    ------
    NotProvedError
    """
    centre, shot = corrected(rod, near, reach)
    values, of_fx, slopes = moment_and_height(rod, shot)
    along = (-(middle_inverse(slopes) * of_fx)).mid()
    line, multiple = Line(centre, Load(arb(1), *along.entries())), arb(0, reach)
    more = arb_mat([[arb(0, width)], [arb(0, width)]])
    for _ in range(ATTEMPTS):
        extra = Load(arb(0), *more.entries())
        vicinity = Vicinity(shot, line.direction, multiple, extra)
        wide = shoot(rod.theta, line.at(multiple, extra), rod.steps, vicinity)
        _, of_fx, slopes = moment_and_height(rod, wide)
        # On the line the conditions are missed by what the mean value theorem says.
        missed = values + (of_fx + slopes * along) * multiple
        image = operator(missed, more, slopes)
        if inside(image, more):
            return _described(rod, line, vicinity, wide, _narrowed(missed, image, slopes))
        more = arb_mat([[arb(0, SLACK * abs(part).upper())] for part in image.entries()])
    raise NotProvedError("Krawczyk's test fails")


def _narrowed(missed: arb_mat, more: arb_mat, slopes: arb_mat) -> arb_mat:
    """Narrow where the equilibria are: what is outside of the operator's image is none."""
    for _ in range(REPEATED):
        more = operator(missed, more, slopes)
    return more


def _described(rod: Rod, line: Line, vicinity: Vicinity, wide: Shot, found: arb_mat) -> Tube:
    """Enclose what changes along the path: the derivatives with respect to fx, by Cramer's rule.

    `wide` is shot with all loads of the tube, and `found` says how far the equilibria may be from
    the line.
    """
    _, of_fx, slopes = moment_and_height(rod, wide)
    rates = slopes.solve(-of_fx, algorithm="precond").entries()
    loads = line.at(vicinity.multiple, Load(arb(0), *found.entries()))
    rise = (loads.fx * rates[0] - loads.fy) / loads.fy**2
    reach = vicinity.multiple.rad()
    end = line.at(-reach)
    missed, _, _ = moment_and_height(rod, shoot(rod.theta, end, rod.steps))
    fy, m0 = (arb_mat([[end.fy], [end.m0]]) + _narrowed(missed, found, slopes)).entries()
    _, x_fx, *x_others = (section.x for section in wide.tip)
    bend = None
    if not (rise > 0 or rise < 0):
        box = line.at(vicinity.multiple, vicinity.more)
        shot = shoot(rod.theta, box, rod.steps, vicinity, second=True)
        _, (change, *others) = turning(loads, shot)
        bend = change + _along(others, rates)
    return Tube(
        line=line,
        reach=reach,
        more=vicinity.more,
        last=Load(end.fx, fy, m0),
        mu=line.centre.fx / (line.centre.fy + found[0, 0]) + rise * vicinity.multiple,
        rise=rise,
        advance=x_fx + _along(x_others, rates),
        bend=bend,
    )


def _along(changes: Sequence[arb], rates: Sequence[arb]) -> arb:
    """Add changes with fy and m0, which change with fx at these rates."""
    return sum((change * rate for change, rate in zip(changes, rates, strict=True)), arb(0))


def corrected(rod: Rod, near: Load, reach: arb) -> tuple[Load, Shot]:
    """Correct fy and m0 by Newton's method until little of a tube's length is left.

    Raises
    ------
    NotProvedError
        If the method does not converge.
    """
    load = near
    for _ in range(CORRECTIONS):
        shot = shoot(rod.theta, load, rod.steps)
        values, _, slopes = moment_and_height(rod, shot)
        change = middle_inverse(slopes) * values
        if all(abs(part.mid()) < reach * 2.0**-10 for part in change.entries()):
            return load, shot
        fy, m0 = (arb_mat([[load.fy], [load.m0]]) - change).mid().entries()
        load = Load(load.fx, fy, m0)
    raise NotProvedError("Newton's method does not converge")


def moment_and_height(rod: Rod, shot: Shot) -> tuple[arb_mat, arb_mat, arb_mat]:
    """Evaluate the two conditions at the tip, m(1) = 0 and y(1) = η.

    Parameters
    ----------
    rod : Rod
    shot : Shot

    Returns
    -------
    values : arb_mat, shape (2, 1)
        By how much they are missed.
    of_fx : arb_mat, shape (2, 1)
        Derivatives with respect to fx.
    slopes : arb_mat, shape (2, 2)
        Derivatives with respect to fy and m0.
    """
    tip, x, y, m, *_ = shot.tip
    values = arb_mat([[tip.m], [tip.y - rod.eta]])
    return values, arb_mat([[x.m], [x.y]]), arb_mat([[y.m, m.m], [y.y, m.y]])
