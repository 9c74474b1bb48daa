"""Design of the rod of a sensor: requirements, constraints, materials and the search.

The command line calls `design`. This package builds on `vibrissa.sensor`. The public names are
imported when first used.
"""

from typing import TYPE_CHECKING

from vibrissa.lazy import attached

if TYPE_CHECKING:
    from vibrissa.design.candidate import Candidate as Candidate
    from vibrissa.design.materials import MATERIALS as MATERIALS
    from vibrissa.design.materials import Material as Material
    from vibrissa.design.requirements import Requirements as Requirements
    from vibrissa.design.search import Design as Design
    from vibrissa.design.search import DesignStatus as DesignStatus
    from vibrissa.design.search import design as design

__getattr__, __all__ = attached(
    __name__,
    {
        "candidate": "Candidate",
        "materials": "MATERIALS Material",
        "requirements": "Requirements",
        "search": "Design DesignStatus design",
    },
)
