"""Conversion of a laboratory's file to a recording that `vibrissa identify` reads.

What the file leaves open is found and reported; an ambiguous file is rejected.
"""

from vibrissa.sensor.importing.importing import Imported, Settings, import_recording

__all__ = ["Imported", "Settings", "import_recording"]
