"""What a rod is to measure, with what, and what it must keep to."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibrissa.sensor.identification import Method
from vibrissa.status import Contact

# Second moment of area of a circle over the fourth power of its diameter.
INERTIA = np.pi / 64.0


@dataclass(frozen=True)
class Requirements:
    """What a rod is to measure, with what, and what it must keep to. SI units throughout.

    Attributes
    ----------
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which the material is elastic.
    mu0 : (float, float)
        Least and largest friction to be measured.
    step : float
        Step of the stage (m).
    noise : (float, float, float)
        Standard deviation of one reading of force_x, force_y (N) and moment_z (N·m), rounding
        included (`Transducer.deviation`).
    range : (float, float, float)
        Largest force_x, force_y and moment_z that the transducer measures; infinite if any.
    density : float, optional
        Of the material (kg/m³). Without it the weight is not looked at.
    method : Method
        What friction is read from, as in `identify`.
    contact : Contact
        ``point``: the rod may touch with its tip alone; ``line``: it may lie down on the surface.
    theta, eta : (float, float)
        Tapers and heights of the surface (L) among which to choose; equal where they are given.
    diameter, length : (float, float)
        Diameters at the clamp and lengths among which to choose (m).
    tip : float
        Least diameter of the tip (m).
    safety : float
        Factor by which the strain must stay below the yield strain.
    lock_factor : float
        Factor by which the locking friction must exceed the largest friction.
    steps : float
        Least number of steps of the stage in the shortest period of sticking.
    weight : float
        Largest weight of the rod, relative to the least normal force: the model has no gravity.
    spacing : float
        Largest travel from slip to slip (m), that is between two measurements.
    """

    modulus: float
    yield_strain: float
    mu0: tuple[float, float]
    step: float
    noise: tuple[float, float, float]
    range: tuple[float, float, float] = (np.inf, np.inf, np.inf)
    density: float | None = None
    method: Method = Method.FORCES
    contact: Contact = Contact.POINT
    theta: tuple[float, float] = (1.0, 10.0)
    eta: tuple[float, float] = (0.5, 0.98)
    diameter: tuple[float, float] = (1e-4, 1e-2)
    length: tuple[float, float] = (0.02, 0.2)
    tip: float = 1e-4
    safety: float = 1.5
    lock_factor: float = 1.1
    steps: float = 10.0
    weight: float = 0.1
    spacing: float = np.inf

    def __post_init__(self) -> None:
        """Refuse what no rod can be asked for."""
        object.__setattr__(self, "method", Method(self.method))
        object.__setattr__(self, "contact", Contact(self.contact))
        for name in ("yield_strain", "weight", "spacing"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)!r}")
        for name in ("modulus", "step", "steps"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)!r}")
        for name in ("safety", "lock_factor"):
            if not 1.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)!r}")
        if not 0.0 <= self.tip < np.inf:
            raise ValueError(f"tip must not be negative, got {self.tip!r}")
        if self.density is not None and not self.density > 0.0:
            raise ValueError(f"density must be positive, got {self.density!r}")
        bounds = {"mu0": (0.0, np.inf), "theta": (1.0, np.inf), "eta": (0.0, 1.0)}
        for name in ("mu0", "theta", "eta", "diameter", "length"):
            low, high = getattr(self, name)
            least, most = bounds.get(name, (0.0, np.inf))
            inside = low >= least if name == "theta" else low > least
            if not (inside and low <= high < most):
                raise ValueError(
                    f"{name} must be a range of increasing values "
                    f"{'from' if name == 'theta' else 'above'} {least:g} to below {most:g}, got "
                    f"{low:g} to {high:g}"
                )
        for name in ("noise", "range"):
            values = getattr(self, name)
            if len(values) != 3 or not all(value > 0.0 for value in values):
                raise ValueError(f"{name} must be three positive values, got {values}")
        if not max(self.noise) < np.inf:
            raise ValueError(f"noise must be finite, got {self.noise}")

    @property
    def given(self) -> bool:
        """Whether the whole rod is given, so that there is nothing to search."""
        chosen = (self.theta, self.eta, self.diameter, self.length)
        return all(low == high for low, high in chosen)


def without_units(**requirements: Any) -> Requirements:
    """Set requirements in units of the rod: lengths in L, forces in E·I0/L², moments in E·I0/L.

    Parameters
    ----------
    **requirements
        As in `Requirements`, with `yield_strain` in units of d0/L and without modulus, diameter,
        length and tip: d0 and L stay open, and only θ and η are sought.

    Returns
    -------
    Requirements
    """
    # The rod that is itself the unit: E·I0 = d0 = L = 1.
    unit = {"modulus": 1.0 / INERTIA, "diameter": (1.0, 1.0), "length": (1.0, 1.0), "tip": 0.0}
    return Requirements(**{"yield_strain": np.inf, **unit, **requirements})
