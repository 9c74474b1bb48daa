"""The deformed shape of a rod."""

from typing import NamedTuple

from vibrissa.numerics.arrays import FloatArray


class Shape(NamedTuple):
    """Deformed shape of one rod, or of n rods, with the clamp at the origin.

    Attributes
    ----------
    x, y : ndarray, shape (points,) or (n, points)
        Positions (L).
    phi : ndarray, shape (points,) or (n, points)
        Slopes (rad).
    """

    x: FloatArray
    y: FloatArray
    phi: FloatArray
