"""A real rod from measured diameters and moduli: taper, stiffness and the errors of their fit."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.limits import MOST_POWERS, check_stiffening
from vibrissa.mechanics.fitting import fitted_stiffness
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities import series
from vibrissa.quantities.units import SI_UNITS, Kind

if TYPE_CHECKING:
    from pandas import DataFrame

COLUMNS = {"position": Kind.LENGTH, "diameter": Kind.LENGTH, "modulus": Kind.STRESS}
# Largest relative difference of a diameter from those of a cone, by default.
TOLERANCE = 0.02
# Number of coefficients of the stiffness, by default.
DEGREE = 2


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredRod:
    """A measured rod and the rod of the model that is fitted to it.

    Attributes
    ----------
    source : str
        Name of the table.
    position, diameter, young : ndarray, shape (n,)
        Measured distances from the clamp (m), diameters (m) and Young's moduli (Pa).
    theta, base, modulus : float
        Taper factor, diameter (m) and modulus (Pa) at the clamp, of the fit.
    stiffening : tuple of float
        Coefficients of s, s², … in the stiffness over that of a cone of one material.
    tolerance : float
        Largest allowed relative difference between the diameters and those of the cone.
    """

    source: str
    position: FloatArray
    diameter: FloatArray
    young: FloatArray
    theta: float
    base: float
    modulus: float
    stiffening: tuple[float, ...]
    tolerance: float

    @property
    def length(self) -> float:
        """Length from the first to the last row (m)."""
        return float(self.position[-1])

    def cone(self, s: FloatArray) -> FloatArray:
        """Diameters of the fitted cone at arc lengths (L), in m."""
        return np.asarray(self.base * (1.0 - (1.0 - 1.0 / self.theta) * s))

    def stiffness(self, s: FloatArray) -> FloatArray:
        """Bending stiffness of the fitted rod at arc lengths (L), in N·m²."""
        factor = np.polynomial.Polynomial([1.0, *self.stiffening])(s)
        return np.asarray(np.pi / 64.0 * self.modulus * self.cone(s) ** 4 * factor)

    @property
    def measured_stiffness(self) -> FloatArray:
        """Bending stiffness of the measured rod (N·m²)."""
        return np.asarray(np.pi / 64.0 * self.young * self.diameter**4)

    @property
    def cone_errors(self) -> FloatArray:
        """Relative differences of the measured diameters from those of the cone."""
        return np.asarray(self.diameter / self.cone(self.position / self.length) - 1.0)

    @property
    def stiffness_errors(self) -> FloatArray:
        """Relative differences of the fitted stiffness from the measured one."""
        fitted = self.stiffness(self.position / self.length)
        return np.asarray(fitted / self.measured_stiffness - 1.0)

    @property
    def is_cone(self) -> bool:
        """Whether all diameters are those of the cone within the tolerance."""
        return bool(np.abs(self.cone_errors).max() <= self.tolerance)

    def keys(self) -> dict[str, Any]:
        """Return the keys of a set-up file."""
        return {
            "theta": float(f"{self.theta:.6g}"),
            "modulus": f"{1e-9 * self.modulus:.6g} GPa",
            "diameter": f"{1e3 * self.base:.6g} mm",
            "length": f"{1e3 * self.length:.6g} mm",
            "stiffening": [float(f"{power:.6g}") for power in self.stiffening],
        }

    def report(self) -> Iterator[str]:
        """Make lines about the fit."""
        keys = self.keys()
        powers = ", ".join(f"{power:g}" for power in keys.pop("stiffening"))
        yield ", ".join(f"{name} {value}" for name, value in keys.items())
        yield f"stiffening {powers}"
        worst = self._worst(self.stiffness_errors)
        yield f"the stiffness differs from the measured one by up to {worst}"
        if np.abs(self.stiffness_errors).max() > 4.0 * self.tolerance:
            yield "this is much: choose a larger degree; steps cannot be followed by any degree"
        worst = self._worst(self.cone_errors)
        if self.is_cone:
            yield f"the diameter differs from that of a cone by up to {worst}"
        else:
            yield (
                f"this rod is no cone within {self.tolerance:.3g}: its diameter differs from that "
                f"of a cone by up to {worst}. The stiffness has the measured diameters; strains, "
                "stresses and the mass are those of the cone"
            )

    def _worst(self, errors: FloatArray) -> str:
        row = int(np.abs(errors).argmax())
        return f"{abs(errors[row]):.2%}, {1e3 * self.position[row]:.4g} mm from the clamp"


def measured_rod(
    readings: "Path | DataFrame", degree: int = DEGREE, tolerance: float = TOLERANCE
) -> MeasuredRod:
    """Fit a rod of the model to measured diameters and moduli.

    Parameters
    ----------
    readings : Path or DataFrame
        A table as `vibrissa.quantities.series.read` reads it, with the columns ``position``,
        ``diameter`` and ``modulus``, each with its unit; the first row is at the clamp, the last at
        the tip.
    degree : int
        Number of coefficients of the stiffness along the rod.
    tolerance : float
        Largest relative difference between the diameters and those of a cone.

    Raises
    ------
    RecordingError
        If the table cannot be read.
    ArgumentError
        If a column has no unit, positions do not increase, a value is not positive, there are too
        few rows, the rod is thicker at its tip, or no positive stiffness fits.
    """
    if not 1 <= degree <= MOST_POWERS:
        raise ArgumentError(f"degree must lie between 1 and {MOST_POWERS}, got {degree}")
    table = series.read(readings, [*COLUMNS])
    position, diameter, young = (
        table.columns[name] * _factor(table, name, kind) for name, kind in COLUMNS.items()
    )
    if len(position) < degree + 2:
        raise ArgumentError(
            f"{table.source}: a fit with {degree} coefficients needs {degree + 2} rows, got "
            f"{len(position)}; add rows, or choose a smaller degree"
        )
    if not (np.diff(position) > 0.0).all():
        row = int(table.line[1:][~(np.diff(position) > 0.0)][0])
        raise ArgumentError(f"{table.source}: position must increase from clamp to tip; row {row}")
    for name, values in (("diameter", diameter), ("modulus", young)):
        if not (values > 0.0).all():
            row = int(table.line[~(values > 0.0)][0])
            raise ArgumentError(f"{table.source}: {name} must be positive; row {row}")
    position = position - position[0]
    s = position / position[-1]
    # The straight line for which the squares of the relative differences are least.
    rows = np.stack([1.0 / diameter, s / diameter], axis=1)
    (base, slope), *_ = np.linalg.lstsq(rows, np.ones(len(s)), rcond=None)
    tip = base + slope
    if not base / MOST_TAPER <= tip <= base * (1.0 + tolerance):
        raise ArgumentError(
            f"{table.source}: the cone that fits best is {1e3 * base:.4g} mm thick at the clamp "
            f"and {1e3 * tip:.4g} mm at the tip; allowed: a taper from 1 to {MOST_TAPER:g}"
        )
    theta = max(1.0, float(base / tip))
    cone = 1.0 - (1.0 - 1.0 / theta) * s
    modulus, powers = fitted_stiffness(s, young * (diameter / (base * cone)) ** 4, degree)
    check_stiffening(powers)
    return MeasuredRod(
        source=table.source,
        position=position,
        diameter=diameter,
        young=young,
        theta=theta,
        base=float(base),
        modulus=modulus,
        stiffening=powers,
        tolerance=tolerance,
    )


def _factor(table: series.Table, name: str, kind: Kind) -> float:
    what = f"{table.source}: {name}"
    if name not in table.units:
        raise ArgumentError(f"{what} has no unit; write it in the title: '{name} [{kind.si}]'")
    return SI_UNITS.column_factor(table.units[name], kind, what)
