"""The study file as it is written: its YAML, and every mistake in it with its line."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from vibrissa.errors import StudyError
from vibrissa.study.mistakes import Location, Mistake, at, spell_value
from vibrissa.study.model import Study
from vibrissa.study.parsing import examine

# What YAML 1.1 reads as an octal number, and as one to the base of 60.
OCTAL = re.compile("[-+]?0[0-9_]+")
SIXTIES = ":"


@dataclass(frozen=True, kw_only=True)
class Written:
    """A study file as it is written.

    Attributes
    ----------
    name : str
        Of the file, for messages.
    config : dict
        What YAML reads.
    node : yaml.MappingNode
        The same with the lines.
    mistakes : tuple of Mistake
        What YAML would read as something else than it looks like.
    """

    name: str
    config: dict[str, Any]
    node: yaml.MappingNode
    mistakes: tuple[Mistake, ...]

    def line(self, location: Location) -> int:
        """Line of a place, or of what is nearest above it (from 1; 0 of the file as a whole)."""
        node, line = self.node, 0
        for step in location:
            if isinstance(node, yaml.MappingNode):
                found = [pair for pair in node.value if pair[0].value == str(step)]
                if not found:
                    break
                key, node = found[-1]
                line = key.start_mark.line + 1
            elif isinstance(node, yaml.SequenceNode) and isinstance(step, int):
                node = node.value[step]
                line = node.start_mark.line + 1
        return line

    def line_of(self, mistake: Mistake) -> int:
        """Line of a mistake."""
        return mistake.line or self.line(mistake.path)

    def spell(self, mistake: Mistake) -> str:
        """Message of a mistake with file and line."""
        line = self.line_of(mistake)
        return f"{self.name}:{line}: {mistake}" if line else f"{self.name}: {mistake}"

    def has(self, mistake: Mistake, config: Mapping[str, Any]) -> bool:
        """Whether a mistake of what is to be run is in the file, and not in what changes it."""
        return not mistake.path or at(self.config, mistake.path) == at(config, mistake.path)


def read_study(paths: Sequence[Path], config: Mapping[str, Any] | None = None) -> Study:
    """Read a study file.

    Parameters
    ----------
    paths : sequence of Path
        The file; of several none is the study.
    config : mapping, optional
        What is to be run, where it is not all from the file: the command line may change a key. Of
        a workflow that has this one as a module the file is another, with other keys.

    Returns
    -------
    Study

    Raises
    ------
    StudyError
        If something is wrong, with a line for each mistake: file, line, key, value and what is
        allowed.
    """
    files = [read_yaml(path) for path in paths]
    if config is None:
        config = files[0].config
    files = [file for file in files if file.config.keys() <= config.keys()]
    if len(files) > 1:
        names = ", ".join(file.name for file in files)
        raise StudyError(
            f"{len(files)} study files are given ({names}); one is allowed: run them one after the "
            "other, or put what differs after --config"
        )
    study, mistakes = examine(config)
    written = files[0] if files else None
    if written is None:
        told = list(map(str, mistakes))
    else:
        inside = [mistake for mistake in mistakes if written.has(mistake, config)]
        told = [f"--config: {mistake}" for mistake in mistakes if mistake not in inside]
        told += map(written.spell, sorted([*inside, *written.mistakes], key=written.line_of))
    if study is None or told:
        raise StudyError(*told)
    return study


def read_yaml(path: Path) -> Written:
    """Read the YAML of a study file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Written

    Raises
    ------
    StudyError
        If there is no such file, or it has no keys.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise StudyError(f"No such study file: {path}") from None
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise StudyError(f"{path} is not a text in UTF-8: {error.reason}") from None
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        if node is None:
            raise StudyError(f"{path} is empty; a study file has at least the keys study and grids")
        if not isinstance(node, yaml.MappingNode):
            raise StudyError(
                f"{path}:{node.start_mark.line + 1}: {_kind(node)} is not allowed; a study file "
                "has keys with values, such as 'study: mine'"
            )
        mistakes = tuple(_unclear(node, (), (), set()))
        # This puts what << merges in its place.
        config = {} if _recursive(mistakes) else loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark else ""
        what = ", ".join(filter(None, (error.context, error.problem)))
        raise StudyError(f"{path}{line}: not valid YAML: {' '.join(what.split())}") from None
    except (yaml.YAMLError, ValueError) as error:
        text = " ".join(str(error).split())
        raise StudyError(f"{path}: not valid YAML: {text}") from None
    except RecursionError:
        raise StudyError(f"{path}: not valid YAML: too many sections within sections") from None
    found = Written(name=str(path), config=config, node=node, mistakes=mistakes)
    if _recursive(mistakes):
        raise StudyError(*map(found.spell, mistakes))
    return found


def _kind(node: yaml.Node) -> str:
    return "a list" if isinstance(node, yaml.SequenceNode) else spell_value(node.value)


@dataclass(frozen=True, kw_only=True)
class _Recursion(Mistake):
    """An anchor within what it stands for, of which no value can be made."""


def _recursive(mistakes: Sequence[Mistake]) -> bool:
    return any(isinstance(mistake, _Recursion) for mistake in mistakes)


def _unclear(
    node: yaml.Node, location: Location, above: tuple[int, ...], seen: set[int]
) -> Iterator[Mistake]:
    """Find keys that stand twice, anchors within themselves, and numbers that look like others.

    `above` are the nodes that lead to this one, and `seen` all those that were looked at.
    """
    if id(node) in above:
        text = "an anchor stands within what it names; allowed: after it"
        yield _Recursion(location=location, text=text)
        return
    if id(node) in seen:
        return
    seen.add(id(node))
    above = (*above, id(node))
    if isinstance(node, yaml.ScalarNode):
        if text := _misread(node):
            yield Mistake(location=location, text=text, line=node.start_mark.line + 1)
    elif isinstance(node, yaml.SequenceNode):
        for i, value in enumerate(node.value):
            yield from _unclear(value, (*location, i), above, seen)
    else:
        yield from _repeated(node, location)
        for key, value in node.value:
            name = key.value if isinstance(key, yaml.ScalarNode) else str(key.tag)
            yield from _unclear(value, (*location, name), above, seen)


def _repeated(node: yaml.MappingNode, location: Location) -> Iterator[Mistake]:
    """Find keys that stand twice; YAML would silently take the last."""
    lines: dict[Any, int] = {}
    for key, _ in node.value:
        if not isinstance(key, yaml.ScalarNode):
            continue
        line = key.start_mark.line + 1
        if key.value in lines:
            text = (
                f"{key.value!r} stands twice, in lines {lines[key.value]} and {line}; a key is "
                "allowed once"
            )
            yield Mistake(location=location, text=text, line=line)
        lines[key.value] = line


def _misread(node: yaml.ScalarNode) -> str:
    """Say what YAML makes of a number, if not what a reader does."""
    if node.style is not None or not node.tag.endswith((":int", ":float")):
        return ""
    if not (SIXTIES in node.value or (node.tag.endswith(":int") and OCTAL.fullmatch(node.value))):
        return ""
    number = yaml.safe_load(node.value)
    return (
        f"{node.value} is not allowed, as YAML reads it as {number:g}; write the number in decimal "
        "digits, without leading zeros, or a text in quotes"
    )


def retyped(value: Any) -> Any:
    """Read numbers in a section that was given on the command line.

    Snakemake (9.27) leaves all values within a section after ``--config`` as texts.
    """
    if isinstance(value, Mapping):
        return {key: _scalar(part) for key, part in value.items()}
    return [_scalar(part) for part in value] if isinstance(value, list) else value


def _scalar(part: Any) -> Any:
    return as_text_says(part) if isinstance(part, str) else retyped(part)


def as_text_says(text: str) -> Any:
    """Read a text as YAML does, unless a number looks like another or it is no YAML."""
    try:
        node = yaml.compose(text, yaml.SafeLoader)
        misread = isinstance(node, yaml.ScalarNode) and _misread(node)
        return text if misread else yaml.safe_load(text)
    except yaml.YAMLError:
        return text
