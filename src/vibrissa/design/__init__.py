"""Design of the rod of a sensor: requirements, constraints, materials and the search.

The command line calls `design`. This package builds on `vibrissa.sensor`.
"""

from vibrissa.design import materials
from vibrissa.design.candidate import Candidate
from vibrissa.design.materials import Material
from vibrissa.design.requirements import Requirements
from vibrissa.design.search import Design, DesignStatus, design

__all__ = ["MATERIALS", "Candidate", "Design", "DesignStatus", "Material", "Requirements", "design"]

MATERIALS = materials.MATERIALS
"""Materials by name, such as ``music-wire``."""
