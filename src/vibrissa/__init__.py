"""Vibrissa: how a whisker-like tactile sensor sticks to and slips over a surface.

The names below are loaded when first used: whoever needs only the study grid or the table schema
does not wait for the solvers.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.api import (
        EquilibriumState,
        Onset,
        solve_curve,
        solve_onset,
        solve_state,
    )
    from vibrissa.curve import StickingCurve, StickingState
    from vibrissa.cycles import Scan, stick_slip
    from vibrissa.status import Status
    from vibrissa.units import Rod

__version__ = "0.1.0"

_HOMES = {
    "EquilibriumState": "api",
    "Onset": "api",
    "solve_curve": "api",
    "solve_onset": "api",
    "solve_state": "api",
    "StickingCurve": "curve",
    "StickingState": "curve",
    "Scan": "cycles",
    "stick_slip": "cycles",
    "Status": "status",
    "Rod": "units",
}

__all__ = [
    "EquilibriumState",
    "Onset",
    "Rod",
    "Scan",
    "Status",
    "StickingCurve",
    "StickingState",
    "solve_curve",
    "solve_onset",
    "solve_state",
    "stick_slip",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
