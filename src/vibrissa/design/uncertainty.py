"""The uncertainty of μ0 that a rod of some size reads, by its sources.

The equations are in `vibrissa.design.sensitivity`; here rods of one pair (θ, η) get a size.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Requirements
from vibrissa.design.sensitivity import PARAMETERS, PART_WEIGHTS, PERIODS
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.given.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.identification.parameters import SLOPE, parameters_of
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.whisker import Whisker


@dataclass(frozen=True, eq=False, kw_only=True)
class Uncertainty(Batch):
    """Standard deviation of μ0 from one period of sticking, by its sources, shape (m, k).

    Attributes
    ----------
    by_step, by_reading : ndarray
        Random: by the step of the stage, and by the noise of the readings.
    by_tolerances : ndarray
        Common to all periods: by what remains of the tolerances after the fit of `identify`.
    """

    by_step: FloatArray
    by_reading: FloatArray
    by_tolerances: FloatArray

    @property
    def whole(self) -> FloatArray:
        """All of them, added in quadrature; NaN where the tip locks."""
        return np.sqrt(self.by_step**2 + self.by_reading**2 + self.by_tolerances**2)

    @property
    def largest(self) -> FloatArray:
        """Largest of all friction coefficients, shape (m,)."""
        return np.asarray(self.whole.max(axis=-1))


@dataclass(frozen=True, eq=False, kw_only=True)
class Fitted(Batch):
    """What the fit leaves of the tolerances, for m rods of one pair (θ, η) at k frictions.

    Attributes
    ----------
    sigma : ndarray, shape (m, q)
        Tolerances.
    effect : ndarray, shape (m, k, q)
        D, mean of all periods, in tolerances.
    covariance : ndarray, shape (m, k, q, q)
        C, in tolerances.
    by_reading : ndarray, shape (m, k)
        Random deviation of μ0 by the noise.
    """

    sigma: FloatArray
    effect: FloatArray
    covariance: FloatArray
    by_reading: FloatArray


def uncertainties(
    r: Requirements, pair: Pairs, diameter: FloatArray, length: FloatArray
) -> Uncertainty:
    """Predict the uncertainty of μ0 as `identify` will give it.

    Parameters
    ----------
    r : Requirements
    pair : Pairs
        One pair (θ, η).
    diameter, length : ndarray, shape (m,)
        Sizes of rods (m).

    Returns
    -------
    Uncertainty
    """
    sizes = tolerances_of(r, pair, diameter, length)
    fit = fitted(r, pair, diameter, length, sizes)
    common = np.einsum("mkq,mkqr,mkr->mk", fit.effect, fit.covariance, fit.effect)
    # No reading tells a slope of the surface from friction.
    tilt = np.array([one.get(SLOPE, 0.0) for one in sizes])[:, None]
    common += (tilt * (1.0 + r.frictions**2)) ** 2
    step = (r.step / length)[:, None]
    return Uncertainty(
        by_step=np.abs(pair.sensitivity.slope) * step / np.sqrt(12.0),
        by_reading=fit.by_reading,
        by_tolerances=np.sqrt(common),
    )


def tolerances_of(
    r: Requirements, pair: Pairs, diameter: FloatArray, length: FloatArray
) -> list[dict[str, float]]:
    """Tolerances of each rod, stated or by default, in units of the rod."""
    theta, eta, found = float(pair.theta[0]), float(pair.eta[0]), []
    for size in zip(diameter.tolist(), length.tolist(), strict=True):
        whisker = Whisker(theta=theta, eta=eta, rod=Rod(r.modulus, *size))
        units = whisker.units
        noise = np.array(r.noise) / units.channels
        assumed = assumed_tolerances(units, noise) if r.assume else {}
        found.append(assumed | read_tolerances(units, r.tolerances, whisker))
    return found


def fitted(
    r: Requirements,
    pair: Pairs,
    diameter: FloatArray,
    length: FloatArray,
    sizes: Sequence[Mapping[str, float]],
) -> Fitted:
    """Compute what the fit of a recording leaves of the tolerances of m rods."""
    of = pair.sensitivity.take(0)
    units = np.array(
        [Units(Rod(r.modulus, *size)).channels for size in zip(diameter, length, strict=True)]
    )
    readings = pair.x0_slip[0] * length[:, None] / r.step
    # Inverse variances of the channels of a period, shape (m, k, 3).
    weight = readings[..., None] * ((units / np.array(r.noise)) ** 2)[:, None]
    sigma = np.array([_sigma(one, r, unit, pair) for one, unit in zip(sizes, units, strict=True)])
    contact = (weight * of.of_contact).sum(axis=-1)
    both = np.einsum("mkc,kcrq->mkrq", weight, of.of_both) * sigma[:, None, None]
    setup = np.einsum("mkc,kcab->mkab", weight, of.of_setup) * _outer(sigma)[:, None]
    in_all = PERIODS * PART_WEIGHTS
    # A period of no length tells nothing.
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = both / contact[..., None, None]
        by_reading = np.abs(of.slope) / np.sqrt(contact)
    known = np.einsum("r,mkra,mkrb->mkab", in_all, both, moved)
    effect = of.friction * sigma[:, None, None] - of.slope[:, None, None] * moved
    return Fitted(
        sigma=sigma,
        effect=np.einsum("r,mkrq->mkq", PART_WEIGHTS, effect),
        covariance=np.linalg.inv(setup - known + np.eye(len(PARAMETERS))),
        by_reading=by_reading,
    )


def _outer(values: FloatArray) -> FloatArray:
    return np.asarray(values[:, :, None] * values[:, None, :])


def _sigma(
    sizes: Mapping[str, float], r: Requirements, units: FloatArray, pair: Pairs
) -> FloatArray:
    """Tolerances of all parameters, shape (q,); crosstalk is a part of full scale."""
    full = np.array(r.range) / units
    full = np.where(np.isfinite(full), full, pair.largest_reaction[0])
    found = parameters_of(sizes, frozenset(), full)
    ratio = [
        1.0 if one.mixing is None or one.of != "crosstalk" else one.mixing.max() for one in found
    ]
    return np.array([one.deviation for one in found]) * ratio


@dataclass(frozen=True, kw_only=True)
class TolerancePart:
    """What one tolerance costs in the uncertainty of μ0.

    Attributes
    ----------
    name : str
    size : float
        Standard deviation, in units of the rod, rad, or relative.
    stated : bool
        Whether it was stated; otherwise it is the default.
    alone : float
        Standard deviation of μ0 by it, if nothing is fitted to the recording.
    halved : float
        By which part the uncertainty of μ0 falls if it is halved.
    """

    name: str
    size: float
    stated: bool
    alone: float
    halved: float


def parts_of(
    r: Requirements, pair: Pairs, diameter: FloatArray, length: FloatArray, k: int, whole: float
) -> list[TolerancePart]:
    """Tell what each tolerance of one rod costs at the k-th friction, what to measure first.

    Notes
    -----
    The quantities of one tolerance have half of it if they are measured once more with a third of
    its variance S. By then the variance D·C·Dᵀ falls by D·Cₖ·(S/3 + Cₖₖ)⁻¹·Cₖᵀ·Dᵀ, with the columns
    k of these quantities in C. So correlations are kept.
    """
    (sizes,) = tolerances_of(r, pair, diameter, length)
    fit = fitted(r, pair, diameter, length, [sizes])
    effect, covariance = fit.effect[0, k], fit.covariance[0, k]
    found = []
    for name, tolerance in sizes.items():
        own = np.flatnonzero([one.of == name for one in PARAMETERS])
        alone = float(np.linalg.norm(effect[own]))
        shared = covariance[own] @ effect
        measured = np.eye(len(own)) / 3.0 + covariance[np.ix_(own, own)]
        falls = float(shared @ np.linalg.solve(measured, shared))
        if name == SLOPE:
            alone = tolerance * (1.0 + float(r.frictions[k]) ** 2)
            falls = 0.75 * alone**2
        found.append(
            TolerancePart(
                name=name,
                size=tolerance,
                stated=name in r.tolerances,
                alone=alone,
                halved=1.0 - float(np.sqrt(max(1.0 - falls / whole**2, 0.0))),
            )
        )
    return sorted(found, key=lambda one: -one.halved)
