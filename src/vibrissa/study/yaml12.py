"""Texts of study files, and of values given beside them, as YAML 1.2.

Snakemake reads them by other rules first: as YAML 1.1, in which ``010`` is 8, or as Python numbers.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import ScalarNode
from ruamel.yaml.resolver import VersionedResolver

from vibrissa.errors import StudyError
from vibrissa.study.sections import shown

_DATE = "tag:yaml.org,2002:timestamp"


class _Resolver(VersionedResolver):
    """Leave 2024_01_15 and 2024-01-15 as texts, as YAML 1.2 has neither such numbers nor dates."""

    def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
        found = super().resolve(kind, value, implicit)
        if kind is ScalarNode and implicit[0] and ("_" in value or str(found) == _DATE):
            return self.DEFAULT_SCALAR_TAG
        return found


def _parsed(text: str) -> Any:
    """Parse a document in YAML 1.2."""
    reader = YAML(typ="safe", pure=True)
    reader.Resolver = _Resolver
    return reader.load(text)


def text_of(path: Path) -> str:
    """Read the text of a study file, in UTF-8.

    Raises
    ------
    StudyError
        If the file cannot be read, or is not a text in UTF-8.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        line = 1 + error.object[: error.start].count(b"\n")
        raise StudyError(
            f"{path}:{line}: not a text in UTF-8 ({error.reason}); save it in this encoding"
        ) from None


def loaded(path: Path, text: str) -> dict[Any, Any]:
    """Parse the text of a study file: keys with values.

    Raises
    ------
    StudyError
        If it is not valid YAML, or has no keys; the message has the file and the line.
    """
    try:
        document = _parsed(text)
    except MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark else ""
        reason = error.problem or error.context
        raise StudyError(f"{path}{line}: not valid YAML: {reason}") from None
    except (YAMLError, ValueError, RecursionError) as error:
        raise StudyError(f"{path}: not valid YAML: {' '.join(str(error).split())}") from None
    if document is None:
        raise StudyError(
            f"{path}: the file is empty; a study file has keys with values, such as 'study: mine'"
        )
    if not isinstance(document, dict):
        raise StudyError(
            f"{path}: a study file has keys with values, such as 'study: mine', got "
            f"{shown(document)}"
        )
    return document


def changes_of(entries: Iterable[str]) -> dict[str, Any]:
    """Parse the entries ``key=value`` of ``--config``, whose values are what they are in a file.

    Raises
    ------
    StudyError
        If a value is not valid YAML.
    """
    found = {}
    for entry in entries:
        key, _, text = entry.partition("=")
        try:
            found[key] = _parsed(text)
        except (YAMLError, ValueError) as error:
            reason = getattr(error, "problem", None) or " ".join(str(error).split())
            raise StudyError(f"--config: {entry}: not valid YAML: {reason}") from None
    return found


def as_written(config: Mapping[str, Any], files: Iterable[Path]) -> Mapping[str, Any]:
    """Return a part of a configuration as YAML 1.2, if one of the files has it.

    Parameters
    ----------
    config : mapping
        The part as Snakemake has it, which reads the files as YAML 1.1.
    """
    for path in files:
        text = text_of(path)
        try:
            by_1_1 = yaml.safe_load(text)
        except yaml.YAMLError:
            continue  # a file of JSON, say, which has one meaning
        for was, now in _pairs(by_1_1, loaded(path, text)):
            if was == config:
                return now
    return config


def _pairs(was: Any, now: Any) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """Yield all mappings of a document with the same mappings of another reading of it."""
    if isinstance(was, Mapping) and isinstance(now, Mapping):
        yield was, now
        for one, other in zip(was.values(), now.values(), strict=True):
            yield from _pairs(one, other)
