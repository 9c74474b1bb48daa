"""Reading of a study file; its mistakes are reported together, with lines and allowed values."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import date
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError
from pydantic_core import ErrorDetails
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from vibrissa.errors import StudyError
from vibrissa.study.json_schema import allowed_at
from vibrissa.study.model import Study
from vibrissa.study.sections import NAME_ALLOWED, Mistake, in_words, shown
from vibrissa.study.yaml12 import loaded, text_of

# Prefix of top-level keys that only hold YAML anchors.
FOR_ANCHORS = "x-"
Location = tuple[str | int, ...]


def read_study(
    path: Path | None,
    changes: Mapping[str, Any] | None = None,
    check: Callable[[Study], Iterable[Mistake]] | None = None,
) -> Study:
    """Read a study file (YAML 1.2).

    Parameters
    ----------
    path : Path or None
        The file; None if all keys are in `changes`, as in a workflow that includes this one.
    changes : mapping, optional
        Values that replace those of top-level keys, as given with ``--config``.
    check : callable, optional
        Finds further mistakes, by code that this package does not import.

    Raises
    ------
    StudyError
        If there are mistakes: one line for each, with file, line, key, value and what is allowed.
    """
    changes = dict(changes or {})
    text = text_of(path) if path else yaml.safe_dump(changes, sort_keys=False)
    written = (loaded(path, text) if path else {}) | changes
    changed = "".join(f"# --config {key}={value}\n" for key, value in changes.items() if path)
    # Keys that only hold anchors are left out.
    sections = {key: written[key] for key in written if not str(key).startswith(FOR_ANCHORS)}
    folder = path.parent if path else Path()
    context = {"written": written, "text": text + changed, "folder": folder}
    mistakes: Iterable[Mistake] = ()
    try:
        study = Study.model_validate(sections, context=context)
        mistakes = check(study) if check else ()
    except ValidationError as error:
        mistakes = [found for one in error.errors() for found in _in_words(one)]
    if mistakes := list(mistakes):
        document, lines = YAML().load(text), []
        elsewhere = "--config" if path else "config"
        for location, mistake in mistakes:
            is_changed = not path or (bool(location) and location[0] in changes)
            line = 0 if is_changed else _line(document, location)
            where = elsewhere if is_changed else f"{path}:{line}" if line else str(path)
            place = f"{spell_location(location)}: " if location else ""
            lines.append((line, f"{where}: {place}{mistake}"))
        lines.sort(key=lambda one: one[0])
        raise StudyError("\n".join(text for _, text in lines))
    return study


def name_in(path: Path) -> str:
    """Return the study's name from a file, which may have mistakes; empty if it has no name."""
    return str(loaded(path, text_of(path)).get("study", ""))


def _line(document: Any, location: Location) -> int:
    """Return the line of a location or of its nearest parent; 0 for the whole file."""
    line = 0
    for step in location:
        if isinstance(document, CommentedMap) and step in document:
            # A key merged with << has no line here; values below it have their lines at the anchor.
            line = document.lc.key(step)[0] + 1 if step in document.lc.data else line
        elif isinstance(document, CommentedSeq) and isinstance(step, int) and step < len(document):
            line = document.lc.item(step)[0] + 1
        else:
            break
        document = document[step]
    return line


def spell_location(location: Location) -> str:
    """Format a place in the file, as in ``grids.main.theta[1]``."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in location]
    return "".join(parts).removeprefix(".")


def _in_words(error: ErrorDetails) -> Iterator[Mistake]:
    """Convert an error of pydantic to mistakes in plain words, with their places."""
    steps: Location = error["loc"]
    # Pydantic marks keys and the kinds of grids by steps of its own.
    location = tuple(step for step in steps if not str(step).startswith("["))
    *above, last = location or ("",)
    match error["type"]:
        case "mistakes":
            for path, text in error["ctx"]["mistakes"]:
                yield (*location, *path), text
        case "extra_forbidden":
            yield location, f"{last!r} is not a valid key; allowed: {allowed_at(steps[:-1])}"
        case "missing":
            yield tuple(above), f"missing {last!r}"
        case "string_pattern_mismatch" | "invalid_key":
            name = last if above else error["input"]
            yield location, f"{shown(name)} is not allowed; allowed: {NAME_ALLOWED}"
        case "string_type" if isinstance(error["input"], int | float | date):
            yield location, f"{error['input']} is a number or a date; put a text in quotes"
        case _:
            yield location, in_words(error)
