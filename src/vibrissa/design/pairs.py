"""Pairs (θ, η), each solved once for all sizes of rods.

Lengths are in L, forces in E·I0/L², moments in E·I0/L and strains in d0/L.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibrissa.design.sensitivity import Sensitivity, sensitivities
from vibrissa.mechanics.bending import strains
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor.response.branch import Response, tabulated
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.solving.collocation import solve_curves

# States of a period among which the largest reactions and the largest strain are sought.
STATES, STRAIN_STATES = 129, 9


@dataclass(frozen=True, eq=False, kw_only=True)
class Pairs(Batch):
    """n pairs (θ, η) and their longest period of sticking, nondimensional.

    The longest period ends where the tip slips at the largest of the k friction coefficients, or
    where it locks.

    Attributes
    ----------
    x0_touch : ndarray, shape (n,)
        Where more than the tip of the rod touches the surface (L); infinite if nowhere.
    longest : ndarray, shape (n,)
        Length of the longest period (L).
    x0_slip : ndarray, shape (n, k)
        Onset of slip for each friction coefficient (L); NaN where the tip locks.
    largest_reaction : ndarray, shape (n, 3)
        Largest magnitudes of fx, fy and m.
    least_normal_force : ndarray, shape (n,)
        In E·I0/L².
    least_slope : ndarray, shape (n, 2)
        Derivatives of fx and fy with respect to x0 where the sum of their squares is least.
    strain : ndarray, shape (n,)
        Largest strain (d0/L).
    """

    theta: FloatArray
    eta: FloatArray
    mu_lock: FloatArray
    x0_touch: FloatArray
    longest: FloatArray
    x0_slip: FloatArray
    largest_reaction: FloatArray
    least_normal_force: FloatArray
    least_slope: FloatArray
    strain: FloatArray
    sensitivity: Sensitivity


def survey(
    theta: FloatArray, eta: FloatArray, frictions: FloatArray, contact: Contact
) -> tuple[Pairs | None, list[str]]:
    """Solve pairs (θ, η) at k increasing friction coefficients.

    Returns those that were solved, if any, and why the others were not.
    """
    curves = solve_curves(theta, eta, contact)
    failures = [curve.message for curve in curves if curve.status is not Status.SOLVED]
    responses = [tabulated(curve) for curve in curves if curve.status is Status.SOLVED]
    if not responses:
        return None, failures
    rows = [_longest_period(response, frictions) for response in responses]
    columns = {name: np.array([row[name] for row in rows], dtype=float) for name in rows[0]}
    solved = [response.curve for response in responses]
    strain = _largest_strains(solved, columns["longest"])
    sensitivity = sensitivities(responses, columns["x0_slip"], contact)
    return Pairs(**columns, strain=strain, sensitivity=sensitivity), failures


def _longest_period(response: Response, frictions: FloatArray) -> dict[str, Any]:
    """One row of `Pairs`, without strain and sensitivity."""
    curve = response.curve
    x0_slip = curve.onset(frictions)
    end = float(x0_slip[-1]) if np.isfinite(x0_slip[-1]) else curve.x0_lock
    x0 = np.linspace(0.0, end, STATES)
    reactions, slopes = response(x0), response.slope(x0)[:, :2]
    return {
        "theta": curve.theta,
        "eta": curve.eta,
        "mu_lock": curve.mu_lock,
        "x0_touch": np.inf if np.isnan(curve.x0_touch) else curve.x0_touch,
        "longest": end,
        "x0_slip": x0_slip,
        "largest_reaction": np.abs(reactions).max(axis=0),
        "least_normal_force": np.abs(reactions[:, 1]).min(),
        "least_slope": slopes[np.argmin((slopes**2).sum(axis=1))],
    }


def _largest_strains(curves: Sequence[StickingCurve], longest: FloatArray) -> FloatArray:
    """Largest strains in the longest periods."""
    periods = zip(curves, longest, strict=True)
    state = StickingState.concatenate(
        [curve.state(np.linspace(0.0, end, STRAIN_STATES)) for curve, end in periods]
    )
    rods = np.array([(curve.theta, curve.eta, curve.x1_init) for curve in curves])
    theta, eta, x1_init = np.repeat(rods, STRAIN_STATES, axis=0).T
    x_c = x1_init - state.x0 - (1.0 - state.s_c)
    values = strains(theta, state.f, state.alpha, x_c, eta, state.s_c)
    return np.asarray(values.largest.reshape(-1, STRAIN_STATES).max(axis=1))
