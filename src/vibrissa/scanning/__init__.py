"""Scans: the clamp moves over a surface in steps, and the tip sticks and slips.

The public names are imported when first used.
"""

from typing import TYPE_CHECKING

from vibrissa.lazy import attached

if TYPE_CHECKING:
    from vibrissa.scanning import surfaces as surfaces
    from vibrissa.scanning import textures as textures
    from vibrissa.scanning.cycles import move as move
    from vibrissa.scanning.cycles import stage_maker as stage_maker
    from vibrissa.scanning.cycles import stick_slip as stick_slip
    from vibrissa.scanning.periods import Periods as Periods
    from vibrissa.scanning.rods import MountedRod as MountedRod
    from vibrissa.scanning.scan import Outcome as Outcome
    from vibrissa.scanning.scan import Scan as Scan
    from vibrissa.scanning.simulation import simulate as simulate
    from vibrissa.scanning.slip_model import SlipLaw as SlipLaw
    from vibrissa.scanning.slip_model import SlipModel as SlipModel
    from vibrissa.scanning.stage import path as path
    from vibrissa.scanning.stage import stage_of as stage_of
    from vibrissa.scanning.surfaces import Surface as Surface
    from vibrissa.scanning.textures import Texture as Texture

__getattr__, __all__ = attached(
    __name__,
    {
        "cycles": "move stage_maker stick_slip",
        "periods": "Periods",
        "rods": "MountedRod",
        "scan": "Outcome Scan",
        "simulation": "simulate",
        "slip_model": "SlipLaw SlipModel",
        "stage": "path stage_of",
        # Last, as the reference documents the members of a module where it is listed.
        "surfaces": "Surface surfaces",
        "textures": "Texture textures",
    },
)
