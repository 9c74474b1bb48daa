"""The set-up that a recording is read with, and what of it is not known exactly."""

from dataclasses import dataclass

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.periods import Placed

# Part of an axis of unit length that is more than rounding.
COUNTS = 0.1


@dataclass(frozen=True, eq=False, kw_only=True)
class Setup:
    """A rod at a height, and what is not known exactly of it.

    Attributes
    ----------
    branch : Branch or ObliqueStage
    displaced : tuple of Alternative
        What is not known exactly, each of k things a little larger.
    shared : ndarray, shape (k, k) or None
        Covariance of their errors; None where they are independent and their deviations are 1.
    penalty : float
        Sum of the squares, in tolerances, by which what was given has been adjusted.
    """

    branch: Placed
    displaced: tuple[Alternative, ...] = ()
    shared: FloatArray | None = None
    penalty: float = 0.0


def principal_axes(covariance: FloatArray) -> FloatArray:
    """Vectors of one standard deviation each whose squares add up to the covariance.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)

    Returns
    -------
    ndarray, shape (q, k)
        One row for each axis that is not known exactly; of its first part that counts, each is
        positive, so that rounding does not turn it.
    """
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    variance, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
    first = [axis[np.abs(axis) > COUNTS][0] for axis in axes.T]
    axes = axes * np.sign(first)
    rows = (np.sqrt(np.maximum(variance, 0.0)) * axes).T * scale
    return np.asarray(rows[variance > 1e-14])
