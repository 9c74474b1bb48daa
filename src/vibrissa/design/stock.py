"""Diameters in which rods and wires are sold."""

from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import Kind, in_si

# Preferred numbers of ISO 3, series R20, in which many wires are made, from 1 to 10.
R20 = (
    *(1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8),
    *(3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1, 8.0, 9.0),
)
SERIES = {"r20": R20, "r10": R20[::2]}
# So many diameters on each side of the best one are tried.
NEIGHBOURS = 2


def read_stock(text: str) -> tuple[float, ...]:
    """Read diameters (m): ``"0.5 mm, 0.8 mm"``, or a series of ISO 3 from 0.1 to 10 mm, ``"R20"``.

    Raises
    ------
    ArgumentError
        If it is neither.
    """
    series = SERIES.get(text.strip().lower())
    if series is not None:
        return tuple(sorted(round(x * 10.0**k, 12) for k in (-4, -3) for x in series))
    sizes = sorted({float(in_si(part, Kind.LENGTH, "stock")) for part in text.split(",")})
    if not sizes[0] > 0.0:
        raise ArgumentError(f"stock must be diameters above 0, or R10 or R20, got {text!r}")
    return tuple(sizes)


def near(stock: tuple[float, ...], diameter: float) -> tuple[float, ...]:
    """Diameters of a stock next to the best one, on both sides of it."""
    below = [size for size in stock if size <= diameter]
    above = [size for size in stock if size > diameter]
    return (*below[-NEIGHBOURS:], *above[:NEIGHBOURS])
