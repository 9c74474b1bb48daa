"""Periods of sticking, proved."""

from dataclasses import dataclass
from decimal import Decimal

import numpy as np
from flint import arb, fmpq

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError, NotProvedError
from vibrissa.proof.equilibrium import Equilibrium, Rod, inclined, prove
from vibrissa.proof.flow import Effort
from vibrissa.proof.path import Path, follow
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

# A float stands for the shortest decimal that reads back as it.
Number = float | Decimal | str


@dataclass(frozen=True, kw_only=True)
class ProvedOnset:
    """First and last state of a period of sticking, in tip contact.

    Attributes
    ----------
    init : Equilibrium
        State with α = 0.
    slip : Equilibrium
        State with −tan α = μ0.
    x0_slip : arb
        How far the clamp moves between the two (L).
    bent_once : bool
        Whether the rod is bent once in the first state: m < 0 from the clamp up to the tip.
    first : bool or None
        Whether the onset is the first one on the equilibrium path from α = 0; None if not asked.
    """

    init: Equilibrium
    slip: Equilibrium
    x0_slip: arb
    bent_once: bool
    first: bool | None

    def columns(self) -> dict[str, arb]:
        """Return the enclosures, by the names that the tables have for them."""
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
        }


def onset(
    theta: Number,
    mu0: Number,
    eta: Number,
    *,
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
    first : bool, optional
        Also prove that the path from α = 0 leads to this onset, and to no other before. This takes
        ten times as long.
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
    [0.052838042795739907695 +/- 4.59e-22]
    """
    number = numbers(theta=theta, mu0=mu0, eta=eta)
    if not number["mu0"] > 0:
        raise ArgumentError(f"mu0 must be positive, got {mu0!r}")
    curve = solve_curve(float(number["theta"]), float(number["eta"]))
    x0_slip = curve.onset([float(number["mu0"])])[0]
    if np.isnan(x0_slip):
        raise NotProvedError(
            f"no onset of slip is known for mu0 = {mu0}: mu_lock is {curve.mu_lock:.6g}"
        )
    effort = effort or suitable(number["theta"])
    with effort.spent():
        rod = Rod(theta=ball(number["theta"]), eta=ball(number["eta"]), steps=effort.steps)
        init = prove(rod, inclined(arb(0)), start(curve, 0.0))
        slip = prove(rod, inclined(ball(number["mu0"])), start(curve, float(x0_slip)))
        x0 = init.offset - slip.offset
    proved = None
    if first:
        path = path_of(number["theta"], number["eta"], init, beyond=number["mu0"])
        proved = path.slips_first(slip)
    return ProvedOnset(init=init, slip=slip, x0_slip=x0, bent_once=init.bent_once(), first=proved)


def path_of(theta: Decimal, eta: Decimal, init: Equilibrium, beyond: Decimal | None) -> Path:
    """Cover the path from a proved state α = 0 on; see `vibrissa.proof.path.follow`.

    Tubes are so wide that few digits are enough.
    """
    effort = Effort(bits=64, order=16, steps=max(12, round(7 * float(theta) ** 0.75)))
    with effort.spent():
        rod = Rod(theta=ball(theta), eta=ball(eta), steps=effort.steps)
        return follow(rod, init, None if beyond is None else ball(beyond))


def suitable(theta: Decimal) -> Effort:
    """Choose the effort for a taper: a thin tip needs more steps."""
    return Effort(steps=max(16, round(8 * float(theta) ** 0.75)))


def numbers(**values: Number) -> dict[str, Decimal]:
    """Read arguments as exact decimals.

    Raises
    ------
    ArgumentError
        If one is no finite number.
    """
    try:
        return {name: exact(value) for name, value in values.items()}
    except (ValueError, TypeError) as error:
        raise ArgumentError(f"theta, mu0 and eta must be numbers: {error}") from None


def ball(value: Decimal) -> arb:
    """Enclose an exact decimal."""
    return arb(fmpq(*value.as_integer_ratio()))


def start(curve: StickingCurve, x0: float) -> list[float]:
    """Return the load from the solver that a proof starts from."""
    state = curve.state(x0)
    return [float(v) for v in (state.reaction_fx, state.reaction_fy, state.reaction_m)]
