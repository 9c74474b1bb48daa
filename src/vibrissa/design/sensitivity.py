"""Dependence of the measured friction on noise and tolerances: the uncertainty of μ0.

`identify` fits the set-up p, within its tolerances, and the contact u of each period to all
readings. With J and j the changes of the readings per unit of p and of u, in standard deviations,

    A = Σ JᵀJ − Σ (Jᵀj)(jᵀJ)/(jᵀj) + 1/σ²,    C = A⁻¹,

remains of p. The friction of a period changes by D = ∂μ/∂p − ∂μ/∂u·(jᵀJ)/(jᵀj), so that D·C·Dᵀ is
common to all periods, and (∂μ/∂u)²/(jᵀj) is random.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
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
# Step of a derivative over a property of the rod; away from the surface, where there is a choice.
STEP = 1e-4
# Rows of a period, as far as their number counts: for a creep.
ROWS = 100
# What `identify` fits, with crosstalk as a part of the same full scale of all channels.
PARAMETERS = parameters_of({}, frozenset(), np.ones(3))
# Those for each of which another rod is solved.
SOLVED = (*OF_ROD, "eta")


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity(Batch):
    """Changes of readings and friction in n pairs (θ, η) at k frictions, per unit of q parameters.

    Squares are per channel, in units of the rod, and means over the readings of a period, of which
    p are computed.

    Attributes
    ----------
    of_setup : ndarray, shape (n, k, 3, q, q)
        JᵀJ, summed over all periods.
    of_both : ndarray, shape (n, k, 3, p, q)
        jᵀJ.
    of_contact : ndarray, shape (n, k, 3)
        jᵀj.
    friction : ndarray, shape (n, k, p, q)
        ∂μ/∂p.
    slope : ndarray, shape (n, k)
        ∂μ/∂u: growth of the demand −tan α with x0 at the onset (1/L); NaN where the tip locks.
    """

    of_setup: FloatArray
    of_both: FloatArray
    of_contact: FloatArray
    friction: FloatArray
    slope: FloatArray


def sensitivities(
    responses: Sequence[Response], x0_slip: FloatArray, contact: Contact
) -> Sensitivity:
    """Compute the sensitivities of n solved pairs, with periods up to `x0_slip`, shape (n, k)."""
    theta = np.array([response.curve.theta for response in responses])
    eta = np.array([response.curve.eta for response in responses])
    steps = {name: -STEP if name in ("eta", "curvature") else STEP for name in SOLVED}
    others = {}
    for name, step in steps.items():
        mounted = name not in ("theta", "eta")
        mounting = replace(IDEAL, **{name: step}) if mounted else IDEAL
        others[name] = solve_curves(
            theta + step * (name == "theta"),
            eta + step * (name == "eta"),
            contact,
            [mounting] * len(theta),
        )
    rows = []
    for n, response in enumerate(responses):
        moved = {name: (others[name][n], step) for name, step in steps.items()}
        ends = np.where(np.isfinite(x0_slip[n]), x0_slip[n], response.x0_lock)
        rows.append(Sensitivity.stack([_of_period(response, moved, end) for end in ends]))
    found = Sensitivity.stack(rows)
    return replace(found, slope=np.where(np.isfinite(x0_slip), found.slope, np.nan))


def _of_period(
    response: Response, moved: Mapping[str, tuple[StickingCurve, float]], end: float
) -> Sensitivity:
    """Sensitivity of one pair in periods that end at a displacement (L), without leading axes."""
    x0 = end * NODES
    y, slope = response(x0), response.slope(x0)
    of_rod: dict[str, FloatArray] = {}
    of_end: dict[str, Any] = {}
    for name, (curve, step) in moved.items():
        loads = _loads(curve, np.append(x0, end))
        of_rod[name] = (loads[:-1] - y) / step
        of_end[name] = (loads[-1, 0] / loads[-1, 1] - float(response.demand(end))) / step
    x1_slope = (moved["eta"][0].x1_init - response.x1_init) / moved["eta"][1]
    starts, eta = STARTS[:, None, None] * end, response.curve.eta
    before, way = (x0 - end)[:, None] * slope, starts + x0[:, None]
    part = (STARTS[:, None, None] + NODES[:, None]) / PERIODS
    named = of_rod | {
        "stage_angle": -way * of_rod["eta"] - x1_slope * before,
        "stage_scale": before,
        "length": -eta * of_rod["eta"] - before - y * np.array([2.0, 2.0, 1.0]),
        CREEP: -y * np.log10(1.0 + PERIODS * ROWS * part),
    }
    changes = [named.get(one.name, _of_transducer(one, y, part)) for one in PARAMETERS]
    shape = (len(STARTS), len(NODES), 3)
    jacobian = np.stack([np.broadcast_to(one, shape) for one in changes])
    weighted = jacobian * NODE_WEIGHTS[:, None]
    of_end |= {
        "stage_angle": -(starts[:, 0, 0] + end) * of_end["eta"],
        "length": -eta * of_end["eta"],
    }
    friction = np.zeros((len(STARTS), len(PARAMETERS)))
    for k, one in enumerate(PARAMETERS):
        friction[:, k] = of_end.get(one.name, 0.0)
    in_all = PERIODS * PART_WEIGHTS
    return Sensitivity(
        of_setup=np.einsum("r,arxc,brxc->cab", in_all, weighted, jacobian),
        of_both=np.einsum("arxc,xc->cra", weighted, slope),
        of_contact=np.einsum("x,xc->c", NODE_WEIGHTS, slope**2),
        friction=friction,
        slope=np.asarray(response.demand_slope(end)),
    )


def _loads(curve: StickingCurve, x0: FloatArray) -> FloatArray:
    """Reactions of a rod, shape (n, 3); NaN of one that is not solved."""
    if curve.status is not Status.SOLVED:
        return np.full((len(x0), 3), np.nan)
    state = curve.state(x0)
    return np.stack([state.reaction_fx, state.reaction_fy, state.reaction_m], axis=-1)


def _of_transducer(one: Parameter, y: FloatArray, part: FloatArray) -> FloatArray:
    """Change of the readings of loads y at parts of the recording, by a zero or a mixing."""
    if one.mixing is not None:
        return y @ one.mixing.T
    return np.asarray(one.zero(part) * np.eye(3)[one.channel])
