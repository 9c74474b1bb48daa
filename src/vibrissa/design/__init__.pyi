"""Design of the rod of a sensor: requirements, constraints, materials and the search."""

from .candidate import Candidate as Candidate
from .materials import MATERIALS as MATERIALS
from .materials import Material as Material
from .requirements import Requirements as Requirements
from .search import Design as Design
from .search import DesignStatus as DesignStatus
from .search import design as design
