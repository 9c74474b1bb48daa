"""The set-up of a measurement: rod, mounting and transducer, each quantity with its tolerance.

In a TOML file a line is ``name = number`` or ``name = "value ± tolerance unit"``.
"""

import json
import tomllib
from collections.abc import Container, Iterator, Mapping
from decimal import Decimal
from difflib import get_close_matches
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from vibrissa.errors import ArgumentError
from vibrissa.files import write_atomically
from vibrissa.mechanics.mounting import Mounting
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor.quantities import (
    Kind,
    Measured,
    Quantity,
    Units,
    channels_of,
    chosen,
    read_rod,
    wished_units,
)
from vibrissa.sensor.tolerances import check_name, read_tolerances
from vibrissa.sensor.whisker import Whisker

TOLERANCES = "tolerances"
# Each pair describes one property: an option takes the place of either in the file.
EITHER = (
    ("clamp_compliance", "clamp_stiffness"),
    ("transducer", "noise"),
    ("material", "yield_strain"),
)


class Setup(BaseModel):
    """Rod, mounting and transducer, as they were stated; see `Setup.read`.

    Numbers without a unit are nondimensional: lengths in units of the rod's length.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    theta: Annotated[Measured | None, Kind.NUMBER] = Field(
        None, description="Taper, base over tip diameter: '2 ± 0.02'."
    )
    eta: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Height of the surface above the clamp: 0.85 or '85 ± 0.1 mm'."
    )
    modulus: Annotated[Measured | None, Kind.STRESS] = Field(
        None, description="Young's modulus: '210 ± 5 GPa'."
    )
    diameter: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Diameter at the clamp: '1 mm ± 0.5 %'."
    )
    length: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Length of the rod: '100 mm'."
    )
    contact: Contact = Field(
        Contact.POINT,
        description="point: the rod touches with its tip alone; line: it may lie flat.",
    )
    section: RodSection = Field(
        RodSection.ROUND,
        description="round: the rod may buckle out of its plane; planar: a strip stays in it.",
    )
    clamp_angle: Annotated[Measured, Kind.ANGLE] = Field(
        Measured(0), description="Inclination of the clamp, positive backward: '2 deg'."
    )
    clamp_compliance: Annotated[Measured | None, Kind.COMPLIANCE] = Field(
        None, description="Rotational compliance of the clamp: '0.05 rad/(N*m)'."
    )
    clamp_stiffness: Annotated[Measured | None, Kind.STIFFNESS] = Field(
        None, description="Its inverse: '20 N*m/rad'. Without either the clamp is rigid."
    )
    curvature: Annotated[Measured, Kind.CURVATURE] = Field(
        Measured(0),
        description="Natural curvature, negative away from the surface: '-2 m^-1'. 'a, b, c' are "
        "coefficients of the powers of s/L.",
    )
    stage_angle: Annotated[Measured, Kind.ANGLE] = Field(
        Measured(0), description="Angle of the stage to the surface: '1 deg'."
    )
    transducer: str | None = Field(
        None, description="Transducer, such as nano17-si-12-0.12, or a file (.toml)."
    )
    noise: str | None = Field(
        None,
        description="Standard deviation of one reading of force_x, force_y and moment_z: "
        "'3 mN, 3 mN, 10 uN*m'.",
    )
    material: str | None = Field(
        None, description="Material of the rod, such as music-wire, or a file (.toml)."
    )
    yield_strain: float | None = Field(
        None, gt=0.0, description="Yield strain, without a modulus in units of d0/L."
    )
    density: Annotated[Measured | None, Kind.DENSITY] = Field(
        None, description="Density of the material: '7800 kg/m^3'."
    )
    assume: bool = Field(
        True, description="Whether quantities without a stated tolerance have the default one."
    )
    tolerances: dict[str, Quantity] = Field(
        default_factory=dict, description="Standard deviations of further quantities."
    )

    @classmethod
    def read(cls, path: Path | str | None = None, **options: Any) -> Self:
        """Read a set-up from a TOML file, from options, or from both.

        Raises
        ------
        ArgumentError
            With a line for each key or value that is not allowed.

        Examples
        --------
        >>> setup = Setup.read(theta=2, eta="85 ± 0.1 mm", modulus="210 GPa", diameter="1 mm",
        ...                    length="100 mm")
        >>> print(f"{setup.whisker.eta} ± {setup.whisker.tolerances['eta']:.3f}")
        0.85 ± 0.001
        """
        keys = {} if path is None else read_keys(path)
        return validated(cls, with_options(keys, options), path, keys)

    @field_validator("*", mode="before")
    @classmethod
    def _read_field(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        field = cls.model_fields[name]
        if name in ("assume", TOLERANCES):
            return value
        if isinstance(value, bool) or not isinstance(value, str | Real | Decimal):
            raise ArgumentError(f"{name} is a number or a text in quotes, got {value!r}")
        if field.annotation in (Contact, RodSection):
            return chosen(field.annotation, str(value), name)
        kind = next((each for each in field.metadata if isinstance(each, Kind)), None)
        if kind is None:
            return value
        measured = Measured.read(str(value), name)
        if name == "curvature" and "," in str(measured.value):
            for part in str(measured.value).split(","):
                Measured(part).check(Kind.NUMBER, name)
        else:
            measured.check(kind, name)
        return measured

    @field_validator(TOLERANCES)
    @classmethod
    def _check_names(cls, tolerances: dict[str, Quantity]) -> dict[str, Quantity]:
        for name in tolerances:
            check_name(name)
        return tolerances

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        if self.clamp_compliance is not None and self.clamp_stiffness is not None:
            raise ArgumentError("give clamp_compliance or clamp_stiffness, not both")
        if self.noise is not None:
            for part, kind in channels_of(self.noise, "noise"):
                Measured(part).check(kind, "noise")
        return self

    def stated(self) -> dict[str, Any]:
        """Keys of a set-up file with the same content."""
        return {
            name: (value.text if value.tolerance else value.value)
            if isinstance(value, Measured)
            else value
            for name, value in self
            if name in self.model_fields_set
        }

    @cached_property
    def whisker(self) -> Whisker:
        """The whisker, with the tolerances that were stated.

        Raises
        ------
        ArgumentError
            If taper or height is missing, or the values do not fit each other.
        """
        if self.theta is None or self.eta is None:
            name = "theta" if self.theta is None else "eta"
            raise ArgumentError(f"{name} is not given: neither as an option nor in a set-up file")
        modulus, diameter, length = (
            None if one is None else str(one.value)
            for one in (self.modulus, self.diameter, self.length)
        )
        rod = read_rod(modulus, diameter, length)
        lengths = [each.value for each in (self.length, self.eta, self.diameter) if each]
        units = Units(rod, wished_units([Kind.LENGTH], *lengths))
        whisker = Whisker(
            theta=float(units.read(self.theta.value, Kind.NUMBER, "theta")),
            eta=_height(units, self.eta.value),
            contact=self.contact,
            section=self.section,
            rod=rod,
            mounting=self._mounting(units),
            wished=units.wished,
        )
        stated = {**dict(self._tolerances(units)), **self.tolerances}
        whisker = whisker.tolerating(read_tolerances(units, stated, whisker))
        return whisker.wishing(self.noise, *self.tolerances.values())

    def _mounting(self, units: Units) -> Mounting:
        def read(measured: Measured | None, kind: Kind, name: str) -> float:
            return 0.0 if measured is None else float(units.read(measured.value, kind, name))

        compliance = read(self.clamp_compliance, Kind.COMPLIANCE, "clamp_compliance")
        if (stiffness := self.clamp_stiffness) is not None:
            compliance = 1.0 / float(
                units.read_positive(stiffness.value, Kind.STIFFNESS, "clamp_stiffness")
            )
        powers = str(self.curvature.value).split(",")
        curvature = (
            read(self.curvature, Kind.CURVATURE, "curvature")
            if len(powers) == 1
            else tuple(map(float, powers))
        )
        return Mounting(
            clamp_angle=read(self.clamp_angle, Kind.ANGLE, "clamp_angle"),
            clamp_compliance=compliance,
            curvature=curvature,
            stage_angle=read(self.stage_angle, Kind.ANGLE, "stage_angle"),
        )

    def _tolerances(self, units: Units) -> Iterator[tuple[str, str]]:
        """Tolerances that are written with their values."""
        for name, measured in self:
            if not isinstance(measured, Measured) or measured.tolerance is None:
                continue
            if name == "clamp_stiffness":
                yield "clamp_compliance", _relative(units, measured)
            else:
                yield name, measured.tolerance


def _height(units: Units, eta: Quantity) -> float:
    """Height of the surface (L); a rod with a length must reach it."""
    height = float(units.read(eta, Kind.LENGTH, "eta"))
    if units.rod is not None and not 0.0 < height < 1.0:
        raise ArgumentError(
            f"eta must lie between 0 and the length of the rod, {units.spelled(1.0, Kind.LENGTH)}: "
            f"write a height with its unit, as in '85 mm', got {eta!r}"
        )
    return height


def _relative(units: Units, stiffness: Measured) -> str:
    """Relative tolerance of a compliance, from that of the stiffness: both are equal."""
    tolerance = str(stiffness.tolerance)
    if tolerance.endswith("%"):
        return tolerance
    size, value = (
        units.read(each, Kind.STIFFNESS, "clamp_stiffness") for each in (tolerance, stiffness.value)
    )
    return f"{100 * size / value} %"


def with_options(keys: Mapping[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    """Put options in the place of the keys of a file; None is not stated."""
    given = {name: value for name, value in options.items() if value is not None}
    replaced = {name for pair in EITHER if set(pair) & given.keys() for name in pair}
    kept = {name: value for name, value in keys.items() if name not in replaced}
    tables = [each[TOLERANCES] for each in (keys, given) if TOLERANCES in each]
    if tables and all(isinstance(each, Mapping) for each in tables):
        given[TOLERANCES] = {name: size for each in tables for name, size in each.items()}
    return {TOLERANCES: {}, **kept, **given}


def read_keys(path: Path | str) -> dict[str, Any]:
    """Read the keys of a set-up file and their values.

    Raises
    ------
    ArgumentError
        If it cannot be read as TOML; the message names the line.
    """
    path = Path(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        raise ArgumentError(
            f"{path}: a set-up file is written in TOML, as in theta = 2 (not theta: 2), and named "
            "setup.toml"
        )
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ArgumentError(f"no such set-up file: {path}") from None
    except OSError as error:
        raise ArgumentError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ArgumentError(f"{path} is not a text in UTF-8: save it as UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise ArgumentError(
            f"{path}: {error}; write name = number, with a decimal point, or "
            'name = "value unit", in quotes'
        ) from None


def write_keys(path: Path, keys: Mapping[str, Any], comment: str) -> None:
    """Write a set-up file."""
    tables = {name: value for name, value in keys.items() if isinstance(value, Mapping)}
    lines = [f"# {comment}", "", *_assignments({n: v for n, v in keys.items() if n not in tables})]
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *_assignments(table)]
    with write_atomically(path) as temporary:
        temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _assignments(keys: Mapping[str, Any]) -> list[str]:
    # TOML writes numbers and texts as JSON does.
    return [f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in keys.items()]


Model = TypeVar("Model", bound=BaseModel)


def validated(
    model: type[Model], given: Mapping[str, Any], path: Path | str | None, keys: Container[str]
) -> Model:
    """Validate keys and their values.

    Raises
    ------
    ArgumentError
        With a line for each key or value that is not allowed.
    """
    try:
        return model.model_validate(given)
    except ValidationError as error:
        lines = [_line(each, model) for each in error.errors()]
        places = [f"{path}: " if _key(each) in keys else "" for each in error.errors()]
    told = dict.fromkeys(place + line for place, line in zip(places, lines, strict=True))
    raise ArgumentError("\n".join(told))


def _key(error: Any) -> str:
    return str(error["loc"][0]) if error["loc"] else ""


def _line(error: Any, model: type[BaseModel]) -> str:
    """Message of one error of pydantic's."""
    name = _key(error)
    if error["type"] == "extra_forbidden":
        allowed = [field.alias or key for key, field in model.model_fields.items()]
        near = get_close_matches(name, allowed, 1)
        hint = f"did you mean {near[0]}?" if near else f"the keys are {', '.join(allowed)}"
        return f"there is no key {name}; {hint}"
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    if error["type"] == "missing":
        return f"{name} is not given"
    if error["type"] == "dict_type":
        return f"{name} is a table: [{name}], then lines name = value"
    return f"{name}: {error['msg'].lower()}, got {error['input']!r}"
