"""Collocated equations of equilibrium of the clamped rod in contact: residuals and Jacobian.

The differential equation that they integrate is in `vibrissa.mechanics.elastica`.

The rod touches the surface at arc length s_c. In point contact this is the tip, s_c = 1. In line
contact the rod touches tangentially at s_c < 1, and the part beyond is unloaded: if straight, it
lies on the surface. On the free part, up to s_c, the moment m of the contact force (fx, fy) obeys
m' = fx·sin φ − fy·cos φ with m(s_c) = 0. The slope obeys B·(φ' − κ0) = m with
φ(0) = π/2 + β + c·m(0). The mounting gives β, c and κ0 (`vibrissa.mechanics.mounting`); all are 0
in the paper. Integrated twice, the equations are

    φ(s) = π/2 + β + c·m(0) + ∫₀ˢ κ0 du − ∫₀ˢ B⁻¹(u) ∫ᵤ^s_c (fx·sin φ − fy·cos φ) dv du ,
    m(0) = −∫₀^s_c (fx·sin φ − fy·cos φ) dv ,                                            (E1)

The height of the contact point above the clamp (E2), one prescribed quantity (E3a to E3d) and the
kind of contact (E4a or E4b) close the equations:

    ∫ sin φ ds − tan δ·offset = η − tan δ·x1_init ,                                      (E2)
    offset = ∫ cos φ ds + 1 − s_c ,  fx·cos α + fy·sin α = 0 ,
    direction·(−offset/scale, 0.3·fx/force, 0.1·fy/force, s_c) = parameter  or
    φ(s_c) = 0 ,                                                              (E3a, E3b, E3c, E3d)
    s_c = 1     or     φ(s_c) = 0 .                                               (E4a, E4b)

In E2 the clamp moves at the angle δ to the surface. E3a prescribes the position of the tip relative
to the clamp, E3b the inclination α of the force, E3c the continuation parameter of
`vibrissa.sticking.solving.following`. E3d with s_c = 1 holds where the kind of contact changes.

φ on the free part is a polynomial in the bending coordinate τ (`vibrissa.mechanics.taper`), given
by its values at Gauss–Legendre nodes. All functions work on batches: the first axis counts states.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from vibrissa.mechanics.mounting import polynomial, tail
from vibrissa.mechanics.shape import Shape
from vibrissa.mechanics.states import RodStates
from vibrissa.mechanics.taper import arc_length_growth, bending_coordinate
from vibrissa.numerics.angles import direction
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch, slices
from vibrissa.numerics.spectral import gauss_rule, legendre_series

# The contact point in the bending coordinate: τ = 1.
END = np.ones(1)
# Number of states whose residuals are computed together; their arrays fit into the cache.
STATES_AT_ONCE = 128
# Indices of the quantities in the weighted sum of E3.
OFFSET, FX, FY, S_C, PHI1 = range(5)


@dataclass(frozen=True, eq=False, kw_only=True)
class ClosingCondition(Batch):
    """Height and prescribed quantity, E2 and E3, which close the equations of n states.

    Every form of E3 prescribes a weighted sum: weights·(offset, fx, fy, s_c, φ1) = value.

    Attributes
    ----------
    height, tilt : ndarray, shape (n,)
        Right-hand side of E2 (L), and tan δ for the angle δ of the stage.
    weights, value : ndarray, shape (n, 5) and (n,)
        Weights of the five quantities in the sum E3, and the value of the sum.
    """

    height: FloatArray
    tilt: FloatArray
    weights: FloatArray
    value: FloatArray

    @classmethod
    def prescribing(
        cls,
        height: FloatArray,
        weights: Mapping[int, FloatArray | float],
        value: FloatArray | float = 0.0,
        tilt: FloatArray | float = 0.0,
    ) -> Self:
        """Prescribe the value of a weighted sum as E3.

        Parameters
        ----------
        weights : mapping
            Weights by the indices of the quantities, `OFFSET` to `PHI1`. Missing weights are zero.
        """
        every = np.zeros((len(height), 5))
        for quantity, weight in weights.items():
            every[:, quantity] = weight
        value, tilt = (np.full(len(height), one) for one in (value, tilt))
        return cls(height=height, tilt=tilt, weights=every, value=value)


@dataclass(frozen=True, eq=False, kw_only=True)
class FreeParts(Batch):
    """Free parts of n rods, from the clamp to the contact point, as long as s_c does not change.

    Attributes
    ----------
    density, compliance : ndarray, shape (n, nodes)
        Both `RodStates.densities` at the nodes.
    slope : ndarray, shape (n, nodes) or (n, 1)
        Slope of the unloaded rod at the nodes (rad).
    end_slope : ndarray, shape (n,)
        Slope of the unloaded rod at the contact point (rad).
    """

    density: FloatArray
    compliance: FloatArray
    slope: FloatArray
    end_slope: FloatArray

    @classmethod
    def of(cls, states: RodStates) -> Self:
        """Evaluate the free parts of the rods of some states."""
        nodes = gauss_rule(states.nodes).nodes
        density, compliance = states.densities(nodes)
        return cls(
            density=density,
            compliance=compliance,
            slope=states.natural_slope(nodes),
            end_slope=states.natural_slope(END)[:, 0],
        )


class _Integrands(NamedTuple):
    """Functions to be integrated over τ: their values at the nodes, shape (n, nodes) each.

    Attributes
    ----------
    height, reach : ndarray
        Growth of y and of x.
    fall : ndarray
        Fall −m' of the moment, with m' = fx·sin φ − fy·cos φ = f·cos(φ − α).
    bend : ndarray
        Bent part m/B of the growth of the slope.
    """

    height: FloatArray
    reach: FloatArray
    fall: FloatArray
    bend: FloatArray


def _integrands(states: RodStates, free: FreeParts) -> _Integrands:
    """Evaluate the integrands of height, reach, moment and slope."""
    rule = gauss_rule(states.nodes)
    height, reach = direction(states.phi)
    height *= free.density
    reach *= free.density
    fall = states.fy[:, None] * reach
    fall -= states.fx[:, None] * height
    bend = fall @ rule.to_end.T
    bend *= free.compliance
    return _Integrands(height=height, reach=reach, fall=fall, bend=bend)


def bending_moment(states: RodStates) -> FloatArray:
    """Bending moment m(s) = −∫ m' ds from s to the contact point, at the nodes (E·I0/L)."""
    fall = _integrands(states, FreeParts.of(states)).fall
    return np.asarray(fall @ gauss_rule(states.nodes).to_end.T)


class Ends(NamedTuple):
    """Quantities of n states at the clamp and at the contact point.

    Attributes
    ----------
    offset : ndarray, shape (n,)
        Distance of the tip ahead of the clamp along the surface, ∫cos φ ds + 1 − s_c (L).
    height : ndarray, shape (n,)
        Height of the contact point above the clamp, ∫sin φ ds (L).
    moment : ndarray, shape (n,)
        Bending moment m(0) at the clamp (E·I0/L).
    phi1 : ndarray, shape (n,)
        Slope at the contact point (rad).
    """

    offset: FloatArray
    height: FloatArray
    moment: FloatArray
    phi1: FloatArray


def ends(states: RodStates) -> Ends:
    """Evaluate states at the clamp and at the contact point, whose slope follows from E1."""
    free = FreeParts.of(states)
    return _ends(states, free, _integrands(states, free))


def _ends(states: RodStates, free: FreeParts, integrands: _Integrands) -> Ends:
    weights = gauss_rule(states.nodes).weights
    height, reach, fall, bend = integrands
    moment = fall @ weights
    return Ends(
        offset=reach @ weights + 1.0 - states.s_c,
        height=height @ weights,
        moment=moment,
        phi1=free.end_slope + states.clamp_compliance * moment + bend @ weights,
    )


def residuals(
    states: RodStates, closing: ClosingCondition, free: FreeParts | None = None
) -> FloatArray:
    """Residuals of the equations of n states.

    Parameters
    ----------
    free : FreeParts, optional
        The free parts of the rods, if they are known already.

    Returns
    -------
    ndarray, shape (n, nodes + 3)
        Residuals of E1, the slope at each node; of E2, the height; of E3, the prescribed quantity;
        and of E4, the kind of contact; in this order.
    """
    nodes, rule = states.nodes, gauss_rule(states.nodes)
    free = FreeParts.of(states) if free is None else free
    integrands = _integrands(states, free)
    end = _ends(states, free, integrands)
    values = np.empty_like(states.unknowns)
    np.subtract(states.phi, integrands.bend @ rule.from_start.T, out=values[:, :nodes])
    turn = states.clamp_compliance * end.moment
    values[:, :nodes] -= free.slope + turn[:, None]
    values[:, nodes] = end.height - closing.tilt * end.offset - closing.height
    prescribed = np.array([end.offset, states.fx, states.fy, states.s_c, end.phi1])
    values[:, nodes + 1] = np.vecdot(closing.weights, prescribed.T) - closing.value
    values[:, nodes + 2] = np.where(states.line, end.phi1, states.s_c - 1.0)
    return values


def largest_residual(states: RodStates, closing: ClosingCondition) -> FloatArray:
    """Largest residual of each state, also between its nodes, shape (n,).

    The equations E1 to E4 are evaluated on more than twice as many nodes.
    """
    largest = np.empty(len(states))
    for some in slices(len(states), STATES_AT_ONCE):
        fine = states.take(some).on_nodes(2 * states.nodes + 7)
        largest[some] = np.abs(residuals(fine, closing.take(some))).max(axis=1)
    return largest


class Derivatives(NamedTuple):
    """Derivatives of n states with respect to their unknowns; the last axis counts the unknowns.

    Attributes
    ----------
    slope : ndarray, shape (n, nodes, nodes + 3)
        Derivatives of the residuals of E1, the slope at the nodes.
    height : ndarray, shape (n, nodes + 3)
        Derivatives of the height ∫ sin φ ds.
    ends : ndarray, shape (n, 5, nodes + 3)
        Derivatives of the quantities in E3: offset, fx, fy, s_c and φ1.
    """

    slope: FloatArray
    height: FloatArray
    ends: FloatArray


def derivatives(states: RodStates) -> Derivatives:
    """Compute the derivatives from which `jacobian` is composed."""
    nodes, rule = states.nodes, gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    sin, cos = direction(states.phi)
    sin *= density
    cos *= density
    fx, fy = states.fx[:, None], states.fy[:, None]
    load, load_slope = fx * sin - fy * cos, fx * cos + fy * sin
    arc_growth, compliance_growth = states.density_growth(rule.nodes)
    # Derivatives of −dφ/dτ (straighten) and of −c·m(0) (turn_back). A slope changes dm/dτ at its
    # own node alone, so that its column of the integral is only scaled.
    by_scalars = np.empty((len(states), nodes, 3))
    by_scalars[..., 0], by_scalars[..., 1], by_scalars[..., 2] = sin, -cos, arc_growth * load
    straighten = np.empty((len(states), nodes, nodes + 3))
    np.multiply(rule.to_end, load_slope[:, None, :], out=straighten[:, :, :nodes])
    straighten[:, :, nodes:] = rule.to_end @ by_scalars
    straighten[:, :, nodes + 2] += compliance_growth * (load @ rule.to_end.T)
    straighten *= compliance[:, :, None]
    turn_back = np.empty((len(states), nodes + 3))
    turn_back[:, :nodes] = rule.weights * load_slope
    turn_back[:, nodes:] = rule.weights @ by_scalars
    turn_back *= states.clamp_compliance[:, None]
    slope = rule.from_start @ straighten
    slope += turn_back[:, None]
    diagonal = np.arange(nodes)
    slope[:, diagonal, diagonal] += 1.0
    height, offset = np.zeros((2, *states.unknowns.shape))
    height[:, :nodes], offset[:, :nodes] = rule.weights * cos, -rule.weights * sin
    height[:, nodes + 2] = (arc_growth * sin) @ rule.weights
    offset[:, nodes + 2] = (arc_growth * cos) @ rule.weights - 1.0
    by_ends = np.zeros((len(states), 5, nodes + 3))
    by_ends[:, OFFSET] = offset
    by_ends[:, [FX, FY, S_C], [nodes, nodes + 1, nodes + 2]] = 1.0
    by_ends[:, PHI1] = -turn_back - rule.weights @ straighten
    if states.curvature.shape[1]:
        slope[:, :, nodes + 2] -= _natural_growth(states, rule.nodes)
        by_ends[:, PHI1, nodes + 2] += _natural_growth(states, END)[:, 0]
    return Derivatives(slope, height, by_ends)


def _natural_growth(states: RodStates, tau: FloatArray) -> FloatArray:
    """Differentiate the slope ∫₀ˢ κ0 du of the unloaded rod with respect to s_c at fixed τ."""
    growth = arc_length_growth(tau, states.theta[:, None], states.s_c[:, None])
    return polynomial(states.curvature, states.arc_length(tau)) * growth


def jacobian(
    states: RodStates, closing: ClosingCondition, changes: Derivatives | None = None
) -> FloatArray:
    """Differentiate `residuals` with respect to the unknowns, shape (n, nodes + 3, nodes + 3).

    Parameters
    ----------
    changes : Derivatives, optional
        The `derivatives` of the states, if they are known already.
    """
    slope, height, by_ends = derivatives(states) if changes is None else changes
    matrix = np.empty((len(states), states.nodes + 3, states.nodes + 3))
    matrix[:, :-3] = slope
    matrix[:, -3] = height - closing.tilt[:, None] * by_ends[:, OFFSET]
    matrix[:, -2] = np.vecmat(closing.weights, by_ends)
    matrix[:, -1] = np.where(states.line[:, None], by_ends[:, PHI1], by_ends[:, S_C])
    return matrix


def shape(states: RodStates, s: FloatArray) -> Shape:
    """Deformed shapes of n states, including the part beyond the contact point.

    Parameters
    ----------
    s : ndarray, shape (points,)
        Arc lengths from the clamp in [0, 1] (L).
    """
    rule = gauss_rule(states.nodes)
    free = np.minimum(s, states.s_c[:, None])
    tau = bending_coordinate(free, states.theta[:, None], states.s_c[:, None])
    values, integrals = legendre_series(states.nodes, tau)
    density, _ = states.densities(rule.nodes)

    def at_points(series: FloatArray, nodal: FloatArray) -> FloatArray:
        return np.einsum("npk,nk->np", series, nodal @ rule.to_coefficients.T)

    phi = at_points(values, states.phi)
    x = at_points(integrals, density * np.cos(states.phi))
    y = at_points(integrals, density * np.sin(states.phi))
    # Beyond the contact point the rod has its natural shape, which continues the slope there.
    along, up, turn = tail(states.curvature, free, np.broadcast_to(s, free.shape))
    cos, sin = np.cos(phi), np.sin(phi)
    return Shape(x=x + along * cos - up * sin, y=y + along * sin + up * cos, phi=phi + turn)


def coefficient_decay(states: RodStates) -> FloatArray:
    """Larger of the last two Legendre coefficients of φ over the largest of all, shape (n,).

    It is near rounding error where the nodes resolve φ, and of order one where they do not.
    """
    coefficients = np.abs(states.phi @ gauss_rule(states.nodes).to_coefficients.T)
    return np.asarray(coefficients[:, -2:].max(axis=1) / coefficients.max(axis=1))
