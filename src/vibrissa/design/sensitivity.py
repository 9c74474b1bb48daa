"""Dependence of the measured friction on noise and tolerances, of one pair (θ, η).

`identify` fits the set-up p, within its tolerances, and the contact u of each period to all
readings. With J and j the changes of the readings per unit of p and of u, in standard deviations,

    A = Σ JᵀJ − Σ (Jᵀj)(jᵀJ)/(jᵀj) + 1/σ²,    C = A⁻¹,

remains of p. The friction of a period changes by D = ∂μ/∂p − ∂μ/∂u·(jᵀJ)/(jᵀj), so that D·C·Dᵀ is
common to all periods, and (∂μ/∂u)²/(jᵀj) is random.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor.identification.parameters import CREEP, OF_ROD, Parameter, parameters_of
from vibrissa.sensor.response.branch import Response
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

# Periods of the recording to which the set-up is fitted, and of how many of them readings are
# computed; the places of the readings in a period, as parts of it, and their weights.
PERIODS = 30
STARTS = PERIODS * (np.polynomial.legendre.leggauss(6)[0] + 1.0) / 2.0
PART_WEIGHTS = np.polynomial.legendre.leggauss(6)[1] / 2.0
NODES = (np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0
NODE_WEIGHTS = np.polynomial.legendre.leggauss(8)[1] / 2.0
# Properties for each of which another rod is solved, and the steps of the derivatives: away from
# the surface, where there is a choice.
STEPS = dict.fromkeys((*OF_ROD, "eta"), 1e-4) | {"eta": -1e-4, "curvature": -1e-4}
# Rows of a period, as far as their number counts: for a creep.
ROWS = 100
# What `identify` fits, with crosstalk as a part of the same full scale of all channels.
PARAMETERS = parameters_of({}, frozenset(), np.ones(3))


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity:
    """Changes of readings and friction at k frictions, per unit of u and of q parameters.

    Readings are at x nodes in each of p periods, in units of the rod.

    Attributes
    ----------
    contact : ndarray, shape (k, x, 3)
        Change of the readings over u (1/L).
    setup : ndarray, shape (k, p, x, 3, q)
        Change of the readings over each parameter.
    demand : ndarray, shape (k,)
        ∂μ/∂u: growth of the demand −tan α with x0 at the onset (1/L).
    friction : ndarray, shape (k, p, q)
        ∂μ/∂p.
    """

    contact: FloatArray
    setup: FloatArray
    demand: FloatArray
    friction: FloatArray


def sensitivity_of(response: Response, end: FloatArray, contact: Contact) -> Sensitivity:
    """Compute the sensitivity of a pair, with periods that end at k displacements (L)."""
    x0 = end[:, None] * NODES
    y, slope, eta = response(x0), response.slope(x0), response.curve.eta
    of_rod, of_end = {}, {}
    moved = _moved(response.curve, contact)
    for name, curve in moved.items():
        loads, at_end = _loads(curve, x0), _loads(curve, end)
        of_rod[name] = (loads - y) / STEPS[name]
        of_end[name] = (at_end[:, 0] / at_end[:, 1] - response.demand(end)) / STEPS[name]
    x1_slope = (moved["eta"].x1_init - response.x1_init) / STEPS["eta"]
    # Axes: friction, period, node, channel.
    start = STARTS[:, None, None] * end[:, None, None, None]
    before = ((x0 - end[:, None])[..., None] * slope)[:, None]
    part = (STARTS[:, None, None] + NODES[:, None]) / PERIODS
    loads = y[:, None]
    named = {name: change[:, None] for name, change in of_rod.items()}
    named |= {
        "stage_angle": -(start + x0[:, None, :, None]) * named["eta"] - x1_slope * before,
        "stage_scale": before,
        "length": -eta * named["eta"] - before - loads * np.array([2.0, 2.0, 1.0]),
        CREEP: -loads * np.log10(1.0 + PERIODS * ROWS * part),
    }
    of_end = {name: change[:, None] for name, change in of_end.items()}
    of_end |= {
        "stage_angle": -(start[:, :, 0, 0] + end[:, None]) * of_end["eta"],
        "length": -eta * of_end["eta"],
    }
    shape = (len(end), len(STARTS), len(NODES), 3)
    changes = [named.get(one.name, _of_transducer(one, loads, part)) for one in PARAMETERS]
    frictions = [of_end.get(one.name, 0.0) for one in PARAMETERS]
    return Sensitivity(
        contact=slope,
        setup=np.stack([np.broadcast_to(one, shape) for one in changes], axis=-1),
        demand=response.demand_slope(end),
        friction=np.stack([np.broadcast_to(one, shape[:2]) for one in frictions], axis=-1),
    )


def _moved(curve: StickingCurve, contact: Contact) -> Mapping[str, StickingCurve]:
    """Solve the rods that differ from one by a step of one property."""
    theta, eta = (
        [getattr(curve, own) + step * (name == own) for name, step in STEPS.items()]
        for own in ("theta", "eta")
    )
    mountings = [
        IDEAL if name in ("theta", "eta") else replace(IDEAL, **{name: step})
        for name, step in STEPS.items()
    ]
    found = solve_curves(np.array(theta), np.array(eta), contact, mountings)
    return dict(zip(STEPS, found, strict=True))


def _loads(curve: StickingCurve, x0: FloatArray) -> FloatArray:
    """Reactions of a rod, shape x0.shape + (3,); NaN of one that is not solved."""
    if curve.status is not Status.SOLVED:
        return np.full((*x0.shape, 3), np.nan)
    state = curve.state(x0)
    return np.stack([state.reaction_fx, state.reaction_fy, state.reaction_m], axis=-1)


def _of_transducer(one: Parameter, loads: FloatArray, part: FloatArray) -> FloatArray:
    """Change of the readings of loads at parts of the recording, by a zero or a mixing."""
    if one.mixing is not None:
        return loads @ one.mixing.T
    return np.asarray(one.zero(part) * np.eye(3)[one.channel])
