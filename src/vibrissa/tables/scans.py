"""Scans as tables: a row for each step of the clamp, and a row for each period of sticking."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from vibrissa.errors import ArgumentError, EndedScanError, NoResponseError
from vibrissa.mechanics.mounting import Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, RodSection, Solver, TipMotion
from vibrissa.scanning import surfaces as scanned
from vibrissa.scanning import textures
from vibrissa.scanning.cycles import as_far, move, stages
from vibrissa.scanning.response import LOADS
from vibrissa.scanning.simulation import Outcome, Scan, TipPhase, TipSide
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.textures import Texture
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.vibration import state_frequencies
from vibrissa.study.axes import (
    AXES,
    FRICTION_AXES,
    LAW_AXES,
    MOUNTING_AXES,
    POWERS,
    SURFACE_AXES,
    Values,
    sortable,
)
from vibrissa.study.chunks import points_of, spell_powers
from vibrissa.study.surfaces import Variant, read_heights, read_profile
from vibrissa.tables.records import frequency_values, state_values, table_of
from vibrissa.tables.rods import Rod, solve
from vibrissa.tables.schemas import PERIODS, SCANS, SHAPE


class ScanTables(NamedTuple):
    """Rows of a scan: of its steps and of its periods."""

    steps: pa.Table
    periods: pa.Table


def computed_scans(
    scan: str,
    axes: Mapping[str, Values],
    surfaces: Sequence[Variant],
    laws: Sequence[Mapping[str, Any]],
    to: Sequence[float] | None,
    cycles: int | None,
    shapes: bool,
    study: str,
    *,
    each_step: bool = True,
    method: Solver,
    contact: Contact,
    section: RodSection,
    frequencies: int = 0,
) -> Iterator[ScanTables]:
    """Compute the scans of a chunk one after the other, and yield the rows of each.

    The arguments are those of `vibrissa.study.scans.ScanChunk`, and `frequencies` is the number of
    natural frequencies to compute at each step.
    """
    places = [surface_of(variant) for variant in surfaces]
    for rod in points_of(axes):
        # Solved alone, as a command solves it: together with others it differs by rounding.
        (curve,) = solve([rod], method=method, contact=contact, section=section, retract=True)
        for variant, surface in zip(surfaces, places, strict=True):
            for law in laws:
                radius = variant.get("tip_radius", 0.0)
                found = _moved(curve, surface, rod, law, to=to, cycles=cycles, tip_radius=radius)
                point = {**rod, **variant, **law}
                print(scan, spelled(point), found.status, found.message)
                yield scan_tables(
                    scan,
                    point,
                    found,
                    study=study,
                    method=method,
                    shapes=shapes,
                    each_step=each_step,
                    frequencies=frequencies,
                )


def _moved(
    curve: StickingCurve,
    surface: Surface,
    rod: Rod,
    law: Mapping[str, Any],
    *,
    to: Sequence[float] | None,
    cycles: int | None,
    tip_radius: float,
) -> Scan:
    """Compute a scan; without rows where it has no result, with the reason in its message."""
    if not curve.pieces:
        return Scan.without_rows(Outcome(curve.status), curve.message)
    scan = partial(move, stages(curve), surface, rod["dx0"], tip_radius=tip_radius, **law)
    try:
        return _kept(scan, rod["dx0"], to, cycles)
    except NoResponseError as error:
        return Scan.without_rows(Outcome.OUT_OF_REACH, str(error))
    except ArgumentError as error:
        return Scan.without_rows(Outcome.FAILED, str(error))


def _kept(
    scan: Callable[..., Scan], step: float, to: Sequence[float] | None, cycles: int | None
) -> Scan:
    """Compute a scan, or its steps up to where the tip leaves the surface or the rod's heights."""
    try:
        if to is None:
            return scan(cycles=cycles)
        return as_far(lambda turns: scan(to=turns), step, to)
    except EndedScanError as error:
        found: Scan = error.scan
        return found


def surface_of(variant: Variant) -> Surface:
    """Make the surface that a variant of a study file describes."""
    friction, texture = _friction_of(variant), texture_of(variant)
    return friction if texture is None else friction.with_texture(texture)


def texture_of(variant: Variant) -> Texture | None:
    """Make the heights of a surface, the sum of all that a variant describes; None without any."""
    found = []
    for name, make in (
        ("wave", textures.wave),
        ("grooves", textures.grooves),
        ("rough", textures.rough),
    ):
        prefix = f"{name}_"
        values = {
            axis.removeprefix(prefix): variant[axis] for axis in variant if axis.startswith(prefix)
        }
        if values:
            found.append(make(**values))
    if "heights" in variant:
        found.append(textures.measured(*read_heights(Path(variant["heights"]))))
    if not found:
        return None
    return sum(found[1:], start=found[0]).with_lay(variant.get("lay", 0.0))


def _friction_of(variant: Variant) -> Surface:
    """Make a plane with the friction that a variant describes."""
    if "patches" in variant:
        starts, mu0 = zip(*variant["patches"], strict=True)
        return scanned.patches(starts, mu0)
    if "profile" in variant:
        return scanned.profile(*read_profile(Path(variant["profile"])))
    if "mean" in variant:
        return scanned.random(**{axis: variant[axis] for axis in FRICTION_AXES})
    return scanned.constant(variant["mu0"])


def spelled(point: Mapping[str, Any]) -> str:
    """Format the values of a scan for its log."""
    shown = {key: value for key, value in point.items() if value not in (None, 0.0)}
    return ", ".join(f"{key} {value}" for key, value in shown.items() if key != "content")


def scan_tables(
    name: str,
    point: Mapping[str, Any],
    scan: Scan,
    *,
    study: str,
    method: Solver,
    shapes: bool,
    each_step: bool = True,
    frequencies: int = 0,
) -> ScanTables:
    """Make the rows of a scan; if it has no result, one row in each table.

    Parameters
    ----------
    point : mapping
        Values of the axes, of the surface and of the slip law.
    shapes : bool
        Whether to keep the shape of the rod at each step.
    each_step : bool
        Whether to keep all steps; else the last one.
    frequencies : int
        Number of natural frequencies to compute at each step.
    """
    same = {
        **{"study": study, "method": method, "scan": name},
        **axis_columns(point),
        **{"status": scan.status, "message": scan.message},
    }
    return ScanTables(
        steps=_table(
            SCANS, same, _steps(scan, point, shapes, each_step, frequencies) if len(scan) else {}
        ),
        periods=_table(PERIODS, same, _periods(scan) if len(scan) else {}),
    )


def axis_columns(point: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the axes of a scan by column; None for axes that it does not have."""
    powers = {column: spell_powers(point[axis]) for axis, column in POWERS.items()}
    values = {**point, **powers, **{axis: sortable(point[axis])[0] for axis in POWERS}}
    keys = (*AXES, *POWERS.values(), "surface", *SURFACE_AXES, *LAW_AXES)
    return {key: values.get(key) for key in keys}


def _table(schema: pa.Schema, same: Mapping[str, Any], columns: Mapping[str, Any]) -> pa.Table:
    """Make a table whose rows share some values; one row without further values if it has none."""
    count = len(next(iter(columns.values()))) if columns else 1
    columns = {key: [value] * count for key, value in same.items()} | dict(columns)
    lists = {field.name for field in SHAPE}
    missing: dict[str, list[Any]] = {
        field.name: [[] if field.name in lists else None] * count
        for field in schema
        if field.name not in columns
    }
    return table_of(schema, missing | columns)


def _steps(
    scan: Scan, rod: Mapping[str, Any], shapes: bool, each_step: bool, frequencies: int
) -> dict[str, Any]:
    rows = slice(None) if each_step else slice(-1, None)
    # Numbers of steps and x0 are counted from the slip before.
    cycle, step, since = scan.cycle[rows], scan.step[rows], scan.since[rows]
    scan = scan.take(rows)
    state = scan.state
    columns = {
        "cycle": cycle,
        "step": step,
        "phase": np.where(scan.phase == TipPhase.SLIP, TipPhase.SLIP, TipPhase.STICK),
        "side": scan.side,
        "footpoint": scan.clamp,
        "x1": scan.contact,
        "mu0_tip": scan.mu0,
        "height": scan.lift,
        "inclination": scan.inclination,
        "apparent_friction": scan.apparent_friction,
        **state_values(state),
        "x0": since,
        # As commands and notebooks report them; the state has them to rounding.
        **dict(zip(LOADS, scan.reactions.T, strict=True)),
        **frequency_values(_frequencies(rod, state, frequencies)),
    }
    if not shapes:
        return columns
    found = scan.shapes()
    return columns | {
        "residual": found.residual,
        "shape_s": [found.s] * len(scan),
        "shape_x": list(found.x),
        "shape_y": list(found.y),
        "shape_phi": list(found.phi),
    }


def _frequencies(rod: Mapping[str, Any], states: StickingState, count: int) -> FloatArray:
    """Compute natural frequencies in all states of a scan, shape (n, count)."""
    if not count:
        return np.empty((len(states), 0))
    mounting = Mounting(**{axis: rod[axis] for axis in MOUNTING_AXES})
    line = states.s_c < 1.0
    return state_frequencies(rod["theta"], mounting, states, line, count, TipMotion.STICKS)


def _periods(scan: Scan) -> dict[str, Any]:
    periods = scan.periods
    loads = {
        f"{load}_{end}": values
        for end, found in (("onset", periods.loads_onset), ("rest", periods.loads_rest))
        for load, values in zip(LOADS, found.T, strict=True)
    }
    return {
        "period": periods.period,
        "ends_by": periods.ends_by,
        "side": np.where(periods.side == 1, TipSide.AHEAD, TipSide.BEHIND),
        "steps": periods.steps,
        "footpoint_begin": periods.begin,
        "footpoint_last": periods.last,
        "footpoint_onset": periods.onset,
        "footpoint_slip": periods.slip,
        "travel": periods.travel,
        "x1": periods.contact,
        "x1_rest": periods.contact_rest,
        "slip_length": periods.slip_length,
        "mu0_tip": periods.mu0,
        "height": periods.lift,
        "inclination": periods.inclination,
        "apparent_friction": periods.apparent_friction,
        "x0_onset": periods.x0_onset,
        "x0_rest": periods.x0_rest,
        **loads,
        "released": periods.released,
        "dissipated": periods.dissipated,
    }
