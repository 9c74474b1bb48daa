"""Dependence of the measured friction on noise and tolerances, of one pair (θ, η).

`identify` fits the set-up p, within its tolerances, and the contact u of each period to all
readings. With J and j the changes of the readings per unit of p and of u, in standard deviations,

    A = Σ JᵀJ − Σ (Jᵀj)(jᵀJ)/(jᵀj) + 1/σ²,    C = A⁻¹,

remains of p. The friction of a period changes by D = ∂μ/∂p − ∂μ/∂u·(jᵀJ)/(jᵀj), so that D·C·Dᵀ is
common to all periods, and (∂μ/∂u)²/(jᵀj) is random.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor.identification.parameters import OF_ROD, parameters_of
from vibrissa.sensor.response.branch import Response
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

# Periods of the recording to which the set-up is fitted, and rows of each, as far as their number
# counts: for a creep.
PERIODS, ROWS = 30, 100
# Of which periods readings are computed, where in a period, as parts of it, and their weights; the
# last one is the onset, where friction is read.
STARTS = PERIODS * (np.polynomial.legendre.leggauss(6)[0] + 1.0) / 2.0
PART_WEIGHTS = np.polynomial.legendre.leggauss(6)[1] / 2.0
NODES = np.append((np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0, 1.0)
NODE_WEIGHTS = np.append(np.polynomial.legendre.leggauss(8)[1] / 2.0, 0.0)
# Properties for each of which another rod is solved, and the steps of the derivatives: away from
# the surface, where there is a choice.
STEPS = dict.fromkeys((*OF_ROD, "eta"), 1e-4) | {"eta": -1e-4, "curvature": -1e-4}
# What `identify` fits, with crosstalk as a part of the same full scale of all channels.
PARAMETERS = parameters_of({}, frozenset(), np.ones(3))


class Sensitivity(NamedTuple):
    """Changes of readings and friction at k frictions, per unit of u and of q parameters.

    Readings are at x nodes in each of p periods, in units of the rod.

    Attributes
    ----------
    contact : ndarray, shape (k, x, 3)
        Change of the readings over u (1/L).
    setup : ndarray, shape (k, p, x, 3, q)
        Change of the readings over each parameter.
    friction : ndarray, shape (k, p, q)
        ∂μ/∂p.
    """

    contact: FloatArray
    setup: FloatArray
    friction: FloatArray


def sensitivity_of(response: Response, end: FloatArray, contact: Contact) -> Sensitivity:
    """Compute the sensitivity of a pair, with periods that end at k displacements (L)."""
    x0 = end[:, None] * NODES
    y, slope, eta = response(x0), response.slope(x0), response.curve.eta
    moved = dict(zip(STEPS, _moved(response.curve, contact), strict=True))
    of_rod = {name: (_loads(curve, x0) - y) / STEPS[name] for name, curve in moved.items()}
    x1_slope = (moved["eta"].x1_init - response.x1_init) / STEPS["eta"]
    # Axes: friction, period, node, channel.
    part = (STARTS[:, None, None] + NODES[:, None]) / PERIODS
    way = PERIODS * part * end[:, None, None, None]
    before, loads = (((x0 - end[:, None])[..., None] * slope)[:, None], y[:, None])
    changes = {name: change[:, None] for name, change in of_rod.items()}
    changes |= {
        "stage_angle": -way * changes["eta"] - x1_slope * before,
        "stage_scale": before,
        "length": -eta * changes["eta"] - before - loads * np.array([2.0, 2.0, 1.0]),
    }
    for one in PARAMETERS:
        if one.effect is not None:
            changes[one.name] = one.effect(loads, part, PERIODS * ROWS)
    shape = (len(end), len(STARTS), len(NODES), 3)
    setup = np.stack([np.broadcast_to(changes[p.name], shape) for p in PARAMETERS], axis=-1)
    # The demand fx/fy at the onset changes with the loads themselves alone.
    fx, fy, _ = np.moveaxis(setup[:, :, -1], 2, 0)
    demand = response.demand(end)[:, None, None]
    of_loads = np.array([one.effect is None for one in PARAMETERS])
    friction = of_loads * (fx - demand * fy) / loads[:, :, -1, 1, None]
    return Sensitivity(contact=slope, setup=setup, friction=friction)


def _moved(curve: StickingCurve, contact: Contact) -> list[StickingCurve]:
    """Solve the rods that differ from one by a step of one property."""
    theta, eta = (
        np.array([getattr(curve, own) + step * (name == own) for name, step in STEPS.items()])
        for own in ("theta", "eta")
    )
    mountings = [
        IDEAL if name in ("theta", "eta") else replace(IDEAL, **{name: step})
        for name, step in STEPS.items()
    ]
    return solve_curves(theta, eta, contact, mountings)


def _loads(curve: StickingCurve, x0: FloatArray) -> FloatArray:
    """Reactions of a rod, shape x0.shape + (3,); NaN of one that is not solved."""
    if curve.status is not Status.SOLVED:
        return np.full((*x0.shape, 3), np.nan)
    state = curve.state(x0)
    return np.stack([state.reaction_fx, state.reaction_fy, state.reaction_m], axis=-1)
