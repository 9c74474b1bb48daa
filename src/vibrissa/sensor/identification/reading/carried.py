"""Errors of the readings that a ratio of forces has: nothing is adjusted, all is carried on."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from vibrissa.errors import UnknownNameError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.identification.adjusting.properties import Bench, Component, components_of
from vibrissa.sensor.identification.reading.slope import NAME as SLOPE
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.quantities import Quantity, Units

# What changes the forces that are read, and so their ratio. A surface that is inclined against the
# transducer is a transducer that is turned.
BEARING = (
    "zero_force_x",
    "zero_force_y",
    "drift_force_x",
    "drift_force_y",
    "transducer_angle",
    "crosstalk",
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Carried:
    """Errors of the readings, each with a standard deviation.

    Attributes
    ----------
    bench : Bench
    components : tuple of Component
    sizes : ndarray, shape (k,)
        Their standard deviations.
    """

    bench: Bench
    components: tuple[Component, ...]
    sizes: FloatArray

    @classmethod
    def of(cls, tolerances: Mapping[str, float], bench: Bench) -> Self:
        """Take those tolerances that change the ratio of the forces."""
        components = tuple(
            one
            for name in BEARING
            if tolerances.get(name, 0.0) > 0.0
            for one in components_of(name, bench)
        )
        sizes = np.array([one.weight * tolerances[one.of] for one in components])
        return cls(bench=bench, components=components, sizes=sizes)

    def effects(self, forces: FloatArray, last: Recording) -> FloatArray:
        """Tell how the ratio of forces changes per unit of each error.

        Parameters
        ----------
        forces : ndarray, shape (p, 2)
            fx and fy at the onset that ends each period.
        last : Recording
            Last sample of each period: tells the moment there, and when that was. A moment that
            was not recorded is taken as that of full scale.

        Returns
        -------
        ndarray, shape (p, k)
        """
        moment = last.readings[:, 2]
        moment = np.where(np.isnan(moment), self.bench.full_scale[2], moment)
        readings = np.column_stack([forces, moment])
        at_onset = Recording(clamp=last.clamp, readings=readings, line=last.line)
        found = np.zeros((len(forces), len(self.components)))
        for number, one in enumerate(self.components):
            size = float(self.sizes[number])
            fx, fy, _ = one.property.recording(at_onset, size).readings.T
            found[:, number] = (fx / fy - forces[:, 0] / forces[:, 1]) / size
        return found


def bearing_tolerances(
    given: Mapping[str, Quantity], units: Units, noise: FloatArray, assume: bool
) -> dict[str, float]:
    """Put together the tolerances that change the ratio of the forces, without a rod.

    Parameters
    ----------
    given : mapping of str to str or number
        Such as ``{"zero_force_x": "2 mN", "transducer_angle": "0.5 deg"}``, or ``"exact"``.
    units : Units
    noise : ndarray, shape (3,)
        Standard deviation of one reading; NaN where it is not known.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.

    Returns
    -------
    dict of str to float
        In units of the rod, rad, or relative; 0 where something is exact.

    Raises
    ------
    ArgumentError
        If one that is given does not change the ratio, is no such quantity, or negative.
    """
    for name in given:
        if name not in (*BEARING, SLOPE):
            raise UnknownNameError(
                f"the method ratio uses no rod: a tolerance is of one of "
                f"{', '.join((*BEARING, SLOPE))}, "
                f"got {name!r}"
            )
    assumed = assumed_tolerances(units, noise) if assume else {}
    return assumed | read_tolerances(units, given)
