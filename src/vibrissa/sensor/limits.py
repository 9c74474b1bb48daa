"""What limits a rod of given θ and η, and how well it measures: power laws in d0 and L.

A period of sticking depends on θ and η alone if lengths are in units of L, forces in E·I0/L²,
moments in E·I0/L and strains in d0/L. So each (θ, η) is solved once (`survey`), and every limit is
a power law in d0 and L (`limits_of`): straight in their logarithms. The deviation of μ0
(`deviations`) is a sum of powers, so convex in them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from scipy.integrate import cumulative_simpson

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.bending import strains
from vibrissa.collocation import solve_curves
from vibrissa.curve import StickingCurve
from vibrissa.sensor.identification import READS, Method
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.requirements import INERTIA, Requirements
from vibrissa.sensor.response import tabulated
from vibrissa.sensor.sticking import JUMP
from vibrissa.sensor.uncertainty import ratio_deviation, step_deviation
from vibrissa.status import Contact, Status

GRAVITY = 9.80665
# Values of μ0 in the range at which the deviation is computed; the largest counts.
FRICTIONS = 9
# States of a period among which the largest forces and strains are sought.
STATES, STRAINED = 129, 9
# Logarithms beyond this mean that something is zero or infinite.
HUGE = 100.0
# What tells a slip from noise must be passed by this, or one in two slips is missed; so, in 1,000.
CLEARLY = 1.5
# Error of the margin of stability: below it a rod does not count as stable.
STABLE = 1e-4


@dataclass(frozen=True, eq=False)
class Shapes:
    """What a design needs to know of n pairs (θ, η), nondimensional.

    Attributes
    ----------
    theta, eta : ndarray, shape (n,)
    mu_lock, x0_touch, x0_end : ndarray, shape (n,)
        Locking friction; where the rod comes to lie on the surface (infinite if nowhere); onset of
        slip for the largest friction, or the lock if it locks (L).
    x0, slope, fx, fy, path : ndarray, shape (n, k)
        For each friction: onset of slip (L), growth of the demand with x0 there, forces there
        (E·I0/L²), and the integral of the squared slope of the moment up to there; NaN where the
        tip locks.
    peak : ndarray, shape (n, 3)
        Largest magnitude of fx, fy and m in a period.
    lightest : ndarray, shape (n,)
        Least normal force in a period.
    faintest : ndarray, shape (n, 3)
        Slopes with x0 where a reading tells least: of fx and fy, where the sum of their squares is
        least in a period, and the least of m.
    strain : ndarray, shape (n,)
        Largest strain in a period (d0/L).
    stability : ndarray, shape (n,)
        Least margin of stability in a period.
    """

    theta: FloatArray
    eta: FloatArray
    mu_lock: FloatArray
    x0_touch: FloatArray
    x0_end: FloatArray
    x0: FloatArray
    slope: FloatArray
    fx: FloatArray
    fy: FloatArray
    path: FloatArray
    peak: FloatArray
    lightest: FloatArray
    faintest: FloatArray
    strain: FloatArray
    stability: FloatArray

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.theta)

    def take(self, index: IntArray | BoolArray) -> "Shapes":
        """Select pairs."""
        return Shapes(*(getattr(self, f.name)[index] for f in fields(self)))

    def joined(self, other: "Shapes") -> "Shapes":
        """Append other pairs."""
        names = [f.name for f in fields(self)]
        return Shapes(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in names))


def survey(
    theta: FloatArray, eta: FloatArray, mu0: tuple[float, float], contact: Contact
) -> tuple[Shapes, list[str]]:
    """Solve pairs (θ, η) for what a design needs of them.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
    mu0 : (float, float)
        Least and largest friction.
    contact : Contact

    Returns
    -------
    Shapes
        Of those that were solved.
    list of str
        Why others were not.
    """
    frictions = np.linspace(*mu0, FRICTIONS)
    curves = solve_curves(theta, eta, contact)
    solved = [curve for curve in curves if curve.status is Status.SOLVED]
    rows = [_read(curve, frictions) for curve in solved]
    names = [f.name for f in fields(Shapes) if f.name != "strain"]
    columns = {name: np.array([row[name] for row in rows], dtype=float) for name in names}
    for name, width in (("x0 slope fx fy path", FRICTIONS), ("peak faintest", 3)):
        columns |= {n: columns[n].reshape(-1, width) for n in name.split()}
    shapes = Shapes(**columns, strain=_strains(solved, columns["x0_end"]))
    return shapes, [curve.message for curve in curves if curve.status is not Status.SOLVED]


def _read(curve: StickingCurve, frictions: FloatArray) -> dict[str, Any]:
    response = tabulated(curve)
    onset = curve.onset(frictions)
    end = float(onset[-1]) if np.isfinite(onset[-1]) else curve.x0_lock
    x = np.linspace(0.0, end, STATES)
    reactions, slopes = response(x), response.slope(x)
    path = cumulative_simpson(slopes[:, 2] ** 2, x=x, initial=0.0)
    slips = np.isfinite(onset)
    at = np.where(slips, onset, 0.0)
    fx, fy, _ = response(at).T

    def where_slips(values: FloatArray) -> FloatArray:
        return np.where(slips, values, np.nan)

    return {
        "theta": curve.theta,
        "eta": curve.eta,
        "mu_lock": curve.mu_lock,
        "x0_touch": np.inf if np.isnan(curve.x0_touch) else curve.x0_touch,
        "x0_end": end,
        "x0": onset,
        "slope": where_slips(response.demand_slope(at)),
        "fx": where_slips(fx),
        "fy": where_slips(fy),
        "path": where_slips(np.interp(at, x, path)),
        "peak": np.abs(reactions).max(axis=0),
        "lightest": np.abs(reactions[:, 1]).min(),
        "faintest": np.append(
            slopes[np.argmin((slopes[:, :2] ** 2).sum(axis=1)), :2], slopes[:, 2].min()
        ),
        "stability": curve.state(x).stability.min(),
    }


def _strains(curves: Sequence[StickingCurve], x0_end: FloatArray) -> FloatArray:
    """Largest strains in a period, all shapes integrated together."""
    if not len(curves):
        return np.empty(0)
    columns = []
    for curve, end in zip(curves, x0_end, strict=True):
        state = curve.state(np.linspace(0.0, end, STRAINED))
        contact = curve.x1_init - state.x0 - (1.0 - state.s_c)
        both = (np.full(STRAINED, value) for value in (curve.theta, curve.eta))
        theta, eta = both
        columns.append((theta, state.f, state.alpha, contact, eta, state.s_c))
    values = strains(*(np.concatenate(parts) for parts in zip(*columns, strict=True)))
    return np.asarray(values.reshape(-1, STRAINED).max(axis=1))


@dataclass(frozen=True, eq=False)
class Limit:
    """A limit on coefficient·d0^p·L^q, for n pairs (θ, η).

    Attributes
    ----------
    name, meaning : str
    kind : Kind
        What it measures.
    coefficient : ndarray, shape (n,)
    p, q : int
        Powers of d0 and L.
    bound : float
    upper : bool
        Whether the bound is the largest value allowed, not the least.
    hard : bool
        Whether it says among which rods to choose, not what they must do.
    """

    name: str
    meaning: str
    kind: Kind
    coefficient: FloatArray
    p: int
    q: int
    bound: float
    upper: bool = True
    hard: bool = False

    def value(self, diameter: FloatArray, length: FloatArray) -> FloatArray:
        """Give what is limited, for rods of given sizes (m)."""
        return np.asarray(self.coefficient * diameter**self.p * length**self.q)

    @property
    def log_use(self) -> tuple[FloatArray, int, int]:
        """Logarithm of how much of the limit is used, at d0 = L = 1, and its powers."""
        sign = 1 if self.upper else -1
        with np.errstate(divide="ignore"):
            use = sign * (np.log(self.coefficient) - np.log(self.bound))
        return np.clip(use, -HUGE, HUGE), sign * self.p, sign * self.q


def limits_of(requirements: Requirements, shapes: Shapes) -> list[Limit]:
    """Limits that the requirements set to rods of given (θ, η).

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes

    Returns
    -------
    list of Limit
        Without those that allow everything.
    """
    r, n = requirements, len(shapes)
    one, force = np.ones(n), INERTIA * r.modulus
    peaks = shapes.peak.T * force
    # One over the deviation of x0 as one reading tells it, by the forces or by the moment.
    by_moment = r.method is Method.MOMENT
    used = READS[Method.MOMENT if by_moment else Method.FORCES]
    slopes = np.maximum(shapes.faintest, 0.0) if by_moment else shapes.faintest
    told = np.sqrt(((slopes * force / np.array(r.noise))[:, used] ** 2).sum(axis=1))
    shortest = np.nan_to_num(shapes.x0[:, 0], nan=0.0)
    limits = [
        Limit(
            "strain",
            "largest strain, of the yield strain over its safety factor",
            Kind.NUMBER,
            shapes.strain,
            1,
            -1,
            r.yield_strain / r.safety,
        ),
        Limit("force_x", "largest force", Kind.FORCE, peaks[0], 4, -2, r.range[0]),
        Limit("force_y", "largest force", Kind.FORCE, peaks[1], 4, -2, r.range[1]),
        Limit("moment_z", "largest moment", Kind.MOMENT, peaks[2], 4, -1, r.range[2]),
        Limit(
            "lock",
            "locking friction, of the largest friction times its factor",
            Kind.NUMBER,
            shapes.mu_lock,
            0,
            0,
            r.lock_factor * r.mu0[1],
            upper=False,
        ),
        Limit(
            "steps",
            "steps of the stage in the shortest period",
            Kind.NUMBER,
            shortest / r.step,
            0,
            1,
            r.steps,
            upper=False,
        ),
        Limit(
            "slips",
            "shortest period over what tells a slip from noise",
            Kind.NUMBER,
            shortest * told / (np.sqrt(2.0) * JUMP),
            4,
            -1 if by_moment else -2,
            CLEARLY,
            upper=False,
        ),
        Limit(
            "spacing",
            "travel from slip to slip, at most",
            Kind.LENGTH,
            shapes.x0_end,
            0,
            1,
            r.spacing,
        ),
        Limit(
            "stability",
            "margin of stability",
            Kind.NUMBER,
            np.maximum(shapes.stability, 0.0),
            0,
            0,
            STABLE,
            upper=False,
        ),
        Limit(
            "tip",
            "diameter of the tip",
            Kind.LENGTH,
            1.0 / shapes.theta,
            1,
            0,
            r.tip,
            upper=False,
        ),
        Limit("thickest", "diameter", Kind.LENGTH, one, 1, 0, r.diameter[1], hard=True),
        Limit(
            "thinnest", "diameter", Kind.LENGTH, one, 1, 0, r.diameter[0], upper=False, hard=True
        ),
        Limit("longest", "length", Kind.LENGTH, one, 0, 1, r.length[1], hard=True),
        Limit("shortest", "length", Kind.LENGTH, one, 0, 1, r.length[0], upper=False, hard=True),
    ]
    if r.contact is Contact.POINT:
        limits.append(
            Limit(
                "touch",
                "displacement at which the rod would lie down, over the longest period",
                Kind.NUMBER,
                shapes.x0_touch / shapes.x0_end,
                0,
                0,
                1.0,
                upper=False,
            )
        )
    if r.density is not None:
        cone = np.pi / 12.0 * (1.0 + 1.0 / shapes.theta + 1.0 / shapes.theta**2)
        weight = r.density * GRAVITY * cone / (shapes.lightest * force)
        limits.append(
            Limit(
                "weight",
                "weight over the least normal force",
                Kind.NUMBER,
                weight,
                -2,
                3,
                r.weight,
            )
        )
    return [limit for limit in limits if limit.bound != (np.inf if limit.upper else 0.0)]


def deviations(
    requirements: Requirements, shapes: Shapes, diameter: FloatArray, length: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give the standard deviation of μ0 from one period, by the step and by the readings.

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes
        n pairs (θ, η).
    diameter, length : ndarray, shape (n, ...)
        Sizes of rods of each (m).

    Returns
    -------
    step, reading : ndarray, shape (n, ..., k)
        For each friction of the range; NaN where the tip locks. They add up in squares.

    Notes
    -----
    What `identify` states, of a period that begins at α = 0. The moment is read in all samples of
    the period; the sum over them is taken as an integral.
    """
    r = requirements
    length_ = np.asarray(length)[..., None]
    force = INERTIA * r.modulus * np.asarray(diameter)[..., None] ** 4 / length_**2
    spread = (len(shapes),) + (1,) * (length_.ndim - 2) + (-1,)
    slope, fx, fy, path = (
        values.reshape(spread) for values in (shapes.slope, shapes.fx, shapes.fy, shapes.path)
    )
    dx0 = r.step / length_
    by_step = step_deviation(slope, dx0)
    if r.method is Method.FORCES:
        by_reading = ratio_deviation(fx, fy, *r.noise[:2]) / force
    elif r.method is Method.MOMENT:
        by_reading = np.abs(slope) * r.noise[2] / (force * length_) * np.sqrt(dx0 / path)
    else:
        by_reading = np.zeros(by_step.shape)
    return by_step, np.broadcast_to(np.abs(by_reading), by_step.shape)
