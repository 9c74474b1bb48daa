"""What a rod is to measure, with what, and the limits it must keep to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind, Quantity, chosen
from vibrissa.sticking.api import MOST_TAPER

# The least and the largest value; equal for a value that is given.
Range = tuple[float, float]
# A value each for force_x, force_y and moment_z.
Channels = tuple[float, float, float]

# Values of μ0 in its range at which the standard deviation is computed.
FRICTIONS = 9


@dataclass(frozen=True, kw_only=True)
class Requirements:
    """What a rod is to measure, with what, and the limits it must keep to; in SI units.

    Attributes
    ----------
    modulus : float or None
        Young's modulus (Pa). None: everything is in units of the rod (see `nondimensional`).
    yield_strain : float
        Strain up to which the material is elastic.
    mu0 : (float, float)
        Range of the friction coefficients to be measured.
    step : float
        Step of the stage (m).
    noise : (float, float, float)
        Standard deviation of one reading of force_x, force_y (N) and moment_z (N·m), rounding
        included (`Transducer.deviation`).
    range : (float, float, float)
        Largest force_x, force_y and moment_z that the transducer measures.
    density : float, optional
        Of the material (kg/m³). Without it the weight is not limited.
    contact : Contact
        ``point``: the rod touches with its tip alone; ``line``: it may lie flat on the surface.
    theta, eta : (float, float)
        Ranges of the taper and of the height of the surface (L).
    diameter, length : (float, float)
        Ranges of the diameter at the clamp and of the length (m).
    tip : float
        Least diameter of the tip (m).
    safety : float
        Least ratio of the yield strain to the largest strain.
    lock_factor : float
        Least ratio of the critical friction coefficient μ_lock to the largest μ0.
    steps : float
        Least number of steps of the stage in the shortest period of sticking.
    weight : float
        Largest ratio of the weight to the normal force: the model has no gravity.
    spacing : float
        Largest clamp travel between slips (m): the distance between two measurements.
    stock : tuple of float
        Diameters of which one is taken at the clamp (m); any, if there are none.
    tolerances : mapping of str to str or number
        Standard deviations that were stated, as `read_tolerances` reads them of the rod.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.
    carried : mapping of str to str or number
        Further keys of a rod file, which that of the result has, too (`Design.rod_file`): the names
        of material and transducer, and what no design asks for.
    wished : dict of Kind to str
        Units in which results are told; lengths are in millimetres.
    room : dict
        Factors by which limits are relaxed, by name; infinite for a limit that is left out.

    Raises
    ------
    ArgumentError
        If a value is out of range.
    """

    modulus: float | None
    yield_strain: float
    mu0: Range
    step: float
    noise: Channels
    range: Channels = (np.inf, np.inf, np.inf)
    density: float | None = None
    contact: Contact = Contact.POINT
    theta: Range = (1.0, 10.0)
    eta: Range = (0.5, 0.98)
    diameter: Range = (1e-4, 1e-2)
    length: Range = (0.02, 0.2)
    tip: float = 1e-4
    safety: float = 1.5
    lock_factor: float = 1.1
    steps: float = 10.0
    weight: float = 0.1
    spacing: float = np.inf
    stock: tuple[float, ...] = ()
    tolerances: Mapping[str, Quantity] = field(default_factory=dict)
    assume: bool = True
    carried: Mapping[str, Quantity] = field(default_factory=dict, compare=False)
    wished: Mapping[Kind, str] = field(default_factory=dict)
    room: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what no rod can be asked for."""
        object.__setattr__(self, "contact", chosen(Contact, self.contact, "contact"))
        for name in ("yield_strain", "weight", "spacing"):
            self._require(name, getattr(self, name) > 0.0, "be positive")
        for name in ("step", "steps"):
            self._require(name, 0.0 < getattr(self, name) < np.inf, "be positive and finite")
        for name in ("modulus", "density"):
            value = getattr(self, name)
            self._require(name, value is None or 0.0 < value < np.inf, "be positive and finite")
        unit = self.diameter == self.length == (1.0, 1.0)
        self._require("modulus", self.modulus is not None or unit, "be given with a size")
        for name in ("safety", "lock_factor"):
            self._require(name, 1.0 <= getattr(self, name) < np.inf, "be at least 1 and finite")
        self._require("tip", 0.0 <= self.tip < np.inf, "not be negative, and be finite")
        for name in ("noise", "range"):
            values = getattr(self, name)
            positive = len(values) == len(CHANNEL_KINDS) and all(value > 0.0 for value in values)
            self._require(name, positive, "be three positive values")
        self._require("noise", max(self.noise) < np.inf, "be finite")
        single = self.diameter[0] == self.diameter[1]
        self._require("stock", not (self.stock and single), "not be given with a diameter")
        tapers = self.theta[0] >= 1.0 and self.theta[1] <= MOST_TAPER
        self._require_range("theta", tapers, f"lie between 1 and {MOST_TAPER:g}")
        self._require_range("eta", self.eta[0] > 0.0 and self.eta[1] < 1.0, "lie between 0 and 1")
        for name in ("mu0", "diameter", "length"):
            self._require_range(name, getattr(self, name)[0] > 0.0, "lie above 0")

    def _require(self, name: str, holds: bool, what: str) -> None:
        if not holds:
            raise ArgumentError(f"{name} must {what}, got {getattr(self, name)!r}")

    def _require_range(self, name: str, within: bool, what: str) -> None:
        low, high = getattr(self, name)
        given = f"{low:g}" if low == high else f"{low:g} to {high:g}"
        unit = " m" if name in ("diameter", "length") else ""
        if not (within and low <= high < np.inf):
            raise ArgumentError(f"{name} must {what}, from low to high, got {given}{unit}")

    @classmethod
    def nondimensional(cls, **requirements: Any) -> "Requirements":
        """Set requirements in units of the rod: lengths in L, forces in E·I0/L², moments in E·I0/L.

        Parameters
        ----------
        **requirements
            As above, with `yield_strain` in units of d0/L, and without modulus, density, diameter,
            length and tip: d0 and L stay open, and only θ and η are chosen.

        Returns
        -------
        Requirements
        """
        unit = (1.0, 1.0)
        others = {"yield_strain": np.inf, **requirements}
        return cls(modulus=None, diameter=unit, length=unit, tip=0.0, **others)

    @property
    def rigidity(self) -> float:
        """Bending stiffness at the clamp over the fourth power of the diameter, E·I0/d0⁴ (Pa)."""
        return 1.0 if self.modulus is None else np.pi / 64.0 * self.modulus

    @property
    def frictions(self) -> FloatArray:
        """Values of μ0, of the whole range, at which the standard deviation is computed."""
        return np.linspace(*self.mu0, FRICTIONS)

    @property
    def given(self) -> bool:
        """Whether the whole rod is given, so that it is only checked."""
        return all(low == high for low, high in (self.theta, self.eta, self.diameter, self.length))
