"""Equilibria of the rod in tip contact, proved.

A rod with the load (fx, fy, m0) is in equilibrium beside the surface if its tip carries no moment
and lies at the height of the surface,

    m(1) = 0,   y(1) = η,

and one more condition says which of these equilibria is meant (`Closing`). These are three
equations for three unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from vibrissa.errors import NotProvedError
from vibrissa.proof.flow import Load, Section, Shot, shoot
from vibrissa.proof.krawczyk import krawczyk, middle_inverse

# A box reaches so many times as far as Newton's last correction.
REACH = 2
# More of Newton's corrections do not help: they began too far away.
CORRECTIONS = 10


@dataclass(frozen=True, kw_only=True)
class Rod:
    """The rod and its surface, and the number of steps in which the rod is integrated.

    Attributes
    ----------
    theta, eta : arb
        Taper factor and clamp–surface distance (L).
    steps : int
    """

    theta: arb
    eta: arb
    steps: int


@dataclass(frozen=True, kw_only=True)
class Closing:
    """The third condition: of_fx·fx + of_fy·fy + of_x·x(1) = level."""

    of_fx: arb
    of_fy: arb
    of_x: arb
    level: arb


def inclined(mu: arb) -> Closing:
    """Close with the inclination of the force, −tan α = fx/fy = μ."""
    return Closing(of_fx=arb(1), of_fy=-mu, of_x=arb(0), level=arb(0))


def reaching(offset: arb) -> Closing:
    """Close with the place of the tip, x(1) = x1 − x0."""
    return Closing(of_fx=arb(0), of_fy=arb(0), of_x=arb(1), level=offset)


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """An equilibrium that exists, and that no other load in `box` has.

    If the level of the closing condition is an interval, this holds for each level in it, and
    the enclosures hold all these equilibria.

    Attributes
    ----------
    load : Load
        Contact force (E·I0/L²) and moment at the clamp (E·I0/L).
    box : Load
        Where no other load gives an equilibrium.
    f, alpha, mu : arb
        Magnitude of the force, its inclination (rad), and −tan α.
    offset, phi1 : arb
        x1 − x0 (L), and the slope at the tip (rad).
    rates : Load
        Derivatives of the load with respect to the level.
    passed : list of Section
        Boxes that hold the sections of the rod, from the clamp to the tip.
    """

    load: Load
    box: Load
    f: arb
    alpha: arb
    mu: arb
    offset: arb
    phi1: arb
    rates: Load
    passed: list[Section]

    def bent_once(self) -> bool:
        """Whether m < 0 from the clamp up to the tip, where it vanishes: proved, if true."""
        fx, fy, _ = self.load
        bends = [box.m < 0 for box in self.passed]
        first = bends.index(False) if False in bends else len(bends)
        # From there on m grows up to m(1) = 0.
        return all(fx * box.phi.sin() - fy * box.phi.cos() > 0 for box in self.passed[first:])


def prove(rod: Rod, closing: Closing, near: Sequence[arb | float]) -> Equilibrium:
    """Prove that there is an equilibrium near a load, and no other.

    Parameters
    ----------
    rod : Rod
    closing : Closing
        If its level is a ball, this is proved for each number in it.
    near : sequence of float, length 3
        Load from which Newton's method starts. No proof depends on where it came from.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotProvedError
        If Newton's method does not converge, or Krawczyk's test fails.
    """
    centre = arb_mat([[arb(value)] for value in near])
    for _ in range(CORRECTIONS):
        values, slopes, _ = conditions(rod, closing, centre)
        correction = middle_inverse(slopes) * values
        # Until it cannot be told from the errors of the integration.
        if all(change.contains(0) for change in correction.entries()):
            return examined(rod, closing, centre, values, reached(correction))
        centre = (centre - correction).mid()
    raise NotProvedError("Newton's method does not converge")


def examined(
    rod: Rod, closing: Closing, centre: arb_mat, values: arb_mat, reach: arb_mat
) -> Equilibrium:
    """Prove that there is an equilibrium in a box of loads, and no other.

    Parameters
    ----------
    rod : Rod
    closing : Closing
    centre, values, reach : arb_mat, shape (3, 1)
        Middle of the box, by how much it misses the conditions, and half the box's widths.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotProvedError
        If Krawczyk's test fails.
    """
    box = arb_mat([[arb(c, r)] for c, r in zip(centre.entries(), reach.entries(), strict=True)])
    _, slopes, _ = conditions(rod, closing, box)
    image = krawczyk(centre, values, box, slopes)
    _, slopes, shot = conditions(rod, closing, image)
    load = Load(*image.entries())
    mu = load.fx / load.fy
    return Equilibrium(
        load=load,
        box=Load(*box.entries()),
        f=(load.fx**2 + load.fy**2).sqrt(),
        alpha=-mu.atan(),
        mu=mu,
        offset=shot.tip[0].x,
        phi1=shot.tip[0].phi,
        rates=Load(*slopes.solve(arb_mat([[0], [0], [1]]), algorithm="precond").entries()),
        passed=shot.passed,
    )


def conditions(rod: Rod, closing: Closing, at: arb_mat) -> tuple[arb_mat, arb_mat, Shot]:
    """Evaluate the three equations.

    Parameters
    ----------
    rod : Rod
    closing : Closing
    at : arb_mat, shape (3, 1)
        Load, or a box of loads.

    Returns
    -------
    values : arb_mat, shape (3, 1)
        By how much the equations are missed.
    slopes : arb_mat, shape (3, 3)
        Derivatives with respect to the load.
    shot : Shot
    """
    load = Load(*at.entries())
    shot = shoot(rod.theta, load, rod.steps)
    tip, *tangents = shot.tip
    closed = closing.of_fx * load.fx + closing.of_fy * load.fy + closing.of_x * tip.x
    values = arb_mat([[tip.m], [tip.y - rod.eta], [closed - closing.level]])
    own = (closing.of_fx, closing.of_fy, arb(0))
    slopes = arb_mat(
        [
            [tangent.m for tangent in tangents],
            [tangent.y for tangent in tangents],
            [o + closing.of_x * tangent.x for o, tangent in zip(own, tangents, strict=True)],
        ]
    )
    return values, slopes, shot


def reached(correction: arb_mat) -> arb_mat:
    """Say how far a box should reach, given Newton's correction at its centre."""
    sizes = [abs(change).upper() for change in correction.entries()]
    # A part that happens to change little is not known better than the others.
    least = max(sizes, key=float) / 8
    return arb_mat([[REACH * max(size, least, key=float)] for size in sizes])
