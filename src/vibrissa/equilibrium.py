r"""Equilibrium of the clamped rod under a force at its tip: spectral collocation and Newton.

The moment m obeys m' = fx·sin φ − fy·cos φ with m(1) = 0 for the contact force (fx, fy) on the
tip, and B·φ' = m with φ(0) = π/2. Integrated twice this is one equation for the slope φ alone,

    φ(s) = π/2 − ∫₀ˢ B⁻¹(u) ∫ᵤ¹ (fx·sin φ − fy·cos φ) dv du ,                            (E1)

closed by the height of the contact point above the clamp and by one more condition,

    ∫₀¹ sin φ ds = η ,                                                                   (E2)
    ∫₀¹ cos φ ds = offset     or     fx·cos α + fy·sin α = 0 .                      (E3a, E3b)

E3a prescribes where the tip sits relative to the clamp (sticking), E3b the inclination α of the
force (α = 0 is the state in which sticking begins). φ is a polynomial in the bending coordinate τ
(`vibrissa.taper`) through Gauss–Legendre nodes. All functions work on batches: the first axis
counts states.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index
from vibrissa.spectral import gauss_rule, refinement_matrix
from vibrissa.taper import arc_density, compliance_density

MAX_ITERATIONS = 25
# Newton converges quadratically: an update this small leaves an error of its square.
UPDATE_TOLERANCE = 1e-8


@dataclass(frozen=True)
class TipStates:
    """A batch of rod shapes with the tip force that belongs to each.

    Attributes
    ----------
    theta : ndarray, shape (n,)
        Taper factors.
    phi : ndarray, shape (n, nodes)
        Slope angle at the Gauss nodes in τ, in rad.
    fx, fy : ndarray, shape (n,)
        Contact force on the tip, in units of E·I0/L²; f·sin α and −f·cos α.
    """

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.theta)

    @property
    def nodes(self) -> int:
        """Number of collocation nodes along the rod."""
        return int(self.phi.shape[1])

    def take(self, index: Index) -> Self:
        """Select states by index or mask."""
        return type(self)(self.theta[index], self.phi[index], self.fx[index], self.fy[index])

    def put(self, index: Index, other: Self) -> None:
        """Overwrite the states at `index` by those of `other`."""
        self.phi[index], self.fx[index], self.fy[index] = other.phi, other.fx, other.fy


@dataclass(frozen=True)
class Closure:
    """The second closing condition, E3a or E3b, of a batch of states.

    Attributes
    ----------
    offset : ndarray, shape (n,), or None
        Prescribed x1 − x0, in units of L.
    alpha : ndarray, shape (n,), or None
        Prescribed inclination of the tip force, in rad.
    """

    offset: FloatArray | None = None
    alpha: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse a closure that prescribes both or nothing."""
        if (self.offset is None) == (self.alpha is None):
            raise ValueError("prescribe either the offset or the inclination alpha, not both")

    def take(self, index: Index) -> "Closure":
        """Select the conditions of some states."""
        if self.offset is not None:
            return Closure(offset=self.offset[index])
        assert self.alpha is not None
        return Closure(alpha=self.alpha[index])


def load_density(phi: FloatArray, fx: FloatArray, fy: FloatArray) -> FloatArray:
    """Moment gradient m' = fx·sin φ − fy·cos φ = f·cos(φ − α).

    Parameters
    ----------
    phi : ndarray, shape (n, points)
        Slope angles, in rad.
    fx, fy : ndarray, shape (n,)
        Tip force, in units of E·I0/L².

    Returns
    -------
    ndarray, shape (n, points)
        Moment gradient, in units of E·I0/L².
    """
    return fx[:, None] * np.sin(phi) - fy[:, None] * np.cos(phi)


def bending_moment(states: TipStates) -> FloatArray:
    """Bending moment m(τ) = −∫_s¹ m' ds at the nodes.

    Parameters
    ----------
    states : TipStates

    Returns
    -------
    ndarray, shape (n, nodes)
        Moment, in units of E·I0/L.
    """
    rule = gauss_rule(states.nodes)
    density = arc_density(rule.nodes, states.theta[:, None])
    return -(density * load_density(states.phi, states.fx, states.fy)) @ rule.to_end.T


def clamp_moment(states: TipStates) -> FloatArray:
    """Clamp reaction moment φ'(0) = m(0).

    Parameters
    ----------
    states : TipStates

    Returns
    -------
    ndarray, shape (n,)
        Moment, in units of E·I0/L.
    """
    rule = gauss_rule(states.nodes)
    density = arc_density(rule.nodes, states.theta[:, None])
    return -(density * load_density(states.phi, states.fx, states.fy)) @ rule.weights


def tip_slope(states: TipStates) -> FloatArray:
    """Slope φ1 at the tip by equation E1 at s = 1.

    Parameters
    ----------
    states : TipStates

    Returns
    -------
    ndarray, shape (n,)
        Slope, in rad.

    Notes
    -----
    The integral is more accurate than the polynomial's own value at τ = 1: Gauss collocation
    superconverges at the ends.
    """
    rule = gauss_rule(states.nodes)
    compliance = compliance_density(rule.nodes, states.theta[:, None])
    return np.pi / 2 + (compliance * bending_moment(states)) @ rule.weights


def tip_position(states: TipStates) -> tuple[FloatArray, FloatArray]:
    """Tip position relative to the clamp, ∫cos φ ds and ∫sin φ ds.

    Parameters
    ----------
    states : TipStates

    Returns
    -------
    offset, height : ndarray, shape (n,)
        In units of L.
    """
    rule = gauss_rule(states.nodes)
    weights = rule.weights * arc_density(rule.nodes, states.theta[:, None])
    return (weights * np.cos(states.phi)).sum(axis=1), (weights * np.sin(states.phi)).sum(axis=1)


def residual(states: TipStates, eta: FloatArray, closure: Closure) -> FloatArray:
    """Largest misfit of E1, E2 and E3, measured on more than twice the nodes.

    Collocation satisfies the equations at its own nodes whatever their number. Interpolating φ to
    a finer rule and asking again tells whether the polynomial satisfies them between the nodes.

    Parameters
    ----------
    states : TipStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure

    Returns
    -------
    ndarray, shape (n,)
        Largest of the misfits of E1 (rad), E2 and E3a (L) or E3b (relative to the force).
    """
    fine = 2 * states.nodes + 7
    rule = gauss_rule(fine)
    phi = states.phi @ refinement_matrix(states.nodes, fine).T
    theta = states.theta[:, None]
    weights = rule.weights * arc_density(rule.nodes, theta)
    inner = phi[:, 1:-1]
    gradient = arc_density(rule.nodes, theta) * load_density(inner, states.fx, states.fy)
    bend = -compliance_density(rule.nodes, theta) * (gradient @ rule.to_end.T)
    expected = np.pi / 2 + np.concatenate(
        [np.zeros((len(states), 1)), bend @ rule.from_start.T, (bend @ rule.weights)[:, None]],
        axis=1,
    )
    slope = np.abs(phi - expected).max(axis=1)
    height = np.abs((weights * np.sin(inner)).sum(axis=1) - eta)
    if closure.offset is not None:
        third = np.abs((weights * np.cos(inner)).sum(axis=1) - closure.offset)
    else:
        assert closure.alpha is not None
        third = np.abs(states.fx * np.cos(closure.alpha) + states.fy * np.sin(closure.alpha))
        third /= np.hypot(states.fx, states.fy)
    return np.maximum(np.maximum(slope, height), third)


def coefficient_decay(states: TipStates) -> FloatArray:
    """Size of the last Legendre coefficients of φ relative to the largest.

    Parameters
    ----------
    states : TipStates

    Returns
    -------
    ndarray, shape (n,)
        Near rounding error where φ is resolved; of order one where it is not.
    """
    coefficients = np.abs(states.phi @ gauss_rule(states.nodes).to_coefficients.T)
    return coefficients[:, -2:].max(axis=1) / coefficients.max(axis=1)


def integral_operator(theta: FloatArray, nodes: int) -> FloatArray:
    """Matrix of ∫₀ˢ B⁻¹(u) ∫ᵤ¹ (·) dv du at the nodes.

    Parameters
    ----------
    theta : ndarray, shape (n,)
        Taper factors.
    nodes : int
        Number of Gauss nodes.

    Returns
    -------
    ndarray, shape (n, nodes, nodes)
    """
    rule = gauss_rule(nodes)
    compliance = compliance_density(rule.nodes, theta[:, None])
    density = arc_density(rule.nodes, theta[:, None])
    return (rule.from_start * compliance[:, None, :]) @ (rule.to_end * density[:, None, :])


def newton_system(
    states: TipStates, eta: FloatArray, closure: Closure, operator: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Misfit of the collocated equations E1–E3 and its Jacobian.

    The unknowns are φ at the nodes, fx and fy, in this order; the equations are E1 at the nodes,
    E2 and E3.

    Parameters
    ----------
    states : TipStates
    eta : ndarray, shape (n,)
    closure : Closure
    operator : ndarray, shape (n, nodes, nodes)
        `integral_operator` of the states' taper.

    Returns
    -------
    misfit : ndarray, shape (n, nodes + 2)
    jacobian : ndarray, shape (n, nodes + 2, nodes + 2)
    """
    nodes = states.nodes
    rule = gauss_rule(nodes)
    weights = rule.weights * arc_density(rule.nodes, states.theta[:, None])
    sin, cos = np.sin(states.phi), np.cos(states.phi)
    fx, fy = states.fx[:, None], states.fy[:, None]
    bent_sin = np.matvec(operator, sin)
    bent_cos = np.matvec(operator, cos)

    misfit = np.empty((len(states), nodes + 2))
    misfit[:, :nodes] = states.phi - np.pi / 2 + fx * bent_sin - fy * bent_cos
    misfit[:, nodes] = (weights * sin).sum(axis=1) - eta

    jacobian = np.zeros((len(states), nodes + 2, nodes + 2))
    jacobian[:, :nodes, :nodes] = operator * (fx * cos + fy * sin)[:, None, :]
    diagonal = np.arange(nodes)
    jacobian[:, diagonal, diagonal] += 1.0
    jacobian[:, :nodes, nodes] = bent_sin
    jacobian[:, :nodes, nodes + 1] = -bent_cos
    jacobian[:, nodes, :nodes] = weights * cos

    if closure.offset is not None:
        misfit[:, nodes + 1] = (weights * cos).sum(axis=1) - closure.offset
        jacobian[:, nodes + 1, :nodes] = -weights * sin
    else:
        assert closure.alpha is not None
        cos_alpha, sin_alpha = np.cos(closure.alpha), np.sin(closure.alpha)
        misfit[:, nodes + 1] = states.fx * cos_alpha + states.fy * sin_alpha
        jacobian[:, nodes + 1, nodes] = cos_alpha
        jacobian[:, nodes + 1, nodes + 1] = sin_alpha
    return misfit, jacobian


def solve(
    guess: TipStates, eta: FloatArray, closure: Closure, operator: FloatArray | None = None
) -> tuple[TipStates, BoolArray]:
    """Newton iteration from a guess, for a batch of states at once.

    Parameters
    ----------
    guess : TipStates
        Starting states; not modified.
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
        The offset or the inclination that each state must have.
    operator : ndarray, optional
        `integral_operator(guess.theta, guess.nodes)`, where the caller has it already.

    Returns
    -------
    states : TipStates
        Solutions; NaN where the iteration did not converge.
    converged : ndarray of bool, shape (n,)
    """
    if operator is None:
        operator = integral_operator(guess.theta, guess.nodes)
    states = TipStates(guess.theta, guess.phi.copy(), guess.fx.copy(), guess.fy.copy())
    converged = np.zeros(len(states), dtype=bool)
    active = np.arange(len(states))
    for _ in range(MAX_ITERATIONS):
        everything = len(active) == len(states)
        current = states if everything else states.take(active)
        misfit, jacobian = newton_system(
            current,
            eta[active],
            closure.take(active),
            operator if everything else operator[active],
        )
        usable = np.isfinite(misfit).all(axis=1) & np.isfinite(jacobian).all(axis=(1, 2))
        update = np.full_like(misfit, np.nan)
        try:
            update[usable] = np.linalg.solve(jacobian[usable], misfit[usable, :, None])[..., 0]
        except np.linalg.LinAlgError:  # one exactly singular matrix spoils the whole stack
            update[usable] = [
                _solve_or_nan(a, b) for a, b in zip(jacobian[usable], misfit[usable], strict=True)
            ]
        nodes = states.nodes
        states.put(
            active,
            TipStates(
                current.theta,
                current.phi - update[:, :nodes],
                current.fx - update[:, nodes],
                current.fy - update[:, nodes + 1],
            ),
        )
        scale = 1.0 + np.abs(current.fx) + np.abs(current.fy)
        size = np.maximum(
            np.abs(update[:, :nodes]).max(axis=1), np.abs(update[:, nodes:]).max(axis=1) / scale
        )
        done = size < UPDATE_TOLERANCE
        converged[active[done]] = True
        active = active[~done & np.isfinite(size)]
        if not len(active):
            break
    states.phi[~converged], states.fx[~converged], states.fy[~converged] = np.nan, np.nan, np.nan
    return states, converged


def _solve_or_nan(matrix: FloatArray, right: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)
