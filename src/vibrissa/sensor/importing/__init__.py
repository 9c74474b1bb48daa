"""Conversion of a laboratory's file to a recording that `vibrissa identify` reads.

The layout of the file and its units are found and reported; an ambiguous file is rejected.
"""

from vibrissa.sensor.importing.importing import Imported, import_recording
from vibrissa.sensor.importing.settings import Settings

__all__ = ["Imported", "Settings", "import_recording"]
