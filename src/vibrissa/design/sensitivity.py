"""How the friction that a rod reads depends on noise and tolerances: the uncertainty of μ0.

`identify` fits the set-up p, within its tolerances, and the contact u of each period to all
readings. With J and j the changes of the readings per unit of p and of u, in standard deviations,

    A = Σ JᵀJ − Σ (Jᵀj)(jᵀJ)/(jᵀj) + 1/σ²,    C = A⁻¹,

remains of p. The friction of a period changes by D = ∂μ/∂p − ∂μ/∂u·(jᵀJ)/(jᵀj), so that D·C·Dᵀ is
common to all periods, and (∂μ/∂u)²/(jᵀj) is random. J and j of a pair (θ, η) are computed once, in
units of the rod; its size only scales them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Status
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
# Half waves of a drift about its line.
WAVES = 3
SLOPE = "surface_slope"
ZEROS = ("zero_force_x", "zero_force_y", "zero_moment_z")
DRIFTS = ("drift_force_x", "drift_force_y", "drift_moment_z")
# What changes the rod: another rod is solved for each. The others change how it is passed or read.
OF_ROD = ("theta", "eta", "clamp_angle", "clamp_compliance", "curvature")
PARAMETERS = (
    *OF_ROD,
    *("stage_angle", "stage_scale", "length", "modulus", "diameter"),
    *ZEROS,
    *(name for name in DRIFTS for _ in range(WAVES + 1)),
    *("transducer_angle", "moment_origin_x", "moment_origin_y"),
    *("crosstalk" for _ in permutations(range(3), 2)),
)
# Deviations of the parts of a drift (Wiener's series), in those of the whole.
WIENER = np.append(1.0, np.sqrt(2.0) / (np.pi * np.arange(1, WAVES + 1)))
# By which part of the loads the channels are larger: axes that are turned from x to y, and the
# moment about a point (a, b), which is less by a·fy − b·fx.
TURNED = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
ORIGIN_X = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
ORIGIN_Y = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity(Batch):
    """Changes of readings and friction in n pairs (θ, η) at k frictions, per unit of q parameters.

    Squares are of a channel in units of the rod, and means over the readings of a period, of which
    p are computed.

    Attributes
    ----------
    of_setup : ndarray, shape (n, k, 3, q, q)
        JᵀJ, summed over all periods.
    of_both : ndarray, shape (n, k, 3, p, q)
        jᵀJ of each period.
    of_contact : ndarray, shape (n, k, 3)
        jᵀj of a period.
    friction : ndarray, shape (n, k, p, q)
        ∂μ/∂p in each period.
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
    steps = {name: -STEP if name in ("eta", "curvature") else STEP for name in OF_ROD}
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
    of_rod, of_end = {}, {}
    for name, (curve, step) in moved.items():
        loads = _loads(curve, np.append(x0, end))
        of_rod[name] = (loads[:-1] - y) / step
        of_end[name] = (loads[-1, 0] / loads[-1, 1] - float(response.demand(end))) / step
    x1_slope = (moved["eta"][0].x1_init - response.x1_init) / moved["eta"][1]
    starts, eta = STARTS[:, None, None] * end, response.curve.eta
    before, way = (x0 - end)[:, None] * slope, starts + x0[:, None]
    changes = [
        *(of_rod[name] for name in OF_ROD),
        -way * of_rod["eta"] - x1_slope * before,
        before,
        -eta * of_rod["eta"] - before - y * np.array([2.0, 2.0, 1.0]),
        *(y, 4.0 * y),
        *_of_transducer(y, (STARTS[:, None, None] + NODES[:, None]) / PERIODS),
    ]
    shape = (len(STARTS), len(NODES), 3)
    jacobian = np.stack([np.broadcast_to(one, shape) for one in changes])
    weighted = jacobian * NODE_WEIGHTS[:, None]
    friction = np.zeros((len(STARTS), len(PARAMETERS)))
    friction[:, : len(OF_ROD)] = [of_end[name] for name in OF_ROD]
    friction[:, PARAMETERS.index("stage_angle")] = -(starts[:, 0, 0] + end) * of_end["eta"]
    friction[:, PARAMETERS.index("length")] = -eta * of_end["eta"]
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


def _of_transducer(y: FloatArray, part: FloatArray) -> Iterator[FloatArray]:
    """Compute changes by zeros, drifts, axes, origin, crosstalk: the order of `PARAMETERS`."""
    channels = np.eye(3)
    yield from channels
    for channel in channels:
        yield part * channel
        for wave in range(1, WAVES + 1):
            yield np.sin(np.pi * wave * part) * channel
    yield from (y @ mixing.T for mixing in (TURNED, ORIGIN_X, ORIGIN_Y))
    for to, source in permutations(range(3), 2):
        yield y[:, source, None] * channels[to]
