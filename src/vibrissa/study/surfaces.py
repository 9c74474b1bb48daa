"""Surfaces of a study file: friction and height under the tip, as functions of the place."""

from collections.abc import Mapping
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated, Any, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from vibrissa.study.axes import AXES, FRICTION_AXES, TEXTURE_AXES, Values, sortable
from vibrissa.study.data_files import digest_of, file_below, read_heights, read_profile
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
