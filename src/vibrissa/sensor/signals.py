"""Signals of a scan at the clamp, in the units of a real rod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import SlipLaw
from vibrissa.quantities.series import Column, Tabular
from vibrissa.quantities.units import Kind, Quantity, Units
from vibrissa.scanning.cycles import move
from vibrissa.scanning.scan import Scan, TipPhase, TipSide
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.surfaces import Surface
from vibrissa.sensor.transducer import Transducer, transducer_of
from vibrissa.sensor.whisker import Whisker
from vibrissa.wording import counted


@dataclass(frozen=True, eq=False, kw_only=True)
class Signals(Tabular):
    """Signals of a scan at the clamp: `scan` returns them exact, `measured` with noise.

    Attributes
    ----------
    truth : Scan
        States of the scan, nondimensional and without noise.
    readings : ndarray, shape (n, 3)
        Columns force_x, force_y and moment_z in the units that `columns` gives: exact clamp
        reactions, or readings of a transducer.
    units : Units
    about : mapping
        Texts for the header of the table, such as the source of the heights.
    """

    truth: Scan
    readings: FloatArray
    units: Units
    about: Mapping[str, str] = field(default_factory=dict)

    def header(self) -> dict[str, str]:
        """Texts that hold for the whole table."""
        return dict(self.about)

    def measured(self, transducer: Transducer | str, seed: int = 0) -> "Signals":
        """Return a copy with readings of a transducer; `seed` fixes their noise."""
        sensor = transducer_of(transducer, self.units)
        generator = np.random.default_rng([seed, 1])
        return replace(self, readings=sensor.measured(self.readings, generator))

    def __repr__(self) -> str:
        """Numbers of steps and periods, and how the scan ended."""
        truth = self.truth
        counts = f"{counted(len(truth), 'step')}, {counted(int(truth.period[-1]), 'period')}"
        return "\n".join(filter(None, (f"{counts}, {truth.outcome}", truth.message)))

    def columns(self) -> dict[str, Column]:
        """Columns by name, with units; they have one row for each step of the clamp."""
        truth = self.truth
        unit = self.units.unit(Kind.LENGTH)
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
            "height": Column(truth.height * unit, length, "height of the surface under the tip"),
            "inclination": Column(truth.inclination, "rad", "of the surface; < 0 where it rises"),
            "apparent_friction": Column(
                truth.apparent_friction,
                "1",
                "|force_x/force_y| without noise",
            ),
            "period": Column(truth.period, "1", "number of the period of sticking"),
            "phase": Column(truth.phase, "", ", ".join(TipPhase)),
            "side": Column(truth.side, "", "where the tip is: " + " or ".join(TipSide)),
        }


def scan(
    whisker: Whisker,
    surface: Surface,
    *,
    step: Quantity,
    to: Quantity | Sequence[Quantity],
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    damping: float | None = None,
    tip_radius: Quantity = 0,
) -> Signals:
    """Move the clamp over a surface and record the signals.

    Parameters
    ----------
    whisker : Whisker
    surface : Surface
    step : str or number
        Step of the stage.
    to : str or number, or sequence of these
        Positions at which the stage turns; at the last one it stops.
    law : SlipLaw
        Where a slip ends.
    kinetic_ratio : float
        μk/μ0, for all laws but ``free``.
    damping : float, optional
        Damping ratio ζ of the rod, from 0, which the law ``damped`` needs.
    tip_radius : str or number
        Radius of a ball at the tip, which traces the heights of the surface.

    Returns
    -------
    Signals
        Exact signals; `Signals.measured` adds the noise of a transducer.

    Raises
    ------
    ArgumentError
        If an argument is out of range, or the tip leaves the known part of the surface.
    """
    units = whisker.units
    size = units.read_positive(step, Kind.LENGTH, "step")
    turns = [units.read(turn, Kind.LENGTH, "to") for turn in np.array(to, dtype=object).ravel()]
    surface = replace(surface, spell=whisker.spell)
    radius = float(units.read(tip_radius, Kind.LENGTH, "tip_radius"))
    truth = move(
        whisker.stage,
        surface,
        size,
        to=turns,
        model=SlipModel.of(law, kinetic_ratio, damping),
        tip_radius=radius,
    )
    return Signals(truth=truth, readings=truth.reactions * units.channels, units=units)
