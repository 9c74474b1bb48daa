"""Which rod measures friction best: θ, η, d0 and L for a material, a transducer and a stage.

A period of sticking depends on θ and η alone if lengths are in units of L, forces in E·I0/L²,
moments in E·I0/L and strains in d0/L. So each (θ, η) is solved once (`survey`), and every limit is
a power law in d0 and L (`limits_of`): straight in their logarithms. The deviation of μ0 is a sum of
powers, so convex in them; it falls as d0 grows. For each (θ, η) the best rod is therefore as thick
as the limits allow, and its length is sought along one line (`best_sizes`). What is left is a
search over (θ, η) (`design`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from typing import Any

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.optimize import linprog

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.bending import strains
from vibrissa.collocation import BATCH, solve_curves
from vibrissa.curve import StickingCurve
from vibrissa.sensor.identification import READS, Method
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.response import tabulated
from vibrissa.sensor.sticking import JUMP
from vibrissa.sensor.uncertainty import ratio_deviation, step_deviation
from vibrissa.status import Contact, Status
from vibrissa.units import Rod

GRAVITY = 9.80665
# Second moment of area of a circle over the fourth power of its diameter.
INERTIA = np.pi / 64.0
# Values of μ0 in the range at which the deviation is computed; the largest counts.
FRICTIONS = 9
# States of a period among which the largest forces and strains are sought.
STATES, STRAINED = 129, 9
# Values of θ and η at which a search begins, and how often the mesh is halved around the best.
TAPERS, HEIGHTS, ROUNDS = 10, 14, 5
# Lengths among which the best is sought, twice: on the whole range and around the best of those.
LENGTHS = 129
# A limit is used up from here on: the search comes no closer to where it is.
USED_UP = 0.97
# By this much, in logarithms, a limit may be exceeded: a rod that was found keeps to its limits
# when it is solved again.
ROUNDING = 1e-6
# Logarithms beyond this mean that something is zero or infinite.
HUGE = 100.0
# What tells a slip from noise must be passed by this, or one in two slips is missed; so, in 1,000.
CLEARLY = 1.5
# Error of the margin of stability: below it a rod does not count as stable.
STABLE = 1e-4


@dataclass(frozen=True)
class Requirements:
    """What a rod is to measure, with what, and what it must keep to. SI units throughout.

    Attributes
    ----------
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which the material is elastic.
    mu0 : (float, float)
        Least and largest friction to be measured.
    step : float
        Step of the stage (m).
    noise : (float, float, float)
        Standard deviation of one reading of force_x, force_y (N) and moment_z (N·m), rounding
        included (`Transducer.deviation`).
    range : (float, float, float)
        Largest force_x, force_y and moment_z that the transducer measures; infinite if any.
    density : float, optional
        Of the material (kg/m³). Without it the weight is not looked at.
    method : Method
        What friction is read from, as in `identify`.
    contact : Contact
        ``point``: the rod may touch with its tip alone; ``line``: it may lie down on the surface.
    theta, eta : (float, float)
        Tapers and heights of the surface (L) among which to choose; equal where they are given.
    diameter, length : (float, float)
        Diameters at the clamp and lengths among which to choose (m).
    tip : float
        Least diameter of the tip (m).
    safety : float
        Factor by which the strain must stay below the yield strain.
    lock_factor : float
        Factor by which the locking friction must exceed the largest friction.
    steps : float
        Least number of steps of the stage in the shortest period of sticking.
    weight : float
        Largest weight of the rod, relative to the least normal force: the model has no gravity.
    spacing : float
        Largest travel from slip to slip (m), that is between two measurements.
    """

    modulus: float
    yield_strain: float
    mu0: tuple[float, float]
    step: float
    noise: tuple[float, float, float]
    range: tuple[float, float, float] = (np.inf, np.inf, np.inf)
    density: float | None = None
    method: Method = Method.FORCES
    contact: Contact = Contact.POINT
    theta: tuple[float, float] = (1.0, 10.0)
    eta: tuple[float, float] = (0.5, 0.98)
    diameter: tuple[float, float] = (1e-4, 1e-2)
    length: tuple[float, float] = (0.02, 0.2)
    tip: float = 1e-4
    safety: float = 1.5
    lock_factor: float = 1.1
    steps: float = 10.0
    weight: float = 0.1
    spacing: float = np.inf

    def __post_init__(self) -> None:
        """Refuse what no rod can be asked for."""
        object.__setattr__(self, "method", Method(self.method))
        object.__setattr__(self, "contact", Contact(self.contact))
        for name in ("yield_strain", "weight", "spacing"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)!r}")
        for name in ("modulus", "step", "steps"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)!r}")
        for name in ("safety", "lock_factor"):
            if not 1.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)!r}")
        if not 0.0 <= self.tip < np.inf:
            raise ValueError(f"tip must not be negative, got {self.tip!r}")
        if self.density is not None and not self.density > 0.0:
            raise ValueError(f"density must be positive, got {self.density!r}")
        bounds = {"mu0": (0.0, np.inf), "theta": (1.0, np.inf), "eta": (0.0, 1.0)}
        for name in ("mu0", "theta", "eta", "diameter", "length"):
            low, high = getattr(self, name)
            least, most = bounds.get(name, (0.0, np.inf))
            inside = low >= least if name == "theta" else low > least
            if not (inside and low <= high < most):
                raise ValueError(
                    f"{name} must be a range of increasing values "
                    f"{'from' if name == 'theta' else 'above'} {least:g} to below {most:g}, got "
                    f"{low:g} to {high:g}"
                )
        for name in ("noise", "range"):
            values = getattr(self, name)
            if len(values) != 3 or not all(value > 0.0 for value in values):
                raise ValueError(f"{name} must be three positive values, got {values}")
        if not max(self.noise) < np.inf:
            raise ValueError(f"noise must be finite, got {self.noise}")

    @property
    def given(self) -> bool:
        """Whether the whole rod is given, so that there is nothing to search."""
        chosen = (self.theta, self.eta, self.diameter, self.length)
        return all(low == high for low, high in chosen)


def without_units(**requirements: Any) -> Requirements:
    """Set requirements in units of the rod: lengths in L, forces in E·I0/L², moments in E·I0/L.

    Parameters
    ----------
    **requirements
        As in `Requirements`, with `yield_strain` in units of d0/L and without modulus, diameter,
        length and tip: d0 and L stay open, and only θ and η are sought.

    Returns
    -------
    Requirements
    """
    # The rod that is itself the unit: E·I0 = d0 = L = 1.
    unit = {"modulus": 1.0 / INERTIA, "diameter": (1.0, 1.0), "length": (1.0, 1.0), "tip": 0.0}
    return Requirements(**{"yield_strain": np.inf, **unit, **requirements})


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


def _worst(
    requirements: Requirements, shapes: Shapes, diameter: FloatArray, length: FloatArray
) -> FloatArray:
    step, reading = deviations(requirements, shapes, diameter, length)
    return np.asarray(np.hypot(step, reading).max(axis=-1))


def best_sizes(
    requirements: Requirements, shapes: Shapes, without: str = ""
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sizes that measure best within the limits, for each (θ, η).

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes
        n pairs (θ, η).
    without : str
        A limit that is left out.

    Returns
    -------
    deviation, diameter, length : ndarray, shape (n,)
        Largest standard deviation of μ0 in the range, and the sizes (m); infinite and NaN where
        no size keeps to all limits.
    """
    uses = [x.log_use for x in limits_of(requirements, shapes) if x.name != without]
    low, high, possible = _lengths(uses, len(shapes))
    best = low.copy()
    thickness = np.zeros(len(shapes))
    for _ in range(2):
        part = np.linspace(0.0, 1.0, LENGTHS)
        log_length = low[:, None] + (high - low)[:, None] * part
        thickest = [-(c[:, None] + q * log_length) / p for c, p, q in uses if p > 0]
        log_diameter = np.min(thickest, axis=0)
        worst = _worst(requirements, shapes, np.exp(log_diameter), np.exp(log_length))
        rows, column = np.arange(len(shapes)), np.argmin(np.nan_to_num(worst, nan=np.inf), axis=1)
        best, thickness = log_length[rows, column], log_diameter[rows, column]
        deviation = worst[rows, column]
        low, high = (
            log_length[rows, np.maximum(column - 1, 0)],
            log_length[rows, np.minimum(column + 1, LENGTHS - 1)],
        )
    good = possible & np.isfinite(deviation)
    return (
        np.where(good, deviation, np.inf),
        np.where(good, np.exp(thickness), np.nan),
        np.where(good, np.exp(best), np.nan),
    )


def _lengths(
    uses: Sequence[tuple[FloatArray, int, int]], n: int
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Logarithms of the least and largest length for which some diameter keeps to all limits."""
    low, high, possible = np.full(n, -np.inf), np.full(n, np.inf), np.ones(n, dtype=bool)
    # c + q·ln L ≤ 0: from limits without d0, and from each pair of an upper and a lower one to it.
    rows = [(c, float(q)) for c, p, q in uses if p == 0]
    for c, p, q in uses:
        for other, below, power in uses:
            if p > 0 > below:
                rows.append((c / p - other / below, q / p - power / below))
    for c, slope in rows:
        if slope == 0.0:
            possible &= c <= ROUNDING
        elif slope > 0.0:
            high = np.minimum(high, -c / slope)
        else:
            low = np.maximum(low, -c / slope)
    possible &= low <= high + ROUNDING
    # Where nothing is possible any length will do: it is not used.
    high = np.maximum(low, high)
    return np.clip(low, -HUGE, HUGE), np.clip(high, -HUGE, HUGE), possible


def nearest_sizes(
    requirements: Requirements, shapes: Shapes
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sizes, among those to choose from, that exceed the limits least.

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes
        n pairs (θ, η).

    Returns
    -------
    excess, diameter, length : ndarray, shape (n,)
        Logarithm of the largest excess over a limit, and the sizes (m).
    """
    limits = limits_of(requirements, shapes)
    rows = [(*limit.log_use, 0.0 if limit.hard else -1.0) for limit in limits]
    matrix = [[p, q, soft] for _, p, q, soft in rows]
    results = []
    for i in range(len(shapes)):
        found = linprog(
            [0.0, 0.0, 1.0],
            A_ub=matrix,
            b_ub=[-c[i] for c, *_ in rows],
            bounds=[(None, None)] * 3,
        )
        results.append(found.x if found.x is not None else [np.nan, np.nan, np.inf])
    diameter, length, excess = np.array(results).reshape(-1, 3).T
    return excess, np.exp(diameter), np.exp(length)


class Verdict(StrEnum):
    """What came out of a design.

    Attributes
    ----------
    FOUND
        A rod that keeps to all limits: the best of them.
    NONE
        No rod keeps to all limits: the one that exceeds them least.
    FAILED
        No rod could be solved at all; the message says why.
    """

    FOUND = "found"
    NONE = "none"
    FAILED = "failed"


@dataclass(frozen=True)
class Check:
    """One limit at the rod of a design.

    Attributes
    ----------
    name, meaning : str
    kind : Kind
    value, bound : float
    upper : bool
        Whether the bound is the largest value allowed, not the least.
    use : float
        How much of it is used: above 1 it is exceeded.
    """

    name: str
    meaning: str
    kind: Kind
    value: float
    bound: float
    upper: bool
    use: float


@dataclass(frozen=True, eq=False)
class Design:
    """The best rod, what limits it and what would help.

    Attributes
    ----------
    verdict : Verdict
    message : str
        The verdict in words.
    requirements : Requirements
    theta, eta, diameter, length : float
        The rod (m); NaN if none was solved.
    deviation : float
        Largest standard deviation of μ0 in the range, from one period of sticking.
    mu0, by_step, by_reading, x0_slip : ndarray, shape (k,)
        Frictions of the range; standard deviation by the step and by the readings, which add up in
        squares; travel in a period (m). NaN where the tip locks.
    mu_lock : float
        Locking friction.
    checks : list of Check
    limited_by : list of str
        Limits that are used up, or, where there is no rod, exceeded; `theta` or `eta` where the
        best lies at the end of the range to choose from.
    helps : dict
        Deviation if a limit that is used up were twice as wide, or noise or step half as large.
    shapes : Shapes
        All (θ, η) that were solved, and
    worst : ndarray
        the deviation with the best sizes for each; infinite where no size keeps to all limits.
    """

    verdict: Verdict
    message: str
    requirements: Requirements
    theta: float = np.nan
    eta: float = np.nan
    diameter: float = np.nan
    length: float = np.nan
    deviation: float = np.nan
    mu0: FloatArray = field(default_factory=lambda: np.empty(0))
    by_step: FloatArray = field(default_factory=lambda: np.empty(0))
    by_reading: FloatArray = field(default_factory=lambda: np.empty(0))
    x0_slip: FloatArray = field(default_factory=lambda: np.empty(0))
    mu_lock: float = np.nan
    checks: list[Check] = field(default_factory=list)
    limited_by: list[str] = field(default_factory=list)
    helps: dict[str, float] = field(default_factory=dict)
    shapes: Shapes | None = None
    worst: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def rod(self) -> Rod:
        """The rod, for `vibrissa.sensor.quantities.Units`."""
        return Rod(self.requirements.modulus, self.diameter, self.length)


class _Search:
    """(θ, η) solved so far; a mesh, geometric in θ and 1 − η, that is refined around the best."""

    def __init__(self, requirements: Requirements, progress: Callable[[int], None]) -> None:
        self.requirements, self.progress = requirements, progress
        self.known: set[tuple[float, float]] = set()
        nothing = np.empty(0)
        self.shapes, self.failures = self._survey(nothing, nothing)
        # Coordinates u, v in [0, 1] of θ and η in their ranges.
        theta, eta = requirements.theta, requirements.eta
        self.free = (theta[0] < theta[1], eta[0] < eta[1])
        counts = [
            n if is_free else 1 for n, is_free in zip((TAPERS, HEIGHTS), self.free, strict=True)
        ]
        self.mesh = [1.0 / max(n - 1, 1) for n in counts]
        u, v = np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in counts))
        self.add(u.ravel(), v.ravel())

    def _survey(self, theta: FloatArray, eta: FloatArray) -> tuple[Shapes, list[str]]:
        return survey(theta, eta, self.requirements.mu0, self.requirements.contact)

    def add(self, u: FloatArray, v: FloatArray) -> None:
        (theta0, theta1), (eta0, eta1) = self.requirements.theta, self.requirements.eta
        theta = theta0 * (theta1 / theta0) ** np.clip(u, 0.0, 1.0)
        eta = 1.0 - (1.0 - eta0) * ((1.0 - eta1) / (1.0 - eta0)) ** np.clip(v, 0.0, 1.0)
        pairs = dict.fromkeys(zip(theta.round(12).tolist(), eta.round(12).tolist(), strict=True))
        new = [pair for pair in pairs if pair not in self.known]
        for start in range(0, len(new), BATCH):
            some = new[start : start + BATCH]
            theta_, eta_ = np.array(some).T
            shapes, failures = self._survey(theta_, eta_)
            self.shapes = self.shapes.joined(shapes)
            self.failures += failures
            self.known |= set(some)
            self.progress(len(self.known))

    def refine(self, requirements: Requirements, rounds: Sequence[int]) -> int:
        """Halve the mesh around the best so often, and return the best."""
        best = self.best(requirements)
        for depth in rounds:
            (theta0, theta1), (eta0, eta1) = self.requirements.theta, self.requirements.eta
            theta, eta = (float(values[best]) for values in (self.shapes.theta, self.shapes.eta))
            u = np.log(theta / theta0) / np.log(theta1 / theta0) if self.free[0] else 0.0
            v = (
                np.log((1.0 - eta) / (1.0 - eta0)) / np.log((1.0 - eta1) / (1.0 - eta0))
                if self.free[1]
                else 0.0
            )
            around = np.array([-1.0, 0.0, 1.0]) / 2**depth
            u_, v_ = np.meshgrid(
                u + around * self.mesh[0] * self.free[0], v + around * self.mesh[1] * self.free[1]
            )
            self.add(u_.ravel(), v_.ravel())
            best = self.best(requirements)
        return best

    def best(self, requirements: Requirements) -> int:
        """Return which is best, or exceeds the limits least."""
        deviation, _, _ = best_sizes(requirements, self.shapes)
        if np.isfinite(deviation).any():
            return int(np.argmin(deviation))
        return int(np.argmin(nearest_sizes(requirements, self.shapes)[0]))


def curves_to_solve(requirements: Requirements) -> int:
    """Count about how many curves a search solves, for showing how far it is."""
    free = [low < high for low, high in (requirements.theta, requirements.eta)]
    around = 3 ** sum(free) - 1
    counts = (n if is_free else 1 for n, is_free in zip((TAPERS, HEIGHTS), free, strict=True))
    return int(np.prod(list(counts))) + 2 * ROUNDS * around


def design(
    requirements: Requirements, progress: Callable[[int], None] = lambda done: None
) -> Design:
    """Find the rod that measures friction best, and say what limits it.

    Parameters
    ----------
    requirements : Requirements
        A rod that is given whole is checked against the limits.
    progress : callable
        Told how many curves are solved, of about `curves_to_solve`.

    Returns
    -------
    Design

    Examples
    --------
    The paper's rod, of structural steel:

    >>> result = design(
    ...     Requirements(
    ...         modulus=210e9,
    ...         yield_strain=0.00112,
    ...         mu0=(0.2, 0.4),
    ...         step=100e-6,
    ...         noise=(0.003, 0.003, 2e-5),
    ...         range=(12.0, 12.0, 0.12),
    ...         theta=(2.0, 2.0),
    ...         eta=(0.85, 0.85),
    ...         diameter=(5e-3, 5e-3),
    ...         length=(0.1, 0.1),
    ...     )
    ... )
    >>> print(result.verdict, *result.limited_by)
    none moment_z force_y force_x strain
    """
    search = _Search(requirements, progress)
    shapes = search.shapes
    if not len(shapes):
        why = search.failures[0]
        return Design(Verdict.FAILED, f"no such rod could be solved: {why}", requirements)
    best = search.refine(requirements, range(1, ROUNDS + 1) if any(search.free) else ())
    shapes = search.shapes
    worst, diameters, lengths = best_sizes(requirements, shapes)
    found = bool(np.isfinite(worst[best]))
    if not found:
        _, diameters, lengths = nearest_sizes(requirements, shapes)
    one = np.array([best])
    rod = shapes.take(one)
    diameter, length = diameters[one], lengths[one]
    by_step, by_reading = deviations(requirements, rod, diameter, length)
    checks = [
        Check(
            limit.name,
            limit.meaning,
            limit.kind,
            value := float(limit.value(diameter, length)[0]),
            limit.bound,
            limit.upper,
            value / limit.bound if limit.upper else limit.bound / value if value > 0.0 else np.inf,
        )
        for limit in limits_of(requirements, rod)
        if not _is_given(requirements, limit)
    ]
    limited = _limited(requirements, checks, rod, found)
    helps = {}
    if found and not requirements.given:
        for name, relaxed in _relaxed(requirements, limited).items():
            index = search.refine(relaxed, (1, 2) if any(search.free) else ())
            helps[name] = float(best_sizes(relaxed, search.shapes)[0][index])
    return Design(
        Verdict.FOUND if found else Verdict.NONE,
        _message(requirements, search.shapes, checks, limited, found),
        requirements,
        float(rod.theta[0]),
        float(rod.eta[0]),
        float(diameter[0]),
        float(length[0]),
        float(np.hypot(by_step, by_reading).max()),
        np.linspace(*requirements.mu0, FRICTIONS),
        by_step[0],
        by_reading[0],
        rod.x0[0] * float(length[0]),
        float(rod.mu_lock[0]),
        checks,
        limited,
        helps,
        shapes,
        worst,
    )


def _is_given(requirements: Requirements, limit: Limit) -> bool:
    """Whether a limit to sizes leaves no choice."""
    low, high = {
        "diameter": requirements.diameter,
        "length": requirements.length,
    }.get(limit.meaning, (0.0, 1.0))
    return low == high


def _limited(
    requirements: Requirements, checks: Sequence[Check], rod: Shapes, found: bool
) -> list[str]:
    """Name the limits that are used up or exceeded, the most first, and ends of the ranges."""
    from_ = USED_UP if found else 1.0 + ROUNDING
    names = [
        check.name for check in sorted(checks, key=lambda check: -check.use) if check.use >= from_
    ]
    for name, (low, high), value in (
        ("theta", requirements.theta, rod.theta[0]),
        ("eta", requirements.eta, rod.eta[0]),
    ):
        if found and low < high and not low < value < high:
            names.append(name)
    return names


def _relaxed(requirements: Requirements, limited: Sequence[str]) -> dict[str, Requirements]:
    """Loosen one thing at a time: noise, step, and each limit that is used up."""
    r = requirements
    changes: dict[str, dict[str, Any]] = {
        "noise": {"noise": tuple(0.5 * value for value in r.noise)},
        "step": {"step": 0.5 * r.step},
        "strain": {"yield_strain": 2.0 * r.yield_strain},
        "lock": {"lock_factor": 1.0},
        "steps": {"steps": 0.5 * r.steps},
        "spacing": {"spacing": 2.0 * r.spacing},
        "weight": {"weight": 2.0 * r.weight},
        "tip": {"tip": 0.5 * r.tip},
        "thickest": {"diameter": (r.diameter[0], 2.0 * r.diameter[1])},
        "thinnest": {"diameter": (0.5 * r.diameter[0], r.diameter[1])},
        "longest": {"length": (r.length[0], 2.0 * r.length[1])},
        "shortest": {"length": (0.5 * r.length[0], r.length[1])},
    }
    for i, name in enumerate(("force_x", "force_y", "moment_z")):
        wider = tuple(2.0 * value if i == j else value for j, value in enumerate(r.range))
        changes[name] = {"range": wider}
    chosen = ["noise", "step", *(name for name in limited if name in changes)]
    return {name: replace(r, **changes[name]) for name in chosen}


def _message(
    requirements: Requirements,
    shapes: Shapes,
    checks: Sequence[Check],
    limited: Sequence[str],
    found: bool,
) -> str:
    subject = "this rod" if requirements.given else "the best rod"
    if found:
        by = ", ".join(limited)
        return f"{subject} keeps to all limits" + (f"; it is limited by {by}" if by else "")
    exceeded = ", ".join(
        f"{check.name} ({check.use:.3g} times what is allowed)"
        for check in sorted(checks, key=lambda check: -check.use)
        if check.name in limited
    )
    if requirements.given:
        return f"this rod cannot be used: it exceeds {exceeded}"
    alone = [
        check.name
        for check in checks
        if check.use >= USED_UP
        and np.isfinite(best_sizes(requirements, shapes, without=check.name)[0]).any()
    ]
    advice = (
        f"without the limit on {' or on '.join(alone)} there would be one"
        if alone
        else "no single limit is to blame"
    )
    return f"no rod keeps to all limits: the nearest exceeds {exceeded}; {advice}"
