"""Candidate rods: diameters as sold, lengths and tapers as made, heights as mounted."""

from collections.abc import Callable

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import Kind, is_number, range_of

Choice = tuple[float, ...]

# Tapers to which a rod as it is sold, the first, is turned, ground or printed.
TAPERS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
# Diameters in which wire and rods are sold (m).
DIAMETERS = tuple(
    1e-3 * mm
    for mm in (
        *(0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9),
        *(1.0, 1.2, 1.5, 1.8, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0),
    )
)
# Lengths to which a rod is cut (m).
LENGTHS = tuple(1e-3 * mm for mm in range(20, 210, 10))
# How many heights of a range are tried.
MOST_HEIGHTS = 15


def choices_of(text: str, read: Callable[[str], float], sold: Choice = ()) -> Choice:
    """Read a value, a list, or a range: its ends and the sizes that are sold between them.

    Examples
    --------
    >>> choices_of("1 to 2.5", float, TAPERS)
    (1.0, 1.5, 2.0, 2.5)
    """
    if "," in text:
        return tuple(sorted({read(part.strip()) for part in text.split(",")}))
    low, high = (read(end) for end in range_of(text))
    if low > high:
        raise ArgumentError(f"a range must go from low to high, got {text!r}")
    return tuple(sorted({low, *(value for value in sold if low < value < high), high}))


def heights_of(text: str, lengths: Choice) -> Choice:
    """Read heights in units of the length, or with a unit where the rod has a single length."""

    def read(part: str) -> float:
        if is_number(part):
            return Kind.NUMBER.read(part, "eta")
        if len(lengths) != 1:
            raise ArgumentError(
                f"eta = {part!r} has a unit, but several lengths are allowed: give it in units "
                "of the length"
            )
        return Kind.LENGTH.read(part, "eta") / lengths[0]

    found = choices_of(text, read)
    return found if "," in text else _between(found[0], found[-1])


def _between(low: float, high: float) -> Choice:
    """Heights that come the closer together, the closer they are to that of an upright rod."""
    if not 0.0 < low < high < 1.0:
        return tuple(sorted({low, high}))
    between = np.round(1.0 - np.geomspace(1.0 - low, 1.0 - high, MOST_HEIGHTS), 3)[1:-1]
    return tuple(np.unique([low, *between, high]).tolist())


HEIGHTS = _between(0.5, 0.98)
