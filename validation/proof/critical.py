"""The critical state in tip contact, proved: where −tan α has its maximum on an equilibrium path.

The equilibria of a rod are a path in the space of loads (fx, fy, m0), where

    g(fx, fy, m0) = (m(1), y(1) − η) = 0.

μ = −tan α = fx/fy is stationary where the force keeps its direction along the path. There the
path's tangent is a·(fx, fy, 0) + b·(0, 0, 1), with numbers a and b that are not both zero, and

    a·E + b·M = 0,   E = fx·∂g/∂fx + fy·∂g/∂fy,   M = ∂g/∂m0.

So the critical state solves three equations for its load: g = 0 and D = det(E, M) = 0. The
derivatives of D contain the second derivatives of g, which the integration encloses as well.

Where each fx has one equilibrium, as in a tube of `validation.proof.path`, dμ/dfx is D divided by
fy²·det(∂g/∂fy, M), which does not vanish. So D changes its sign where −tan α has an extremum.
"""

from collections.abc import Sequence

from flint import arb, arb_mat

from validation.proof.equilibrium import Equilibrium, Rod, described
from validation.proof.flow import PAIRS, Load, Shot, shoot
from validation.proof.krawczyk import System, solution

# Derivatives of m(1) and y(1).
Pair = tuple[arb, arb]


def prove_critical(rod: Rod, near: Sequence[arb | float]) -> Equilibrium:
    """Prove that there is a critical state near a load, and no other.

    Parameters
    ----------
    rod : Rod
    near : sequence of float, length 3
        Load from which Newton's method starts; the proof does not depend on it.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotProvedError
        If Newton's method does not converge, or Krawczyk's test fails.
    """
    return described(rod, solution(stationary(rod), near))


def stationary(rod: Rod) -> System:
    """Return the three equations of a critical state, as a function of the load."""

    def missed(at: arb_mat) -> tuple[arb_mat, arb_mat]:
        load = Load(*at.entries())
        shot = shoot(rod.theta, load, rod.steps, second=True)
        tip, *changes = shot.tip
        turn, of_turn = turning(load, shot)
        slopes = [
            [change.m for change in changes[:3]],
            [change.y for change in changes[:3]],
            list(of_turn),
        ]
        return arb_mat([[tip.m], [tip.y - rod.eta], [turn]]), arb_mat(slopes)

    return missed


def turning(load: Load, shot: Shot) -> tuple[arb, Load]:
    """Evaluate D, which vanishes where −tan α is stationary.

    Parameters
    ----------
    load : Load
        A load, or a box of them.
    shot : Shot
        The rod with this load, with second derivatives.

    Returns
    -------
    value : arb
    slopes : Load
        Derivatives with respect to the load.
    """
    _, *changes = ((section.m, section.y) for section in shot.tip)
    of_fx, of_fy, of_m0 = changes[:3]
    twice = dict(zip(PAIRS, changes[3:], strict=True))
    of_force = _along(load, of_fx, of_fy)
    # The product rule; E has fx and fy themselves as factors, too.
    return _det(of_force, of_m0), Load(
        fx=_det(_along(load, twice[0, 0], twice[0, 1]), of_m0)
        + _det(of_fx, of_m0)
        + _det(of_force, twice[0, 2]),
        fy=_det(_along(load, twice[0, 1], twice[1, 1]), of_m0)
        + _det(of_fy, of_m0)
        + _det(of_force, twice[1, 2]),
        m0=_det(_along(load, twice[0, 2], twice[1, 2]), of_m0) + _det(of_force, twice[2, 2]),
    )


def _along(load: Load, of_fx: Pair, of_fy: Pair) -> Pair:
    """Return the derivative fx·∂/∂fx + fy·∂/∂fy, along a force of fixed direction."""
    (m_fx, y_fx), (m_fy, y_fy) = of_fx, of_fy
    return load.fx * m_fx + load.fy * m_fy, load.fx * y_fx + load.fy * y_fy


def _det(one: Pair, other: Pair) -> arb:
    return one[0] * other[1] - one[1] * other[0]
