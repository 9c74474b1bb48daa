"""The choice of a rod for a sensor: requirements, limits, materials, the search.

`design` is what the command line does. Stands on `vibrissa.sensor`. The names below are loaded when
first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.design.materials import MATERIALS
    from vibrissa.design.reading import read_requirements
    from vibrissa.design.requirements import Requirements
    from vibrissa.design.result import Design, DesignStatus
    from vibrissa.design.search import design

_HOMES = {
    "materials": ("MATERIALS",),
    "reading": ("read_requirements",),
    "requirements": ("Requirements",),
    "result": ("Design", "DesignStatus"),
    "search": ("design",),
}

__all__ = [
    "MATERIALS",
    "Design",
    "DesignStatus",
    "Requirements",
    "design",
    "read_requirements",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
