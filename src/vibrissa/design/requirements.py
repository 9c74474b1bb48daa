"""What a rod is to measure, with what, and the constraints it must meet.

Quantities are text with a unit, or numbers in SI units.
"""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from vibrissa.design.choices import (
    DIAMETERS,
    LENGTHS,
    TAPERS,
    Choice,
    choices_of,
    heights,
    heights_of,
)
from vibrissa.design.materials import material as material_named
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact
from vibrissa.sensor.quantities import (
    CHANNEL_KINDS,
    PLUS_MINUS,
    Kind,
    Measured,
    Quantity,
    Units,
    channels_of,
    chosen,
    in_si,
    wished_units,
)
from vibrissa.sensor.setup import TOLERANCES, read_keys, with_options
from vibrissa.sensor.tolerances import TOLERABLE, read_tolerances
from vibrissa.sensor.transducer import preset
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.api import MOST_TAPER

# Values of μ0 in its range at which the uncertainty is computed.
FRICTIONS = 5
# What may have a tolerance, as in "210 ± 5 GPa".
TOLERATED = ("theta", "eta", "modulus", "diameter", "length")
# A design is of a rod in the ideal mounting: of these only the tolerance counts.
MOUNTING = ("clamp_angle", "clamp_compliance", "clamp_stiffness", "curvature", "stage_angle")


def _read(text: str, kind: Kind, name: str) -> float:
    return float(Units().read(text, kind, name) if kind is Kind.NUMBER else in_si(text, kind, name))


def _quantity(kind: Kind) -> BeforeValidator:
    def read(value: Any, info: ValidationInfo) -> Any:
        return _read(value, kind, str(info.field_name)) if isinstance(value, str) else value

    return BeforeValidator(read)


def _channels(value: Any, info: ValidationInfo) -> Any:
    name = str(info.field_name)
    if not isinstance(value, str):
        return value
    return tuple(_read(part, kind, name) for part, kind in channels_of(value, name))


def _choice(kind: Kind, sold: Choice) -> BeforeValidator:
    def read(value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        if not isinstance(value, str):
            return (value,) if isinstance(value, float | int) else value
        return choices_of(value, lambda text: _read(text, kind, name), sold)

    return BeforeValidator(read)


FINITE = Field(gt=0.0, allow_inf_nan=False)
Positive = Annotated[float, Field(gt=0.0)]
Size = Annotated[float, FINITE]
Length = Annotated[float, _quantity(Kind.LENGTH)]
# A value each for force_x, force_y and moment_z.
Channels = tuple[Positive, Positive, Positive]
Lengths = Annotated[tuple[Size, ...], Field(min_length=1)]


class Requirements(BaseModel):
    """What a rod is to measure, with what, and the constraints it must meet; see `read`.

    Of `theta`, `eta` (L), `diameter` and `length` (m) these are the values to choose from, and of
    `mu0` the ends of its range. `carried` are further keys for the set-up file of the result.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    mu0: Annotated[tuple[Size, ...], Field(max_length=2), _choice(Kind.NUMBER, ())]
    step: Annotated[Length, FINITE]
    modulus: Annotated[Size, _quantity(Kind.STRESS)]
    yield_strain: Annotated[Positive, _quantity(Kind.NUMBER)]
    density: Annotated[Size, _quantity(Kind.DENSITY)] | None = None
    noise: Annotated[tuple[Size, Size, Size], BeforeValidator(_channels)]
    range: Annotated[Channels, BeforeValidator(_channels)] = (np.inf, np.inf, np.inf)
    load: float = Field(0.8, gt=0.0, le=1.0)
    contact: Contact = Contact.POINT
    theta: Annotated[
        tuple[Annotated[float, Field(ge=1.0, le=MOST_TAPER)], ...], _choice(Kind.NUMBER, TAPERS)
    ] = TAPERS
    diameter: Annotated[Lengths, _choice(Kind.LENGTH, DIAMETERS)] = DIAMETERS
    length: Annotated[Lengths, _choice(Kind.LENGTH, LENGTHS)] = LENGTHS
    eta: tuple[Annotated[float, Field(gt=0.0, lt=1.0)], ...] = heights()
    tip: Annotated[Length, Field(ge=0.0, allow_inf_nan=False)] = 1e-4
    safety: float = Field(1.5, ge=1.0, allow_inf_nan=False)
    lock_factor: float = Field(1.1, ge=1.0, allow_inf_nan=False)
    steps: Size = 10.0
    weight: Positive = 0.1
    spacing: Annotated[Length, Field(gt=0.0)] = np.inf
    tolerances: dict[str, Quantity] = Field(default_factory=dict)
    assume: bool = True
    carried: dict[str, Quantity] = Field(default_factory=dict)
    wished: dict[Kind, str] = Field(default_factory=dict)

    @classmethod
    def read(cls, path: Path | str | None = None, **asked: Any) -> "Requirements":
        """Read requirements from text, and from a set-up file.

        Parameters
        ----------
        path : Path or str, optional
            Set-up file; what is asked for takes the place of what it states.
        **asked
            Fields, None for the default; ``material`` in place of modulus and yield strain, and
            ``transducer`` in place of noise and range. ``theta``, ``eta``, ``diameter`` and
            ``length`` are a value, a list, ``"0.8 mm, 1 mm"``, or a range, ``"20 to 100 mm"``, of
            what can be had. Tolerances are standard deviations, as in ``modulus="210 ± 5 GPa"`` or
            ``tolerances={"clamp_angle": "0.5 deg"}``.

        Raises
        ------
        ArgumentError
            With a line for each value that is missing, given twice, or not allowed.
        """
        keys = with_options({} if path is None else read_keys(path), asked)
        try:
            return cls.model_validate(_named(_ideal(keys, path)))
        except ValidationError as error:
            raise ArgumentError("\n".join(map(_line, error.errors()))) from None

    @model_validator(mode="before")
    @classmethod
    def _split_tolerances(cls, data: Any) -> Any:
        """Take tolerances off the values."""
        stated = {}
        for name in set(TOLERATED) & data.keys():
            text = data[name]
            if not isinstance(text, str):
                continue
            if PLUS_MINUS.search(text) and ("," in text or " to " in text):
                raise ArgumentError(
                    f"{name} is a range: give its tolerance apart, as in --tolerance "
                    f"'{name}=1 %', got {text!r}"
                )
            given = Measured.read(text, name)
            data = {**data, name: str(given.value)}
            if given.tolerance is not None:
                stated[name] = given.tolerance
        return {**data, TOLERANCES: {**stated, **data.get(TOLERANCES, {})}}

    @field_validator("contact", mode="before")
    @classmethod
    def _check_contact(cls, value: Any) -> Contact:
        return chosen(Contact, value, "contact")

    @field_validator("eta", mode="before")
    @classmethod
    def _read_heights(cls, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, str):
            return (value,) if isinstance(value, float | int) else value
        return heights_of(value, info.data.get("length", ()))

    @model_validator(mode="after")
    def _check_tolerances(self) -> "Requirements":
        """Refuse what is no tolerance of a rod, before any rod is looked for."""
        whisker = Whisker(theta=2.0, eta=0.85, rod=Rod(self.modulus, 1e-3, 0.1))
        read_tolerances(whisker.units, self.tolerances, whisker)
        return self

    @property
    def rigidity(self) -> float:
        """Bending stiffness at the clamp over the fourth power of the diameter, E·I0/d0⁴ (Pa)."""
        return np.pi / 64.0 * self.modulus

    @property
    def frictions(self) -> FloatArray:
        """Values of μ0, of the whole range, at which the uncertainty is computed."""
        return np.linspace(self.mu0[0], self.mu0[-1], FRICTIONS)

    @property
    def given(self) -> bool:
        """Whether the whole rod is given, so that it is only checked."""
        return all(len(one) == 1 for one in (self.theta, self.eta, self.diameter, self.length))


def _ideal(keys: dict[str, Any], path: Path | str | None) -> dict[str, Any]:
    """Take a mounting off the keys; only its tolerances count."""
    for name in MOUNTING:
        if name not in keys:
            continue
        given = Measured.read(keys.pop(name), name)
        kind = Kind.STIFFNESS if name == "clamp_stiffness" else TOLERABLE[name].kind
        if Units(Rod(1.0, 1.0, 1.0)).read(given.value, kind, name):
            raise ArgumentError(
                f"{path}: a design is of a straight rod in a rigid, upright clamp on a level "
                f"stage; of {name} give the tolerance alone, in the table [{TOLERANCES}]"
            )
        if given.tolerance is not None:
            keys[TOLERANCES] = {name: given.tolerance} | keys[TOLERANCES]
    return keys


def _named(keys: dict[str, Any]) -> dict[str, Any]:
    """Put the values of a material and of a transducer in the place of their names."""
    told = (keys.get("noise"), keys.get("range"), *keys[TOLERANCES].values())
    named = {name: keys.pop(name, None) for name in ("material", "transducer", "section")}
    keys["wished"] = wished_units(CHANNEL_KINDS, *told)
    keys["carried"] = {name: value for name, value in named.items() if value is not None}
    if named["material"] is not None:
        if "yield_strain" in keys:
            raise ArgumentError("give the material or its yield strain, not both")
        found = material_named(named["material"])
        if "modulus" in keys:
            measured = Measured.read(keys["modulus"], "modulus").value
            found = found.with_modulus(_read(str(measured), Kind.STRESS, "modulus"))
        own = {"modulus": found.modulus, "density": found.density}
        keys = {**own, **keys, "yield_strain": found.yield_strain}
    if named["transducer"] is not None:
        if "noise" in keys or "range" in keys:
            raise ArgumentError("give the transducer, or its noise and range, not both")
        sensor = preset(named["transducer"])
        keys |= {"noise": sensor.deviation, "range": sensor.limit}
    return keys


def _line(error: Any) -> str:
    """Write one error of pydantic's."""
    name = str(error["loc"][0]) if error["loc"] else ""
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    if error["type"] == "missing":
        instead = {"modulus": "material", "yield_strain": "material", "noise": "transducer"}
        return f"{name} is not given" + (f", nor a {instead[name]}" if name in instead else "")
    return f"{name}: {error['msg'].lower()}, got {error['input']!r}"
