"""Conversion of dimensionless numbers to SI units for a real rod."""

import math
from dataclasses import dataclass

from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore


@dataclass(frozen=True)
class Rod:
    """A real rod, which sets the units of length, force and moment.

    Attributes
    ----------
    youngs_modulus : float
        Young's modulus E, in Pa; that at the clamp, if it changes along the rod.
    base_diameter : float
        Diameter d0 at the clamp, in m.
    length : float
        Length L, in m.
    bore : float
        Diameter of a bore, in units of d0.

    Raises
    ------
    ArgumentError
        If the bore is not between 0 and 1, or if another property is not between 1e-30 and 1e30.

    Examples
    --------
    The force f = 10.86 on the paper's steel rod, in N:

    >>> rod = Rod(youngs_modulus=2.10e11, base_diameter=5e-3, length=0.1)
    >>> round(10.86 * rod.force_unit)
    6997
    """

    youngs_modulus: float
    base_diameter: float
    length: float
    bore: float = 0.0

    def __post_init__(self) -> None:
        """Check all values."""
        check_bore(self.bore, 1.0)
        for name, value, unit in (
            ("modulus", self.youngs_modulus, "Pa"),
            ("diameter", self.base_diameter, "m"),
            ("length", self.length, "m"),
        ):
            # Within these bounds the units of force and moment do not overflow.
            if not 1e-30 < value < 1e30:
                raise ArgumentError(
                    f"the {name} of a rod must lie between 1e-30 and 1e30 {unit}, got {value:g}"
                )

    @property
    def second_moment(self) -> float:
        """Second moment of area at the base, I0 = π·d0⁴·(1 − b⁴)/64 with the bore b, in m⁴."""
        return math.pi * self.base_diameter**4 / 64.0 * (1.0 - self.bore**4)

    @property
    def length_unit(self) -> float:
        """Unit of length, L, in m."""
        return self.length

    def frequency_unit(self, density: float) -> float:
        """Frequency in Hz of a rod of this density (kg/m³) whose natural frequency ω is 1.

        It is √(E·I0/(ρA0·L⁴))/(2π), with I0/A0 = d0²·(1 + b²)/16 for the bore b.

        Raises
        ------
        ArgumentError
            If the density is not between 1e-30 and 1e30 kg/m³.
        """
        if not 1e-30 < density < 1e30:
            raise ArgumentError(
                f"the density of a rod must lie between 1e-30 and 1e30 kg/m³, got {density:g}"
            )
        speed = math.sqrt(self.youngs_modulus / density) * math.sqrt(1.0 + self.bore**2)
        return speed * self.base_diameter / (8.0 * math.pi * self.length**2)

    @property
    def force_unit(self) -> float:
        """Unit of force, E·I0/L², in N."""
        return self.youngs_modulus * self.second_moment / self.length**2

    @property
    def moment_unit(self) -> float:
        """Unit of moment, E·I0/L, in N·m."""
        return self.youngs_modulus * self.second_moment / self.length
