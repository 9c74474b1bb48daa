"""Surfaces of a study file: the friction under the tip, as a function of the place."""

import csv
from collections.abc import Mapping, Sequence
from hashlib import sha256
from itertools import pairwise, product
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from vibrissa.study.axes import AXES, SURFACE_AXES, Values
from vibrissa.study.sections import Mistakes, Section

# Name of the surface of a scan that states mu0 itself.
PLANE = "plane"
# A surface with one value of each of its axes, as plain values: the parameters of a job.
Variant: TypeAlias = Mapping[str, Any]
# Keys of which a surface has exactly one, with the further keys that each needs.
KINDS: Mapping[str, tuple[str, ...]] = {
    "mu0": (),
    "patches": (),
    "profile": (),
    "mean": ("deviation", "correlation", "seed"),
}

_Friction: TypeAlias = Annotated[FiniteFloat, Field(gt=0)]


class SurfaceSection(Section):
    """A surface: a plane, patches, a measured profile of friction, or random friction."""

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
    mean: Annotated[Values | None, SURFACE_AXES["mean"]] = None
    deviation: Annotated[Values | None, SURFACE_AXES["deviation"]] = None
    correlation: Annotated[Values | None, SURFACE_AXES["correlation"]] = None
    seed: Annotated[Values | None, SURFACE_AXES["seed"]] = None

    @model_validator(mode="after")
    def _is_one_kind(self) -> Self:
        mistakes, given = Mistakes(), self.model_fields_set
        kinds = [kind for kind in KINDS if kind in given]
        if len(kinds) != 1:
            has = " and ".join(kinds) if kinds else "none of them"
            mistakes.add(f"needs exactly one of the keys {', '.join(KINDS)}; it has {has}")
            mistakes.refuse()
        (kind,) = kinds
        for key in KINDS[kind]:
            if key not in given:
                mistakes.add(f"missing {key!r}: a surface with {kind!r} needs it")
        for key in sorted(given - {kind, *KINDS[kind]}):
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
        keys = ("mu0", *SURFACE_AXES)
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}

    @property
    def count(self) -> int:
        """Number of surfaces: of combinations of values of the axes."""
        number = 1
        for values in self.axes.values():
            number *= len(values)
        return number

    def misfits(self, folder: Path) -> Mistakes:
        """Find what is wrong with the file of a profile; `folder` has the study file."""
        mistakes = Mistakes()
        if self.profile is not None:
            try:
                read_profile(file_below(folder, self.profile))
            except ValueError as error:
                mistakes.add(str(error), "profile")
        return mistakes

    def variants(self, name: str, folder: Path) -> list[Variant]:
        """List the surfaces, one for each combination of values."""
        same: dict[str, Any] = {"surface": name}
        if self.patches is not None:
            same["patches"] = [list(patch) for patch in self.patches]
        if self.profile is not None:
            path = folder / self.profile
            same |= {"profile": path.as_posix(), "content": digest_of(path)}
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
    """Friction coefficients at increasing positions (L)."""

    x: list[float]
    mu0: list[float]


def read_profile(path: Path) -> Profile:
    """Read a profile of friction from a CSV file with the columns ``x`` and ``mu0``.

    Raises
    ------
    ValueError
        If the file cannot be used; the message has its line.
    """
    found = Profile([], [])
    for line, (x, mu0) in read_columns(path, ("x", "mu0")):
        if not mu0 > 0.0:
            raise ValueError(f"{path}:{line}: mu0 must be above 0, got {mu0:g}")
        if found.x and not x > found.x[-1]:
            raise ValueError(f"{path}:{line}: x must increase; {x:g} is not above {found.x[-1]:g}")
        found.x.append(x)
        found.mu0.append(mu0)
    if len(found.x) < 2:
        raise ValueError(f"{path}: a profile needs two rows or more")
    return found


def read_columns(path: Path, names: Sequence[str]) -> list[tuple[int, list[float]]]:
    """Read columns of numbers from a CSV file: the number of each line, and its values.

    Lines that are empty or begin with # are left out.

    Raises
    ------
    ValueError
        If a column is missing, or a value is no finite number.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} cannot be read as a text in UTF-8: {error}") from None
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    rows = list(csv.reader([line for _, line in lines], skipinitialspace=True))
    head = [name.strip() for name in rows[0]] if rows else []
    absent = [name for name in names if name not in head]
    if absent:
        has = ", ".join(head) or "nothing"
        raise ValueError(f"{path} has no column {', '.join(absent)}; its first line has {has}")
    found = []
    for (number, _), row in zip(lines[1:], rows[1:], strict=True):
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
