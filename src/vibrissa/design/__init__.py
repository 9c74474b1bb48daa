"""The choice of a rod for a sensor: requirements, constraints, materials, the search.

`design` is what the command line does. Stands on `vibrissa.sensor`.

The names below are loaded when first used: who looks up a material does not wait for the search.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.design.materials import MATERIALS, Material
    from vibrissa.design.requirements import Requirements
    from vibrissa.design.result import Design, DesignStatus
    from vibrissa.design.search import design

_HOMES = {
    "MATERIALS": "materials",
    "Design": "result",
    "DesignStatus": "result",
    "Material": "materials",
    "Requirements": "requirements",
    "design": "search",
}

__all__ = ["MATERIALS", "Design", "DesignStatus", "Material", "Requirements", "design"]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
