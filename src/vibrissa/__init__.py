"""Vibrissa: a whisker-like tactile sensor that sticks to a surface and slips.

Each public name is imported from its module when it is first used.
"""

from typing import TYPE_CHECKING

from vibrissa.lazy import attached

if TYPE_CHECKING:
    from vibrissa.mechanics.mounting import Mounting as Mounting
    from vibrissa.mechanics.rod import Rod as Rod
    from vibrissa.outcomes import Status as Status
    from vibrissa.scanning.cycles import stick_slip as stick_slip
    from vibrissa.scanning.scan import Scan as Scan
    from vibrissa.sticking.api import FrictionRange as FrictionRange
    from vibrissa.sticking.api import friction_from_travel as friction_from_travel
    from vibrissa.sticking.api import solve_curve as solve_curve
    from vibrissa.sticking.api import solve_onset as solve_onset
    from vibrissa.sticking.api import solve_state as solve_state
    from vibrissa.sticking.curve import StickingCurve as StickingCurve
    from vibrissa.sticking.onset_table import solve_onsets as solve_onsets
    from vibrissa.sticking.piece import StickingState as StickingState
    from vibrissa.sticking.results import EquilibriumState as EquilibriumState
    from vibrissa.sticking.results import Onset as Onset
    from vibrissa.sticking.vibration import free_frequencies as free_frequencies
    from vibrissa.tables.frames import read_table as read_table

__version__ = "1.0.0"

__getattr__, __all__ = attached(
    __name__,
    {
        "mechanics.mounting": "Mounting",
        "mechanics.rod": "Rod",
        "outcomes": "Status",
        "scanning.cycles": "stick_slip",
        "scanning.scan": "Scan",
        "sticking.api": "FrictionRange friction_from_travel solve_curve solve_onset solve_state",
        "sticking.curve": "StickingCurve",
        "sticking.onset_table": "solve_onsets",
        "sticking.piece": "StickingState",
        "sticking.results": "EquilibriumState Onset",
        "sticking.vibration": "free_frequencies",
        "tables.frames": "read_table",
    },
)
