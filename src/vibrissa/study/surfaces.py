"""Surfaces of a study file: friction and height under the tip, as functions of the place."""

import csv
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from itertools import pairwise, product
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from vibrissa.study.axes import AXES, FRICTION_AXES, TEXTURE_AXES, Values, sortable
from vibrissa.study.sections import Mistakes, Section

# Name of the surface of a scan that states mu0 itself.
PLANE = "plane"
# A surface with one value of each of its axes, as plain values: the parameters of a job.
Variant: TypeAlias = Mapping[str, Any]
# Keys of which a surface has exactly one, with the further keys that each needs.
FRICTION_KINDS: Mapping[str, tuple[str, ...]] = {
    "mu0": (),
    "patches": (),
    "profile": (),
    "mean": ("deviation", "correlation", "seed"),
}

# Keys of the heights of a surface, which are added.
HEIGHT_KEYS = ("wave", "grooves", "rough", "heights")

_Friction: TypeAlias = Annotated[FiniteFloat, Field(gt=0)]


class WaveSection(Section):
    """Heights of a sine."""

    amplitude: Annotated[Values, TEXTURE_AXES["wave_amplitude"]]
    wavelength: Annotated[Values, TEXTURE_AXES["wave_wavelength"]]
    phase: Annotated[Values, TEXTURE_AXES["wave_phase"]] = (0.0,)


class GroovesSection(Section):
    """Heights of equal grooves in a plane."""

    width: Annotated[Values, TEXTURE_AXES["grooves_width"]]
    depth: Annotated[Values, TEXTURE_AXES["grooves_depth"]]
    pitch: Annotated[Values, TEXTURE_AXES["grooves_pitch"]]
    wall: Annotated[Values, TEXTURE_AXES["grooves_wall"]]

    @model_validator(mode="after")
    def _leaves_land(self) -> Self:
        (widest,), (least,) = max(map(sortable, self.width)), min(map(sortable, self.pitch))
        if not widest < least:
            raise ValueError(f"the pitch {least:g} must be above the width {widest:g} of a groove")
        return self


class RoughSection(Section):
    """Random heights, normally distributed."""

    deviation: Annotated[Values, TEXTURE_AXES["rough_deviation"]]
    correlation: Annotated[Values, TEXTURE_AXES["rough_correlation"]]
    seed: Annotated[Values, TEXTURE_AXES["rough_seed"]]


class SurfaceSection(Section):
    """A surface: its friction (plane, patches, a profile or random), and its heights if any."""

    mu0: Annotated[Values | None, AXES["mu0"]] = None
    patches: list[tuple[FiniteFloat, _Friction]] | None = Field(
        default=None,
        min_length=1,
        description="start in units of L and friction coefficient of each patch, as in "
        "[[0, 0.2], [0.5, 0.4]]; the first patch also reaches to -infinity",
    )
    profile: str | None = Field(
        default=None,
        description="CSV file with the columns x (in units of L, increasing) and mu0, relative to "
        "the study file; mu0 is linear between the points",
    )
    mean: Annotated[Values | None, FRICTION_AXES["mean"]] = None
    deviation: Annotated[Values | None, FRICTION_AXES["deviation"]] = None
    correlation: Annotated[Values | None, FRICTION_AXES["correlation"]] = None
    seed: Annotated[Values | None, FRICTION_AXES["seed"]] = None
    wave: WaveSection | None = Field(
        default=None, description="wavy heights; heights of several keys are added"
    )
    grooves: GroovesSection | None = Field(default=None, description="grooves in a plane")
    rough: RoughSection | None = Field(default=None, description="random heights")
    heights: str | None = Field(
        default=None,
        description="CSV file with the columns x (increasing) and height, both in units of L, "
        "relative to the study file; the height is linear between the points",
    )
    lay: Annotated[Values | None, TEXTURE_AXES["lay"]] = None
    tip_radius: Annotated[Values | None, TEXTURE_AXES["tip_radius"]] = None

    @model_validator(mode="after")
    def _is_one_kind(self) -> Self:
        mistakes = Mistakes()
        given = {key for key in self.model_fields_set if getattr(self, key) is not None}
        kinds = [kind for kind in FRICTION_KINDS if kind in given]
        if len(kinds) != 1:
            has = " and ".join(kinds) if kinds else "none of them"
            mistakes.add(f"needs exactly one of the keys {', '.join(FRICTION_KINDS)}; it has {has}")
            mistakes.refuse()
        (kind,) = kinds
        for key in FRICTION_KINDS[kind]:
            if key not in given:
                mistakes.add(f"missing {key!r}: a surface with {kind!r} needs it")
        if not self.has_heights:
            for key in sorted(given & {"lay", "tip_radius"}):
                text = f"needs heights ({', '.join(HEIGHT_KEYS)}); add some, or remove it"
                mistakes.add(text, key)
        for key in sorted(given - {kind, *FRICTION_KINDS[kind], *HEIGHT_KEYS, "lay", "tip_radius"}):
            mistakes.add(f"is not a key of a surface with {kind!r}; remove it", key)
        for place, (before, after) in enumerate(pairwise(self.patches or ()), start=1):
            if not after[0] > before[0]:
                text = f"starts of patches must increase; {after[0]:g} is not above {before[0]:g}"
                mistakes.add(text, "patches", place)
        mistakes.refuse()
        return self

    @property
    def axes(self) -> dict[str, Values]:
        """Values of each axis in increasing order."""
        keys = ("mu0", *FRICTION_AXES, "lay", "tip_radius")
        found = {key: getattr(self, key) for key in keys}
        for name in ("wave", "grooves", "rough"):
            for key, values in getattr(self, name) or ():
                found[f"{name}_{key}"] = values
        return {key: values for key, values in found.items() if values is not None}

    @property
    def has_heights(self) -> bool:
        """Whether the surface is uneven."""
        return any(getattr(self, key) is not None for key in HEIGHT_KEYS)

    @property
    def files(self) -> list[str]:
        """Files of friction and of heights, relative to the study file."""
        return [name for name in (self.profile, self.heights) if name is not None]

    @property
    def count(self) -> int:
        """Number of surfaces: of combinations of values of the axes."""
        number = 1
        for values in self.axes.values():
            number *= len(values)
        return number

    def misfits(self, folder: Path) -> Mistakes:
        """Find what is wrong with the files of friction and heights in the study's `folder`."""
        mistakes = Mistakes()
        for key, read in (("profile", read_profile), ("heights", read_heights)):
            name = getattr(self, key)
            if name is not None:
                try:
                    read(file_below(folder, name))
                except ValueError as error:
                    mistakes.add(str(error), key)
        return mistakes

    def variants(self, name: str, folder: Path) -> list[Variant]:
        """List the surfaces, one for each combination of values."""
        same: dict[str, Any] = {"surface": name}
        if self.patches is not None:
            same["patches"] = [list(patch) for patch in self.patches]
        for key, file in (("profile", self.profile), ("heights", self.heights)):
            if file is not None:
                same[key] = (folder / file).as_posix()
        if self.files:
            same["content"] = "-".join(digest_of(folder / file) for file in self.files)
        axes = self.axes
        return [same | dict(zip(axes, values, strict=True)) for values in product(*axes.values())]


def file_below(folder: Path, name: str) -> Path:
    """Return the path of a data file of a study.

    Raises
    ------
    ValueError
        If there is no such file in the folder of the study file or below it, so that an archive
        of the study would lack it.
    """
    path = Path(name)
    if path.is_absolute() or ".." in path.parts or not (folder / path).is_file():
        raise ValueError(f"there is no file {name} in the study file's folder or below it")
    return folder / path


def digest_of(path: Path) -> str:
    """Compute a digest of a file's content."""
    return sha256(path.read_bytes()).hexdigest()[:16]


class Profile(NamedTuple):
    """Values at increasing positions (L): friction coefficients, or heights (L)."""

    x: list[float]
    values: list[float]


def read_profile(path: Path) -> Profile:
    """Read a profile of friction from a CSV file with the columns ``x`` and ``mu0``.

    Raises
    ------
    ValueError
        If the file cannot be used; the message has its line.
    """

    def check(line: int, mu0: float) -> None:
        if not mu0 > 0.0:
            raise ValueError(f"{path}:{line}: mu0 must be above 0, got {mu0:g}")

    return _read_profile(path, "mu0", check)


def read_heights(path: Path) -> Profile:
    """Read heights from a CSV file with the columns ``x`` and ``height``.

    Raises
    ------
    ValueError
        If the file cannot be used; the message has its line.
    """
    return _read_profile(path, "height", lambda line, height: None)


def _read_profile(path: Path, name: str, check: Callable[[int, float], None]) -> Profile:
    """Read a column over increasing positions; `check` refuses a wrong value of a line."""
    found = Profile([], [])
    for line, (x, value) in read_columns(path, ("x", name)):
        check(line, value)
        if found.x and not x > found.x[-1]:
            raise ValueError(f"{path}:{line}: x must increase; {x:g} is not above {found.x[-1]:g}")
        found.x.append(x)
        found.values.append(value)
    if len(found.x) < 2:
        raise ValueError(f"{path}: a profile needs two rows or more")
    return found


class TextLine(NamedTuple):
    """A line of a file, with its number from 1."""

    number: int
    text: str


def lines_of(path: Path) -> list[TextLine]:
    """Read the lines of a text in UTF-8, without those that are empty or begin with #.

    Raises
    ------
    ValueError
        If the file cannot be read as such a text.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} cannot be read as a text in UTF-8: {error}") from None
    return [
        TextLine(number=number, text=line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]


def read_columns(path: Path, names: Sequence[str]) -> list[tuple[int, list[float]]]:
    """Read columns of numbers from a CSV file: the number of each line, and its values.

    Lines that are empty or begin with # are left out.

    Raises
    ------
    ValueError
        If a column is missing or there twice, a row is too long, or a value is no finite number.
    """
    lines = lines_of(path)
    rows = list(csv.reader([line.text for line in lines], skipinitialspace=True))
    head = [name.strip() for name in rows[0]] if rows else []
    absent = [name for name in names if name not in head]
    if absent:
        has = ", ".join(head) or "nothing"
        raise ValueError(
            f"{path} has no column {', '.join(absent)}; its first line has {has}, and must name "
            f"the columns {', '.join(names)}, separated by commas"
        )
    for name in names:
        if head.count(name) > 1:
            raise ValueError(f"{path} has the column {name} twice; remove one of them")
    found = []
    for (number, _), row in zip(lines[1:], rows[1:], strict=True):
        if len(row) > len(head):
            raise ValueError(
                f"{path}:{number}: {len(row)} values for {len(head)} columns; write 0.5, not 0,5"
            )
        values = []
        for name in names:
            place = head.index(name)
            written = row[place] if place < len(row) else ""
            try:
                value = float(written)
            except ValueError:
                value = float("nan")
            if not isfinite(value):
                raise ValueError(f"{path}:{number}: {name} must be a number, got {written!r}")
            values.append(value)
        found.append((number, values))
    return found
