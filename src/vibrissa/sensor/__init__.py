"""Identification of friction from signals of the clamp, and signals of simulated scans.

The public names are imported when first used.
"""

from typing import TYPE_CHECKING

from vibrissa.lazy import attached

if TYPE_CHECKING:
    from vibrissa.outcomes import Method as Method
    from vibrissa.sensor.identification.identify import identify as identify
    from vibrissa.sensor.identification.periods import Grade as Grade
    from vibrissa.sensor.identification.periods import Periods as Periods
    from vibrissa.sensor.identification.periods import PeriodStatus as PeriodStatus
    from vibrissa.sensor.identification.profile import ContactProfile as ContactProfile
    from vibrissa.sensor.identification.recording import Recording as Recording
    from vibrissa.sensor.identification.result import Identification as Identification
    from vibrissa.sensor.identification.summary import FrictionSummary as FrictionSummary
    from vibrissa.sensor.location import Located as Located
    from vibrissa.sensor.location import locate as locate
    from vibrissa.sensor.measured import MeasuredRod as MeasuredRod
    from vibrissa.sensor.measured import measured_rod as measured_rod
    from vibrissa.sensor.onset import WhiskerOnset as WhiskerOnset
    from vibrissa.sensor.onset import solve as solve
    from vibrissa.sensor.setup import Setup as Setup
    from vibrissa.sensor.signals import Signals as Signals
    from vibrissa.sensor.signals import scan as scan
    from vibrissa.sensor.transducer import Transducer as Transducer
    from vibrissa.sensor.transducer import preset as preset
    from vibrissa.sensor.whisker import Whisker as Whisker

__getattr__, __all__ = attached(
    __name__,
    {
        "identification.identify": "identify",
        "identification.periods": "Grade PeriodStatus Periods",
        "identification.profile": "ContactProfile",
        "identification.recording": "Method Recording",
        "identification.result": "Identification",
        "identification.summary": "FrictionSummary",
        "location": "Located locate",
        "measured": "MeasuredRod measured_rod",
        "onset": "WhiskerOnset solve",
        "setup": "Setup",
        "signals": "Signals scan",
        "transducer": "Transducer preset",
        "whisker": "Whisker",
    },
)
