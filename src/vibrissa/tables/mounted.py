"""How a rod is mounted, from the key of its curve and in the columns of the tables."""

from functools import lru_cache
from typing import Any

from vibrissa.decimals import SPELLINGS, Value, exact, spell
from vibrissa.mechanics.mounting import Mounting
from vibrissa.study.grid import MOUNTING_AXES
from vibrissa.tables.schemas import CURVATURE_POWERS

# Columns in the order in which tables are sorted.
MOUNTING_COLUMNS = (*MOUNTING_AXES[:3], CURVATURE_POWERS.name, *MOUNTING_AXES[3:])


@lru_cache(SPELLINGS)
def mounting_of(values: tuple[Value, ...]) -> Mounting:
    """How a rod is mounted, from the exact values of `MOUNTING_AXES`."""
    return Mounting(**dict(zip(MOUNTING_AXES, map(_numbers, values), strict=True)))


def _numbers(value: Value) -> Any:
    return tuple(map(float, value)) if isinstance(value, tuple) else float(value)


def mounting_row(mounting: Mounting) -> dict[str, float | str | None]:
    """Return what `MOUNTING_COLUMNS` hold of a rod."""
    constant, *powers = mounting.coefficients
    return {
        "clamp_angle": mounting.clamp_angle,
        "clamp_compliance": mounting.clamp_compliance,
        "curvature": constant,
        CURVATURE_POWERS.name: spell(tuple(map(exact, powers))) or None,
        "stage_angle": mounting.stage_angle,
    }
