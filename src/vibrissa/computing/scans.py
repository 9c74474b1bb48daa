"""Scans as tables: a row for each step of the clamp, and a row for each period of sticking."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from vibrissa.computing.columns import axis_columns, frequency_values, spell_point, state_values
from vibrissa.computing.rods import SolverSettings, solve
from vibrissa.computing.surfaces import slip_model_of, surface_of
from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.mechanics.mounting import Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Solver, TipMotion
from vibrissa.scanning.cycles import Motion, move_as_far_as_possible, stage_maker
from vibrissa.scanning.response import LOADS
from vibrissa.scanning.scan import Outcome, Scan, TipPhase, TipSide
from vibrissa.scanning.surfaces import Surface
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.vibration import state_frequencies
from vibrissa.study.axes import MOUNTING_AXES, Values
from vibrissa.study.chunks import points_of
from vibrissa.study.surfaces import Variant
from vibrissa.tables.rows import table_of
from vibrissa.tables.schemas import PERIODS, SCANS, SHAPE


class ScanTables(NamedTuple):
    """Rows of a scan: of its steps and of its periods."""

    steps: pa.Table
    periods: pa.Table


def computed_scans(
    scan_name: str,
    axes: Mapping[str, Values],
    surfaces: Sequence[Variant],
    laws: Sequence[Mapping[str, Any]],
    to: Sequence[float] | None,
    cycles: int | None,
    shapes: bool,
    study: str,
    solver: SolverSettings,
    *,
    each_step: bool = True,
) -> Iterator[ScanTables]:
    """Compute the scans of a chunk one after the other, and yield the rows of each.

    Parameters
    ----------
    scan_name : str
        Name of the scans in the study file.
    axes : mapping
        Values of the axes of the rod, and of the step Δx0 (L).
    surfaces : sequence of mapping
        Surfaces of the study, each with one value for each of its axes. A scan that states mu0 has
        a plane for each coefficient.
    laws : sequence of mapping
        Slip laws, each with the values that bear on it.
    to, cycles : optional
        Turning points of the clamp (L), or the number of slips; one of them is None.
    shapes : bool
        Whether to keep the shape of the rod at each step.
    each_step : bool
        Whether to keep all steps; else the last one.
    """
    described = [(variant, surface_of(variant)) for variant in surfaces]
    curve_of: Callable[..., StickingCurve] = partial(_curve_of, solver)
    if len(axes["dx0"]) > 1:
        curve_of = cache(curve_of)  # a rod has scans in several steps
    for rod_and_step in points_of(axes):
        rod = rod_and_step if solver.method.by_step else {**rod_and_step, "dx0": None}
        curve = curve_of(**rod)
        for (variant, surface), law in product(described, laws):
            point = {**rod_and_step, **variant, **law}
            scan = scan_of(point, curve, surface, to=to, cycles=cycles)
            print(scan_name, spell_point(point), scan.status, scan.message)
            yield scan_tables(
                scan_name,
                point,
                scan,
                study=study,
                method=solver.method,
                shapes=shapes,
                each_step=each_step,
                frequencies=solver.frequencies,
            )


def _curve_of(solver: SolverSettings, **rod: Any) -> StickingCurve:
    """Solve the path of a rod alone, as a command does: beside others it differs by rounding."""
    (curve,) = solve([rod], solver, retract=True)
    return curve


def scan_of(
    point: Mapping[str, Any],
    curve: StickingCurve,
    surface: Surface,
    *,
    to: Sequence[float] | None,
    cycles: int | None,
) -> Scan:
    """Compute the scan of a point; without rows where it has no result, with the reason.

    Parameters
    ----------
    point : mapping
        Values of the axes, of the surface and of the slip law.
    """
    if not curve.pieces:
        return Scan.without_rows(Outcome(curve.status), curve.message)
    try:
        motion = Motion(
            make_stage=stage_maker(curve),
            surface=surface,
            model=slip_model_of(point),
            tip_radius=point.get("tip_radius", 0.0),
        )
        return move_as_far_as_possible(motion, point["dx0"], to=to, cycles=cycles)
    except NoResponseError as error:
        return Scan.without_rows(Outcome.OUT_OF_REACH, str(error))
    except ArgumentError as error:
        return Scan.without_rows(Outcome.FAILED, str(error))


def scan_tables(
    scan_name: str,
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
        "study": study,
        "method": method,
        "scan": scan_name,
        **axis_columns(point),
        "status": scan.status,
        "message": scan.message,
    }
    if not len(scan):
        return ScanTables(steps=_table(SCANS, same, {}), periods=_table(PERIODS, same, {}))
    steps = _steps(scan, point, shapes, each_step, frequencies)
    return ScanTables(
        steps=_table(SCANS, same, steps), periods=_table(PERIODS, same, _periods(scan))
    )


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
    scan: Scan, point: Mapping[str, Any], shapes: bool, each_step: bool, frequencies: int
) -> dict[str, Any]:
    rows = slice(None) if each_step else slice(-1, None)
    # Numbers of steps are counted from the slip before; x0 is 0 after the slip of this very step.
    cycle, step, x0 = scan.cycle[rows], scan.step[rows], scan.x0_along_stage[rows]
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
        "height": scan.height,
        "inclination": scan.inclination,
        "apparent_friction": scan.apparent_friction,
        **state_values(state),
        "x0": x0,
        # In place of the same numbers of the state, as commands and notebooks report them: they
        # differ by rounding.
        **dict(zip(LOADS, scan.reactions.T, strict=True)),
        **frequency_values(_frequencies(point, state, frequencies)),
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


def _frequencies(point: Mapping[str, Any], states: StickingState, count: int) -> FloatArray:
    """Compute natural frequencies in all states of a scan, shape (n, count)."""
    if not count:
        return np.empty((len(states), 0))
    mounting = Mounting(**{axis: point[axis] for axis in MOUNTING_AXES})
    line = states.s_c < 1.0
    return state_frequencies(point["theta"], mounting, states, line, count, TipMotion.STICKS)


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
        "height": periods.height,
        "inclination": periods.inclination,
        "apparent_friction": periods.apparent_friction,
        "x0_onset": periods.x0_onset,
        "x0_rest": periods.x0_rest,
        **loads,
        "released": periods.released,
        "dissipated": periods.dissipated,
    }
