"""Check of the readings of a study file before any work: rods, transducers, errors, tolerances."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from vibrissa.design.materials import stated_material
from vibrissa.errors import VibrissaError
from vibrissa.outcomes import Contact
from vibrissa.readings.reading import Stated, setup_of
from vibrissa.sensor.deviations import Prior
from vibrissa.sensor.identification.parameters import SLOPE
from vibrissa.sensor.tolerances import EXACT
from vibrissa.sensor.transducer import preset
from vibrissa.study.model import Study
from vibrissa.study.readings import ReadingChunk, ReadingSection
from vibrissa.study.sections import Mistakes


def misfits(study: Study) -> Mistakes:
    """Find values of the section `readings` that no rod, transducer or tolerance can have."""
    mistakes = Mistakes()
    first: dict[str, ReadingChunk] = {}
    for chunk in study.reading_chunks.values():
        first.setdefault(chunk.readings, chunk)
    for name, chunk in first.items():
        _check(
            study, chunk, lambda text, *place, at=name: mistakes.add(text, "readings", at, *place)
        )
    return mistakes


def _check(study: Study, chunk: ReadingChunk, add: Callable[..., None]) -> None:
    section = study.readings[chunk.readings]
    known = []
    for place, entry in enumerate(section.transducers(study.folder)):
        with _told(add, "transducer", place):
            preset(entry.get("card", entry["transducer"]))
            known.append(entry)
    if not known:
        return
    point = {**chunk.point, **known[0]}

    def stated(tolerances: dict[str, Any]) -> Prior:
        with_tolerances = Stated(
            rod=section.rod.model_dump(exclude_none=True),
            tolerances=tolerances,
            assume=section.assumes,
            contact=study.contact,
            section=study.section,
        )
        setup = setup_of(point, with_tolerances)
        stated_material(setup)
        return Prior.of(setup.whisker, preset(str(setup.transducer)), setup.assume)

    priors: list[Prior] = []
    with _told(add, "rod"):
        priors.append(stated({}))
    if not priors:
        return
    for key, size in section.stated.items():
        with _told(add, "tolerances", key):
            stated({key: size})
    for key, size in (section.sizes or {}).items():
        with _told(add, "errors", key):
            priors[0].stated({key: size})
    if study.contact is Contact.LINE and _has_slopes(section):
        text = "on a surface with a random slope the contact must be point, not line"
        add(f"{text}; set tolerances: {{surface_slope: exact}}, and no error of {SLOPE}")


def _has_slopes(section: ReadingSection) -> bool:
    """Whether recordings are of a surface with a random slope."""
    if section.sizes is not None:
        return SLOPE in section.sizes
    stated = section.stated.get(SLOPE, EXACT if not section.assumes else None)
    return stated != EXACT


@contextmanager
def _told(add: Callable[..., None], *place: str | int) -> Iterator[None]:
    """Add the message of an error as a mistake."""
    try:
        yield
    except VibrissaError as error:
        add("; ".join(str(error).splitlines()), *place)
