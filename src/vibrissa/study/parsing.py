"""Reading a study file: a study, or its mistakes in one line each."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from functools import reduce
from operator import getitem
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from vibrissa.decimals import exact
from vibrissa.errors import StudyError
from vibrissa.study.claims import Claims
from vibrissa.study.figures import KINDS
from vibrissa.study.mistakes import Location, Mistake, UnknownName, at, spell_value, unknown_name
from vibrissa.study.model import Study
from vibrissa.study.schema import FOR_ANCHORS, MAY_BE_EMPTY, place_of

NUMBER_AS_TEXT = (
    " (YAML reads this as text; write a number without quotes, an exponent with a decimal point: "
    "0.001 or 1.0e-3)"
)
# What figures are drawn from.
SOURCES = sorted({kind.source for kind in KINDS})
# Grids in place of those of which none is as it should be.
ONE_POINT = {"g": {"theta": [1], "mu0": [0.3], "eta": [0.85], "dx0": [0.001]}}


def parse_study(config: Mapping[str, Any]) -> Study:
    """Check a study file and give its values their exact form.

    Parameters
    ----------
    config : mapping
        The study file as YAML reads it.

    Returns
    -------
    Study

    Raises
    ------
    StudyError
        If something is wrong; its message is that of the first mistake.
    """
    study, mistakes = examine(config)
    if study is None or mistakes:
        raise StudyError(*map(str, mistakes))
    return study


def examine(config: Mapping[str, Any]) -> tuple[Study | None, list[Mistake]]:
    """Find the mistakes of a study file.

    Parameters
    ----------
    config : mapping
        The study file as YAML reads it.

    Returns
    -------
    study : Study or None
        None where the sections by themselves are not as they should be.
    mistakes : list of Mistake
        Those nearest to the top of the file first.
    """
    if isinstance(config, Mapping):
        config = {
            key: value
            for key, value in config.items()
            if not (str(key).startswith(FOR_ANCHORS) or (key in MAY_BE_EMPTY and value is None))
        }
    try:
        study = Study.model_validate(config)
    except ValidationError as error:
        mistakes = _in_sections(error.errors(include_url=False), config)
        if isinstance(config, Mapping):
            mistakes += [*_among_sections(config, mistakes), *_unknown_names(config)]
        return None, mistakes
    return study, list(study.mistakes())


def _among_sections(config: Mapping[str, Any], mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Find what does not fit together of those parts of a file that are right by themselves."""
    wrong = {mistake.path[:2] for mistake in mistakes}
    rest = {
        key: {name: part for name, part in value.items() if (key, name) not in wrong}
        if isinstance(value, Mapping)
        else value
        for key, value in config.items()
        if (key,) not in wrong
    }
    # What a study must have.
    rest = {"study": "a", **rest, "grids": rest.get("grids") or ONE_POINT}
    try:
        found = Study.model_validate(rest).mistakes()
        return [mistake for mistake in found if not isinstance(mistake, UnknownName)]
    except ValidationError:
        return []


def _unknown_names(config: Mapping[str, Any]) -> Iterator[Mistake]:
    """Find names that nothing has in figures and claims of a file that is no study for others."""
    places: list[tuple[str, Location]] = [
        (source, ("claims", key)) for key, source in Claims.sources.items()
    ]
    figures = config.get("figures")
    for name in figures if isinstance(figures, Mapping) else ():
        places += [(kind, ("figures", name, kind)) for kind in SOURCES]
    for source, location in places:
        known, wanted = config.get(f"{source}s", {}), at(config, location)
        if isinstance(wanted, str) and isinstance(known, Mapping) and wanted not in known:
            yield unknown_name(location, wanted, source, map(str, known))


def _in_sections(errors: Sequence[ErrorDetails], config: Any) -> list[Mistake]:
    """Mistakes within sections, those nearest to the top of the file first.

    What is wrong there explains what follows, and an unknown key may be the misspelled one that is
    missing.
    """
    unknown: defaultdict[tuple[str | int, ...], list[str | int]] = defaultdict(list)
    missing: defaultdict[tuple[str | int, ...], list[str | int]] = defaultdict(list)
    others = []
    for error in errors:
        loc = error["loc"]
        if error["type"] in ("extra_forbidden", "invalid_key"):
            unknown[loc[:-1]].append(loc[-1])
        elif error["type"] == "missing":
            missing[loc[:-1]].append(loc[-1])
        else:
            others.append(_value_mistake(error, config))
    mistakes = [
        *(_unknown_keys(loc, keys) for loc, keys in unknown.items()),
        *(_missing_keys(loc, keys) for loc, keys in missing.items()),
        *others,
    ]
    return sorted(mistakes, key=lambda mistake: len(mistake.location))


def _unknown_keys(section: Sequence[str | int], keys: Sequence[str | int]) -> Mistake:
    place = place_of(section)
    text = f"unknown key {', '.join(map(repr, keys))}; allowed: {', '.join(sorted(place.keys))}"
    return Mistake(location=place.location, text=text, key=keys[0])


def _missing_keys(section: Sequence[str | int], keys: Sequence[str | int]) -> Mistake:
    location = place_of(section).location
    allowed = f"; allowed: {place_of([*section, *keys]).allowed}" if len(keys) == 1 else ""
    return Mistake(location=location, text=f"missing {', '.join(map(repr, keys))}{allowed}")


def _value_mistake(error: ErrorDetails, config: Any) -> Mistake:
    """Mistake of a value, or of a section that is none or has no kind."""
    place = place_of(error["loc"])
    location, allowed, value = place.location, place.allowed, _written(error, config)
    if place.kinds and isinstance(value, Mapping):
        allowed = f"{', '.join(place.kinds[:-1])} or {place.kinds[-1]}"
        if "kind" not in value:
            return Mistake(location=location, text=f"missing 'kind'; allowed: {allowed}")
        location, value = (*location, "kind"), value["kind"]
    if error["type"] == "value_error":
        reason = str(error["ctx"]["error"])
    else:
        reason = f"allowed: {allowed}"
    text = f"{spell_value(value)} is not allowed{_hint(error)}; {reason}"
    return Mistake(location=location, text=text)


def _written(error: ErrorDetails, config: Any) -> Any:
    """Value as it is written, where pydantic has what a validator made of it."""
    if not isinstance(error["input"], Decimal):
        return error["input"]
    try:
        return reduce(getitem, place_of(error["loc"]).location, config)
    except KeyError:  # below a name that is no text, of which pydantic has the text alone
        return error["input"]


def _hint(error: ErrorDetails) -> str:
    """Say why a value is no number, although it looks like one."""
    if error["type"] == "finite_number":
        return " (not a finite number)"
    is_text = isinstance(error["input"], str) and error["type"] in ("decimal_type", "int_type")
    return NUMBER_AS_TEXT if is_text and _reads_as_number(error["input"]) else ""


def _reads_as_number(text: str) -> bool:
    try:
        exact(text)
    except ValueError:
        return False
    return True
