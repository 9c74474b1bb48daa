"""From signals of the clamp to friction, and from friction to signals.

The names below are loaded when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.sensor import surfaces
    from vibrissa.sensor.identification.identify import identify
    from vibrissa.sensor.identification.periods import Grade, Periods, PeriodStatus
    from vibrissa.sensor.identification.recording import Method, Recording
    from vibrissa.sensor.identification.result import Identification
    from vibrissa.sensor.identification.summary import FrictionSummary
    from vibrissa.sensor.onset import WhiskerOnset, solve
    from vibrissa.sensor.quantities import Units
    from vibrissa.sensor.response.branch import Response, respond
    from vibrissa.sensor.setup import Setup
    from vibrissa.sensor.simulation.scanning import SurfaceScan, path, simulate
    from vibrissa.sensor.simulation.signals import Signals, scan
    from vibrissa.sensor.simulation.slips import SlipLaw
    from vibrissa.sensor.surfaces import Surface
    from vibrissa.sensor.transducer import Transducer, preset
    from vibrissa.sensor.whisker import Whisker

_HOMES = {
    "FrictionSummary": "identification.summary",
    "Grade": "identification.periods",
    "Identification": "identification.result",
    "Method": "identification.recording",
    "PeriodStatus": "identification.periods",
    "Periods": "identification.periods",
    "Recording": "identification.recording",
    "Response": "response.branch",
    "Setup": "setup",
    "Signals": "simulation.signals",
    "SlipLaw": "simulation.slips",
    "Surface": "surfaces",
    "SurfaceScan": "simulation.scanning",
    "Transducer": "transducer",
    "Units": "quantities",
    "Whisker": "whisker",
    "WhiskerOnset": "onset",
    "identify": "identification.identify",
    "path": "simulation.scanning",
    "preset": "transducer",
    "respond": "response.branch",
    "scan": "simulation.signals",
    "simulate": "simulation.scanning",
    "solve": "onset",
}

__all__ = [
    "FrictionSummary",
    "Grade",
    "Identification",
    "Method",
    "PeriodStatus",
    "Periods",
    "Recording",
    "Response",
    "Setup",
    "Signals",
    "SlipLaw",
    "Surface",
    "SurfaceScan",
    "Transducer",
    "Units",
    "Whisker",
    "WhiskerOnset",
    "identify",
    "path",
    "preset",
    "respond",
    "scan",
    "simulate",
    "solve",
    "surfaces",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name == "surfaces":
        return import_module(f"{__name__}.surfaces")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
