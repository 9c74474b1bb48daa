"""Equilibria of the rod in tip contact, proved.

A rod with the load (fx, fy, m0) is in equilibrium beside the surface if its tip carries no moment
and lies at the height of the surface,

    m(1) = 0,   y(1) = η.

A third condition (`Closing`) selects one of these equilibria. So there are three equations for the
load.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from validation.proof.flow import Load, Section, shoot
from validation.proof.krawczyk import System, solution


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
    """The third condition: of_fx·fx + of_fy·fy + of_x·x(1) = level.

    x(1) is the position of the tip relative to the clamp, x1 − x0.
    """

    of_fx: arb | int = 0
    of_fy: arb | int = 0
    of_x: arb | int = 0
    level: arb | int = 0


def inclined(mu: arb) -> Closing:
    """Prescribe the inclination of the force, −tan α = fx/fy = μ."""
    return Closing(of_fx=1, of_fy=-mu)


def reaching(offset: arb) -> Closing:
    """Prescribe the position of the tip, x1 − x0."""
    return Closing(of_x=1, level=offset)


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A proved equilibrium: it exists, and no other one nearby meets the same conditions.

    Attributes
    ----------
    load : Load
        Contact force (E·I0/L²) and moment at the clamp (E·I0/L).
    f, alpha, mu : arb
        Magnitude of the force, its inclination (rad), and −tan α.
    offset, phi1 : arb
        x1 − x0 (L), and the slope at the tip (rad).
    passed : list of Section
        Boxes that contain the sections of the rod, from the clamp to the tip.
    """

    load: Load
    f: arb
    alpha: arb
    mu: arb
    offset: arb
    phi1: arb
    passed: list[Section]

    def bent_once(self) -> bool:
        """Whether m < 0 from the clamp up to the tip, where m = 0: proved, if true."""
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
        If its level is a ball, the proof holds for each number in the ball.
    near : sequence of float
        Load from which Newton's method starts; the proof does not depend on it.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotProvedError
        If Newton's method does not converge, or Krawczyk's test fails.
    """
    return described(rod, solution(equations(rod, closing), near))


def equations(rod: Rod, closing: Closing) -> System:
    """Return the three equations of an equilibrium, as a function of the load."""

    def missed(at: arb_mat) -> tuple[arb_mat, arb_mat]:
        load = Load(*at.entries())
        tip, *changes = shoot(rod.theta, load, rod.steps).tip
        closed = closing.of_fx * load.fx + closing.of_fy * load.fy + closing.of_x * tip.x
        direct = (closing.of_fx, closing.of_fy, 0)
        values = arb_mat([[tip.m], [tip.y - rod.eta], [closed - closing.level]])
        slopes = [
            [change.m for change in changes],
            [change.y for change in changes],
            [own + closing.of_x * change.x for own, change in zip(direct, changes, strict=True)],
        ]
        return values, arb_mat(slopes)

    return missed


def described(rod: Rod, image: arb_mat) -> Equilibrium:
    """Enclose the quantities of an equilibrium, given an enclosure of its load."""
    load = Load(*image.entries())
    shot = shoot(rod.theta, load, rod.steps)
    mu = load.fx / load.fy
    return Equilibrium(
        load=load,
        f=(load.fx**2 + load.fy**2).sqrt(),
        alpha=-mu.atan(),
        mu=mu,
        offset=shot.tip[0].x,
        phi1=shot.tip[0].phi,
        passed=shot.passed,
    )
