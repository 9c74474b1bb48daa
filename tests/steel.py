"""A steel whisker read by a real transducer, as several tests of the sensor use it."""

import numpy as np

from vibrissa.mechanics.rod import Rod
from vibrissa.sensor import Recording, preset, series
from vibrissa.sensor.quantities import Units

ROD = Rod(2.1e11, 0.8e-3, 0.1)
SENSOR = preset("nano17-si-12-0.12")
SCALE = Units(ROD).channels
# Tests in units of the rod have the noise of a rod of 1 mm; that it would yield is nothing to them.
STIFF = Units(Rod(2.1e11, 1e-3, 0.1)).channels
NOISE = np.array(SENSOR.deviation) / STIFF

# The same on the command line.
SI = ["--modulus", "210 GPa", "--diameter", "0.8 mm", "--length", "100 mm"]
WHISKER = ["--theta", "2", "--eta", "0.85"]
NANO = ["--transducer", "nano17-si-12-0.12"]


def measured(reactions, seed):
    """Readings of clamp reactions, both nondimensional."""
    return SENSOR.measured(reactions * STIFF, np.random.default_rng(seed)) / STIFF


def recording_of(clamp, readings, first_line=2):
    """A recording of which nothing was left out."""
    return Recording(clamp=clamp, readings=readings, line=np.arange(len(clamp)) + first_line)


class Given(series.Tabular):
    """A table of given columns."""

    def __init__(self, columns, header=None):
        self.given, self.above = columns, header or {}

    def columns(self):
        return self.given

    def header(self):
        return self.above


def write(path, recording):
    """Write a recording in units of the rod."""
    units = {"footpoint": "L", "force_x": "E*I0/L^2", "force_y": "E*I0/L^2", "moment_z": "E*I0/L"}
    values = np.column_stack([recording.clamp, recording.readings]).T
    columns = {
        name: series.Column(value, unit, "")
        for (name, unit), value in zip(units.items(), values, strict=True)
    }
    series.write(path, Given(columns))
