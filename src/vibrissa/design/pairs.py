"""Pairs (θ, η), each solved once for rods of all sizes, and the sensitivity of friction to errors.

Lengths are in L, forces in E·I0/L², moments in E·I0/L and strains in d0/L.

`identify` fits the parameters p of the set-up, with tolerances σ, and u, the last x0 of each
period, to all readings. Let J and j be the derivatives of the readings of a period with respect to
p and u, in standard deviations of the readings. The covariance of p is

    C = (Σ JᵀJ − Σ (Jᵀj)(jᵀJ)/(jᵀj) + 1/σ²)⁻¹,    summed over the periods.

The friction of a period changes by D = ∂μ/∂p − ∂μ/∂u·(jᵀJ)/(jᵀj) per unit of p. Its variance has
the part D·C·Dᵀ, common to all periods, and the random part (∂μ/∂u)²/(jᵀj).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.scanning.response import Response
from vibrissa.scanning.rods import MountedRod
from vibrissa.sensor.identification.derivatives import derivatives, moved
from vibrissa.sensor.identification.parameters import (
    OF_ROD,
    Parameter,
    ScanRows,
    parameters_of,
    ranges_of,
)
from vibrissa.sensor.onset import STATES_OF_PERIOD, strains_in
from vibrissa.sensor.ringing import Ringing, ringing
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

# Places in a period, as parts of its length, at which the largest reactions are sought.
PLACES = np.linspace(0.0, 1.0, 129)
# Number of periods in the recording to which the set-up is fitted.
PERIODS = 30
# Number of rows in each period; only the effect of creep depends on it.
ROWS = 100
# Quadrature over the periods (STARTS, PART_WEIGHTS), and over the displacement in one period, as
# parts of its length (NODES, NODE_WEIGHTS). The last node is the onset, where friction is read.
STARTS = PERIODS * (np.polynomial.legendre.leggauss(6)[0] + 1.0) / 2.0
PART_WEIGHTS = np.polynomial.legendre.leggauss(6)[1] / 2.0
NODES = np.append((np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0, 1.0)
NODE_WEIGHTS = np.append(np.polynomial.legendre.leggauss(8)[1] / 2.0, 0.0)
# Properties whose derivatives need another rod solved.
SOLVED = (*OF_ROD, "eta")


def fitted_parameters(sizes: Mapping[str, float], full_scale: FloatArray) -> tuple[Parameter, ...]:
    """Make the parameters that `identify` fits, for rods with a sharp tip; see `parameters_of`."""
    parameters = parameters_of(sizes, frozenset(), full_scale)
    return tuple(parameter for parameter in parameters if parameter.of != "tip_radius")


# For crosstalk, the full scale of each channel is 1.
PARAMETERS = fitted_parameters({}, np.ones(3))


class Sensitivity(NamedTuple):
    """Derivatives of readings and friction with respect to what `identify` fits.

    The axes are k friction coefficients, p of the fitted periods, x displacements in a period,
    3 channels and q parameters of the set-up. All quantities are in units of the rod.

    Attributes
    ----------
    contact : ndarray, shape (k, x, 3)
        Derivatives of the readings with respect to u, the x0 at the end of the period.
    setup : ndarray, shape (k, p, x, 3, q)
        Derivatives of the readings with respect to the parameters.
    friction : ndarray, shape (k, p, q)
        Derivatives of the friction with respect to the parameters, at constant u.
    """

    contact: FloatArray
    setup: FloatArray
    friction: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Pair:
    """A pair (θ, η) and its longest period of sticking, nondimensional.

    The longest period ends where the tip slips at the largest of the k friction coefficients, or
    where it locks.

    Attributes
    ----------
    x0_slip : ndarray, shape (k,)
        Onset of slip for each friction coefficient (L); NaN where the tip locks.
    longest : float
        Length of the longest period (L).
    stress : float
        Largest stress in the longest period (E·d0/L): the largest strain, if the modulus E is
        the same along the rod.
    """

    response: Response
    contact: Contact
    x0_slip: FloatArray
    longest: float
    stress: float

    @property
    def curve(self) -> StickingCurve:
        """Sticking curve."""
        return self.response.curve

    @property
    def shortest(self) -> float:
        """Length of the shortest period (L)."""
        return float(np.nan_to_num(self.x0_slip[0], nan=self.longest))

    @cached_property
    def ringing(self) -> Ringing:
        """Vibrations after the shortest period, in units of √(ρA0·L⁴/(E·I0))."""
        return ringing(self.curve, self.shortest)

    @cached_property
    def reactions(self) -> FloatArray:
        """Clamp reactions fx, fy and m at 129 places in the longest period, shape (129, 3)."""
        return self.response.reactions(self.longest * PLACES)

    @cached_property
    def demand_slope(self) -> FloatArray:
        """Derivative of the mobilised friction −tan α with respect to x0 at each onset (1/L)."""
        return self.response.demand_slope(self.x0_slip)

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Sensitivity in k periods, each up to the onset of slip or, if the tip locks, the lock."""
        end = np.where(np.isfinite(self.x0_slip), self.x0_slip, self.response.x0_lock)
        return sensitivity_of(self.response, end, self.contact)


def survey(
    theta: FloatArray,
    eta: FloatArray,
    frictions: FloatArray,
    contact: Contact,
    mounting: Mounting = IDEAL,
) -> list[Pair]:
    """Solve pairs (θ, η), and find the onset of slip for k increasing friction coefficients.

    Of the mounting of all rods, only their stiffness may differ from the ideal one.

    Pairs that cannot be solved are left out.

    Raises
    ------
    NoResponseError
        If no pair could be solved.
    """
    curves = solve_curves(theta, eta, contact, [mounting] * len(theta))
    solved = [curve for curve in curves if curve.status is Status.SOLVED]
    if not solved:
        raise NoResponseError(
            f"no rod of the given theta and eta could be solved; the first one: {curves[0].message}"
        )
    onsets = [curve.onset(frictions) for curve in solved]
    ends = [
        float(x0[-1]) if np.isfinite(x0[-1]) else curve.x0_lock
        for curve, x0 in zip(solved, onsets, strict=True)
    ]
    largest = strains_in(solved, [np.linspace(0.0, end, STATES_OF_PERIOD) for end in ends]).stress
    stress = largest.reshape(len(solved), STATES_OF_PERIOD).max(axis=1)
    return [
        Pair(
            response=Response(curve=curve),
            contact=contact,
            x0_slip=x0_slip,
            longest=end,
            stress=float(most),
        )
        for curve, x0_slip, end, most in zip(solved, onsets, ends, stress, strict=True)
    ]


def sensitivity_of(response: Response, end: FloatArray, contact: Contact) -> Sensitivity:
    """Compute the sensitivity of readings and friction in k periods that end at x0 = `end` (L)."""
    x0 = end[:, None] * NODES
    at_nodes = response.reactions(x0)
    slope = response.reactions_slope(x0)
    steps, curves = _neighbours(response.curve, contact)
    near = {name: _loads(curve, x0) for name, curve in curves.items()}
    of_rod = derivatives(at_nodes, near, steps)
    x1_init = {name: np.array(curve.x1_init) for name, curve in curves.items()}
    x1_slope = derivatives(response.x1_init, x1_init, steps)["eta"]
    # Axes: friction, period, node, channel.
    part = (STARTS[:, None, None] + NODES[:, None]) / PERIODS
    way = PERIODS * part * end[:, None, None, None]
    before = ((x0 - end[:, None])[..., None] * slope)[:, None]
    loads = at_nodes[:, None]
    changes = {name: change[:, None] for name, change in of_rod.items()}
    changes |= {
        "stage_angle": -way * changes["eta"] - x1_slope * before,
        "stage_scale": before,
        "length": -response.curve.eta * changes["eta"] - before - loads * np.array([2.0, 2.0, 1.0]),
    }
    rows = ScanRows(part=part, last=PERIODS * ROWS)
    for parameter in PARAMETERS:
        if parameter.effect is not None:
            changes[parameter.name] = parameter.effect(loads, rows)
    shape = (len(end), len(STARTS), len(NODES), 3)
    setup = np.stack([np.broadcast_to(changes[p.name], shape) for p in PARAMETERS], axis=-1)
    # Friction is fx/fy of the loads at the onset: only parameters that change the loads change it.
    fx, fy, _ = np.moveaxis(setup[:, :, -1], 2, 0)
    demand = response.demand(end)[:, None, None]
    of_loads = np.array([parameter.effect is None for parameter in PARAMETERS])
    friction = of_loads * (fx - demand * fy) / loads[:, :, -1, 1, None]
    return Sensitivity(contact=slope, setup=setup, friction=friction)


def _neighbours(
    curve: StickingCurve, contact: Contact
) -> tuple[dict[str, float], dict[str, StickingCurve]]:
    """Solve, for each property in `SOLVED`, the rod with this property changed by a step.

    Returns the steps and the curves by the names of the properties.
    """
    rod = MountedRod.of(curve)
    ranges = ranges_of(rod)
    steps = {name: ranges[name].step for name in SOLVED}
    rods = [moved(rod, {name: step}) for name, step in steps.items()]
    theta, eta = np.array([(rod.theta, rod.eta) for rod in rods]).T
    curves = solve_curves(theta, eta, contact, [rod.mounting for rod in rods])
    return steps, dict(zip(SOLVED, curves, strict=True))


def _loads(curve: StickingCurve, x0: FloatArray) -> FloatArray:
    """Clamp reactions at displacements x0, shape x0.shape + (3,); NaN for an unsolved curve."""
    if curve.status is not Status.SOLVED:
        return np.full((*x0.shape, 3), np.nan)
    state = curve.state(x0)
    return np.stack([state.reaction_fx, state.reaction_fy, state.reaction_m], axis=-1)
