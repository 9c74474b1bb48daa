"""What is known to a tolerance alone is adjusted to the recording, and its error carried on.

The adjustments p minimise χ²(p) + Σ (p/σ)², where σ are the tolerances, and each period has its own
best contact. The recording may tell a quantity much better than its tolerance, or not at all: what
remains is the covariance (JᵀJ + 1/σ²)⁻¹, J = ∂(residuals)/∂p. This is Bayes' theorem for normal
errors, by Gauss-Newton steps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.optimize import lsq_linear

from vibrissa.errors import ArgumentError, UndeterminedError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.alternatives import (
    PROPERTIES,
    RELATIVE,
    STEP,
    Alternative,
    alternative,
    told,
)
from vibrissa.sensor.identification.calibration import Setup, known_setup, principal_axes
from vibrissa.sensor.identification.periods import Channels, Placed
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.identification.sides import parts_of
from vibrissa.sensor.quantities import Kind, Quantity, Units, in_si
from vibrissa.sensor.whisker import Whisker

# Most steps, and when they end: a step of this part of the deviation that remains.
ROUNDS, SETTLED = 8, 0.05
# What a rod has that sets its tolerance in SI units.
OF_SIZE = {
    "modulus": ("youngs_modulus", Kind.STRESS),
    "diameter": ("base_diameter", Kind.LENGTH),
    "length": ("length", Kind.LENGTH),
}
# A derivative is a difference over this part of the tolerance at most.
PART = 0.1

_Readings = TypeVar("_Readings", bound=Recording)


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """A property that is known to a tolerance.

    Attributes
    ----------
    name : str
    tolerance : float
        Standard deviation of what was given.
    adjusted, deviation : float
        By how much it is larger by the recording, and the standard deviation that remains.
    """

    name: str
    tolerance: float
    adjusted: float
    deviation: float

    def spelled(self, units: Units) -> str:
        """Say it in a person's units."""
        adjusted, unit = told(self.name, self.adjusted, units)
        deviation, tolerance = (
            told(self.name, size, units)[0] for size in (self.deviation, self.tolerance)
        )
        return (
            f"{self.name}: {adjusted:+.3g} ± {deviation:.2g} {unit} beside what was given "
            f"(tolerance {tolerance:.3g})"
        ).replace("  ", " ")


@dataclass(frozen=True, eq=False, kw_only=True)
class Adjusted:
    """What was given, adjusted to a recording within its tolerances.

    Attributes
    ----------
    setup : Setup
        Of the adjusted rod.
    recording : Recording
        Without the errors of transducer and stage.
    whisker : Whisker
        The adjusted one.
    mixing : ndarray, shape (3, 3)
        By which the readings were multiplied, and their noise with them.
    tolerances : tuple of Tolerance
    """

    setup: Setup
    recording: Recording
    whisker: Whisker
    mixing: FloatArray
    tolerances: tuple[Tolerance, ...]

    def noise_of(self, noise: FloatArray) -> FloatArray:
        """Give the noise of the adjusted readings, from that of the readings."""
        return np.asarray(np.sqrt(self.mixing**2 @ noise**2))


def adjusted(
    whisker: Whisker,
    recording: Recording,
    channels: Channels,
    deviations: Mapping[str, float],
    solved: Callable[[Whisker], Placed],
) -> Adjusted:
    """Adjust what was given to a recording, within its tolerances.

    Parameters
    ----------
    whisker : Whisker
        That was given.
    recording : Recording
    channels : Channels
        All that were recorded.
    deviations : mapping of str to float
        Tolerances, as standard deviations, of some of `PROPERTIES`: in units of the rod, rad, or
        relative.
    solved : callable
        Solves a whisker.

    Returns
    -------
    Adjusted

    Raises
    ------
    UndeterminedError
        If the steps do not settle.
    NoResponseError
        If a rod within the tolerances has no response.
    """
    names, sigma = list(deviations), np.array(list(deviations.values()))
    sizes, least = np.zeros(len(names)), np.array([_least(whisker, name) for name in names])
    for _ in range(ROUNDS):
        rod, undone = _with(whisker, names, sizes), _without(recording, names, sizes)
        seen = _seen(known_setup(solved(rod), rod.eta), undone, channels)
        effects = [
            seen.effect_of(alternative(name, _step(one), rod, solved)).ravel() * one
            for name, one in zip(names, sigma, strict=True)
        ]
        jacobian = np.stack(effects, axis=1)
        information = jacobian.T @ jacobian + np.eye(len(names))
        covariance = np.linalg.inv(information)
        best = covariance @ (jacobian.T @ seen.residuals.ravel() - sizes / sigma)
        # Of all changes that are allowed the one with the least sum.
        root = np.linalg.cholesky(information).T
        change = lsq_linear(root, root @ best, ((least - sizes) / sigma, np.inf)).x
        settled = (np.abs(change) <= SETTLED * np.sqrt(np.diag(covariance))).all()
        sizes = sizes + sigma * change
        if settled:
            break
    else:
        raise UndeterminedError(
            "the recording is too far from what was given to be adjusted within the tolerances of "
            f"{', '.join(names)}"
        )
    rod, undone = _with(whisker, names, sizes), _without(recording, names, sizes)
    covariance *= np.outer(sigma, sigma)
    remaining = np.sqrt(np.diag(covariance))
    known = known_setup(solved(rod), rod.eta)
    setup = Setup(
        eta=known.eta,
        offset=known.offset,
        covariance=known.covariance,
        branch=known.branch,
        displaced=tuple(
            _displaced(rod, names, _within(axis, least - sizes), solved)
            for axis in principal_axes(covariance)
        ),
        penalty=float(((sizes / sigma) ** 2).sum()),
    )
    found = zip(names, sigma, sizes, remaining, strict=True)
    return Adjusted(
        setup=setup,
        recording=undone,
        whisker=rod,
        mixing=_mixing(names, sizes),
        tolerances=tuple(
            Tolerance(name=name, tolerance=float(s), adjusted=float(p), deviation=float(d))
            for name, s, p, d in found
        ),
    )


def read_tolerances(whisker: Whisker, given: Mapping[str, Quantity]) -> dict[str, float]:
    """Read tolerances such as ``{"clamp_angle": "0.5 deg", "modulus": "2 %"}``.

    Parameters
    ----------
    whisker : Whisker
        That was given; a percentage is one of its value.
    given : mapping of str to str or number
        Standard deviations of some of `PROPERTIES`.

    Returns
    -------
    dict of str to float
        In units of the rod, rad, or relative.

    Raises
    ------
    ArgumentError
        If one is no such property or quantity, or not positive.
    """
    found = {}
    for name, value in given.items():
        if name not in PROPERTIES:
            raise ArgumentError(f"a tolerance is of one of {', '.join(PROPERTIES)}, got {name!r}")
        found[name] = _read(whisker, name, value)
        if not 0.0 < found[name] < np.inf:
            raise ArgumentError(f"the tolerance of {name} must be positive, got {value!r}")
    return found


def _read(whisker: Whisker, name: str, value: Quantity) -> float:
    units, what = whisker.units, f"the tolerance of {name}"
    if isinstance(value, str) and value.strip().endswith("%"):
        part = float(units.read(value.strip()[:-1], Kind.NUMBER, what)) / 100.0
        if name in RELATIVE:
            return part
        of = {"theta": whisker.theta, "eta": whisker.eta} | vars(whisker.mounting)
        if name not in of:
            raise ArgumentError(f"{what} has no value of which it could be {value}: give a size")
        return part * abs(float(np.atleast_1d(of[name])[0]))
    if name in OF_SIZE and whisker.rod is not None and isinstance(value, str):
        attribute, kind = OF_SIZE[name]
        try:
            return float(in_si(value, kind, what)) / float(getattr(whisker.rod, attribute))
        except ArgumentError:
            if not _is_number(value):
                raise
    return float(units.read(value, PROPERTIES[name].kind, what))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _least(whisker: Whisker, name: str) -> float:
    """Least size that a property can take."""
    return {
        "theta": 1.0 - whisker.theta,
        "clamp_compliance": -whisker.mounting.clamp_compliance,
    }.get(name, -np.inf)


def _within(axis: FloatArray, least: FloatArray) -> FloatArray:
    """Turn an axis, which has no direction, to where its end is allowed; or bring it there."""
    if (axis < least).any() and not (-axis < least).any():
        return -axis
    return np.maximum(axis, least)


def _step(tolerance: float) -> float:
    return min(STEP, PART * tolerance)


def _with(whisker: Whisker, names: Sequence[str], sizes: FloatArray) -> Whisker:
    """Make properties of a whisker larger."""
    for name, size in zip(names, sizes, strict=True):
        whisker = PROPERTIES[name].whisker(whisker, float(size))
    return whisker


def _without(recording: _Readings, names: Sequence[str], sizes: FloatArray) -> _Readings:
    """Take errors of such sizes off a recording."""
    for name, size in zip(names, sizes, strict=True):
        recording = PROPERTIES[name].recording(recording, float(size))
    return recording


def _mixing(names: Sequence[str], sizes: FloatArray) -> FloatArray:
    """Matrix by which `_without` multiplies readings."""
    units = np.vstack([np.zeros(3), np.eye(3)])
    number = np.arange(len(units))
    probe = Recording(clamp=np.zeros(len(units)), readings=units, line=number)
    undone = _without(probe, names, sizes).readings
    return np.asarray((undone[1:] - undone[0]).T)


def _displaced(
    whisker: Whisker, names: Sequence[str], sizes: FloatArray, solved: Callable[[Whisker], Placed]
) -> Alternative:
    other = _with(whisker, names, sizes)
    return Alternative(
        name="tolerances",
        step=1.0,
        corrected=lambda samples: _without(samples, names, sizes),
        branch=None if other == whisker else solved(other),
    )


def _seen(setup: Setup, recording: Recording, channels: Channels) -> Seen:
    """Periods of the samples that fit as well as most, ahead of the clamp."""
    part = parts_of(setup, recording, channels)[0].with_all()
    seen = part.only(part.samples.usual).seen(channels)
    # At the largest moment, by the moment alone, no contact is told.
    return seen.only(np.isfinite(seen.contacts.place) & np.isfinite(seen.contacts.deviation))
