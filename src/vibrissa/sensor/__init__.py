"""Identification of friction from signals of the clamp, and simulation of these signals.

The public names are imported when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.sensor import surfaces as surfaces
    from vibrissa.sensor.identification.identify import identify as identify
    from vibrissa.sensor.identification.periods import Grade as Grade
    from vibrissa.sensor.identification.periods import Periods as Periods
    from vibrissa.sensor.identification.periods import PeriodStatus as PeriodStatus
    from vibrissa.sensor.identification.recording import Method as Method
    from vibrissa.sensor.identification.recording import Recording as Recording
    from vibrissa.sensor.identification.result import Identification as Identification
    from vibrissa.sensor.identification.summary import FrictionSummary as FrictionSummary
    from vibrissa.sensor.onset import WhiskerOnset as WhiskerOnset
    from vibrissa.sensor.onset import solve as solve
    from vibrissa.sensor.setup import Setup as Setup
    from vibrissa.sensor.simulation.scanning import Signals as Signals
    from vibrissa.sensor.simulation.scanning import SurfaceScan as SurfaceScan
    from vibrissa.sensor.simulation.scanning import scan as scan
    from vibrissa.sensor.simulation.tip import SlipLaw as SlipLaw
    from vibrissa.sensor.surfaces import Surface as Surface
    from vibrissa.sensor.transducer import Transducer as Transducer
    from vibrissa.sensor.transducer import preset as preset
    from vibrissa.sensor.whisker import Whisker as Whisker

_HOMES = {
    "FrictionSummary": "identification.summary",
    "Grade": "identification.periods",
    "Identification": "identification.result",
    "Method": "identification.recording",
    "PeriodStatus": "identification.periods",
    "Periods": "identification.periods",
    "Recording": "identification.recording",
    "Setup": "setup",
    "Signals": "simulation.scanning",
    "SlipLaw": "simulation.tip",
    "Surface": "surfaces",
    "SurfaceScan": "simulation.scanning",
    "Transducer": "transducer",
    "Whisker": "whisker",
    "WhiskerOnset": "onset",
    "identify": "identification.identify",
    "preset": "transducer",
    "scan": "simulation.scanning",
    "solve": "onset",
}

__all__ = [*_HOMES, "surfaces"]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name == "surfaces":
        return import_module(f"{__name__}.surfaces")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
