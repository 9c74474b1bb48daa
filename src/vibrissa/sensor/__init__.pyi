"""Identification of friction from signals of the clamp, and signals of simulated scans."""

from .identification.findings import Findings as Findings
from .identification.friction_summary import FrictionSummary as FrictionSummary
from .identification.identify import identify as identify
from .identification.periods import Grade as Grade
from .identification.periods import Periods as Periods
from .identification.periods import PeriodStatus as PeriodStatus
from .identification.profile import ContactProfile as ContactProfile
from .identification.recording import Recording as Recording
from .identification.result import Identification as Identification
from .location import Located as Located
from .location import locate as locate
from .measured import MeasuredRod as MeasuredRod
from .measured import measured_rod as measured_rod
from .onset import WhiskerOnset as WhiskerOnset
from .onset import solve as solve
from .setup import Setup as Setup
from .signals import Signals as Signals
from .signals import scan as scan
from .transducer import Transducer as Transducer
from .transducer import preset as preset
from .whisker import Whisker as Whisker
