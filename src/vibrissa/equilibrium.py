r"""Equilibrium of the clamped rod in contact with the surface: spectral collocation and Newton.

The rod touches the surface at arc length s_c: with its tip (point contact, s_c = 1) or, where the
tip would pass through the surface, tangentially at s_c < 1 with the rest lying straight and
unloaded on it (line contact). On the free part the moment obeys m' = fx·sin φ − fy·cos φ with
m(s_c) = 0 for the contact force (fx, fy), and B·φ' = m with φ(0) = π/2. Integrated twice this is
one equation for the slope φ alone,

    φ(s) = π/2 − ∫₀ˢ B⁻¹(u) ∫ᵤ^s_c (fx·sin φ − fy·cos φ) dv du ,                          (E1)

closed by the height of the contact point above the clamp, by one more condition, and by the kind
of contact,

    ∫ sin φ ds = η ,                                                                     (E2)
    offset = ∫ cos φ ds + 1 − s_c ,  fx·cos α + fy·sin α = 0  or
    (x1_init − offset)/x1_init + (3·fx − fy)/(10·force) = advance ,                (E3a, E3b, E3c)
    s_c = 1     or     φ(s_c) = 0 .                                               (E4a, E4b)

E3a prescribes where the tip sits relative to the clamp (sticking: the part that lies on the surface
does not move, the rod rolls on or off), E3b the inclination α of the force (α = 0 is the state in
which sticking begins), E3c the *advance*, the displacement of the clamp and the growth of the force
taken together, each relative to the α = 0 state (it goes on increasing where offset and α turn
back). With none, E4a and E4b hold at once: the state in which the contact changes from one kind to
the other.

φ is a polynomial in the bending coordinate τ (`vibrissa.taper`) of the free part through
Gauss–Legendre nodes. All functions work on batches: the first axis counts states.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index, SingleArray
from vibrissa.spectral import gauss_rule, legendre_series, refinement_matrix
from vibrissa.status import Contact
from vibrissa.taper import (
    arc_density,
    bending_coordinate,
    compliance_density,
    densities,
    density_growth,
)

# What a force grown by its first value adds to the advance: so weighted it increases along every
# curve, in both kinds of contact.
WEIGHT_OF_FX, WEIGHT_OF_FY = 0.3, -0.1
MAX_ITERATIONS = 25
# Part of the nodes on which corrections are found, and the fewest that make sense.
COARSE_NODES = 0.3
FEWEST_COARSE_NODES = 10
# Where a correction is not this much smaller than the one before, the inverse is computed anew.
GOOD_CONTRACTION = 0.1
# Corrections below this may be rounding, on many nodes.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class ContactStates:
    """A batch of rod shapes with the contact force that belongs to each.

    Attributes
    ----------
    theta : ndarray, shape (n,)
        Taper factors.
    phi : ndarray, shape (n, nodes)
        Slope angle at the Gauss nodes in τ on the free part, in rad.
    fx, fy : ndarray, shape (n,)
        Contact force on the rod, in units of E·I0/L²; f·sin α and −f·cos α.
    s_c : ndarray, shape (n,)
        Arc length of the contact point, in units of L.
    """

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray
    s_c: FloatArray

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.theta)

    @property
    def nodes(self) -> int:
        """Number of collocation nodes along the rod."""
        return int(self.phi.shape[1])

    def take(self, index: Index) -> Self:
        """Select states by index or mask."""
        return type(self)(
            self.theta[index], self.phi[index], self.fx[index], self.fy[index], self.s_c[index]
        )

    def put(self, index: Index, other: Self) -> None:
        """Overwrite the states at `index` by those of `other`."""
        self.phi[index], self.fx[index], self.fy[index] = other.phi, other.fx, other.fy
        self.s_c[index] = other.s_c

    def on_nodes(self, nodes: int) -> Self:
        """Interpolate the slopes to another number of nodes."""
        phi = self.phi @ refinement_matrix(self.nodes, nodes)[1:-1].T
        return replace(self, phi=phi)

    def arc_density(self, tau: FloatArray) -> FloatArray:
        """Arc length per bending coordinate on the free part, shape (n, len(tau))."""
        return arc_density(tau, self.theta[:, None], self.s_c[:, None])

    def densities(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both of them at once."""
        return densities(tau, self.theta[:, None], self.s_c[:, None])

    def compliance_density(self, tau: FloatArray) -> FloatArray:
        """Bending compliance per bending coordinate on the free part, shape (n, len(tau))."""
        return compliance_density(tau, self.theta[:, None], self.s_c[:, None])


@dataclass(frozen=True, eq=False)
class Closure:
    """Conditions E3 and E4 that close the equations of a batch of states.

    Attributes
    ----------
    contact : Contact
        Kind of contact of all states: E4a or E4b.
    offset : ndarray, shape (n,), or None
        Prescribed x1 − x0, in units of L: E3a.
    alpha : ndarray, shape (n,), or None
        Prescribed inclination of the contact force, in rad: E3b.
    advance : ndarray, shape (n,), or None
        Prescribed advance along the curve: E3c.
    x1_init, force : ndarray, shape (n,), or None
        Offset (L) and contact force (E·I0/L²) of the α = 0 state that it refers to.

    Notes
    -----
    With none of them the contact is about to change its kind: E4a and E4b.
    """

    contact: Contact = Contact.POINT
    offset: FloatArray | None = None
    alpha: FloatArray | None = None
    advance: FloatArray | None = None
    x1_init: FloatArray | None = None
    force: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse a closure that prescribes more than one, or the advance without its reference."""
        if sum(value is not None for value in (self.offset, self.alpha, self.advance)) > 1:
            raise ValueError("prescribe one of offset, inclination alpha and advance")
        if self.advance is not None and (self.x1_init is None or self.force is None):
            raise ValueError("the advance needs x1_init and force of the state it refers to")

    @property
    def switches(self) -> bool:
        """Whether the contact is about to change its kind."""
        return self.offset is None and self.alpha is None and self.advance is None

    @property
    def condition(self) -> FloatArray:
        """Condition E3 as a·offset + b·fx + c·fy = d, the rows (a, b, c, d)."""
        if self.offset is not None:
            nothing = np.zeros_like(self.offset)
            return np.stack([nothing + 1.0, nothing, nothing, self.offset])
        if self.alpha is not None:
            nothing = np.zeros_like(self.alpha)
            return np.stack([nothing, np.cos(self.alpha), np.sin(self.alpha), nothing])
        if self.advance is None or self.x1_init is None or self.force is None:
            raise ValueError("there is no offset, inclination alpha or advance with its reference")
        of_fx, of_fy = WEIGHT_OF_FX / self.force, WEIGHT_OF_FY / self.force
        return np.stack([-1.0 / self.x1_init, of_fx, of_fy, self.advance - 1.0])

    def take(self, index: Index) -> "Closure":
        """Select the conditions of some states."""
        return Closure(
            self.contact,
            None if self.offset is None else self.offset[index],
            None if self.alpha is None else self.alpha[index],
            None if self.advance is None else self.advance[index],
            None if self.x1_init is None else self.x1_init[index],
            None if self.force is None else self.force[index],
        )


def advance(states: ContactStates, x1_init: FloatArray, force: FloatArray) -> FloatArray:
    """Advance along a curve, the left side of E3c.

    Parameters
    ----------
    states : ContactStates
    x1_init, force : ndarray, shape (n,)
        Offset (L) and contact force (E·I0/L²) of the α = 0 states.

    Returns
    -------
    ndarray, shape (n,)
        0.1 in the α = 0 state itself.
    """
    offset, _ = contact_position(states)
    growth = WEIGHT_OF_FX * states.fx + WEIGHT_OF_FY * states.fy
    return 1.0 - offset / x1_init + growth / force


def bending_moment(states: ContactStates) -> FloatArray:
    """Bending moment m(s) = −∫ m' ds from s to the contact point, at the nodes.

    Parameters
    ----------
    states : ContactStates

    Returns
    -------
    ndarray, shape (n, nodes)
        Moment, in units of E·I0/L.
    """
    return -(_bending(states)[2] @ gauss_rule(states.nodes).to_end.T)


def readings(states: ContactStates) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Offset of the tip, clamp moment and slope at the contact point.

    Parameters
    ----------
    states : ContactStates

    Returns
    -------
    offset : ndarray, shape (n,)
        ∫cos φ ds + 1 − s_c, in units of L.
    moment : ndarray, shape (n,)
        Clamp reaction moment φ'(0) = m(0), in units of E·I0/L.
    phi1 : ndarray, shape (n,)
        Slope φ1 by equation E1 at s = s_c, in rad.

    Notes
    -----
    The integral for φ1 is more accurate than the polynomial's own value at τ = 1: Gauss collocation
    superconverges at the ends.
    """
    rule = gauss_rule(states.nodes)
    _, cos, gradient, bend = _bending(states)
    offset = cos @ rule.weights + 1.0 - states.s_c
    moment = -(gradient @ rule.weights)
    phi1 = np.pi / 2 + bend @ rule.weights
    return offset, moment, phi1


def _bending(states: ContactStates) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Integrands at the nodes, per τ: of height, of reach, of the moment and of the slope φ.

    The moment gradient is m' = fx·sin φ − fy·cos φ = f·cos(φ − α).
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    sin, cos = density * np.sin(states.phi), density * np.cos(states.phi)
    gradient = states.fx[:, None] * sin - states.fy[:, None] * cos
    return sin, cos, gradient, -compliance * (gradient @ rule.to_end.T)


def clamp_moment(states: ContactStates) -> FloatArray:
    """Clamp reaction moment m(0) of `readings`, in units of E·I0/L."""
    return readings(states)[1]


def contact_slope(states: ContactStates) -> FloatArray:
    """Slope φ1 at the contact point of `readings`, in rad."""
    return readings(states)[2]


def contact_position(states: ContactStates) -> tuple[FloatArray, FloatArray]:
    """Position of the tip along the surface and height of the surface, seen from the clamp.

    Parameters
    ----------
    states : ContactStates

    Returns
    -------
    offset, height : ndarray, shape (n,)
        ∫cos φ ds + 1 − s_c and ∫sin φ ds, in units of L.
    """
    rule = gauss_rule(states.nodes)
    weights = rule.weights * states.arc_density(rule.nodes)
    offset = (weights * np.cos(states.phi)).sum(axis=1) + 1.0 - states.s_c
    return offset, (weights * np.sin(states.phi)).sum(axis=1)


def shape(states: ContactStates, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Deformed shape, the part that lies on the surface included, with the clamp at the origin.

    Parameters
    ----------
    states : ContactStates
    s : ndarray, shape (points,)
        Arc lengths from the clamp in [0, 1], in units of L.

    Returns
    -------
    x, y : ndarray, shape (n, points)
        Position, in units of L.
    phi : ndarray, shape (n, points)
        Slope, in rad.
    """
    rule = gauss_rule(states.nodes)
    free = np.minimum(s, states.s_c[:, None])
    tau = bending_coordinate(free, states.theta[:, None], states.s_c[:, None])
    values, integrals = legendre_series(states.nodes, tau)
    density = states.arc_density(rule.nodes)

    def at_points(series: FloatArray, nodal: FloatArray) -> FloatArray:
        return np.einsum("npk,nk->np", series, nodal @ rule.to_coefficients.T)

    # Beyond the contact point the rod is straight, with the slope that it has there.
    phi = at_points(values, states.phi)
    x = at_points(integrals, density * np.cos(states.phi)) + (s - free) * np.cos(phi)
    y = at_points(integrals, density * np.sin(states.phi)) + (s - free) * np.sin(phi)
    return x, y, phi


def residual(states: ContactStates, eta: FloatArray, closure: Closure) -> FloatArray:
    """Largest misfit of E1 to E4, measured on more than twice the nodes.

    Collocation satisfies the equations at its own nodes whatever their number. Interpolating φ to
    a finer rule and asking again tells whether the polynomial satisfies them between the nodes.

    Parameters
    ----------
    states : ContactStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure

    Returns
    -------
    ndarray, shape (n,)
        Largest of the misfits of E1 and E4b (rad), E2 and E3a (L), E3b (relative to the force)
        and E3c.
    """
    fine = 2 * states.nodes + 7
    rule = gauss_rule(fine)
    phi = states.phi @ refinement_matrix(states.nodes, fine).T
    sin, cos, _, bend = _bending(replace(states, phi=phi[:, 1:-1]))
    expected = np.pi / 2 + np.concatenate(
        [np.zeros((len(states), 1)), bend @ rule.from_start.T, (bend @ rule.weights)[:, None]],
        axis=1,
    )
    misfits = [
        np.abs(phi - expected).max(axis=1),
        np.abs(sin @ rule.weights - eta),
    ]
    if not closure.switches:
        of_offset, of_fx, of_fy, value = closure.condition
        offset = cos @ rule.weights + 1.0 - states.s_c
        condition = of_offset * offset + of_fx * states.fx + of_fy * states.fy - value
        if closure.alpha is not None:
            condition /= np.hypot(states.fx, states.fy)
        misfits.append(np.abs(condition))
    if closure.contact is Contact.LINE or closure.switches:
        misfits.append(np.abs(phi[:, -1]))
    if closure.contact is Contact.POINT:
        misfits.append(np.abs(states.s_c - 1.0))
    return np.maximum.reduce(misfits)


def coefficient_decay(states: ContactStates) -> FloatArray:
    """Size of the last Legendre coefficients of φ relative to the largest.

    Parameters
    ----------
    states : ContactStates

    Returns
    -------
    ndarray, shape (n,)
        Near rounding error where φ is resolved; of order one where it is not.
    """
    coefficients = np.abs(states.phi @ gauss_rule(states.nodes).to_coefficients.T)
    return coefficients[:, -2:].max(axis=1) / coefficients.max(axis=1)


def misfit(states: ContactStates, eta: FloatArray, closure: Closure) -> FloatArray:
    """Misfit of the collocated equations E1–E4.

    The equations are E1 at the nodes, E2, E3 and E4, in this order.

    Parameters
    ----------
    states : ContactStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure

    Returns
    -------
    ndarray, shape (n, nodes + 3)
    """
    nodes = states.nodes
    rule = gauss_rule(nodes)
    sin, cos, _, bend = _bending(states)
    values = np.empty((len(states), nodes + 3))
    values[:, :nodes] = states.phi - (np.pi / 2 + bend @ rule.from_start.T)
    values[:, nodes] = sin @ rule.weights - eta
    phi1 = np.pi / 2 + bend @ rule.weights
    if closure.switches:
        values[:, nodes + 1] = phi1
    else:
        of_offset, of_fx, of_fy, value = closure.condition
        offset = cos @ rule.weights + 1.0 - states.s_c
        values[:, nodes + 1] = of_offset * offset + of_fx * states.fx + of_fy * states.fy - value
    point = closure.contact is Contact.POINT
    values[:, nodes + 2] = states.s_c - 1.0 if point else phi1
    return values


def jacobian(states: ContactStates, closure: Closure) -> SingleArray:
    """Differentiate `misfit` by the unknowns, in single precision.

    The unknowns are φ at the nodes, fx, fy and s_c, in this order. In point contact s_c is 1 and
    stays it, so its column is left out.

    Parameters
    ----------
    states : ContactStates
    closure : Closure

    Returns
    -------
    ndarray of float32, shape (n, nodes + 3, nodes + 3)
    """
    nodes = states.nodes
    rule = gauss_rule(nodes)
    density, compliance = states.densities(rule.nodes)
    sin, cos = density * np.sin(states.phi), density * np.cos(states.phi)
    fx, fy = states.fx[:, None], states.fy[:, None]
    load, load_slope = fx * sin - fy * cos, fx * cos + fy * sin
    f_x, f_y, contact = nodes, nodes + 1, nodes + 2  # columns of fx, fy and s_c
    e2, e3, e4 = nodes, nodes + 1, nodes + 2  # rows
    matrix = np.zeros((len(states), nodes + 3, nodes + 3), dtype=np.float32)

    from_start, to_end = rule.from_start.astype(np.float32), rule.to_end.astype(np.float32)
    twice = (from_start * compliance.astype(np.float32)[:, None, :]).reshape(-1, nodes) @ to_end
    slopes = twice.reshape(-1, nodes, nodes) * load_slope.astype(np.float32)[:, None, :]
    matrix[:, :nodes, :nodes] = slopes
    diagonal = np.arange(nodes)
    matrix[:, diagonal, diagonal] += 1.0
    bend_of_fx, bend_of_fy = compliance * (sin @ rule.to_end.T), compliance * (cos @ rule.to_end.T)
    matrix[:, :nodes, f_x] = bend_of_fx @ rule.from_start.T
    matrix[:, :nodes, f_y] = -bend_of_fy @ rule.from_start.T

    matrix[:, e2, :nodes] = rule.weights * cos

    if not closure.switches:
        of_offset, of_fx, of_fy, _ = closure.condition
        matrix[:, e3, :nodes] = -of_offset[:, None] * rule.weights * sin
        matrix[:, e3, f_x], matrix[:, e3, f_y] = of_fx, of_fy

    # The rows of φ(s_c) = 0: E4b, and in place of E3 where the contact changes its kind.
    slope_rows = [e4] if closure.contact is Contact.LINE else []
    slope_rows += [e3] if closure.switches else []
    for row in slope_rows:
        matrix[:, row, :nodes] = -((rule.weights * compliance) @ rule.to_end) * load_slope
        matrix[:, row, f_x] = -(bend_of_fx @ rule.weights)
        matrix[:, row, f_y] = bend_of_fy @ rule.weights
    if closure.contact is Contact.POINT:
        matrix[:, e4, contact] = 1.0
        return matrix

    # How everything grows with the length of the free part.
    arc_growth, compliance_growth = density_growth(
        rule.nodes, states.theta[:, None], states.s_c[:, None]
    )
    bend_growth = compliance * (
        compliance_growth * (load @ rule.to_end.T) + (arc_growth * load) @ rule.to_end.T
    )
    matrix[:, :nodes, contact] = bend_growth @ rule.from_start.T
    matrix[:, e2, contact] = (arc_growth * sin) @ rule.weights
    if not closure.switches:
        matrix[:, e3, contact] = of_offset * ((arc_growth * cos) @ rule.weights - 1.0)
    matrix[:, e4, contact] = -(bend_growth @ rule.weights)
    return matrix


def stability(states: ContactStates, contact: Contact) -> FloatArray:
    """How far each equilibrium is from losing stability with clamp and contact point held fixed.

    An equilibrium is a minimum of the bending energy under its constraints if the second
    variation ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every ψ with ψ(0) = 0 that
    keeps the contact point: ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0, and ψ(s_c) = 0 where the rod lies
    tangentially on the surface.

    Parameters
    ----------
    states : ContactStates
    contact : Contact
        Kind of contact of all states.

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per bending energy of ψ: at most 1, positive where the equilibrium
        is stable, zero where it stops being so.
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    # ψ from u, the square root of its bending energy density: ∫ B·ψ'² ds = Σ u²
    root = np.sqrt(rule.weights * compliance)
    slope = rule.from_start * (compliance / root)[:, None, :]
    load = rule.weights * density
    load_slope = load * (
        states.fx[:, None] * np.cos(states.phi) + states.fy[:, None] * np.sin(states.phi)
    )
    quadratic = np.swapaxes(slope, 1, 2) @ (load_slope[:, :, None] * slope)
    constraints = [
        np.vecmat(load * np.sin(states.phi), slope),
        np.vecmat(load * np.cos(states.phi), slope),
    ]
    if contact is Contact.LINE:
        constraints.append(root)
    basis, _ = np.linalg.qr(np.stack(constraints, axis=-1), mode="complete")
    free = basis[:, :, len(constraints) :]
    projected = np.swapaxes(free, 1, 2) @ quadratic @ free
    found = np.isfinite(projected).all(axis=(1, 2))
    margin = np.full(len(states), np.nan)
    margin[found] = 1.0 + np.linalg.eigvalsh(projected[found])[:, 0]
    return margin


def extrapolated(last: list[ContactStates]) -> ContactStates:
    """Polynomial extrapolation by one step from up to three equally spaced batches of states.

    Parameters
    ----------
    last : list of ContactStates
        One to three batches, the latest one last.

    Returns
    -------
    ContactStates
        A guess of the next batch.
    """
    weights = {1: (1.0,), 2: (-1.0, 2.0), 3: (1.0, -3.0, 3.0)}[len(last)]

    def combined(name: str) -> FloatArray:
        return np.sum([w * getattr(s, name) for w, s in zip(weights, last, strict=True)], axis=0)

    return ContactStates(last[0].theta, *map(combined, ("phi", "fx", "fy", "s_c")))


def coarse_inverse(states: ContactStates, closure: Closure) -> SingleArray:
    """Inverse of the Jacobian on few nodes, which corrects states on all of them.

    Parameters
    ----------
    states : ContactStates
    closure : Closure

    Returns
    -------
    ndarray of float32, shape (n, k + 3, k + 3)
        In single precision: a correction need not be more accurate. NaN where there is none.
    """
    matrices = jacobian(states.on_nodes(coarse_nodes(states.nodes)), closure)
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:  # one exactly singular matrix spoils the whole stack
        return np.stack([_inverse_or_nan(matrix) for matrix in matrices])


def _inverse_or_nan(matrix: SingleArray) -> SingleArray:
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full_like(matrix, np.nan)


def coarse_nodes(nodes: int) -> int:
    """Few nodes: those on which corrections of states on `nodes` nodes are found."""
    return min(nodes, max(FEWEST_COARSE_NODES, round(COARSE_NODES * nodes)))


def corrected(
    states: ContactStates, eta: FloatArray, closure: Closure, inverse: SingleArray
) -> tuple[ContactStates, FloatArray]:
    """Correct states once, on two grids.

    The misfit is that on all nodes, but the correction comes from few: what it has beyond the
    misfit itself is twice integrated by equation E1, hence smooth (K. E. Atkinson, The Numerical
    Solution of Integral Equations of the Second Kind, 1997, §6.2).

    Parameters
    ----------
    states : ContactStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
    inverse : ndarray, shape (n, k + 3, k + 3)
        `coarse_inverse` of the states or of similar ones.

    Returns
    -------
    states : ContactStates
    size : ndarray, shape (n,)
        Largest change, of the slope (rad), of a force relative to it or of s_c (L).
    """
    nodes, few = states.nodes, inverse.shape[1] - 3
    values = misfit(states, eta, closure)
    restriction, prolongation = _transfer(nodes, few), _transfer(few, nodes)
    right = np.concatenate([values[:, :nodes] @ restriction.T, values[:, nodes:]], axis=1)
    # Scaled, as small numbers would lose digits in single precision.
    scale = np.abs(right).max(axis=1, keepdims=True) + np.finfo(float).tiny
    update = np.matvec(inverse, (right / scale).astype(np.float32)) * scale
    change = values[:, :nodes] + (update[:, :few] - right[:, :few]) @ prolongation.T
    of_fx, of_fy, of_s_c = update[:, few:].T
    force = 1.0 + np.abs(states.fx) + np.abs(states.fy)
    size = np.maximum(np.abs(change).max(axis=1), np.abs(update[:, few:]).max(axis=1) / force)
    better = ContactStates(
        states.theta,
        states.phi - change,
        states.fx - of_fx,
        states.fy - of_fy,
        states.s_c - of_s_c,
    )
    return better, size


def _transfer(nodes: int, other: int) -> FloatArray:
    """Interpolation from some nodes to others."""
    return np.eye(nodes) if nodes == other else refinement_matrix(nodes, other)[1:-1]


# Where the iteration diverges numbers overflow; the result says so.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def solve(
    guess: ContactStates,
    eta: FloatArray,
    closure: Closure,
    inverse: SingleArray | None = None,
    tolerance: float = 1e-12,
) -> tuple[ContactStates, BoolArray, SingleArray]:
    """Solve a batch of states at once, starting from a guess.

    Parameters
    ----------
    guess : ContactStates
        Starting states; not modified.
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
        The conditions that each state must satisfy.
    inverse : ndarray, shape (n, k + 3, k + 3), optional
        `coarse_inverse` near each state, where the caller has it already.
    tolerance : float
        Change at which the iteration ends; the error is then about a hundredth of it.

    Returns
    -------
    states : ContactStates
        Solutions; NaN where the iteration did not converge.
    converged : ndarray of bool, shape (n,)
    inverse : ndarray, shape (n, k + 3, k + 3)
        `coarse_inverse` near each of them.
    """
    states = ContactStates(
        guess.theta,
        guess.phi.copy(),
        guess.fx.copy(),
        guess.fy.copy(),
        np.ones_like(guess.s_c) if closure.contact is Contact.POINT else guess.s_c.copy(),
    )
    inverse = coarse_inverse(states, closure) if inverse is None else inverse.copy()
    converged = np.zeros(len(states), dtype=bool)
    active = np.arange(len(states))
    previous = np.ones(len(states))
    for _ in range(MAX_ITERATIONS):
        everything = len(active) == len(states)
        current, conditions, matrices = states, closure, inverse
        if not everything:
            current, conditions = states.take(active), closure.take(active)
            matrices = inverse[active]
        better, size = corrected(current, eta[active], conditions, matrices)
        states.put(active, better)
        shrunk = size / previous[active]
        # Near rounding nothing shrinks any more.
        done = (size < tolerance) | ((size < ROUNDING) & (shrunk > 0.5))
        previous[active] = size
        converged[active[done]] = True
        slow = active[~done & ~(shrunk < GOOD_CONTRACTION) & np.isfinite(size)]
        active = active[~done & np.isfinite(size)]
        if not len(active):
            break
        if len(slow):
            inverse[slow] = coarse_inverse(states.take(slow), closure.take(slow))
    for values in (states.phi, states.fx, states.fy, states.s_c):
        values[~converged] = np.nan
    return states, converged, inverse
