"""Starts of proofs: states of the solver, and a suitable effort.

No proof depends on the solver: from a wrong start, it fails, or proves the state that it finds.
"""

from decimal import Decimal

from flint import arb, fmpq

from validation.proof.equilibrium import Closing, Equilibrium, Rod, prove
from validation.proof.flow import Effort
from validation.proof.path import Path, follow
from vibrissa.sticking.curve import StickingCurve


def suitable(theta: Decimal) -> Effort:
    """Choose the effort for a taper: a thin tip needs more steps."""
    return Effort(steps=max(16, round(8 * float(theta) ** 0.75)))


def ball(value: Decimal) -> arb:
    """Enclose an exact decimal."""
    return arb(fmpq(*value.as_integer_ratio()))


def rod_of(theta: Decimal, eta: Decimal, effort: Effort) -> Rod:
    """Return the rod of a taper factor and a clamp–surface distance."""
    return Rod(theta=ball(theta), eta=ball(eta), steps=effort.steps)


def load_at(curve: StickingCurve, x0: float) -> list[float]:
    """Return the load of the solver's state at a displacement x0 (L)."""
    state = curve.state(x0)
    return [float(v) for v in (state.reaction_fx, state.reaction_fy, state.reaction_m)]


def prove_at(rod: Rod, closing: Closing, curve: StickingCurve, x0: float) -> Equilibrium:
    """Prove the state near the solver's state at a displacement x0 (L)."""
    return prove(rod, closing, load_at(curve, x0))


def path_of(theta: Decimal, eta: Decimal, init: Equilibrium, beyond: Decimal | None) -> Path:
    """Cover the path from a proved state α = 0 on; see `validation.proof.path.follow`.

    Tubes are so wide that few digits suffice.
    """
    effort = Effort(bits=64, order=12, steps=max(12, round(7 * float(theta) ** 0.75)))
    with effort.spent():
        rod = rod_of(theta, eta, effort)
        return follow(rod, init, None if beyond is None else ball(beyond))
