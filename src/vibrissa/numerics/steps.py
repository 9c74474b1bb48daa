"""The step grid: footpoint displacements that are whole multiples of an exact Δx0.

Where a step ends on the onset of slip, up to rounding, the tip still sticks: see `passes`. A scan
whose states are interpolated over η allows more: `accuracy` in `vibrissa.scanning.response`.
"""

from decimal import Decimal
from fractions import Fraction

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray

# Integers up to here are exact in a double.
EXACT_INTEGER = 2**53
# Accuracy of an onset (L). A step that ends this close to the onset counts as ending on it.
ONSET_ACCURACY = 1e-12


def step_position(step: IntArray, dx0: Decimal) -> FloatArray:
    """Footpoint displacement step·Δx0 (L), the double nearest to the exact product: 3·0.1 = 0.3."""
    numerator, denominator = Fraction(dx0).as_integer_ratio()
    step = np.asarray(step, dtype=np.int64)
    largest = int(np.abs(step).max(initial=0)) * numerator
    if max(largest, numerator, denominator) <= EXACT_INTEGER:
        return step * numerator / denominator  # both exact, so the division rounds once
    return np.array([int(k) * numerator / denominator for k in step.ravel()]).reshape(step.shape)


def passes(x0: FloatArray, onset: FloatArray | float) -> BoolArray:
    """Whether displacements lie beyond an onset of slip, so that the tip slips.

    At the onset |tan α| = μ0, and the tip still sticks.

    Returns
    -------
    ndarray of bool
        True if the displacement exceeds the onset by more than `ONSET_ACCURACY`.
    """
    return np.asarray(x0 > onset + ONSET_ACCURACY)


def last_step_within(x0: FloatArray, dx0: Decimal) -> IntArray:
    """Largest number of steps Δx0 that do not pass the displacement `x0` (L).

    Raises
    ------
    ArgumentError
        If there are more steps than a double can count exactly.
    """
    x0 = np.asarray(x0, dtype=float)
    if np.any(x0 > EXACT_INTEGER * float(dx0)):
        raise ArgumentError(f"a step of {dx0} is too small for displacements up to {x0.max():g}")
    step = np.floor((x0 + ONSET_ACCURACY) / float(dx0)).astype(np.int64)
    # The quotient is rounded: 0.3/0.1 is just below 3. The comparison of positions corrects it.
    step += ~passes(step_position(step + 1, dx0), x0)
    step -= passes(step_position(step, dx0), x0)
    return step
