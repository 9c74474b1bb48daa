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
    ∫ cos φ ds + 1 − s_c = offset ,  fx·cos α + fy·sin α = 0  or
    (m(0)/force)·cos p = (∫ cos φ ds + 1 − s_c − centre)·sin p ,                    (E3a, E3b, E3c)
    s_c = 1     or     φ(s_c) = 0 .                                               (E4a, E4b)

E3a prescribes where the tip sits relative to the clamp (sticking: the part that lies on the surface
does not move, the rod rolls on or off), E3b the inclination α of the force (α = 0 is the state in
which sticking begins), E3c the *swing* p, the polar angle of the point that offset and clamp moment
make (it goes on increasing where offset and α turn back). With none, E4a and E4b hold at once: the
state in which the contact changes from one kind to the other.

φ is a polynomial in the bending coordinate τ (`vibrissa.taper`) of the free part through
Gauss–Legendre nodes. All functions work on batches: the first axis counts states.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index
from vibrissa.spectral import gauss_rule, legendre_series, refinement_matrix
from vibrissa.status import Contact
from vibrissa.taper import (
    arc_density,
    bending_coordinate,
    compliance_density,
    density_growth,
)

MAX_ITERATIONS = 25
# Newton converges quadratically: an update this small leaves an error of its square.
UPDATE_TOLERANCE = 1e-8


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
    swing : ndarray, shape (n,), or None
        Prescribed polar angle of (offset − centre, m/force), in rad: E3c.
    centre, force : ndarray, shape (n,), or None
        What it refers to (L and E·I0/L²).

    Notes
    -----
    With none of them the contact is about to change its kind: E4a and E4b.
    """

    contact: Contact = Contact.POINT
    offset: FloatArray | None = None
    alpha: FloatArray | None = None
    swing: FloatArray | None = None
    centre: FloatArray | None = None
    force: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse a closure that prescribes more than one."""
        if sum(value is not None for value in (self.offset, self.alpha, self.swing)) > 1:
            raise ValueError("prescribe one of offset, inclination alpha and swing")

    @property
    def switches(self) -> bool:
        """Whether the contact is about to change its kind."""
        return self.offset is None and self.alpha is None and self.swing is None

    @property
    def condition(self) -> FloatArray:
        """Condition E3 as a·offset + b·m + c·fx + d·fy = e, the rows (a, b, c, d, e)."""
        if self.offset is not None:
            nothing = np.zeros_like(self.offset)
            return np.stack([nothing + 1.0, nothing, nothing, nothing, self.offset])
        if self.alpha is not None:
            nothing = np.zeros_like(self.alpha)
            return np.stack([nothing, nothing, np.cos(self.alpha), np.sin(self.alpha), nothing])
        if self.swing is None or self.centre is None or self.force is None:
            raise ValueError("there is no offset, inclination alpha or swing with its references")
        nothing = np.zeros_like(self.swing)
        across, along = -np.sin(self.swing), np.cos(self.swing) / self.force
        return np.stack([across, along, nothing, nothing, across * self.centre])

    def take(self, index: Index) -> "Closure":
        """Select the conditions of some states."""
        return Closure(
            self.contact,
            None if self.offset is None else self.offset[index],
            None if self.alpha is None else self.alpha[index],
            None if self.swing is None else self.swing[index],
            None if self.centre is None else self.centre[index],
            None if self.force is None else self.force[index],
        )


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
    rule = gauss_rule(states.nodes)
    density = states.arc_density(rule.nodes)
    return -(density * load_density(states.phi, states.fx, states.fy)) @ rule.to_end.T


def clamp_moment(states: ContactStates) -> FloatArray:
    """Clamp reaction moment φ'(0) = m(0).

    Parameters
    ----------
    states : ContactStates

    Returns
    -------
    ndarray, shape (n,)
        Moment, in units of E·I0/L.
    """
    rule = gauss_rule(states.nodes)
    density = states.arc_density(rule.nodes)
    return -(density * load_density(states.phi, states.fx, states.fy)) @ rule.weights


def contact_slope(states: ContactStates) -> FloatArray:
    """Slope φ1 at the contact point by equation E1 at s = s_c.

    Parameters
    ----------
    states : ContactStates

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
    compliance = states.compliance_density(rule.nodes)
    return np.pi / 2 + (compliance * bending_moment(states)) @ rule.weights


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
        Largest of the misfits of E1 and E4b (rad), E2, E3a and E3c (L) and E3b (relative to the
        force).
    """
    fine = 2 * states.nodes + 7
    rule = gauss_rule(fine)
    phi = states.phi @ refinement_matrix(states.nodes, fine).T
    density, compliance = states.arc_density(rule.nodes), states.compliance_density(rule.nodes)
    weights = rule.weights * density
    inner = phi[:, 1:-1]
    gradient = density * load_density(inner, states.fx, states.fy)
    bend = -compliance * (gradient @ rule.to_end.T)
    expected = np.pi / 2 + np.concatenate(
        [np.zeros((len(states), 1)), bend @ rule.from_start.T, (bend @ rule.weights)[:, None]],
        axis=1,
    )
    misfits = [
        np.abs(phi - expected).max(axis=1),
        np.abs((weights * np.sin(inner)).sum(axis=1) - eta),
    ]
    if not closure.switches:
        of_offset, of_moment, of_fx, of_fy, value = closure.condition
        offset = (weights * np.cos(inner)).sum(axis=1) + 1.0 - states.s_c
        misfit = of_offset * offset - of_moment * (gradient @ rule.weights) - value
        misfit += (of_fx * states.fx + of_fy * states.fy) / np.hypot(states.fx, states.fy)
        misfits.append(np.abs(misfit))
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


def integral_operator(theta: FloatArray, nodes: int, s_c: FloatArray | None = None) -> FloatArray:
    """Matrix of ∫₀ˢ B⁻¹(u) ∫ᵤ^s_c (·) dv du at the nodes.

    Parameters
    ----------
    theta : ndarray, shape (n,)
        Taper factors.
    nodes : int
        Number of Gauss nodes.
    s_c : ndarray, shape (n,), optional
        Arc length of the contact point, 1 by default.

    Returns
    -------
    ndarray, shape (n, nodes, nodes)
    """
    rule = gauss_rule(nodes)
    s_c = np.ones_like(theta) if s_c is None else s_c
    compliance = compliance_density(rule.nodes, theta[:, None], s_c[:, None])
    density = arc_density(rule.nodes, theta[:, None], s_c[:, None])
    return (rule.from_start * compliance[:, None, :]) @ (rule.to_end * density[:, None, :])


def newton_system(
    states: ContactStates, eta: FloatArray, closure: Closure, operator: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Misfit of the collocated equations E1–E4 and its Jacobian.

    The unknowns are φ at the nodes, fx, fy and s_c, in this order; the equations are E1 at the
    nodes, E2, E3 and E4. In point contact s_c is 1 and stays it, so its column is left out.

    Parameters
    ----------
    states : ContactStates
    eta : ndarray, shape (n,)
    closure : Closure
    operator : ndarray, shape (n, nodes, nodes)
        `integral_operator` of the states.

    Returns
    -------
    misfit : ndarray, shape (n, nodes + 3)
    jacobian : ndarray, shape (n, nodes + 3, nodes + 3)
    """
    nodes = states.nodes
    rule = gauss_rule(nodes)
    density = states.arc_density(rule.nodes)
    weights = rule.weights * density
    sin, cos = np.sin(states.phi), np.cos(states.phi)
    fx, fy = states.fx[:, None], states.fy[:, None]
    load, load_slope = fx * sin - fy * cos, fx * cos + fy * sin
    bent_sin = np.matvec(operator, sin)
    bent_cos = np.matvec(operator, cos)
    height, reach = (weights * sin).sum(axis=1), (weights * cos).sum(axis=1)
    f_x, f_y, contact = nodes, nodes + 1, nodes + 2  # columns of fx, fy and s_c
    e2, e3, e4 = nodes, nodes + 1, nodes + 2  # rows
    misfit = np.empty((len(states), nodes + 3))
    jacobian = np.zeros((len(states), nodes + 3, nodes + 3))

    misfit[:, :nodes] = states.phi - np.pi / 2 + fx * bent_sin - fy * bent_cos
    jacobian[:, :nodes, :nodes] = operator * load_slope[:, None, :]
    diagonal = np.arange(nodes)
    jacobian[:, diagonal, diagonal] += 1.0
    jacobian[:, :nodes, f_x] = bent_sin
    jacobian[:, :nodes, f_y] = -bent_cos

    misfit[:, e2] = height - eta
    jacobian[:, e2, :nodes] = weights * cos

    if not closure.switches:
        of_offset, of_moment, of_fx, of_fy, value = closure.condition
        offset, moment = reach + 1.0 - states.s_c, -(weights * load).sum(axis=1)
        misfit[:, e3] = of_offset * offset + of_moment * moment - value
        misfit[:, e3] += of_fx * states.fx + of_fy * states.fy
        jacobian[:, e3, :nodes] = -of_moment[:, None] * weights * load_slope
        jacobian[:, e3, :nodes] -= of_offset[:, None] * weights * sin
        jacobian[:, e3, f_x] = of_fx - of_moment * height
        jacobian[:, e3, f_y] = of_fy + of_moment * reach

    # The rows of φ(s_c) = 0: E4b, and in place of E3 where the contact changes its kind.
    slope_rows = [e4] if closure.contact is Contact.LINE else []
    slope_rows += [e3] if closure.switches else []
    if slope_rows:
        compliance = states.compliance_density(rule.nodes)
        functional = ((rule.weights * compliance) @ rule.to_end) * density
        for row in slope_rows:
            misfit[:, row] = np.pi / 2 - (functional * load).sum(axis=1)
            jacobian[:, row, :nodes] = -functional * load_slope
            jacobian[:, row, f_x] = -(functional * sin).sum(axis=1)
            jacobian[:, row, f_y] = (functional * cos).sum(axis=1)
    if closure.contact is Contact.POINT:
        misfit[:, e4] = states.s_c - 1.0
        jacobian[:, e4, contact] = 1.0
        return misfit, jacobian

    # How everything grows with the length of the free part.
    arc_growth, compliance_growth = density_growth(
        rule.nodes, states.theta[:, None], states.s_c[:, None]
    )
    moment = (density * load) @ rule.to_end.T
    bend_growth = compliance * (
        compliance_growth * moment + (arc_growth * density * load) @ rule.to_end.T
    )
    jacobian[:, :nodes, contact] = bend_growth @ rule.from_start.T
    jacobian[:, e2, contact] = (arc_growth * weights * sin).sum(axis=1)
    if not closure.switches:
        longer = arc_growth * weights
        jacobian[:, e3, contact] = of_offset * ((longer * cos).sum(axis=1) - 1.0)
        jacobian[:, e3, contact] -= of_moment * (longer * load).sum(axis=1)
    jacobian[:, e4, contact] = -(bend_growth @ rule.weights)
    return misfit, jacobian


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
    density, compliance = states.arc_density(rule.nodes), states.compliance_density(rule.nodes)
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


# Where the iteration diverges numbers overflow; the result says so.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def solve(
    guess: ContactStates, eta: FloatArray, closure: Closure, operator: FloatArray | None = None
) -> tuple[ContactStates, BoolArray]:
    """Newton iteration from a guess, for a batch of states at once.

    Parameters
    ----------
    guess : ContactStates
        Starting states; not modified.
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
        The offset or the inclination that each state must have.
    operator : ndarray, optional
        `integral_operator(guess.theta, guess.nodes)` for point contact, where the caller has it
        already.

    Returns
    -------
    states : ContactStates
        Solutions; NaN where the iteration did not converge.
    converged : ndarray of bool, shape (n,)
    """
    point = closure.contact is Contact.POINT
    # In point contact the rod, and with it the operator, stays the same throughout.
    fixed = integral_operator(guess.theta, guess.nodes) if operator is None and point else operator
    states = ContactStates(
        guess.theta,
        guess.phi.copy(),
        guess.fx.copy(),
        guess.fy.copy(),
        np.ones_like(guess.s_c) if point else guess.s_c.copy(),
    )
    converged = np.zeros(len(states), dtype=bool)
    active = np.arange(len(states))
    for _ in range(MAX_ITERATIONS):
        everything = len(active) == len(states)
        current = states if everything else states.take(active)
        if fixed is None:
            matrix = integral_operator(current.theta, current.nodes, current.s_c)
        else:
            matrix = fixed if everything else fixed[active]
        misfit, jacobian = newton_system(current, eta[active], closure.take(active), matrix)
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
            ContactStates(
                current.theta,
                current.phi - update[:, :nodes],
                current.fx - update[:, nodes],
                current.fy - update[:, nodes + 1],
                current.s_c - update[:, nodes + 2],
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
    for values in (states.phi, states.fx, states.fy, states.s_c):
        values[~converged] = np.nan
    return states, converged


def _solve_or_nan(matrix: FloatArray, right: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)
