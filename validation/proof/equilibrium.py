"""Equilibria of the rod beside the surface, proved.

A rod with the load (fx, fy, m0) is in equilibrium beside the surface if its contact point, at the
arc length s_c, carries no moment and lies at the height of the surface,

    m(s_c) = 0,   y(s_c) = η.

In tip contact s_c = 1. In line contact s_c is unknown, and the rod touches the surface
tangentially: φ(s_c) = 0. The flat segment behind the contact point is straight and carries no
load. One more condition says which of these equilibria is meant (`Closing`). So there are three
equations for (fx, fy, m0), or four for (fx, fy, m0, s_c).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from validation.proof.flow import Load, Section, shoot
from validation.proof.krawczyk import System, solution
from vibrissa.outcomes import Contact


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
    """The condition that closes: of_fx·fx + of_fy·fy + of_offset·offset + of_phi·φ(s_c) = level.

    The offset, x1 − x0, is that of the tip, x(s_c) + 1 − s_c.
    """

    of_fx: arb | int = 0
    of_fy: arb | int = 0
    of_offset: arb | int = 0
    of_phi: arb | int = 0
    level: arb | int = 0


def inclined(mu: arb) -> Closing:
    """Close with the inclination of the force, −tan α = fx/fy = μ."""
    return Closing(of_fx=1, of_fy=-mu)


def reaching(offset: arb) -> Closing:
    """Close with the place of the tip, x1 − x0."""
    return Closing(of_offset=1, level=offset)


def tangential() -> Closing:
    """Close tip contact with φ1 = 0: there it changes to line contact."""
    return Closing(of_phi=1)


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """An equilibrium that exists, and that is the only one of its kind in `box`.

    If the level of the closing condition is an interval, this holds for each level in it, and
    the enclosures hold all these equilibria.

    Attributes
    ----------
    contact : Contact
    load : Load
        Contact force (E·I0/L²) and moment at the clamp (E·I0/L).
    s_c : arb
        Arc length of the contact point (L).
    box : tuple of arb
        Loads, followed in line contact by contact points, of which no other gives an equilibrium.
    f, alpha, mu : arb
        Magnitude of the force, its inclination (rad), and −tan α.
    offset, phi1 : arb
        x1 − x0 (L), and the slope at the contact point (rad).
    passed : list of Section
        Boxes that hold the sections of the rod, from the clamp to the contact point.
    """

    contact: Contact
    load: Load
    s_c: arb
    box: tuple[arb, ...]
    f: arb
    alpha: arb
    mu: arb
    offset: arb
    phi1: arb
    passed: list[Section]

    def bent_once(self) -> bool:
        """Whether m < 0 from the clamp up to the contact point, where it vanishes, if true."""
        fx, fy, _ = self.load
        bends = [box.m < 0 for box in self.passed]
        first = bends.index(False) if False in bends else len(bends)
        # From there on m grows up to m(s_c) = 0.
        return all(fx * box.phi.sin() - fy * box.phi.cos() > 0 for box in self.passed[first:])

    def keeps_contact(self) -> bool:
        """Whether the contact is of the possible kind, φ1 > 0 or s_c < 1: proved, if true."""
        return bool(self.phi1 > 0 if self.contact is Contact.POINT else self.s_c < 1)


def prove(
    rod: Rod, closing: Closing, near: Sequence[arb | float], contact: Contact = Contact.POINT
) -> Equilibrium:
    """Prove that there is an equilibrium near a load, and no other.

    Parameters
    ----------
    rod : Rod
    closing : Closing
        If its level is a ball, this is proved for each number in it.
    near : sequence of float
        Load, and in line contact contact point, from which Newton's method starts. No proof
        depends on where it came from.
    contact : Contact

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotProvedError
        If Newton's method does not converge, or Krawczyk's test fails.
    """
    return described(rod, contact, *solution(equations(rod, closing, contact), near))


def equations(rod: Rod, closing: Closing, contact: Contact = Contact.POINT) -> System:
    """Return the equations of an equilibrium, as a function of load and contact point."""
    lies = contact is Contact.LINE

    def missed(at: arb_mat) -> tuple[arb_mat, arb_mat]:
        load, s_c = _unknowns(at)
        shot = shoot(rod.theta, load, rod.steps, end=s_c if lies else None)
        end, *changes = shot.tip
        changes += shot.onward[: int(lies)]
        closed = closing.of_fx * load.fx + closing.of_fy * load.fy + closing.of_phi * end.phi
        closed += closing.of_offset * (end.x + 1 - s_c)
        direct = (closing.of_fx, closing.of_fy, 0, -closing.of_offset)
        values = [end.m, end.y - rod.eta, closed - closing.level]
        slopes = [
            [change.m for change in changes],
            [change.y for change in changes],
            [
                own + closing.of_offset * change.x + closing.of_phi * change.phi
                for own, change in zip(direct, changes, strict=False)
            ],
        ]
        if lies:
            values.append(end.phi)
            slopes.append([change.phi for change in changes])
        return arb_mat([[value] for value in values]), arb_mat(slopes)

    return missed


def described(rod: Rod, contact: Contact, image: arb_mat, box: arb_mat) -> Equilibrium:
    """Enclose what there is to say of an equilibrium, given its load and contact point."""
    load, s_c = _unknowns(image)
    shot = shoot(rod.theta, load, rod.steps, end=s_c if contact is Contact.LINE else None)
    mu = load.fx / load.fy
    return Equilibrium(
        contact=contact,
        load=load,
        s_c=s_c,
        box=tuple(box.entries()),
        f=(load.fx**2 + load.fy**2).sqrt(),
        alpha=-mu.atan(),
        mu=mu,
        offset=shot.tip[0].x + 1 - s_c,
        phi1=shot.tip[0].phi,
        passed=shot.passed,
    )


def _unknowns(at: arb_mat) -> tuple[Load, arb]:
    """Read load and contact point; without one it is the tip."""
    fx, fy, m0, *inner = at.entries()
    return Load(fx, fy, m0), *(inner or (arb(1),))
