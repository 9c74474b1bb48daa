"""From signals of the clamp to friction, and from friction to signals.

`solve`, `scan` and `identify` are what the command line does. Knows rods and their response; no
study, no tables of a study. The names below are loaded when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibrissa.sensor.identification.calibration import Unknown
    from vibrissa.sensor.identification.friction import Periods, PeriodStatus
    from vibrissa.sensor.identification.identify import Identification, identify
    from vibrissa.sensor.identification.recording import Method, Recording
    from vibrissa.sensor.onset import WhiskerOnset, solve
    from vibrissa.sensor.quantities import Units
    from vibrissa.sensor.response import Response, respond
    from vibrissa.sensor.scanning import SurfaceScan, path, simulate
    from vibrissa.sensor.signals import Signals, scan
    from vibrissa.sensor.slips import SlipLaw
    from vibrissa.sensor.surfaces import Surface
    from vibrissa.sensor.transducer import Transducer, preset
    from vibrissa.sensor.whisker import Whisker

_HOMES = {
    "identification.calibration": ("Unknown",),
    "identification.friction": ("PeriodStatus", "Periods"),
    "identification.identify": ("Identification", "identify"),
    "identification.recording": ("Method", "Recording"),
    "onset": ("WhiskerOnset", "solve"),
    "quantities": ("Units",),
    "response": ("Response", "respond"),
    "scanning": ("SurfaceScan", "path", "simulate"),
    "signals": ("Signals", "scan"),
    "slips": ("SlipLaw",),
    "surfaces": ("Surface",),
    "transducer": ("Transducer", "preset"),
    "whisker": ("Whisker",),
}

__all__ = [
    "Identification",
    "Method",
    "PeriodStatus",
    "Periods",
    "Recording",
    "Response",
    "Signals",
    "SlipLaw",
    "Surface",
    "SurfaceScan",
    "Transducer",
    "Units",
    "Unknown",
    "Whisker",
    "WhiskerOnset",
    "identify",
    "path",
    "preset",
    "respond",
    "scan",
    "simulate",
    "solve",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
