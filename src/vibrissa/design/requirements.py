"""Requirements on a rod: range of friction, stage, transducer, sizes to choose from, constraints.

Each requirement is a field of `Requirements` and an option of the command line.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from vibrissa.design.materials import Material, stated_material
from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.keys import Keyed, NotNegative, Positive, read_keys, with_options
from vibrissa.quantities.units import Kind, Measured, channels_in_si, is_number, range_of
from vibrissa.sensor.setup import MOUNTING, TOLERANCES, Setup
from vibrissa.sensor.tolerances import EXACT
from vibrissa.sensor.transducer import preset

Choice = tuple[float, ...]

# Values in a range. Tapers: 1 is a rod as it is sold; the others are turned, ground or printed.
# Diameters in which wire and rods are sold, and lengths to which a rod is cut (m).
SOLD_DIAMETERS = """
    0.02 0.03 0.04 0.05 0.06 0.07 0.08 0.09
    0.1 0.15 0.2 0.25 0.3 0.35 0.4 0.5 0.6 0.7 0.8 0.9
    1 1.2 1.5 1.8 2 2.5 3 4 5 6 8 10
    12 15 18 20 25 30 40 50 60 80 100
"""  # mm
SOLD = {
    "theta": (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 15.0, 20.0, 30.0, 50.0),
    "diameter": tuple(float(mm) / 1e3 for mm in SOLD_DIAMETERS.split()),
    "length": tuple(mm / 1e3 for mm in range(10, 2010, 10)),
}
# Number of heights that are tried in a range.
MOST_HEIGHTS = 15


def choices_of(text: str, read: Callable[[str], float], sold: Choice = ()) -> Choice:
    """Read a value, a list, or a range, which stands for its ends and the sizes sold in between.

    Examples
    --------
    >>> choices_of("1 to 2.5", float, SOLD["theta"])
    (1.0, 1.5, 2.0, 2.5)
    """
    if "," in text:
        return tuple(sorted({read(part.strip()) for part in text.split(",")}))
    low, high = (read(end) for end in range_of(text))
    if low > high:
        raise ArgumentError(f"a range must go from low to high, got {text!r}")
    return tuple(sorted({low, *(value for value in sold if low < value < high), high}))


def heights_of(text: str, lengths: Choice) -> Choice:
    """Read heights in units of the length; a height in mm needs a single length of the rod."""

    def read(part: str) -> float:
        if is_number(part):
            return Kind.NUMBER.read(part, "eta")
        if len(lengths) != 1:
            raise ArgumentError(
                f"eta = {part!r} has a unit, which needs a single length of the rod: give one "
                "length, or give eta as a part of the length, such as 0.85"
            )
        return Kind.LENGTH.read(part, "eta") / lengths[0]

    heights = choices_of(text, read)
    return heights if "," in text else _between(heights[0], heights[-1])


def _between(low: float, high: float) -> Choice:
    """Heights from `low` to `high` (L), spaced more closely near 1, the upright rod."""
    if not 0.0 < low < high < 1.0:
        return tuple(sorted({low, high}))
    between = np.round(1.0 - np.geomspace(1.0 - low, 1.0 - high, MOST_HEIGHTS), 3)
    return tuple(np.unique([low, *between[(between > low) & (between < high)], high]).tolist())


def _default(name: str, low: float, high: float) -> Choice:
    return tuple(value for value in SOLD[name] if low <= value <= high)


HEIGHTS = _between(0.5, 0.98)
TAPERS = _default("theta", 1.0, 10.0)
DIAMETERS = _default("diameter", 1e-4, 0.01)
LENGTHS = _default("length", 0.02, 0.2)
# Number of values of μ0 in its range at which the uncertainty is computed.
FRICTIONS = 5
# Quantities that the design chooses.
SIZES = ("theta", "eta", "diameter", "length")

Factor = Annotated[float, Field(ge=1.0), Kind.NUMBER]
Part = Annotated[float, Field(gt=0.0, lt=1.0)]
Taper = Annotated[float, Field(ge=1.0, le=MOST_TAPER)]


class Requirements(Keyed):
    """Requirements on a rod, made by `read`.

    `theta`, `eta` (L), `diameter` and `length` (m) hold the values to choose from. `mu0` holds the
    ends of its range.
    """

    mu0: Annotated[tuple[Positive, ...], Kind.NUMBER]
    """Friction coefficients to be measured: '0.2 to 0.4'."""
    step: Annotated[Positive, Kind.LENGTH]
    """Step of the stage: '20 um'."""
    theta: Annotated[tuple[Taper, ...], Kind.NUMBER] = TAPERS
    """Taper, base over tip: a value, a list or a range; by default from 1 to 10."""
    length: Annotated[tuple[Positive, ...], Kind.LENGTH] = LENGTHS
    """Length of the rod: a value, a list or a range; by default from 20 to 200 mm."""
    eta: Annotated[tuple[Part, ...], Kind.NUMBER] = HEIGHTS
    """Height in units of the length, or '85 mm': a value, a list or a range; by default from 0.5
    to 0.98."""
    diameter: Annotated[tuple[Positive, ...], Kind.LENGTH] = DIAMETERS
    """Diameter at the clamp: a value, a list or a range; by default the sizes sold, from
    0.1 to 10 mm."""
    tip: Annotated[NotNegative, Kind.LENGTH] = 1e-4
    """Least diameter of the tip; by default 0.1 mm."""
    safety: Factor = 1.5
    """Least ratio of yield strain to largest strain."""
    steps: Annotated[Positive, Kind.NUMBER] = 10.0
    """Least number of steps in a period of sticking."""
    load: Annotated[Part, Kind.NUMBER] = 0.8
    """Largest part of the transducer's range that the loads may use."""
    speed: Annotated[Positive | None, Kind.SPEED] = None
    """Speed of the clamp: '1 mm/s'. The rod must be at rest before it slips again."""
    spacing: Annotated[Positive, Kind.LENGTH] = np.inf
    """Largest clamp travel between two measurements: '5 mm'."""
    setup: Setup

    @classmethod
    def read(cls, path: Path | str | None = None, **asked: Any) -> Self:
        """Read requirements from arguments and a set-up file; an argument overrides the file.

        Parameters
        ----------
        **asked
            Fields of `Requirements` and of `Setup`; None means the default. Quantities are text
            with a unit. ``theta``, ``eta``, ``diameter`` and ``length`` are each a value, a list
            (``"0.8 mm, 1 mm"``) or a range (``"20 to 100 mm"``) of sizes to choose from.

        Raises
        ------
        ArgumentError
            With a line for each value that is missing or not allowed.
        """
        stated = {} if path is None else read_keys(path)
        keys = with_options(stated, asked, Setup.either)
        own = {name: keys.pop(name) for name in cls.model_fields if name in keys}
        for name in SIZES:
            if isinstance(own.get(name), str):
                own[name], tolerance = Measured.read(own[name])
                others = keys.get(TOLERANCES) or {}
                if tolerance is not None and isinstance(others, Mapping):
                    keys[TOLERANCES] = {name: tolerance} | dict(others)
        own["setup"] = Setup.validated(keys, path, stated)
        return cls.validated(own, path, stated)

    @field_validator("mu0", *SIZES, mode="before")
    @classmethod
    def _read_choices(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        if not isinstance(value, str):
            return value
        if name == "eta":
            # A wrong length has its own message.
            return heights_of(value, info.data["length"]) if "length" in info.data else HEIGHTS
        kind = cls.kinds()[name]
        return choices_of(value, lambda text: kind.read(text, name), SOLD.get(name, ()))

    @model_validator(mode="after")
    def _check_setup(self) -> Self:
        """Refuse a set-up for which no rod can be designed, before the search."""
        if self.setup.transducer is None and self.setup.noise is None:
            raise ArgumentError("neither transducer nor noise is given: give one of them")
        if min(self.noise) <= 0.0:
            source = self.setup.noise or f"the transducer {self.setup.transducer}"
            raise ArgumentError(f"noise must be positive in all channels, got that of {source}")
        if self.setup.tolerances.get("tip_radius", EXACT) != EXACT:
            raise ArgumentError(
                "a rod is designed with a sharp tip: leave out the tolerance of tip_radius"
            )
        if self.speed is not None and self.material.density is None:
            raise ArgumentError("with a speed, give the density of the material")
        deviations = [name for name in MOUNTING if name != "bore"]
        if replace(self.mounting, stiffening=0.0, bore=0.0) != IDEAL:
            raise ArgumentError(
                "a design needs a straight rod, a rigid upright clamp and a level stage: leave out "
                f"{', '.join(deviations)}; their tolerances may stay, in the table [{TOLERANCES}]"
            )
        return self

    @cached_property
    def mounting(self) -> Mounting:
        """Stiffness of all rods to choose from; clamp and stage are ideal."""
        first = self.rod_setup(self.theta[0], self.eta[0], self.diameter[0], self.length[0])
        return first.whisker.mounting

    @property
    def tapers(self) -> tuple[float, ...]:
        """Tapers to choose from whose tip is thicker than the bore.

        Raises
        ------
        ArgumentError
            If there is none.
        """
        bore = self.mounting.bore
        tapers = tuple(theta for theta in self.theta if bore * theta < 1.0)
        if not tapers:
            check_bore(bore, min(self.theta))
        return tapers

    @cached_property
    def material(self) -> Material:
        """Material of the rod.

        Raises
        ------
        ArgumentError
            If no material is given.
        """
        material = stated_material(self.setup)
        if material is None:
            missing = "yield_strain" if self.setup.modulus is not None else "modulus"
            raise ArgumentError(f"give the material or {missing}")
        return material

    @cached_property
    def noise(self) -> FloatArray:
        """Standard deviation of the noise in one reading of force_x, force_y and moment_z (SI)."""
        if self.setup.noise is None:
            return preset(str(self.setup.transducer)).deviation
        return np.array(channels_in_si(self.setup.noise, "noise"))

    @property
    def largest(self) -> FloatArray:
        """Range of the transducer in each channel (SI); infinite if no transducer is given."""
        named = self.setup.transducer
        return np.full(3, np.inf) if named is None else np.array(preset(named).limit)

    @property
    def frictions(self) -> FloatArray:
        """Values of μ0 over its range at which the uncertainty is computed."""
        return np.unique(np.linspace(self.mu0[0], self.mu0[-1], FRICTIONS))

    @property
    def given(self) -> bool:
        """True if theta, eta, diameter and length have one value each: then nothing is searched."""
        return all(len(getattr(self, name)) == 1 for name in SIZES)

    def rod_setup(self, theta: float, eta: float, diameter: float, length: float) -> Setup:
        """Return the set-up with the sizes of one rod; `diameter` and `length` are in m."""
        stated = self.setup.modulus
        modulus = Measured(f"{1e-9 * self.material.modulus:.10g} GPa", stated and stated.tolerance)
        return self.setup.model_copy(
            update={
                "theta": Measured(theta),
                "eta": Measured(eta),
                "modulus": modulus,
                "diameter": Measured(f"{1e3 * diameter:.10g} mm"),
                "length": Measured(f"{1e3 * length:.10g} mm"),
            }
        )
