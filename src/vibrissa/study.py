"""The study file: what may stand in it, and one clear message where something else does."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import jsonschema
import yaml

from vibrissa.decimals import exact, spell
from vibrissa.grid import AXES, Grid, axis

# Curves per job, by default at least so many: a collocation curve takes milliseconds, a walk by
# shooting many seconds.
LEAST_BLOCK_SIZE = {"collocation": 64, "shooting": 1}
# Axes of which a figure of a grid shows one value.
FIXED_AXES: dict[str, tuple[str, ...]] = {
    "taper": ("eta", "dx0"),
    "friction": ("theta", "eta", "dx0"),
    "locking": (),
    "regimes": (),
    "law": ("eta", "dx0"),
}
# Values that the paper's statements are about: more may be there, less may not.
CLAIMED: dict[str, dict[str, tuple[str, ...]]] = {
    "taper": {"theta": ("1", "2", "3"), "mu0": ("0.2", "0.3", "0.4")},
    "friction": {"theta": ("2",)},
    "scan": {"theta": ("1", "2", "3"), "mu0": ("0.3", "0.4")},
    "state": {"theta": ("1",), "eta": ("0.55",), "x1": ("0.15",)},
}
# Of these there is one value only, the same for all.
CLAIMED_ONCE: dict[str, tuple[str, ...]] = {"eta": ("0.85",), "dx0": ("0.001",)}
# Bound on the rows of a scan, each of which carries a shape.
LONGEST_SCAN = 1_000_000
# Characters of a value that a message shows.
SHOWN = 60
NUMBER_TEXT = (
    " (YAML reads this as text; write a number without quotes, an exponent with a decimal point: "
    "0.001 or 1.0e-3)"
)


class StudyError(ValueError):
    """A study file that cannot be run; the message names the key, the value and what is allowed."""


@dataclass(frozen=True)
class ScanSet:
    """Stick-slip scans: a grid of them, each with the same number of cycles."""

    grid: Grid
    cycles: int


@dataclass(frozen=True)
class StatePoint:
    """One equilibrium with a given contact point (x1, eta) relative to the clamp."""

    theta: Decimal
    eta: Decimal
    x1: Decimal
    contact: str


@dataclass(frozen=True)
class ComparisonGrid:
    """Points that are solved in both contact models: the product of three axes."""

    theta: tuple[Decimal, ...]
    mu0: tuple[Decimal, ...]
    eta: tuple[Decimal, ...]


@dataclass(frozen=True)
class Study:
    """A checked study.

    Attributes
    ----------
    name : str
        Results go to ``results/<name>/``.
    contact, method : str
        Contact model and solver.
    block_size : int
        Curves that one job solves, at most.
    grids, scans, states, comparisons, figures : dict
        By name.
    claims : dict
        Names of the grids, the scan and the state by which the paper's statements are judged;
        empty where they are not.
    """

    name: str
    contact: str
    method: str
    block_size: int
    grids: dict[str, Grid]
    scans: dict[str, ScanSet]
    states: dict[str, StatePoint]
    comparisons: dict[str, ComparisonGrid]
    figures: dict[str, dict[str, Any]]
    claims: dict[str, str]

    @property
    def solver(self) -> str:
        """Contact model and method in one word: names the folders of what they computed."""
        return f"{self.contact}-{self.method}"

    @property
    def by_step(self) -> bool:
        """Whether a curve belongs to one Δx0: the shooting method walks along its steps."""
        return self.method == "shooting"


def parse_study(config: Mapping[str, Any], schema: Mapping[str, Any]) -> Study:
    """Check a study file and give its values their exact form.

    Parameters
    ----------
    config : mapping
        The study file as YAML reads it.
    schema : mapping
        The JSON Schema of study files.

    Returns
    -------
    Study

    Raises
    ------
    StudyError
        At the first thing that is wrong, with one message.
    """
    _check_schema(config, schema)
    for path, value in _numbers(config):
        try:
            exact(value)
        except ValueError:
            raise StudyError(f"{path}: {value!r} is not allowed; a finite number is") from None
    method = config.get("method", "collocation")
    contact = config.get("contact", "point")
    grids = {name: _grid(f"grids.{name}", axes) for name, axes in config["grids"].items()}
    scans = {
        name: ScanSet(_grid(f"scans.{name}", scan), int(scan["cycles"]))
        for name, scan in config.get("scans", {}).items()
    }
    drawn = [*grids.values(), *(scan.grid for scan in scans.values())]
    study = Study(
        name=config["study"],
        contact=contact,
        method=method,
        block_size=int(config.get("block_size", default_block_size(method, drawn))),
        grids=grids,
        scans=scans,
        states={
            name: StatePoint(
                exact(state["theta"]),
                exact(state["eta"]),
                exact(state["x1"]),
                state.get("contact", contact),
            )
            for name, state in config.get("states", {}).items()
        },
        comparisons={
            name: ComparisonGrid(**_axes(f"comparisons.{name}", axes, AXES[:3]))
            for name, axes in config.get("comparisons", {}).items()
        },
        figures={name: dict(figure) for name, figure in config.get("figures", {}).items()},
        claims=dict(config.get("claims", {})),
    )
    if study.contact == "line" and study.method == "shooting":
        raise StudyError(
            "method: 'shooting' is not allowed with contact: line; allowed: collocation"
        )
    for name, scan in study.scans.items():
        # The clamp moves by less than the rod's length in a cycle.
        rows = scan.cycles / min(scan.grid.dx0)
        if rows > LONGEST_SCAN:
            raise StudyError(
                f"scans.{name}: {scan.cycles} cycles in steps of dx0 = "
                f"{spell(min(scan.grid.dx0))} can take {rows:.1g} steps; allowed: cycles/dx0 up to "
                f"{LONGEST_SCAN:.0e}"
            )
    for name, state in study.states.items():
        if state.x1**2 + state.eta**2 >= 1:
            raise StudyError(
                f"states.{name}: the contact point x1 = {state.x1}, eta = {state.eta} is out of "
                "reach; a rod of length 1 needs x1^2 + eta^2 < 1"
            )
    for name, figure in study.figures.items():
        _check_figure(f"figures.{name}", figure, study)
    if study.claims:
        _check_claims(study)
    return study


def default_block_size(method: str, grids: Iterable[Grid]) -> int:
    """Curves per job where the study file does not say it.

    A larger study has more jobs and longer ones: thirteen times the square root of the number of
    curves makes 25 blocks of 10^5 curves and 244 of 10^7. A smaller one has up to eight, for the
    cores.

    Parameters
    ----------
    method : str
    grids : iterable of Grid
        All that curves are solved for.

    Returns
    -------
    int
    """
    if method == "shooting":
        return LEAST_BLOCK_SIZE[method]
    curves = sum(len(grid.theta) * len(grid.eta) for grid in grids)
    return max(LEAST_BLOCK_SIZE[method], min(math.isqrt(13**2 * curves), -(-curves // 8)))


def refuse_repeated_keys(text: str) -> None:
    """Refuse a study file in which a key stands twice; YAML would silently take the last.

    Parameters
    ----------
    text : str
        The study file.

    Raises
    ------
    StudyError
        With the key and the lines.
    """
    pending: list[yaml.Node | None] = [yaml.compose(text, yaml.SafeLoader)]
    while pending:
        node = pending.pop()
        if isinstance(node, yaml.SequenceNode):
            pending += node.value
        if not isinstance(node, yaml.MappingNode):
            continue
        lines: dict[str, int] = {}
        for key, value in node.value:
            pending.append(value)
            line = key.start_mark.line + 1
            if key.value in lines:
                raise StudyError(
                    f"{key.value!r} stands twice, in lines {lines[key.value]} and {line}; a key is "
                    "allowed once"
                )
            lines[key.value] = line


def _check_schema(config: Mapping[str, Any], schema: Mapping[str, Any]) -> None:
    validator = jsonschema.Draft202012Validator(schema)
    # Nearest to the top of the file first: what is wrong there explains what follows.
    # There, an unknown key may be the misspelled one that is missing.
    errors = sorted(
        validator.iter_errors(config),
        key=lambda e: (len(e.absolute_path), e.validator != "additionalProperties", e.message),
    )
    if not errors:
        return
    error = errors[0]
    path = _spell_path(error.absolute_path) or "the study file"
    allowed = error.schema.get("description", "") if isinstance(error.schema, dict) else ""
    if error.validator == "additionalProperties":
        known = sorted(error.schema.get("properties", {}))
        unknown = [key for key in error.instance if key not in known]
        raise StudyError(
            f"{path}: unknown key {', '.join(map(repr, unknown))}; allowed: {', '.join(known)}"
        )
    if error.validator == "required":
        missing = [key for key in error.validator_value if key not in error.instance]
        raise StudyError(f"{path}: missing {', '.join(map(repr, missing))}; {allowed}".rstrip("; "))
    hint = ""
    if isinstance(error.instance, str) and error.validator == "type":
        hint = NUMBER_TEXT if _reads_as_number(error.instance) else ""
    value = repr(error.instance)
    if len(value) > SHOWN:
        value = f"{value[:SHOWN]}..."
    raise StudyError(f"{path}: {value} is not allowed{hint}; allowed: {allowed or error.message}")


def _reads_as_number(text: str) -> bool:
    try:
        exact(text)
    except ValueError:
        return False
    return True


def _spell_path(path: Any) -> str:
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.lstrip(".")


def _numbers(value: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """All numbers of a study file with their paths."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _numbers(item, f"{path}.{key}".lstrip("."))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, f"{path}[{index}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, value


def _grid(path: str, axes: Mapping[str, Any]) -> Grid:
    return Grid(**_axes(path, axes, AXES))


def _axes(
    path: str, axes: Mapping[str, Any], names: tuple[str, ...]
) -> dict[str, tuple[Decimal, ...]]:
    values = {}
    for name in names:
        try:
            values[name] = axis(axes[name])
        except ValueError as error:
            raise StudyError(f"{path}.{name}: {dict(axes[name])} is not allowed; {error}") from None
    return values


def _check_figure(path: str, figure: Mapping[str, Any], study: Study) -> None:
    """Refuse a figure of something that does not exist, or of several series as one."""
    kind = figure["kind"]
    if kind == "state":
        names = [figure["state"]] if isinstance(figure["state"], str) else figure["state"]
        for name in names:
            _choose(f"{path}.state", name, study.states, "a state")
        return
    grid: Grid | ComparisonGrid
    if kind == "models":
        grid = _choose(
            f"{path}.comparison", figure["comparison"], study.comparisons, "a comparison"
        )
        fixed: tuple[str, ...] = ("eta",)
    elif kind in ("scan", "period", "signals"):
        grid = _choose(f"{path}.scan", figure["scan"], study.scans, "a scan").grid
        fixed = AXES
    else:
        grid = _choose(f"{path}.grid", figure["grid"], study.grids, "a grid")
        fixed = FIXED_AXES[kind]
    for name in fixed:
        values = getattr(grid, name)
        allowed = ", ".join(spell(value) for value in values[:10])
        if name in figure and exact(figure[name]) not in values:
            raise StudyError(
                f"{path}.{name}: {figure[name]!r} is not allowed; the data has {allowed}"
            )
        if name not in figure and len(values) > 1:
            raise StudyError(f"{path}: missing {name!r}; the data has several: {allowed}")


def _check_claims(study: Study) -> None:
    """Refuse to judge the paper's statements by data that are not about what they are about."""
    if study.contact != "point":
        raise StudyError(f"claims: contact: {study.contact!r} is not allowed with it; point is")
    chosen: dict[str, Any] = {
        key: _choose(f"claims.{key}", study.claims[key], study.grids, "a grid")
        for key in ("taper", "friction")
    }
    chosen["scan"] = _choose("claims.scan", study.claims["scan"], study.scans, "a scan").grid
    state = _choose("claims.state", study.claims["state"], study.states, "a state")
    for key, needed in CLAIMED.items():
        once = {} if key == "state" else CLAIMED_ONCE
        for name, wanted in (needed | once).items():
            values = (getattr(state, name),) if key == "state" else getattr(chosen[key], name)
            missing = {exact(value) for value in wanted}.difference(values)
            if missing or (name in once and len(values) > 1):
                raise StudyError(
                    f"claims.{key}: {study.claims[key]!r} has {name} = "
                    f"{', '.join(spell(value) for value in values[:10])}; the paper's statements "
                    f"are about {'only ' * (name in once)}{', '.join(wanted)}"
                )


def _choose(path: str, name: str, named: Mapping[str, Any], what: str) -> Any:
    if name not in named:
        known = ", ".join(sorted(named)) or "none is defined"
        raise StudyError(f"{path}: {name!r} is not the name of {what}; allowed: {known}")
    return named[name]
