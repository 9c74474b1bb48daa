"""Proved equilibrium paths from the state α = 0 on, to decide which onset of slip is the first.

Along the path the horizontal force fx falls from 0, and each fx has one equilibrium. So the path is
covered by tubes, each for an interval of fx: the load lies near a straight line,

    (fx, fy, m0) = centre + (fx − centre.fx)·(1, a, b) + a little more,

and Krawczyk's test proves, for all fx of the interval at once, that exactly one load in the tube is
an equilibrium. Where two tubes meet, they have the same equilibrium at a common fx: a small box
that contains the equilibrium of one tube lies in the other tube. On a tube the derivatives along
the path are enclosed. Their signs prove that the clamp advances, and whether −tan α rises. Near the
maximum of −tan α the sign of its derivative is open; there, the derivative of D (`critical`) has
one sign, so that −tan α has only one extremum.
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

# Width of a tube in units of the width of the enclosure that was found in it.
SLACK = 2
# Attempts at a tube's width.
ATTEMPTS = 4
# Half-lengths of tubes, relative to the force at α = 0: of the first tube, of the shortest, and of
# the shortest that is tried only to decide whether −tan α rises.
FIRST, SHORTEST, OPEN = 2.0**-6, 2.0**-20, 2.0**-12
# Factor by which the next tube is longer, and relative overlap of two tubes.
LONGER, OVERLAP = 1.25, 2.0**-6
# How often Krawczyk's operator is applied to narrow a tube.
REPEATED = 4
# Largest number of Newton's corrections of a centre.
CORRECTIONS = 6
# No deviation of a load.
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
        """Return the loads on the line at fx = centre.fx + `way`, plus the deviation `more`."""
        return Load(*(c + d * way + m for c, d, m in zip(*self, more, strict=True)))


@dataclass(frozen=True, kw_only=True)
class Tube:
    """A part of an equilibrium path: for each fx in it exactly one equilibrium.

    Attributes
    ----------
    line : Line
    reach : arb
        Half-length of the tube: largest |fx − centre.fx|.
    more : Load
        Balls around zero: deviations of the tube's loads from the line.
    last : Load
        Enclosure of the equilibrium at the end of the tube, where fx is farthest from α = 0.
    mu : arb
        −tan α of the equilibria.
    rise, advance : arb
        Derivatives of −tan α and of x0 with respect to −fx.
    bend : arb or None
        Derivative of `turning` with respect to fx, if the sign of `rise` is open.
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
        """Return the load on the line at fx."""
        return self.line.at(fx - self.line.centre.fx)

    def holds(self, load: Load) -> bool:
        """Whether all loads of a box lie in the tube: proved, if true."""
        if not abs(load.fx - self.line.centre.fx) <= self.reach:
            return False
        _, fy, m0 = self.on_line(load.fx)
        return self.more.fy.contains(load.fy - fy) and self.more.m0.contains(load.m0 - m0)

    def meets(self, other: "Tube") -> bool:
        """Whether the other tube contains the end of this tube: proved, if true."""
        return other.holds(self.last)


@dataclass(frozen=True, kw_only=True)
class Path:
    """An equilibrium path from the state α = 0 on.

    Attributes
    ----------
    tubes : list of Tube
        Tubes in order; neighbours meet.
    """

    tubes: list[Tube]

    def slips_first(self, slip: Equilibrium, *before: Equilibrium) -> bool:
        """Whether states are on the path, and `slip` is the first with its −tan α: proved, if true.

        The states `before` are sought in the tubes up to that of `slip`.
        """
        for tube in self.tubes:
            if not (tube.rise > 0 and tube.advance > 0):
                return False
            before = tuple(one for one in before if not tube.holds(one.load))
            if tube.holds(slip.load):
                return not before
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
        """Whether −tan α rises up to a critical state, and falls after it: proved, if true."""
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
        Value up to which tubes are so short that −tan α rises in each.

    Returns
    -------
    Path

    Raises
    ------
    NotProvedError
        If the path cannot be followed further; the message has the last fx.
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
    """Whether the sign of `rise` is known or, where −tan α exceeds `beyond`, that of `bend`."""
    if tube.bend is None:
        return True
    past = beyond is None or bool(tube.mu > beyond)
    return past and bool(tube.bend > 0 or tube.bend < 0)


def _end(tubes: list[Tube]) -> arb:
    return tubes[-1].last.fx if tubes else arb(0)


def next_tube(rod: Rod, init: Equilibrium, tubes: list[Tube], reach: arb) -> Tube:
    """Prove the tube that follows the others.

    Raises
    ------
    NotProvedError
        If the tube is not proved, or does not meet the previous tube.
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
        Load near the middle of the line; its fx is kept.
    reach : arb
        Half-length of the interval of fx.
    width : arb
        Half-width of the tube that is tried first.

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
        # Residuals on the line, by the mean value theorem.
        missed = values + (of_fx + slopes * along) * multiple
        image = operator(missed, more, slopes)
        if inside(image, more):
            return _described(rod, line, vicinity, wide, _narrowed(missed, image, slopes))
        more = arb_mat([[arb(0, SLACK * abs(part).upper())] for part in image.entries()])
    raise NotProvedError("Krawczyk's test fails")


def _narrowed(missed: arb_mat, more: arb_mat, slopes: arb_mat) -> arb_mat:
    """Narrow the enclosure of the equilibria: all of them lie in the operator's image."""
    for _ in range(REPEATED):
        more = operator(missed, more, slopes)
    return more


def _described(rod: Rod, line: Line, vicinity: Vicinity, wide: Shot, found: arb_mat) -> Tube:
    """Make a tube: enclose its end, and the derivatives along the path with respect to fx.

    `wide` is the rod with all loads of the tube; `found` encloses the deviations of the equilibria
    from the line.
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
    """Sum the derivatives with respect to fy and m0, times the rates of fy and m0 with fx."""
    return sum((change * rate for change, rate in zip(changes, rates, strict=True)), arb(0))


def corrected(rod: Rod, near: Load, reach: arb) -> tuple[Load, Shot]:
    """Correct fy and m0 by Newton's method, until corrections are small for the tube's length.

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
        Residuals of the two conditions.
    of_fx : arb_mat, shape (2, 1)
        Derivatives with respect to fx.
    slopes : arb_mat, shape (2, 2)
        Derivatives with respect to fy and m0.
    """
    tip, x, y, m, *_ = shot.tip
    values = arb_mat([[tip.m], [tip.y - rod.eta]])
    return values, arb_mat([[x.m], [x.y]]), arb_mat([[y.m, m.m], [y.y, m.y]])
