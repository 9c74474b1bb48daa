"""A design as text."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.sensor.quantities import Kind

if TYPE_CHECKING:
    from vibrissa.design.result import Design

# What is relaxed, in words; otherwise it is the limit of that name.
RELAXED = {"noise": "half the noise", "step": "half the step", "lock": "no margin to self-locking"}


def lines(found: "Design") -> Iterator[str]:
    """Say what was found: the rod, its standard deviations, its limits and what would help."""

    def shown(value: float, kind: Kind, digits: int = 4) -> str:
        told, unit = found.units.told(value, kind)
        return f"{told:.{digits}g} {unit}".removesuffix(" 1")

    yield found.message
    yield f"theta        {found.theta:.4g}{', a cylinder will do' if found.is_cylinder else ''}"
    if found.rod is None:
        yield f"eta          {found.eta:.4g} L"
    else:
        yield f"base         {shown(found.diameter, Kind.LENGTH)} diameter{_of_stock(found)}"
        yield f"tip          {shown(found.diameter / found.theta, Kind.LENGTH)} diameter"
        yield f"length       {shown(found.length, Kind.LENGTH)}"
        height = shown(found.eta * found.length, Kind.LENGTH)
        yield f"height       {height} from the clamp to the surface (eta {found.eta:.4g})"
    yield f"mu_lock      {found.mu_lock:.4g}"
    yield "\nstandard deviation of mu0 from one period of sticking"
    yield "mu0          total     by step   by noise  clamp travel"
    deviations = found.deviations
    parts = deviations.total, deviations.by_step, deviations.by_reading
    rows = list(zip(found.mu0, found.x0_slip, *parts, strict=True))
    # Of a single friction all rows are the same.
    for mu0, travel, *values in rows[:1] if found.mu0[0] == found.mu0[-1] else rows:
        cells = [*(f"{value:.2g}" for value in values), shown(travel, Kind.LENGTH, 3)]
        row = "".join(f"{cell:<10}" for cell in cells).rstrip()
        yield f"{mu0:<12.4g} {'the tip locks' if np.isnan(travel) else row}"
    yield "\nlimit        value         bound           used"
    for check in sorted(found.checks, key=lambda check: -check.use):
        value, bound = shown(check.value, check.kind, 3), shown(check.bound, check.kind, 3)
        used = f"{check.use:.1%}" if check.use < 2.0 else f"{check.use:.3g} times"
        yield f"{check.name:<12} {value:<13} {'<' if check.upper else '>'} {bound:<13} {used}"
    if found.relaxed:
        yield "\nlargest standard deviation with"
    for name, deviation in found.relaxed.items():
        yield f"{deviation:<12.2g} {RELAXED.get(name, f'twice the room at the limit {name}')}"


def _of_stock(found: "Design") -> str:
    """Say what it costs that the diameter is of a stock."""
    best = found.any_size
    if best is None:
        return ""
    size, unit = found.units.told(best.diameter, Kind.LENGTH)
    more = 1.0 - best.deviation / found.deviation
    return f", of the stock; the best is {size:.4g} {unit}, whose deviation is {more:.1%} less"
