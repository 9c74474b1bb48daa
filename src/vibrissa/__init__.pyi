"""Vibrissa: a whisker-like tactile sensor that sticks to a surface and slips."""

from .mechanics.mounting import Mounting as Mounting
from .mechanics.rod import Rod as Rod
from .outcomes import Method as Method
from .outcomes import Status as Status
from .scanning.cycles import stick_slip as stick_slip
from .scanning.scan import Scan as Scan
from .sticking.api import FrictionRange as FrictionRange
from .sticking.api import friction_from_travel as friction_from_travel
from .sticking.api import solve_curve as solve_curve
from .sticking.api import solve_onset as solve_onset
from .sticking.api import solve_state as solve_state
from .sticking.curve import StickingCurve as StickingCurve
from .sticking.onset_table import solve_onsets as solve_onsets
from .sticking.piece import StickingState as StickingState
from .sticking.results import EquilibriumState as EquilibriumState
from .sticking.results import Onset as Onset
from .sticking.vibration import free_frequencies as free_frequencies
from .tables.frames import read_table as read_table

__version__: str
