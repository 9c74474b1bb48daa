"""Readings of a study file: friction read from simulated recordings, and the chunks of these."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import BeforeValidator, Field, FiniteFloat, model_validator

from vibrissa.outcomes import Method
from vibrissa.study.axes import Values, in_list, spell_value
from vibrissa.study.chunks import START_SECONDS, points_of
from vibrissa.study.data_files import digest_of, file_below
from vibrissa.study.scans import ScanSection
from vibrissa.study.sections import Count, Mistakes, Name, Section
from vibrissa.study.surfaces import Variant

# Default largest number of recordings in a chunk. A job then takes some 20 to 30 s; the first
# recording of a job takes longer than the others, as the stated rod is solved once.
MOST_RECORDINGS = 10
# Upper bound of the time of a recording (s).
RECORDING_SECONDS = 30.0
# Words in the place of a table of errors or of tolerances.
DRAWN, EXACT, DEFAULT = "drawn", "exact", "default"
# Key of a table of tolerances: what holds for the quantities that it does not name.
OTHERS = "others"
# Ending of a file that describes a transducer; other names are those of presets.
CARD_ENDING = ".toml"

_Method: TypeAlias = Literal[tuple(one.value for one in Method)]  # type: ignore[valid-type]
# A size with a unit, such as "0.1 mm", or a number in units of the rod.
Size: TypeAlias = str | FiniteFloat


class RodSizes(Section):
    """Material and sizes of the rod, each with its unit."""

    modulus: Size = Field(description="Young's modulus, as in 210 GPa")
    diameter: Size = Field(description="diameter at the clamp, as in 0.8 mm")
    length: Size = Field(description="length, as in 100 mm")
    material: str | None = Field(
        default=None,
        description="material, as in music-wire; if its yield strain is exceeded, a recording has "
        "the status yielded (default: strain is not checked)",
    )
    yield_strain: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None, description="yield strain, in place of the material"
    )


class ReadingSection(Section):
    """Recordings of scans, from each of which friction is read."""

    scan: Name = Field(description="name of the scan; each combination of its values is recorded")
    transducer: Annotated[
        list[str],
        BeforeValidator(in_list, str | list[str]),
        Field(min_length=1),
    ] = Field(
        description="name of a transducer, or of a file beside the study file that describes one, "
        "or a list of names",
    )
    rod: RodSizes = Field(description="material and sizes of the rod")
    method: Annotated[
        list[_Method],
        BeforeValidator(in_list, _Method | list[_Method]),
        Field(min_length=1),
    ] = Field(
        default=[Method.MODEL.value],
        description="method of reading friction, model or ratio, or a list of both",
    )
    errors: Literal["drawn", "exact"] | dict[str, Size] = Field(
        default="drawn",
        description="errors of the set-up: drawn (from the tolerances, for each recording), exact "
        "(none), or sizes by name, as in {eta: 0.1 mm}, which are the same in all recordings",
    )
    tolerances: Literal["default", "exact"] | dict[str, Size] = Field(
        default="default",
        description="tolerances that are stated to the method: default, exact (all are 0), or "
        "standard deviations by name, as in {eta: 0.1 mm, others: exact}; others are default "
        "unless `others: exact`",
    )
    recordings: Count = Field(
        default=1, description="number of recordings of each combination, a whole number from 1"
    )
    seed: int = Field(
        default=0,
        ge=0,
        strict=True,
        description="whole number from 0 that fixes errors and noise",
    )

    @model_validator(mode="after")
    def _has_its_values(self) -> Self:
        mistakes = Mistakes()
        for key in ("transducer", "method"):
            values = getattr(self, key)
            if len(set(values)) < len(values):
                mistakes.add(f"{', '.join(values)} has a name twice; remove one of them", key)
        others = self._table(self.tolerances).get(OTHERS, DEFAULT)
        if others not in (DEFAULT, EXACT):
            mistakes.add(
                f"{others} is not allowed; allowed: {DEFAULT}, {EXACT}", "tolerances", OTHERS
            )
        mistakes.refuse()
        return self

    @staticmethod
    def _table(written: str | dict[str, Size]) -> dict[str, Size]:
        return {} if isinstance(written, str) else written

    @property
    def assumes(self) -> bool:
        """Whether quantities without a stated tolerance have the default one."""
        if isinstance(self.tolerances, str):
            return self.tolerances == DEFAULT
        return self.tolerances.get(OTHERS, DEFAULT) == DEFAULT

    @property
    def stated(self) -> dict[str, Size]:
        """Stated tolerances by name."""
        return {key: size for key, size in self._table(self.tolerances).items() if key != OTHERS}

    @property
    def sizes(self) -> dict[str, Size] | None:
        """Sizes of the errors by name; None if they are drawn."""
        return None if self.errors == DRAWN else self._table(self.errors)

    @property
    def files(self) -> list[str]:
        """Files of transducers, relative to the study file."""
        return [name for name in self.transducer if name.endswith(CARD_ENDING)]

    def transducers(self, folder: Path) -> list[dict[str, Any]]:
        """List the transducers; that of a file has its path and the digest of its content."""
        return [
            {"transducer": name}
            if name not in self.files
            else {
                "transducer": name,
                "card": (folder / name).as_posix(),
                "card_content": digest_of(folder / name),
            }
            for name in self.transducer
        ]

    def misfits(self, folder: Path) -> Mistakes:
        """Find files of transducers that are missing in the study's `folder`."""
        mistakes = Mistakes()
        for name in self.files:
            try:
                file_below(folder, name)
            except ValueError as error:
                mistakes.add(str(error), "transducer")
        return mistakes


# Keys of a point that say where a file is. Its content counts.
_PATHS = ("profile", "heights", "card")


def same_anywhere(point: Mapping[str, Any]) -> dict[str, Any]:
    """Return a point without the paths of files, which may be others in an archive."""
    return {key: value for key, value in point.items() if key not in _PATHS}


@dataclass(frozen=True, kw_only=True)
class ReadingChunk:
    """Some recordings of one point.

    Attributes
    ----------
    readings : str
        Name of the readings.
    point : mapping
        Values of the axes of rod and step, of the surface, of the slip law and of the transducer.
    first, last : int
        Numbers of the recordings, from 1.
    setup : mapping
        The rod, the methods, the errors and tolerances, the seed, and the path of the clamp.
    """

    readings: str
    point: Mapping[str, Any]
    first: int
    last: int
    setup: Mapping[str, Any]

    @cached_property
    def name(self) -> str:
        """Name such as ``best/theta2_eta0.85_0f3a9c1d22b4e567/1``."""
        shown = "_".join(f"{axis}{spell_value(self.point[axis])}" for axis in ("theta", "eta"))
        return f"{self.readings}/{shown}_{digest_of_point(self.point)[:16]}/{self.first}"

    @property
    def params(self) -> dict[str, Any]:
        """Inputs that determine the rows, as plain values."""
        return {
            "readings": self.readings,
            "point": dict(self.point),
            "first": self.first,
            "last": self.last,
            **self.setup,
        }

    def study_part(self, solver: Mapping[str, Any]) -> str:
        """Return the inputs that determine the chunk's rows, as text for its file's metadata."""
        inputs = {**self.params, "point": same_anywhere(self.point), **solver}
        return "".join(f"{key}: {value}\n" for key, value in inputs.items())

    def minutes(self) -> int:
        """Return the minutes to request from a cluster."""
        return 1 + int((START_SECONDS + RECORDING_SECONDS * (1 + self.last - self.first)) / 60)


def digest_of_point(point: Mapping[str, Any]) -> str:
    """Compute a digest of the values of a point; the order of its keys does not count.

    Values of 0 do not count either: an axis that a later version adds has this default, and does
    not change the digests of the points without it.
    """
    values = sorted(same_anywhere(point).items())
    lines = [f"{key}: {value!r}\n" for key, value in values if value != 0.0]
    return sha256("".join(lines).encode()).hexdigest()


def reading_chunks(
    name: str,
    section: ReadingSection,
    scan: ScanSection,
    surfaces: Sequence[Variant],
    transducers: Sequence[Mapping[str, Any]],
    most: int,
) -> Iterator[ReadingChunk]:
    """Cut readings into chunks: a chunk has at most `most` recordings, all of one point."""
    setup = {
        "rod": section.rod.model_dump(),
        "methods": [str(method) for method in section.method],
        "errors": section.sizes,
        "tolerances": section.stated,
        "assume": section.assumes,
        "seed": section.seed,
        "to": scan.to,
        "cycles": scan.cycles,
    }
    rods: Mapping[str, Values] = scan.rods
    for rod, surface, law, transducer in product(points_of(rods), surfaces, scan.laws, transducers):
        point = {**rod, **surface, **law, **transducer}
        for first in range(1, section.recordings + 1, most):
            yield ReadingChunk(
                readings=name,
                point=point,
                first=first,
                last=min(first + most - 1, section.recordings),
                setup=setup,
            )
