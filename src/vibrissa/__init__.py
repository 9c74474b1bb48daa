"""Vibrissa: a whisker-like tactile sensor that sticks to a surface and slips.

Each public name is imported from its module when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.mechanics.mounting import Mounting as Mounting
    from vibrissa.mechanics.rod import Rod as Rod
    from vibrissa.outcomes import Status as Status
    from vibrissa.sticking.api import EquilibriumState as EquilibriumState
    from vibrissa.sticking.api import FrictionRange as FrictionRange
    from vibrissa.sticking.api import Onset as Onset
    from vibrissa.sticking.api import friction_from_travel as friction_from_travel
    from vibrissa.sticking.api import solve_curve as solve_curve
    from vibrissa.sticking.api import solve_onset as solve_onset
    from vibrissa.sticking.api import solve_state as solve_state
    from vibrissa.sticking.curve import StickingCurve as StickingCurve
    from vibrissa.sticking.cycles import Scan as Scan
    from vibrissa.sticking.cycles import stick_slip as stick_slip
    from vibrissa.sticking.piece import StickingState as StickingState
    from vibrissa.tables.frames import read_table as read_table

__version__ = "0.1.0"

_HOMES = {
    "EquilibriumState": "sticking.api",
    "FrictionRange": "sticking.api",
    "Onset": "sticking.api",
    "friction_from_travel": "sticking.api",
    "solve_curve": "sticking.api",
    "solve_onset": "sticking.api",
    "solve_state": "sticking.api",
    "StickingCurve": "sticking.curve",
    "StickingState": "sticking.piece",
    "Scan": "sticking.cycles",
    "stick_slip": "sticking.cycles",
    "Status": "outcomes",
    "Mounting": "mechanics.mounting",
    "Rod": "mechanics.rod",
    "read_table": "tables.frames",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
