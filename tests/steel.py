"""A steel whisker read by a real transducer, as several tests of the sensor use it."""

import numpy as np

from vibrissa.mechanics.rod import Rod
from vibrissa.quantities import series
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor import Recording, Setup, identify, preset
from vibrissa.sensor.tolerances import TOLERABLE

ROD = Rod(2.1e11, 0.8e-3, 0.1)
TRANSDUCER = "nano17-si-12-0.12"
SENSOR = preset(TRANSDUCER)
SCALE = Units(ROD).channels
# Tests in units of the rod have the noise of a rod of 1 mm; that it would yield is nothing to them.
STIFF = Units(Rod(2.1e11, 1e-3, 0.1)).channels
NOISE = np.array(SENSOR.deviation) / STIFF

# The same on the command line.
SI = ["--modulus", "210 GPa", "--diameter", "0.8 mm", "--length", "100 mm"]
WHISKER = ["--theta", "2", "--eta", "0.85"]
NANO = ["--transducer", TRANSDUCER]


def measured(reactions, seed):
    """Readings of clamp reactions, both nondimensional."""
    return SENSOR.measured(reactions * STIFF, np.random.default_rng(seed)) / STIFF


def recording_of(clamp, readings, first_line=2):
    """A recording of which nothing was left out."""
    return Recording(clamp=clamp, readings=readings, line=np.arange(len(clamp)) + first_line)


def identified(whisker, recording, method=None, slip_time=None, delay=None, **stated):
    """Friction by a whisker in numbers, or without one; `stated` is stated of the set-up, too."""
    setup = setup_of(whisker, **stated)
    return identify(setup, recording, method=method, slip_time=slip_time, delay=delay)


def setup_of(whisker, noise=None, tolerances=None, **stated):
    """A set-up that states in words what a whisker, or none, holds in numbers."""
    if noise is not None and not isinstance(noise, str):
        noise = ", ".join(map(repr, np.asarray(noise, dtype=float).tolist()))
    if whisker is not None:
        stated |= {name: getattr(whisker, name) for name in ("theta", "eta", "contact", "section")}
        for name in ("clamp_angle", "stage_angle"):
            stated[name] = f"{float(getattr(whisker.mounting, name))!r} rad"
        stated["clamp_compliance"] = float(whisker.mounting.clamp_compliance)
        stated["curvature"] = float(whisker.mounting.curvature)
        if (rod := whisker.rod) is not None:
            stated["modulus"] = f"{rod.youngs_modulus!r} Pa"
            stated |= {"diameter": f"{rod.base_diameter!r} m", "length": f"{rod.length!r} m"}
        own = {
            name: f"{size!r} rad" if TOLERABLE[name].kind is Kind.ANGLE else size
            for name, size in whisker.tolerances.items()
        }
        tolerances = own | (tolerances or {})
    return Setup.read(noise=noise, tolerances=tolerances, **stated)


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
    columns = {}
    for (name, unit), value in zip(units.items(), values, strict=True):
        columns[name] = series.Column(value, unit, "")
    series.write(path, Given(columns))
