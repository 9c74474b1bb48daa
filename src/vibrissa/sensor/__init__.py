"""From signals of the clamp to friction, and from friction to signals.

`solve`, `scan` and `identify` are what the command line does. Knows rods and their response; no
study, no tables of a study.
"""

from vibrissa.sensor.identification.calibration import Unknown
from vibrissa.sensor.identification.friction import Periods, PeriodStatus
from vibrissa.sensor.identification.identify import Identification, identify
from vibrissa.sensor.identification.recording import Method, Recording
from vibrissa.sensor.onset import WhiskerOnset, solve
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.response.branch import Response, respond
from vibrissa.sensor.scanning import SurfaceScan, path, simulate
from vibrissa.sensor.signals import Signals, scan
from vibrissa.sensor.slips import SlipLaw
from vibrissa.sensor.surfaces import Surface
from vibrissa.sensor.transducer import Transducer, preset
from vibrissa.sensor.whisker import Whisker

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
