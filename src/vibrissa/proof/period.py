"""Periods of sticking, proved."""

from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise

import numpy as np
from flint import arb

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError, NotProvedError
from vibrissa.outcomes import Contact
from vibrissa.proof.critical import prove_critical
from vibrissa.proof.equilibrium import Equilibrium, inclined, prove, tangential
from vibrissa.proof.flow import Effort
from vibrissa.proof.starting import ball, load_at, path_of, prove_at, rod_of, suitable
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

# A float stands for the shortest decimal that reads back as it.
Number = float | Decimal | str


@dataclass(frozen=True, kw_only=True)
class ProvedOnset:
    """First and last state of a period of sticking.

    Attributes
    ----------
    init : Equilibrium
        State with α = 0.
    slip : Equilibrium
        State with −tan α = μ0.
    x0_slip : arb
        How far the clamp moves between the two (L).
    switches : tuple of Equilibrium
        States between the two in which the contact changes its kind, φ1 = 0 and s_c = 1.
    bent_once : bool
        Whether the rod is bent once in the first state: m < 0 from the clamp up to the tip.
    first : bool or None
        Whether the onset is the first one on the equilibrium path from α = 0; None if not asked.
    """

    init: Equilibrium
    slip: Equilibrium
    x0_slip: arb
    switches: tuple[Equilibrium, ...]
    bent_once: bool
    first: bool | None

    def columns(self) -> dict[str, arb]:
        """Return the enclosures, by the names that the tables have for them."""
        switched = {
            f"x0_switch_{number}": self.init.offset - switch.offset
            for number, switch in enumerate(self.switches, start=1)
        }
        lying = {
            f"s_c_{name}": state.s_c
            for name, state in (("init", self.init), ("slip", self.slip))
            if state.contact is Contact.LINE
        }
        return {
            "x1_init": self.init.offset,
            "f_init": self.init.f,
            "phi1_init": self.init.phi1,
            "reaction_m_init": self.init.load.m0,
            "x0_slip": self.x0_slip,
            "f_slip": self.slip.f,
            "alpha_slip": self.slip.alpha,
            "phi1_slip": self.slip.phi1,
            "reaction_fx_slip": self.slip.load.fx,
            "reaction_fy_slip": self.slip.load.fy,
            "reaction_m_slip": self.slip.load.m0,
            **lying,
            **switched,
        }


@dataclass(frozen=True, kw_only=True)
class ProvedLock:
    """First and critical state of the path of a sticking tip, in tip contact.

    Attributes
    ----------
    init : Equilibrium
        State with α = 0.
    critical : Equilibrium
        State where −tan α is stationary.
    mu_lock : arb
        −tan α there.
    x0_lock : arb
        How far the clamp moves between the two (L).
    first : bool or None
        Whether −tan α rises strictly on the path from α = 0 to this state, and falls behind; None
        if not asked.
    """

    init: Equilibrium
    critical: Equilibrium
    mu_lock: arb
    x0_lock: arb
    first: bool | None

    def columns(self) -> dict[str, arb]:
        """Return the enclosures, by the names that the tables have for them."""
        return {
            "mu_lock": self.mu_lock,
            "x0_lock": self.x0_lock,
            "f_lock": self.critical.f,
            "phi1_lock": self.critical.phi1,
            "reaction_fx_lock": self.critical.load.fx,
            "reaction_fy_lock": self.critical.load.fy,
            "reaction_m_lock": self.critical.load.m0,
        }


def onset(
    theta: Number,
    mu0: Number,
    eta: Number,
    *,
    contact: str = Contact.POINT,
    first: bool = False,
    effort: Effort | None = None,
) -> ProvedOnset:
    """Prove that the rod has a state with α = 0 and one with −tan α = μ0, and enclose both.

    Parameters
    ----------
    theta : float, Decimal or str
        Taper factor, at least 1.
    mu0 : float, Decimal or str
        Coefficient of static friction, positive.
    eta : float, Decimal or str
        Clamp–surface distance, 0 < eta < 1 (L).
    contact : str
        ``point``: the tip alone touches; ``line``: the rod lies along the surface where it would
        pass through it. The kind of contact of both states is proved then, too.
    first : bool, optional
        Also prove that the path from α = 0 leads to this onset, and to no other before, in tip
        contact. This takes ten times as long.
    effort : Effort, optional
        Without one, what gives some 25 digits for this taper.

    Returns
    -------
    ProvedOnset

    Raises
    ------
    ArgumentError
        If an argument is out of range.
    NotProvedError
        If the tip does not slip, or no proof was found.

    Examples
    --------
    >>> found = onset(theta=2, mu0=0.4, eta=0.85)
    >>> print(found.x0_slip.str(20))
    [0.052838042795739907695 +/- ...]
    """
    number = numbers(theta=theta, mu0=mu0, eta=eta)
    if not number["mu0"] > 0:
        raise ArgumentError(f"mu0 must be positive, got {mu0!r}")
    if first and contact != Contact.POINT:
        raise ArgumentError("first: paths are proved in tip contact alone (contact: point)")
    curve = solve_curve(float(number["theta"]), float(number["eta"]), contact=contact)
    x0_slip = curve.onset([float(number["mu0"])])[0]
    if np.isnan(x0_slip):
        raise NotProvedError(
            f"no onset of slip is known for mu0 = {mu0}: mu_lock is {curve.mu_lock:.6g}"
        )
    effort = effort or suitable(number["theta"])
    with effort.spent():
        rod = rod_of(number["theta"], number["eta"], effort)
        init = prove_at(rod, inclined(arb(0)), curve, 0.0)
        slip = prove_at(rod, inclined(ball(number["mu0"])), curve, float(x0_slip))
        switches = tuple(
            prove(rod, tangential(), load_at(curve, x0)) for x0 in _switches(curve, float(x0_slip))
        )
        x0 = init.offset - slip.offset
    if contact == Contact.LINE and not (init.keeps_contact() and slip.keeps_contact()):
        raise NotProvedError("a state is too near a change of contact to tell its kind")
    proved = None
    if first:
        path = path_of(number["theta"], number["eta"], init, beyond=number["mu0"])
        proved = path.slips_first(slip)
    return ProvedOnset(
        init=init,
        slip=slip,
        x0_slip=x0,
        switches=switches,
        bent_once=init.bent_once(),
        first=proved,
    )


def _switches(curve: StickingCurve, x0_slip: float) -> list[float]:
    """Return where the contact changes its kind before the onset, as the solver has it."""
    return [
        piece.first_x0
        for before, piece in pairwise(curve.pieces)
        if piece.contact is not before.contact and piece.first_x0 < x0_slip
    ]


def lock(
    theta: Number, eta: Number, *, first: bool = False, effort: Effort | None = None
) -> ProvedLock:
    """Prove that −tan α is stationary in a state of the rod, and enclose μ_lock.

    Parameters
    ----------
    theta : float, Decimal or str
        Taper factor, at least 1.
    eta : float, Decimal or str
        Clamp–surface distance, 0 < eta < 1 (L).
    first : bool, optional
        Also prove that −tan α rises strictly on the path from α = 0 up to this state, and falls
        behind it. This takes ten times as long.
    effort : Effort, optional
        Without one, what gives some 20 digits for this taper.

    Returns
    -------
    ProvedLock

    Raises
    ------
    ArgumentError
        If an argument is out of range.
    NotProvedError
        If no critical state is known, or no proof was found.

    Examples
    --------
    >>> found = lock(theta=2, eta=0.85)
    >>> print(found.mu_lock.str(20))
    [0.47757140928181466471 +/- ...]
    """
    number = numbers(theta=theta, eta=eta)
    curve = solve_curve(float(number["theta"]), float(number["eta"]))
    if not np.isfinite(curve.mu_lock):
        raise NotProvedError("no critical state is known: the tip lifts off, or the path ends")
    effort = effort or suitable(number["theta"])
    with effort.spent():
        rod = rod_of(number["theta"], number["eta"], effort)
        init = prove_at(rod, inclined(arb(0)), curve, 0.0)
        critical = prove_critical(rod, load_at(curve, curve.x0_lock))
        x0 = init.offset - critical.offset
    proved = None
    if first:
        path = path_of(number["theta"], number["eta"], init, over=True)
        proved = path.peaks_first(critical)
    return ProvedLock(init=init, critical=critical, mu_lock=critical.mu, x0_lock=x0, first=proved)


def numbers(**values: Number) -> dict[str, Decimal]:
    """Read arguments as exact decimals.

    Raises
    ------
    ArgumentError
        If one is no finite number.
    """
    return {name: _number(name, value) for name, value in values.items()}


def _number(name: str, value: Number) -> Decimal:
    try:
        number = exact(value)
    except (ValueError, TypeError):
        raise ArgumentError(f"{name} must be a number, got {value!r}") from None
    # The solver has doubles.
    if not np.isfinite(float(number)):
        raise ArgumentError(f"{name} must be smaller than 1e308, got {value!r}")
    return number
