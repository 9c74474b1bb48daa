"""Pairs (θ, η), each solved once for all sizes of rods.

Lengths are in L, forces in E·I0/L², moments in E·I0/L and strains in d0/L.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibrissa.design.sensitivity import Sensitivity, sensitivities
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor.response.branch import Response, tabulated
from vibrissa.sensor.strain import strains_until
from vibrissa.sticking.solving.collocation import solve_curves

# States of a period among which the largest reactions are sought.
STATES = 129


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
    sensitivity = sensitivities(responses, columns["x0_slip"], contact)
    return Pairs(**columns, sensitivity=sensitivity), failures


def _longest_period(response: Response, frictions: FloatArray) -> dict[str, Any]:
    """One row of `Pairs`, without its sensitivity."""
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
        "strain": strains_until(curve, end)[1].largest[0],
    }
