"""The signals of a whisker that is moved over a surface, in the units of its rod."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind, Quantity, Units
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.simulation.scanning import SurfaceScan, TipPhase, TipSide, path, simulate
from vibrissa.sensor.simulation.slips import SlipLaw
from vibrissa.sensor.surfaces import Surface
from vibrissa.sensor.transducer import Transducer, transducer_of
from vibrissa.sensor.whisker import Whisker
from vibrissa.wording import counted


@dataclass(frozen=True, eq=False, kw_only=True)
class Signals(Tabular):
    """A scan as a transducer under the clamp records it.

    Attributes
    ----------
    truth : SurfaceScan
        Nondimensional, without noise.
    readings : ndarray, shape (n, 3)
        force_x, force_y and moment_z, in the units in which they are written.
    units : Units
    """

    truth: SurfaceScan
    readings: FloatArray
    units: Units

    def measured(self, transducer: Transducer | str, seed: int = 0) -> "Signals":
        """Replace the exact reactions by the readings of a transducer, with noise of this seed."""
        sensor = transducer_of(transducer, self.units)
        generator = np.random.default_rng([seed, 1])
        return replace(self, readings=sensor.measured(self.readings, generator))

    def __repr__(self) -> str:
        """Numbers of steps and periods, and how the scan ended."""
        truth = self.truth
        said = f"{counted(len(truth), 'step')}, {counted(int(truth.period[-1]), 'period')}"
        return "\n".join(filter(None, (f"{said}, {truth.outcome}", truth.message)))

    def columns(self) -> dict[str, Column]:
        """One row for each step, with units."""
        truth, unit = self.truth, self.units.unit(Kind.LENGTH)
        length, force, moment = (
            self.units.name(kind) for kind in (Kind.LENGTH, Kind.FORCE, Kind.MOMENT)
        )
        force_x, force_y, moment_z = self.readings.T
        return {
            "footpoint": Column(truth.clamp * unit, length, "position of the clamp"),
            "force_x": Column(force_x, force, "clamp force along the surface"),
            "force_y": Column(force_y, force, "clamp force normal to the surface"),
            "moment_z": Column(moment_z, moment, "clamp moment"),
            "contact": Column(truth.contact * unit, length, "position of the tip"),
            "x0": Column(truth.x0 * unit, length, "clamp displacement from the alpha = 0 state"),
            "mu0": Column(truth.mu0, "1", "static friction under the tip"),
            "period": Column(truth.period, "1", "number of the period of sticking"),
            "phase": Column(truth.phase, "", ", ".join(TipPhase)),
            "side": Column(truth.side, "", "where the tip is: " + " or ".join(TipSide)),
        }


def scan(
    whisker: Whisker,
    surface: Surface,
    *,
    step: Quantity,
    to: Sequence[Quantity],
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
) -> Signals:
    """Move the clamp over a surface and record the signals.

    Parameters
    ----------
    whisker : Whisker
    surface : Surface
    step : str or number
        Step of the stage.
    to : sequence of str or number
        Where the stage turns, and at last stops.
    law : SlipLaw
        Where a slip ends.
    kinetic_ratio : float
        μk/μ0, for the laws ``kinetic`` and ``energy``.

    Returns
    -------
    Signals
        The exact reactions; `Signals.measured` makes them readings.

    Raises
    ------
    ArgumentError
        If an argument is out of range, or the tip leaves the known part of the surface.
    """
    units = whisker.units
    positions = path(
        units.read_positive(step, Kind.LENGTH, "step"),
        [units.read(turn, Kind.LENGTH, "to") for turn in to],
    )
    truth = simulate(
        whisker.stage(positions), replace(surface, units=units), positions, law, kinetic_ratio
    )
    return Signals(truth=truth, readings=truth.reactions * units.channels, units=units)
