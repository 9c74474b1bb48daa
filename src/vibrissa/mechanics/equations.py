r"""Equations of equilibrium of the clamped rod in contact, collocated: residuals and Jacobian.

The rod touches the surface at arc length s_c: with its tip (point contact, s_c = 1) or, where the
tip would pass through the surface, tangentially at s_c < 1 with the rest lying straight and
unloaded on it (line contact). On the free part the moment obeys m' = fx·sin φ − fy·cos φ with
m(s_c) = 0 for the contact force (fx, fy), and B·(φ' − κ0) = m with φ(0) = π/2 + β + c·m(0), where
β, c and κ0 belong to the mounting (`vibrissa.mechanics.mounting`; in the paper all are 0).
Integrated twice this is one equation for the slope φ alone,

    φ(s) = π/2 + β + c·m(0) + ∫₀ˢ κ0 du − ∫₀ˢ B⁻¹(u) ∫ᵤ^s_c (fx·sin φ − fy·cos φ) dv du ,
    m(0) = −∫₀^s_c (fx·sin φ − fy·cos φ) dv ,                                            (E1)

closed by the height of the contact point above the clamp, by one more condition, and by the kind
of contact,

    ∫ sin φ ds − tan δ·offset = η − tan δ·x1_init ,                                      (E2)
    offset = ∫ cos φ ds + 1 − s_c ,  fx·cos α + fy·sin α = 0 ,
    direction·(−offset/scale, 0.3·fx/force, 0.1·fy/force, s_c) = advance  or
    φ(s_c) = 0 ,                                                              (E3a, E3b, E3c, E3d)
    s_c = 1     or     φ(s_c) = 0 .                                               (E4a, E4b)

E2 says that the clamp moves at the angle δ to the surface; with δ = 0 the height is η throughout.

E3a prescribes where the tip sits relative to the clamp. While the tip sticks, the part that lies on
the surface does not move: the rod rolls on or off it. E3b prescribes the inclination α of the
force; α = 0 is the state in which sticking begins. E3c prescribes the *advance*, the continuation
parameter: how far a state lies along a direction in which the path goes. It adds the displacement
of the clamp and the growth of the force, each relative to the α = 0 state of the ideal mounting,
and the contact point, and increases also where offset and α turn back.
E3d with s_c = 1 holds where the contact changes from one kind to the other.

φ is a polynomial in the bending coordinate τ (`vibrissa.mechanics.taper`) of the free part through
Gauss–Legendre nodes. All functions work on batches: the first axis counts states.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.states import RodStates
from vibrissa.mechanics.taper import arc_length_growth, bending_coordinate, density_growth
from vibrissa.numerics.arrays import FloatArray, SingleArray
from vibrissa.numerics.batch import Batch, slices
from vibrissa.numerics.spectral import gauss_rule, legendre_series, refinement_matrix
from vibrissa.outcomes import Contact

# Weights of the forces where they are put beside lengths.
WEIGHT_OF_FX, WEIGHT_OF_FY = 0.3, 0.1
# The contact point, as a place along the free part.
END = np.ones(1)
# Slopes that are computed with together: they stay in the processor's cache.
VALUES_TOGETHER = 2**15


@dataclass(frozen=True, eq=False, kw_only=True)
class Closure(Batch):
    """Conditions E2 to E4 that close the equations of a batch of states.

    All forms of E3 are linear in what they prescribe:
    of_offset·offset + of_fx·fx + of_fy·fy + of_s_c·s_c + of_phi1·φ1 = value.

    Attributes
    ----------
    contact : Contact
        Kind of contact of all states: E4a or E4b.
    of_offset, of_fx, of_fy, of_s_c, of_phi1, value : ndarray, shape (n,)
        Coefficients of E3 and its right side.
    tilt : ndarray, shape (n,), or None
        tan δ in E2; None where the clamp moves along the surface.
    """

    contact: Contact
    of_offset: FloatArray
    of_fx: FloatArray
    of_fy: FloatArray
    of_s_c: FloatArray
    of_phi1: FloatArray
    value: FloatArray
    tilt: FloatArray | None = None

    @classmethod
    def _prescribing(cls, value: FloatArray, contact: Contact, **of: FloatArray | float) -> Self:
        """Prescribe a sum in which only some coefficients are not zero."""
        names = ("of_offset", "of_fx", "of_fy", "of_s_c", "of_phi1")
        coefficients = {name: np.zeros_like(value) + of.get(name, 0.0) for name in names}
        return cls(contact=contact, value=value, **coefficients)

    @classmethod
    def at_offset(cls, offset: FloatArray, contact: Contact = Contact.POINT) -> Self:
        """Prescribe x1 − x0, in units of L: E3a."""
        return cls._prescribing(offset, contact, of_offset=1.0)

    @classmethod
    def at_inclination(cls, alpha: FloatArray, contact: Contact = Contact.POINT) -> Self:
        """Prescribe the inclination of the contact force, in rad: E3b."""
        zero = np.zeros_like(alpha)
        return cls._prescribing(zero, contact, of_fx=np.cos(alpha), of_fy=np.sin(alpha))

    @classmethod
    def at_advance(
        cls,
        advance: FloatArray,
        direction: FloatArray,
        scale: FloatArray,
        force: FloatArray,
        contact: Contact = Contact.POINT,
    ) -> Self:
        """Prescribe the advance along a direction, shape (n, 4): E3c.

        The offset counts in units of `scale` (L), the force in units of `force` (E·I0/L²).
        """
        return cls._prescribing(
            advance,
            contact,
            of_offset=-direction[:, 0] / scale,
            of_fx=WEIGHT_OF_FX * direction[:, 1] / force,
            of_fy=WEIGHT_OF_FY * direction[:, 2] / force,
            of_s_c=direction[:, 3],
        )

    @classmethod
    def at_switch(cls, count: int) -> Self:
        """Prescribe that the contact is about to change its kind: E3d with E4a."""
        return cls._prescribing(np.zeros(count), Contact.POINT, of_phi1=1.0)

    def height(self, height: FloatArray, offset: FloatArray) -> FloatArray:
        """Left side of E2."""
        return height if self.tilt is None else height - self.tilt * offset

    def residual(self, offset: FloatArray, states: RodStates, phi1: FloatArray) -> FloatArray:
        """Left minus right side of E3."""
        force = self.of_fx * states.fx + self.of_fy * states.fy
        place = self.of_offset * offset + self.of_s_c * states.s_c
        return place + force + self.of_phi1 * phi1 - self.value


def path_coordinates(
    offset: FloatArray, states: RodStates, scale: FloatArray, force: FloatArray
) -> FloatArray:
    """Coordinates in which directions of a path are measured, see E3c.

    Parameters
    ----------
    offset : ndarray, shape (n,)
        Position of the tip along the surface (L).
    states : RodStates
    scale, force : ndarray, shape (n,)
        Units of the offset (L) and of the force (E·I0/L²).

    Returns
    -------
    ndarray, shape (n, 4)
        −offset/scale, 0.3·fx/force, 0.1·fy/force and s_c; linear, so that changes of offset and
        states give the change of these.
    """
    fx, fy = WEIGHT_OF_FX * states.fx / force, WEIGHT_OF_FY * states.fy / force
    return np.stack([-offset / scale, fx, fy, states.s_c], axis=1)


class _Integrands(NamedTuple):
    """What is integrated along the rod, at the nodes and per τ: shape (n, nodes) each."""

    height: FloatArray
    reach: FloatArray
    gradient: FloatArray
    bend: FloatArray


def _integrands(states: RodStates) -> _Integrands:
    """Integrands of height, reach, moment and slope.

    The moment gradient is m' = fx·sin φ − fy·cos φ = f·cos(φ − α).
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    sin, cos = density * np.sin(states.phi), density * np.cos(states.phi)
    gradient = states.fx[:, None] * sin - states.fy[:, None] * cos
    return _Integrands(sin, cos, gradient, -compliance * (gradient @ rule.to_end.T))


def _unbent(states: RodStates, tau: FloatArray, gradient: FloatArray) -> FloatArray:
    """Slope that the rod has before it is bent, π/2 + β + c·m(0) + ∫₀ˢ κ0 in E1.

    Of shape (n, len(tau)), or (1, 1) where all mountings are ideal.
    """
    if states.mounting is None:
        return np.full((1, 1), CLAMP_SLOPE)
    moment = -(gradient @ gauss_rule(gradient.shape[1]).weights)
    turn = states.mounting.clamp_compliance * moment
    return states.mounting.natural_slope(states.arc_length(tau)) + turn[:, None]


def _natural_growth(states: RodStates, tau: FloatArray) -> FloatArray:
    """Differentiate ∫₀ˢ κ0 with respect to s_c at fixed places; zero where none is curved."""
    if states.mounting is None:
        return np.zeros((1, 1))
    growth = arc_length_growth(tau, states.theta[:, None], states.s_c[:, None])
    return states.mounting.natural_curvature(states.arc_length(tau)) * growth


def bending_moment(states: RodStates) -> FloatArray:
    """Bending moment m(s) = −∫ m' ds from s to the contact point, at the nodes.

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    ndarray, shape (n, nodes)
        Moment, in units of E·I0/L.
    """
    return -(_integrands(states).gradient @ gauss_rule(states.nodes).to_end.T)


class Ends(NamedTuple):
    """What is seen of a batch of states at the clamp and at the contact point.

    Attributes
    ----------
    offset : ndarray, shape (n,)
        Position of the tip along the surface, ∫cos φ ds + 1 − s_c, in units of L.
    moment : ndarray, shape (n,)
        Clamp reaction moment m(0), φ'(0) where the rod is straight, in units of E·I0/L.
    phi1 : ndarray, shape (n,)
        Slope at the contact point, in rad.
    """

    offset: FloatArray
    moment: FloatArray
    phi1: FloatArray


def ends(states: RodStates) -> Ends:
    """Evaluate states at both ends of the free part.

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    Ends

    Notes
    -----
    φ1 is equation E1 at s = s_c. The integral is more accurate than the polynomial's own value at
    τ = 1: Gauss collocation superconverges at the ends.
    """
    rule = gauss_rule(states.nodes)
    _, reach, gradient, bend = _integrands(states)
    return Ends(
        offset=reach @ rule.weights + 1.0 - states.s_c,
        moment=-(gradient @ rule.weights),
        phi1=_unbent(states, END, gradient)[:, 0] + bend @ rule.weights,
    )


def contact_position(states: RodStates) -> tuple[FloatArray, FloatArray]:
    """Position of the tip along the surface and height of the surface, seen from the clamp.

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    offset, height : ndarray, shape (n,)
        ∫cos φ ds + 1 − s_c and ∫sin φ ds, in units of L.
    """
    rule = gauss_rule(states.nodes)
    weights = rule.weights * states.arc_density(rule.nodes)
    offset = (weights * np.cos(states.phi)).sum(axis=1) + 1.0 - states.s_c
    return offset, (weights * np.sin(states.phi)).sum(axis=1)


def shape(states: RodStates, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Deformed shape, the part that lies on the surface included, with the clamp at the origin.

    Parameters
    ----------
    states : RodStates
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

    phi = at_points(values, states.phi)
    x = at_points(integrals, density * np.cos(states.phi))
    y = at_points(integrals, density * np.sin(states.phi))
    # Beyond the contact point the rod has its natural shape, with the slope that it has there.
    if states.mounting is None:
        return x + (s - free) * np.cos(phi), y + (s - free) * np.sin(phi), phi
    along, up, turn = states.mounting.tail(free, np.broadcast_to(s, free.shape))
    cos, sin = np.cos(phi), np.sin(phi)
    return x + along * cos - up * sin, y + along * sin + up * cos, phi + turn


def largest_residual(states: RodStates, eta: FloatArray, closure: Closure) -> FloatArray:
    """Largest residual of E1 to E4, measured on more than twice the nodes.

    Collocation satisfies the equations at its own nodes whatever their number. Interpolating φ to
    a finer rule and asking again tells whether the polynomial satisfies them between the nodes.

    Parameters
    ----------
    states : RodStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure

    Returns
    -------
    ndarray, shape (n,)
        Largest of the residuals of E1, E3d and E4b (rad), E2 and E3a (L), E3b (relative to the
        force) and E3c.
    """
    largest = np.empty(len(states))
    for part in slices(len(states), VALUES_TOGETHER // _finer(states.nodes)):
        some = _residuals_between(states.take(part), eta[part], closure.take(part))
        largest[part] = np.maximum.reduce(some)
    return largest


def _finer(nodes: int) -> int:
    """More than twice the nodes."""
    return 2 * nodes + 7


def _residuals_between(
    states: RodStates, eta: FloatArray, closure: Closure
) -> tuple[FloatArray, ...]:
    """Largest residuals of E1, E2, E3 and E4 of each state, on more than twice the nodes."""
    fine = _finer(states.nodes)
    rule = gauss_rule(fine)
    phi = states.phi @ refinement_matrix(states.nodes, fine).T
    height, reach, gradient, bend = _integrands(replace(states, phi=phi[:, 1:-1]))
    places = np.concatenate([[0.0], rule.nodes, END])
    expected = _unbent(states, places, gradient) + np.concatenate(
        [np.zeros((len(states), 1)), bend @ rule.from_start.T, (bend @ rule.weights)[:, None]],
        axis=1,
    )
    offset, phi1 = reach @ rule.weights + 1.0 - states.s_c, phi[:, -1]
    condition = closure.residual(offset, states, phi1)
    if not (closure.of_offset.any() or closure.of_s_c.any() or closure.of_phi1.any()):
        condition /= np.hypot(states.fx, states.fy)
    return (
        np.abs(phi - expected).max(axis=1),
        np.abs(closure.height(height @ rule.weights, offset) - eta),
        np.abs(condition),
        np.abs(phi1 if closure.contact is Contact.LINE else states.s_c - 1.0),
    )


def coefficient_decay(states: RodStates) -> FloatArray:
    """Size of the last Legendre coefficients of φ relative to the largest.

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    ndarray, shape (n,)
        Near rounding error where φ is resolved; of order one where it is not.
    """
    coefficients = np.abs(states.phi @ gauss_rule(states.nodes).to_coefficients.T)
    return coefficients[:, -2:].max(axis=1) / coefficients.max(axis=1)


def residuals(states: RodStates, eta: FloatArray, closure: Closure) -> FloatArray:
    """Residuals of the collocated equations: E1 at the nodes, E2, E3 and E4, in this order.

    Parameters
    ----------
    states : RodStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure

    Returns
    -------
    ndarray, shape (n, nodes + 3)
    """
    nodes = states.nodes
    rule = gauss_rule(nodes)
    height, reach, gradient, bend = _integrands(states)
    offset = reach @ rule.weights + 1.0 - states.s_c
    phi1 = _unbent(states, END, gradient)[:, 0] + bend @ rule.weights
    values = np.empty((len(states), nodes + 3))
    np.subtract(states.phi, bend @ rule.from_start.T, out=values[:, :nodes])
    values[:, :nodes] -= _unbent(states, rule.nodes, gradient)
    values[:, nodes] = closure.height(height @ rule.weights, offset) - eta
    values[:, nodes + 1] = closure.residual(offset, states, phi1)
    values[:, nodes + 2] = phi1 if closure.contact is Contact.LINE else states.s_c - 1.0
    return values


def jacobian(states: RodStates, closure: Closure) -> SingleArray:
    """Differentiate `residuals` by the unknowns, in single precision.

    The unknowns are φ at the nodes, fx, fy and s_c. The blocks are::

              φ      fx   fy   s_c
        E1  [ n x n   n    n    n ]
        E2  [ 1 x n   .    .    1 ]
        E3  [ 1 x n   1    1    1 ]
        E4  [ 1 x n   1    1    1 ]

    In point contact s_c is 1 and stays it: its column is left out, but for E4a.

    Parameters
    ----------
    states : RodStates
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
    matrix = np.zeros((len(states), nodes + 3, nodes + 3), dtype=np.float32)
    e1, e2, e3, e4 = matrix[:, :nodes], matrix[:, nodes], matrix[:, nodes + 1], matrix[:, nodes + 2]
    by_fx, by_fy, by_s_c = nodes, nodes + 1, nodes + 2

    from_start, to_end = rule.from_start.astype(np.float32), rule.to_end.astype(np.float32)
    twice = (from_start * compliance.astype(np.float32)[:, None, :]).reshape(-1, nodes) @ to_end
    e1[:, :, :nodes] = twice.reshape(-1, nodes, nodes) * load_slope.astype(np.float32)[:, None, :]
    diagonal = np.arange(nodes)
    e1[:, diagonal, diagonal] += 1.0
    bend_of_fx, bend_of_fy = compliance * (sin @ rule.to_end.T), compliance * (cos @ rule.to_end.T)
    e1[:, :, by_fx] = bend_of_fx @ rule.from_start.T
    e1[:, :, by_fy] = -bend_of_fy @ rule.from_start.T

    e2[:, :nodes] = rule.weights * cos
    if closure.tilt is not None:
        e2[:, :nodes] += closure.tilt[:, None] * rule.weights * sin

    e3[:, :nodes] = -closure.of_offset[:, None] * rule.weights * sin
    e3[:, by_fx], e3[:, by_fy], e3[:, by_s_c] = closure.of_fx, closure.of_fy, closure.of_s_c

    lies, switches = closure.contact is Contact.LINE, closure.of_phi1.any()
    phi1 = np.zeros((len(states), nodes + 3), dtype=np.float32)
    if lies or switches:
        phi1[:, :nodes] = -((rule.weights * compliance) @ rule.to_end) * load_slope
        phi1[:, by_fx] = -(bend_of_fx @ rule.weights)
        phi1[:, by_fy] = bend_of_fy @ rule.weights
    if lies:
        # How everything grows with the length of the free part.
        arc_growth, compliance_growth = density_growth(
            rule.nodes, states.theta[:, None], states.s_c[:, None]
        )
        bend_growth = compliance * (
            compliance_growth * (load @ rule.to_end.T) + (arc_growth * load) @ rule.to_end.T
        )
        e1[:, :, by_s_c] = bend_growth @ rule.from_start.T
        offset_growth = (arc_growth * cos) @ rule.weights - 1.0
        e2[:, by_s_c] = closure.height((arc_growth * sin) @ rule.weights, offset_growth)
        e3[:, by_s_c] += closure.of_offset * offset_growth
        phi1[:, by_s_c] = -(bend_growth @ rule.weights)
    if states.mounting is not None:
        # The turn of the clamp, c·m(0), adds the same to φ everywhere.
        turn = np.zeros((len(states), nodes + 3), dtype=np.float32)
        turn[:, :nodes] = -rule.weights * load_slope
        turn[:, by_fx], turn[:, by_fy] = -sin @ rule.weights, cos @ rule.weights
        if lies:
            turn[:, by_s_c] = -(arc_growth * load) @ rule.weights
            e1[:, :, by_s_c] -= _natural_growth(states, rule.nodes)
            phi1[:, by_s_c] += _natural_growth(states, END)[:, 0]
        turn *= states.mounting.clamp_compliance[:, None].astype(np.float32)
        e1 -= turn[:, None]
        phi1 += turn
    if lies:
        e4[:] = phi1
    else:
        e4[:, by_s_c] = 1.0
    if switches:
        e3 += closure.of_phi1[:, None].astype(np.float32) * phi1
    return matrix
