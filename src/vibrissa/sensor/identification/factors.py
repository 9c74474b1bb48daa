"""A factor by which loads or positions differ from those of the rod, and what is likely wrong."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.mixing import StateTable
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.transducer import CHANNELS

# Factors that are tried, from the inverse of the last one on.
TRIED_FACTORS = np.geomspace(1.0, 3000.0, 61)
# Number of blocks with which a factor is tried.
TRIED_BLOCKS = 200
# Largest misfit, as a part of the readings, with which loads fit the rod after a correction.
FITTING_MISFIT = 0.03
# Misfit of a tried factor from which on no factor between its neighbours fits: the misfit changes
# by at most 1 + misfit times the change of the factor's logarithm, which is 0.13.
HOPELESS_MISFIT = 0.2
# The correction must also make the misfit this many times smaller.
MISFIT_FALL = 5.0
# Largest logarithm of a factor that is taken as 1.
FACTOR_ONE = 0.15
# Largest difference of the logarithms of a factor and of a known factor that it may be.
KNOWN_FACTOR = 0.08
# Groups of channels that may have one wrong unit or gain.
ALL_LOADS = "all loads"
GROUPS = {
    ALL_LOADS: (0, 1, 2),
    "force_x and force_y": (0, 1),
    **{name: (number,) for number, name in enumerate(CHANNELS)},
}
# Common factors: loads or positions over those of the rod, and what may have this factor.
OF_ALL_LOADS = {16.0: "the stated diameter is a radius", 1.0 / 16.0: "the diameter is stated twice"}
OF_LOADS = {
    1000.0: "a unit is N instead of mN, or N*m instead of N*mm",
    1e-3: "a unit is mN instead of N, or N*mm instead of N*m",
    9.80665: "a unit is kgf instead of N",
    1.0 / 9.80665: "a unit is N instead of kgf, or mN instead of g",
    1.0 / 4.44822: "a unit is N instead of lbf",
    25.4: "a length in the unit is an inch instead of mm",
    1.0 / 25.4: "a length in the unit is mm instead of an inch",
}
OF_POSITIONS = {
    1000.0: "the unit of footpoint is m instead of mm, or mm instead of um",
    1e-3: "the unit of footpoint is mm instead of m, or um instead of mm",
    10.0: "the unit of footpoint is cm instead of mm",
    0.1: "the unit of footpoint is mm instead of cm",
    25.4: "the unit of footpoint is the inch instead of mm",
    1.0 / 25.4: "the unit of footpoint is mm instead of the inch",
}


@dataclass(frozen=True, kw_only=True)
class Factor:
    """A factor of a group of channels, and how well the readings fit the rod without it.

    Attributes
    ----------
    group : str
        Name in `GROUPS`.
    size : float
        Readings over the loads of the rod.
    misfit : float
        Median distance of the corrected readings from the states, as a part of the readings.
    """

    group: str
    size: float
    misfit: float

    def __str__(self) -> str:
        """Format the factor, and what may have this factor."""
        of_all = self.group == ALL_LOADS
        known = named(self.size, OF_LOADS | (OF_ALL_LOADS if of_all else {}))
        root = self.size**0.25
        other = f"check modulus and diameter ({root:.3g} times the diameter has this effect)"
        why = [f"perhaps {known}"] if known else []
        why += [other] if of_all else ["check its gain"]
        verb = "is" if self.group in CHANNELS else "are"
        return (
            f"{self.group} {verb} {_spelled(self.size)} times what this rod gives: {'; '.join(why)}"
        )


def named(size: float, known: dict[float, str]) -> str:
    """Return the text of the known factor that is nearest to `size`; empty if none is near."""
    near = min(known, key=lambda factor: abs(np.log(size / factor)))
    return known[near] if abs(np.log(size / near)) < KNOWN_FACTOR else ""


def _spelled(size: float) -> str:
    return f"{size:,.0f}" if size >= 1000.0 else f"{size:.3g}"


def likely_factor(task: Task, table: StateTable) -> str:
    """Say by which factor positions or loads differ from those of the rod; empty if by none.

    Parameters
    ----------
    table : StateTable
        States of the rod.
    """
    if travel := _travel(task, table):
        return travel
    places = np.linspace(0, len(task.blocks) - 1, TRIED_BLOCKS).astype(int)
    readings = task.blocks.readings[places]
    uncorrected = table.misfit(readings)
    best = min(_factors(task, table, readings), key=lambda factor: factor.misfit, default=None)
    allowed = min(FITTING_MISFIT, uncorrected / MISFIT_FALL)
    if best is None or best.misfit > allowed or abs(np.log(best.size)) < FACTOR_ONE:
        return ""
    return str(best)


def _factors(task: Task, table: StateTable, readings: FloatArray) -> Iterator[Factor]:
    """Fit a factor to each group of channels, if there are channels outside it, or several."""
    tried = np.log(np.concatenate([1.0 / TRIED_FACTORS[:0:-1], TRIED_FACTORS]))
    width = float(tried[1] - tried[0])
    for group, channels in GROUPS.items():
        if not set(channels) <= set(task.used) and group != ALL_LOADS:
            continue
        if len(task.used) == 1 or (group != ALL_LOADS and set(channels) == set(task.used)):
            continue
        inside = np.isin(np.arange(len(CHANNELS)), channels)

        def corrected(size: float, inside: BoolArray = inside) -> FloatArray:
            return readings * np.where(inside, np.exp(-size), 1.0)

        def misfit(size: float) -> float:
            return table.misfit(corrected(size))

        near = [
            size for size in tried.tolist() if table.least_misfit(corrected(size)) < HOPELESS_MISFIT
        ]
        if not near:
            continue
        start = min(near, key=misfit)
        best = minimize_scalar(misfit, bounds=(start - width, start + width), method="bounded")
        yield Factor(group=group, size=float(np.exp(best.x)), misfit=float(best.fun))


def _travel(task: Task, table: StateTable) -> str:
    """Compare the travel of the clamp in the periods with that of the states of the rod."""
    blocks = task.blocks
    if table.misfit(blocks.readings) > FITTING_MISFIT:
        return ""
    x0 = table.nearest(blocks.readings).x0
    count = np.bincount(blocks.period)
    clamp = blocks.clamp - (blocks.sums(blocks.clamp) / count)[blocks.period]
    x0 = x0 - (blocks.sums(x0) / count)[blocks.period]
    true = blocks.sums(clamp * x0) / np.maximum(blocks.sums(x0**2), np.finfo(float).tiny)
    factor = float(np.median(true[count > 1])) if (count > 1).any() else 1.0
    if not factor > 0.0 or abs(np.log(factor)) < FACTOR_ONE:
        return ""
    what = named(factor, OF_POSITIONS) or "the scale of footpoint or the length of the rod is wrong"
    return f"the clamp travels {_spelled(factor)} times as far as this rod allows: perhaps {what}"
