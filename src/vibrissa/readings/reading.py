"""One reading: a scan is simulated with a true set-up, recorded, and its friction identified."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.design.materials import stated_material
from vibrissa.errors import ArgumentError, EndedScanError, NoResponseError, VibrissaError
from vibrissa.mechanics.bending import measure
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Method, ReadingStatus, RodSection, Status
from vibrissa.quantities.units import Kind, Quantity
from vibrissa.scanning.cycles import StageMaker, move
from vibrissa.scanning.rods import distance_at
from vibrissa.scanning.scan import Scan
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.surfaces import Surface
from vibrissa.sensor.deviations import Deviations, Prior, Recorded, recorded
from vibrissa.sensor.identification.friction_summary import used_in_mean
from vibrissa.sensor.identification.identify import identify_by
from vibrissa.sensor.identification.periods import PeriodStatus
from vibrissa.sensor.identification.propagation import HALF_WIDTH
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.transducer import preset
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.readings import digest_of_point

# Units in which the columns of a recording are handed to `identify`.
COLUMNS = ("footpoint [m]", "force_x [N]", "force_y [N]", "moment_z [N*m]")
# Line of the first row of a recording that is no file.
FIRST_LINE = 1
LOCKED = "the tip locks before its first slip: it sticks to the end of the path"
# Way of the clamp in a cycle, at most (L): the surface is made as long as that.
WAY_OF_CYCLE = 1.0


@dataclass(frozen=True, kw_only=True)
class Bench:
    """What all recordings of a point have in common.

    Attributes
    ----------
    setup : Setup
        The set-up as it is stated: rod, clamp, stage, transducer and tolerances.
    surface : Surface
        The surface, in units of the stated rod.
    dx0 : float
        Step of the clamp (L).
    to, cycles : optional
        Path of the clamp (L), or number of slips; one of them is None.
    model : SlipModel
        Slip law.
    tip_radius : float
        Radius of a ball at the tip, which traces the heights of the surface (L).
    errors : mapping or None
        Sizes of the errors of the set-up by name; None: they are drawn from the tolerances.
    """

    setup: Setup
    surface: Surface
    dx0: float
    to: Sequence[float] | None
    cycles: int | None
    model: SlipModel
    tip_radius: float
    errors: Mapping[str, Quantity] | None

    @cached_property
    def prior(self) -> Prior:
        """The stated rod and transducer, with the tolerances that `identify` assumes."""
        return Prior.of(self.setup.whisker, preset(str(self.setup.transducer)), self.setup.assume)

    @cached_property
    def yield_strain(self) -> float:
        """Yield strain of the material; infinite if it is not stated."""
        material = stated_material(self.setup)
        return np.inf if material is None else material.yield_strain

    def deviations(self, generator: np.random.Generator) -> Deviations:
        """Return the errors of the set-up of one recording."""
        if self.errors is None:
            return self.prior.draw(generator)
        return self.prior.stated(self.errors)

    def record(self, generator: np.random.Generator) -> Recorded:
        """Simulate a recording; see `vibrissa.sensor.deviations.recorded` for errors."""
        if self.to is None:
            ends = [0.0, WAY_OF_CYCLE * (self.cycles or 0)]
        else:
            ends = [0.0, *self.to]
        deviations = self.deviations(generator)
        return recorded(self.prior, deviations, self.surface, ends, self._moved, generator)

    def _moved(self, make_stage: StageMaker, surface: Surface, scale: float) -> Scan:
        """Move the clamp over the surface, or up to where the tip leaves its known part."""
        try:
            return move(
                make_stage,
                surface,
                self.dx0 * scale,
                to=None if self.to is None else [turn * scale for turn in self.to],
                cycles=self.cycles,
                model=self.model,
                tip_radius=self.tip_radius,
            )
        except EndedScanError as error:
            scan: Scan = error.scan
            return scan


def generator_of(point: Mapping[str, Any], seed: int, recording: int) -> np.random.Generator:
    """Return the random numbers of a recording.

    They depend on the seed, on the values of the point that are not 0, and on the number of the
    recording alone: not on the chunk in which it is computed, nor on other points.
    """
    words = int(digest_of_point(point), 16)
    return np.random.default_rng(np.random.SeedSequence([seed, words, recording]))


@dataclass(frozen=True, kw_only=True)
class Stated:
    """What the readings of a study state of the set-ups of all their points.

    Attributes
    ----------
    rod : mapping
        Keys of a set-up for the size and the material of the rod.
    tolerances : mapping of str to str or float
        Stated tolerances by the names of their quantities.
    assume : bool
        Whether all other quantities have their default tolerances.
    """

    rod: Mapping[str, Any]
    tolerances: Mapping[str, Quantity]
    assume: bool
    contact: Contact
    section: RodSection


def setup_of(point: Mapping[str, Any], stated: Stated) -> Setup:
    """Make the stated set-up of a point.

    Raises
    ------
    ArgumentError
        With a line for each value that is not allowed.
    """
    mounting = {name: point[name] for name in MOUNTING_AXES}
    angles = {name: f"{mounting[name]} rad" for name in MOUNTING_AXES if name.endswith("angle")}
    return Setup.read(
        theta=point["theta"],
        eta=point["eta"],
        contact=stated.contact,
        section=stated.section,
        transducer=point.get("card", point["transducer"]),
        tolerances=dict(stated.tolerances),
        assume=stated.assume,
        **stated.rod,
        **(mounting | angles),
    )


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Friction read from a recording by one method; numbers that are not known are NaN or None.

    Attributes
    ----------
    status : ReadingStatus
    message : str
        Reason of the status or of the grade; empty if there is none.
    way : float
        Way of the clamp (L).
    mu0_true : float
        Mean friction where the tip slipped, in the periods of the estimate.
    limits : mapping of str to float
        For each quantity with a tolerance, the part by which the variance of the estimate would
        fall if this quantity were exact.

    All others are as the columns of the table of friction.
    """

    status: ReadingStatus
    message: str = ""
    grade: str | None = None
    mu0_true: float = np.nan
    mu0_read: float = np.nan
    mu0_random: float = np.nan
    mu0_common: float = np.nan
    periods_true: int | None = None
    periods_read: int | None = None
    periods_used: int | None = None
    period_error: float = np.nan
    period_deviation: float = np.nan
    way: float = np.nan
    strain: float = np.nan
    saturated: float = np.nan
    penetrates: bool | None = None
    limits: Mapping[str, float] | None = None

    @property
    def mu0_deviation(self) -> float:
        """Standard deviation of the estimate."""
        return float(np.hypot(self.mu0_random, self.mu0_common))

    @property
    def mu0_low(self) -> float:
        """Lower end of the 95 % interval."""
        return self.mu0_read - HALF_WIDTH * self.mu0_deviation

    @property
    def mu0_high(self) -> float:
        """Upper end of the 95 % interval."""
        return self.mu0_read + HALF_WIDTH * self.mu0_deviation

    @property
    def inside(self) -> bool | None:
        """Whether the interval contains the true friction; None without an estimate."""
        if np.isnan(self.mu0_read):
            return None
        return self.mu0_low <= self.mu0_true <= self.mu0_high


def read_once(
    bench: Bench, methods: Sequence[Method], generator: np.random.Generator
) -> list[Reading]:
    """Simulate one recording, and read its friction by some methods."""
    try:
        found = bench.record(generator)
    except NoResponseError as error:
        return [Reading(status=ReadingStatus.OUT_OF_REACH, message=str(error)) for _ in methods]
    except ArgumentError as error:
        return [Reading(status=ReadingStatus.FAILED, message=str(error)) for _ in methods]
    scan = found.scan
    if not len(scan):
        status = ReadingStatus(Status(scan.outcome.value))
        return [Reading(status=status, message=scan.message) for _ in methods]
    strain = largest_stress_of(found) * bench.setup.whisker.units.unit(Kind.STRAIN)
    transducer = bench.prior.transducer
    same = Reading(
        status=ReadingStatus.REFUSED,
        mu0_true=float(_slipping(scan).mean()) if scan.slips else np.nan,
        periods_true=scan.slips,
        way=float(np.abs(np.diff(scan.clamp)).sum()),
        strain=strain,
        saturated=float(transducer.saturated(found.readings).any(axis=1).mean()),
        penetrates=scan.penetrates,
    )
    if strain > bench.yield_strain:
        message = f"the strain reaches {strain:.2%}; the yield strain is {bench.yield_strain:.2%}"
        return [replace(same, status=ReadingStatus.YIELDED, message=message) for _ in methods]
    if not scan.slips and scan.status is Status.LOCK:
        message = scan.message or LOCKED
        return [replace(same, status=ReadingStatus.LOCK, message=message) for _ in methods]
    frame = table_of_readings(bench, found)
    by_method = identify_by(bench.setup, frame, methods)
    return [_compared(identified, scan, same) for identified in by_method]


def table_of_readings(bench: Bench, found: Recorded) -> pd.DataFrame:
    """Return a recording as a laboratory has it: stated positions of the clamp, and readings."""
    length = bench.setup.whisker.units.unit(Kind.LENGTH)
    # The stage reports its steps, whatever it moves.
    steps = np.round(found.scan.clamp / (bench.dx0 * found.scale))
    columns = [steps * bench.dx0 * length, *found.readings.T]
    return pd.DataFrame(dict(zip(COLUMNS, columns, strict=True)))


def _slipping(scan: Scan) -> FloatArray:
    """Return the friction under the tip at the ends of the periods that end with a slip."""
    begins = np.flatnonzero(np.diff(scan.period))
    return np.asarray(scan.mu0[begins])


def _compared(found: Identification | VibrissaError, scan: Scan, same: Reading) -> Reading:
    """Compare the friction that was identified with the truth."""
    if isinstance(found, VibrissaError):
        status = ReadingStatus.SATURATED if same.saturated else ReadingStatus.REFUSED
        return replace(same, status=status, message=str(found))
    periods, summary, used = found.periods, found.summary(), used_in_mean(found.periods)
    slips = int((periods.status == PeriodStatus.SLIP).sum())
    same = replace(same, periods_read=slips, periods_used=summary.used)
    if not summary.used:
        status = ReadingStatus.SATURATED if same.saturated else ReadingStatus.NO_SLIP
        lines = [*summary.answer(), *periods.left_out]
        return replace(same, status=status, message="; ".join(lines))
    true = scan.mu0[periods.last_line[used] - FIRST_LINE]
    off = periods.mu0[used] - true
    return replace(
        same,
        status=ReadingStatus.READ,
        message="; ".join(_doubts(found)) if summary.grade else "",
        grade=summary.grade,
        mu0_true=float(true.mean()),
        mu0_read=summary.mean,
        mu0_random=summary.random,
        mu0_common=summary.common,
        period_error=float(np.sqrt(np.mean(off**2))),
        period_deviation=float(np.sqrt(np.mean(periods.deviation[used] ** 2))),
        limits={
            name: 1.0 - (left / summary.deviation) ** 2 for name, left in summary.if_exact.items()
        },
    )


def _doubts(found: Identification) -> list[str]:
    """Return the reasons to doubt periods, without their lines."""
    return [one.sentence for one in found.periods.checks if one.periods.any()]


def largest_stress_of(found: Recorded) -> float:
    """Return the largest stress in the rod at the ends of the periods of a scan (E(0)·d0/L)."""
    scan, whisker = found.scan, found.whisker
    if scan.stage is None:
        return np.nan
    last = np.append(np.flatnonzero(np.diff(scan.period)), len(scan) - 1)
    rows = scan.take(last)
    state, stage = rows.state, scan.stage
    across = distance_at(rows.clamp, stage.eta, stage.angle) - rows.height
    along = rows.contact - stage.along(rows.clamp) - (1.0 - state.s_c)
    theta = np.full(len(rows), whisker.theta)
    bending = measure(theta, state.f, state.alpha, along, across, state.s_c, whisker.mounting)
    return float(bending.stress.max())
