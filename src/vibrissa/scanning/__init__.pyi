"""Scans: the clamp moves over a surface in steps, and the tip sticks and slips."""

from . import surfaces as surfaces
from . import textures as textures
from .cycles import move as move
from .cycles import stage_maker as stage_maker
from .cycles import stick_slip as stick_slip
from .periods import Periods as Periods
from .rods import MountedRod as MountedRod
from .scan import Outcome as Outcome
from .scan import Scan as Scan
from .simulation import simulate as simulate
from .slip_model import SlipLaw as SlipLaw
from .slip_model import SlipModel as SlipModel
from .stage import path as path
from .stage import stage_of as stage_of
from .surfaces import Surface as Surface
from .textures import Texture as Texture
