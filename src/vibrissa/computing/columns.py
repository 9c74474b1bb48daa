"""Columns that several tables have: values of the axes, states and natural frequencies."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sticking.piece import StickingState
from vibrissa.study.axes import AXES, FREQUENCIES, LAW_AXES, POWERS, SURFACE_AXES, sortable
from vibrissa.study.chunks import spell_powers
from vibrissa.tables.schemas import STATE


def axis_columns(point: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the axes of a scan by column; None for axes that it does not have."""
    powers = {column: spell_powers(point[axis]) for axis, column in POWERS.items()}
    values = {**point, **powers, **{axis: sortable(point[axis])[0] for axis in POWERS}}
    keys = (*AXES, *POWERS.values(), "surface", *SURFACE_AXES, *LAW_AXES)
    return {key: values.get(key) for key in keys}


def spell_point(point: Mapping[str, Any]) -> str:
    """Format the values of a scan for its log."""
    shown = {key: value for key, value in point.items() if value not in (None, 0.0)}
    return ", ".join(f"{key} {value}" for key, value in shown.items() if key != "content")


def state_values(state: StickingState, suffix: str = "") -> dict[str, Any]:
    """Return the values of states for the columns `STATE`, whose names get the `suffix`."""
    return {f"{column.name}{suffix}": getattr(state, column.name) for column in STATE}


def frequency_values(frequencies: FloatArray) -> dict[str, FloatArray]:
    """Return the values for the columns `FREQUENCIES` of n states, from an array (n, count).

    Columns beyond `count` are NaN.
    """
    missing = np.full(len(frequencies), np.nan)
    columns = [*frequencies.T, *[missing] * len(FREQUENCIES)]
    return dict(zip(FREQUENCIES, columns, strict=False))
