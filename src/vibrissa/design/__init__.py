"""The choice of a rod for a sensor: requirements, limits, materials, the search.

`design` is what the command line does. Stands on `vibrissa.sensor`.
"""

from vibrissa.design.materials import MATERIALS
from vibrissa.design.reading import read_requirements
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import Design, DesignStatus
from vibrissa.design.search import design

__all__ = [
    "MATERIALS",
    "Design",
    "DesignStatus",
    "Requirements",
    "design",
    "read_requirements",
]
