"""The command line ``vibrissa``."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
import typer
from matplotlib.figure import Figure

from vibrissa.api import solve_onset
from vibrissa.files import write_atomically
from vibrissa.rod import deformed_shape
from vibrissa.sensor import friction, materials, series, transducer
from vibrissa.sensor.calibration import NAMES, Setup, Unknown, calibrate
from vibrissa.sensor.design import Design, Verdict, curves_to_solve, design
from vibrissa.sensor.heights import NODES, respond_between
from vibrissa.sensor.identification import (
    Found,
    Method,
    Periods,
    identify,
    noise_for,
    read_recording,
)
from vibrissa.sensor.quantities import Kind, Units, in_si, range_of
from vibrissa.sensor.requirements import Requirements, without_units
from vibrissa.sensor.response import Branch, NoResponse, largest_strain, respond
from vibrissa.sensor.scanning import SlipLaw, path, scan
from vibrissa.sensor.series import Column
from vibrissa.status import Contact, Status
from vibrissa.units import Rod

PICTURES = (".pdf", ".svg", ".png")
# Work that takes longer shows how far it is.
PATIENCE = 2.0

app = typer.Typer(
    name="vibrissa",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="From a surface to the signals of a whisker-like sensor, and back to friction.\n\n"
    "Quantities have a unit, as in `--step '20 um'`, or are nondimensional without one: lengths "
    "in units of the rod's length L. With `--modulus`, `--diameter` and `--length` results are "
    "in SI units, otherwise nondimensional.",
)

Theta = Annotated[float, typer.Option(help="Taper: base over tip diameter, at least 1.")]
Eta = Annotated[str, typer.Option(help="Height of the surface above the clamp: 0.85, or '85 mm'.")]
Modulus = Annotated[str | None, typer.Option(help="Young's modulus of the rod: '210 GPa'.")]
Diameter = Annotated[str | None, typer.Option(help="Diameter of the rod at the clamp: '1 mm'.")]
Length = Annotated[str | None, typer.Option(help="Length of the rod: '100 mm'.")]
Touch = Annotated[Contact, typer.Option("--contact", help="How the rod may touch the surface.")]
Picture = Annotated[Path | None, typer.Option(help="Draw it: a .pdf, .svg or .png file.")]
Out = Annotated[Path, typer.Option("--output", "-o", help="Table to write: .csv or .parquet.")]


def _transducer(name: str | None, units: Units) -> transducer.Transducer | None:
    """Preset of a name; it reads forces in N, so that the rod has to be known."""
    if name is None:
        return None
    if units.rod is None:
        raise ValueError("a transducer needs the rod: give modulus, diameter and length")
    return transducer.preset(name)


def _units(modulus: str | None, diameter: str | None, length: str | None) -> Units:
    given = {"modulus": modulus, "diameter": diameter, "length": length}
    missing = [name for name, text in given.items() if text is None]
    if len(missing) == len(given):
        return Units()
    if missing:
        raise ValueError(f"a rod needs modulus, diameter and length: {', '.join(missing)} missing")
    return Units(
        Rod(
            float(in_si(modulus or "", Kind.STRESS, "modulus")),
            float(in_si(diameter or "", Kind.LENGTH, "diameter")),
            float(in_si(length or "", Kind.LENGTH, "length")),
        )
    )


@contextmanager
def _plain_messages() -> Iterator[None]:
    """End with one line instead of a traceback where the user can do something about it."""
    try:
        yield
    except (ValueError, OSError) as error:
        typer.echo(f"vibrissa: {error}", err=True)
        raise typer.Exit(2) from None


def _progress(length: int, label: str) -> Callable[[int], None]:
    """Show a progress bar once the work has taken longer than `PATIENCE`."""
    start, bar, before = (
        time.monotonic(),
        typer.progressbar(length=length, label=label, file=sys.stderr),
        0,
    )

    def tell(done: int) -> None:
        nonlocal before
        if time.monotonic() - start > PATIENCE:
            bar.update(done - before)
            before = done
            if done >= length:
                bar.render_finish()

    return tell


def _save(figure: Figure, picture: Path) -> None:
    with write_atomically(picture) as temporary:
        figure.savefig(temporary)


def _check_picture(picture: Path | None) -> None:
    if picture is None:
        return
    if picture.suffix.lower() not in PICTURES:
        raise ValueError(f"{picture}: the ending must be one of {', '.join(PICTURES)}")
    if not picture.parent.is_dir():
        raise ValueError(f"{picture}: there is no folder {picture.parent}")


@app.callback()
def main() -> None:
    """Keep the commands commands, however many there are."""


@app.command(epilog="Example: `vibrissa solve --theta 2 --eta 0.85 --mu0 0.4 --step 0.001`")
def solve(
    theta: Theta,
    eta: Eta,
    mu0: Annotated[str, typer.Option(help="Coefficient of static friction.")],
    step: Annotated[str | None, typer.Option(help="Step of the stage: '20 um'.")] = None,
    contact: Touch = Contact.POINT,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Also write it: .csv or .parquet.")
    ] = None,
    picture: Picture = None,
) -> None:
    """One rod on one surface: how far it sticks, what the clamp feels, how much it is strained.

    A tip that locks is an answer, too: its status says so. If nothing can be computed the exit
    code is 1, after a mistake in the input 2.
    """
    with _plain_messages():
        _check_picture(picture)
        if output is not None:
            series.check_ending(output)
        units = _units(modulus, diameter, length)
        height = float(units.read(eta, Kind.LENGTH, "eta"))
        dx0 = None if step is None else units.read(step, Kind.LENGTH, "step")
        friction0 = units.read(mu0, Kind.NUMBER, "mu0")
        onset = solve_onset(theta, friction0, height, dx0, contact=contact)
        rows: dict[str, tuple[Any, Kind | None, str]] = {
            "status": (onset.status.value, None, "slip, lock, out_of_reach or failed"),
            "message": (onset.message, None, "what the status means here"),
            "mu_lock": (onset.mu_lock, Kind.NUMBER, "largest friction at which the tip slips"),
        }
        if onset.status is Status.SLIP:
            rows |= _slip_rows(theta, height, contact, onset, units)
        for name, (value, kind, _) in rows.items():
            shown = value if kind is None else f"{value:.8g} {units.name(kind)}".removesuffix(" 1")
            typer.echo(f"{name:<12} {shown}")
        if output is not None:
            columns = {
                name: Column([value], "" if kind is None else units.name(kind), what)
                for name, (value, kind, what) in rows.items()
            }
            series.write(output, columns)
        if picture is not None:
            if onset.status is not Status.SLIP:
                raise ValueError(f"no picture of a rod with status {onset.status}")
            _save(_shapes(theta, height, contact, onset.x0_slip, units), picture)
    if onset.status in (Status.FAILED, Status.OUT_OF_REACH):
        raise typer.Exit(1)


def _slip_rows(
    theta: float, eta: float, contact: Contact, onset: Any, units: Units
) -> dict[str, tuple[Any, Kind | None, str]]:
    curve = respond(theta, eta, contact, pull=False).curve
    slip = onset.slip
    length, force, moment = (units.unit(kind) for kind in (Kind.LENGTH, Kind.FORCE, Kind.MOMENT))
    strain = largest_strain(theta, eta, curve.x1_init - onset.x0_slip, slip)
    rows: dict[str, tuple[Any, Kind | None, str]] = {
        "x0_slip": (onset.x0_slip * length, Kind.LENGTH, "exact onset of slip"),
        "force_x": (float(slip.reaction_fx) * force, Kind.FORCE, "clamp force at the onset"),
        "force_y": (float(slip.reaction_fy) * force, Kind.FORCE, "clamp force at the onset"),
        "moment_z": (float(slip.reaction_m) * moment, Kind.MOMENT, "clamp moment at the onset"),
    }
    if onset.n_steps is not None:
        rows["x0_max"] = (onset.x0_max * length, Kind.LENGTH, "last sticking step of the stage")
    if units.rod is None:
        rows["strain"] = (strain, None, "largest strain at the onset, in units of d0/L")
    else:
        slender = units.rod.base_diameter / units.rod.length
        rows["strain"] = (strain * slender, Kind.NUMBER, "largest strain at the onset")
    return rows


def _shapes(theta: float, eta: float, contact: Contact, x0_slip: float, units: Units) -> Figure:
    curve = respond(theta, eta, contact, pull=False).curve
    figure = Figure(figsize=(5.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    unit, s = units.unit(Kind.LENGTH), np.linspace(0.0, 1.0, 101)
    for x0, label in ((0.0, "α = 0"), (x0_slip, "onset of slip")):
        state = curve.state(x0)
        x, y, _ = deformed_shape(
            theta, float(state.f), float(state.alpha), curve.x1_init - x0, eta, s, float(state.s_c)
        )
        axes.plot((x + x0) * unit, y * unit, label=label)
    axes.axhline(eta * unit, color="0.5", linewidth=0.8)
    name = units.name(Kind.LENGTH)
    axes.set(aspect="equal", xlabel=f"x / {name}", ylabel=f"y / {name}")
    axes.legend()
    return figure


@app.command(
    name="scan",
    epilog="Example: `vibrissa scan --theta 2 --eta 0.85 --mu0 0.4 --step 0.001 --to 1 -o a.csv`",
)
def scan_(
    theta: Theta,
    eta: Eta,
    step: Annotated[str, typer.Option(help="Step of the stage: '20 um'.")],
    to: Annotated[
        list[str],
        typer.Option(help="Where the stage stops; repeated, where it turns: --to 1 --to 0."),
    ],
    output: Out,
    mu0: Annotated[str | None, typer.Option(help="Surface of the same friction.")] = None,
    patches: Annotated[
        str | None, typer.Option(help="Surface of patches: '0 mm: 0.3, 50 mm: 0.4'.")
    ] = None,
    profile: Annotated[
        Path | None, typer.Option(help="Measured surface: a table with columns x and mu0.")
    ] = None,
    texture: Annotated[
        str | None, typer.Option(help="Random surface: 'mean, deviation, correlation length'.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the texture and of the noise.")] = 0,
    law: Annotated[SlipLaw, typer.Option(help="Where a slip ends; see docs/sensor.md.")] = (
        SlipLaw.FREE
    ),
    kinetic_ratio: Annotated[
        float, typer.Option(help="Kinetic over static friction, for the other two laws.")
    ] = 0.8,
    transducer_name: Annotated[
        str | None,
        typer.Option("--transducer", help=f"Measured by: {', '.join(transducer.PRESETS)}."),
    ] = None,
    contact: Touch = Contact.POINT,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    picture: Picture = None,
) -> None:
    """Move the clamp over a surface and write what it feels, step by step.

    The columns `footpoint`, `force_x`, `force_y` and `moment_z` are what a sensor records, the
    others what it does not know: the tip's position, x0, friction there, period and phase.
    """
    with _plain_messages():
        series.check_ending(output)
        _check_picture(picture)
        units = _units(modulus, diameter, length)
        height = float(units.read(eta, Kind.LENGTH, "eta"))
        sensor = _transducer(transducer_name, units)
        surface = _surface(units, mu0, patches, profile, texture, seed)
        positions = path(
            units.read(step, Kind.LENGTH, "step"),
            [units.read(turn, Kind.LENGTH, "to") for turn in to],
        )
        backward = bool(np.any(np.diff(positions) < 0.0)) or law is SlipLaw.ENERGY
        response = respond(theta, height, contact, pull=backward)
        tell = _progress(len(positions), "scanning")
        result = scan(response, surface, positions, law, kinetic_ratio, tell)
        scale = [units.unit(kind) for kind in (Kind.FORCE, Kind.FORCE, Kind.MOMENT)]
        reactions = np.stack([result.fx, result.fy, result.m], axis=1) * scale
        if sensor is not None:
            reactions = sensor.measured(reactions, np.random.default_rng([seed, 1]))
        unit, name = units.unit(Kind.LENGTH), units.name(Kind.LENGTH)
        force, moment = units.name(Kind.FORCE), units.name(Kind.MOMENT)
        columns = {
            "footpoint": Column(result.footpoint * unit, name, "position of the clamp"),
            "force_x": Column(reactions[:, 0], force, "clamp force along the surface"),
            "force_y": Column(reactions[:, 1], force, "clamp force normal to the surface"),
            "moment_z": Column(reactions[:, 2], moment, "clamp moment"),
            "contact": Column(result.contact * unit, name, "position of the tip"),
            "x0": Column(result.x0 * unit, name, "clamp displacement from the alpha = 0 state"),
            "mu0": Column(result.mu0, "1", "static friction under the tip"),
            "period": Column(result.period, "1", "number of the period of sticking"),
            "phase": Column([p.value for p in result.phase], "", "stick, lock or slip"),
        }
        series.write(output, columns)
        if picture is not None:
            _save(_signals(columns), picture)
    typer.echo(
        f"{output}: {len(result.footpoint)} steps, {result.period[-1]} periods, {result.outcome}"
    )
    if result.message:
        typer.echo(result.message)


def _surface(
    units: Units,
    mu0: str | None,
    patches: str | None,
    profile: Path | None,
    texture: str | None,
    seed: int,
) -> friction.Friction:
    if sum(kind is not None for kind in (mu0, patches, profile, texture)) != 1:
        raise ValueError("give the surface by one of --mu0, --patches, --profile and --texture")
    if mu0 is not None:
        return friction.constant(float(units.read(mu0, Kind.NUMBER, "mu0")))
    if patches is not None:
        pairs = [part.partition(":") for part in patches.split(",")]
        return friction.patches(
            [float(units.read(start, Kind.LENGTH, "start of a patch")) for start, _, _ in pairs],
            [float(units.read(value, Kind.NUMBER, "mu0 of a patch")) for _, _, value in pairs],
        )
    if profile is not None:
        table = series.read(profile, ["x", "mu0"])
        for column, values in table.columns.items():
            if np.isnan(values).any():
                row = int(np.flatnonzero(np.isnan(values))[0])
                raise ValueError(f"{table.place(row)}: {column} is missing")
        factor = units.column_factor(table.units.get("x", "L"), Kind.LENGTH, f"{profile}: x")
        return friction.profile(table.columns["x"] * factor, table.columns["mu0"])
    parts = (texture or "").split(",")
    if len(parts) != 3:
        raise ValueError(f"texture needs 'mean, deviation, correlation length', got {texture!r}")
    return friction.random(
        seed,
        float(units.read(parts[0], Kind.NUMBER, "mean of the texture")),
        float(units.read(parts[1], Kind.NUMBER, "deviation of the texture")),
        float(units.read(parts[2], Kind.LENGTH, "correlation length of the texture")),
    )


def _signals(columns: dict[str, Column]) -> Figure:
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    clamp = columns["footpoint"]
    for axes, name in zip(panels, transducer.CHANNELS, strict=True):
        axes.plot(clamp.values, columns[name].values, linewidth=0.8)
        axes.set_ylabel(f"{name} / {columns[name].unit}")
    panels[-1].set_xlabel(f"position of the clamp / {clamp.unit}")
    return figure


@app.command(
    name="identify",
    epilog="Example: `vibrissa identify scan.csv --theta 2 --eta 0.85 --noise '0.003, 0.003, "
    "0.0002' -o friction.csv`",
)
def identify_(
    recording: Annotated[
        Path,
        typer.Argument(
            help="Time series, .csv or .parquet: columns footpoint, force_x, force_y, moment_z as "
            "far as the method needs them, each with its unit: 'footpoint [mm],force_x [N]'."
        ),
    ],
    theta: Theta,
    eta: Eta,
    output: Out,
    method: Annotated[Method, typer.Option(help="What friction is read from.")] = Method.FORCES,
    transducer_name: Annotated[
        str | None,
        typer.Option("--transducer", help=f"Measured by: {', '.join(transducer.PRESETS)}."),
    ] = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Standard deviation of force_x, force_y and moment_z: '3 mN, 3 mN, 10 uN*m'; "
            "estimated from the recording if neither it nor the transducer is given."
        ),
    ] = None,
    step: Annotated[
        str | None, typer.Option(help="Step of the stage, if samples were lost: '20 um'.")
    ] = None,
    law: Annotated[
        SlipLaw | None,
        typer.Option(help="Where slips end, for the spacing; without it only bounds are found."),
    ] = None,
    kinetic_ratio: Annotated[
        float | None, typer.Option(help="Kinetic over static friction, for the spacing.")
    ] = None,
    estimate: Annotated[
        list[Unknown] | None,
        typer.Option(
            help="What is not known and estimated, too; repeated for both. eta: the height, near "
            "the one given. offset: what each channel reads without load."
        ),
    ] = None,
    contact: Touch = Contact.POINT,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    picture: Picture = None,
) -> None:
    """From a measured time series to periods of sticking and the friction of each.

    Writes one row for each period: where its tip was, mu0 with its standard deviation and 95 %
    interval, the rows' lines in the recording, and why it may be in doubt. Rows that miss a value,
    are saturated or are spikes are left out and named. If the recording does not tell what is to be
    estimated the exit code is 1, after a mistake in the input 2.
    """
    with _plain_messages():
        series.check_ending(output)
        _check_picture(picture)
        units = _units(modulus, diameter, length)
        height = float(units.read(eta, Kind.LENGTH, "eta"))
        sensor = _transducer(transducer_name, units)
        if sensor is not None and noise is not None:
            raise ValueError("give the noise or the transducer, not both")
        series_ = read_recording(recording, units, method, sensor)
        backward = bool(np.any(np.diff(series_.footpoint) < 0.0))
        kinds = (Kind.FORCE, Kind.FORCE, Kind.MOMENT)
        deviation = None
        if sensor is not None:
            deviation = np.array(sensor.deviation) / [units.unit(kind) for kind in kinds]
        elif noise is not None:
            parts = noise.split(",")
            if len(parts) != 3:
                raise ValueError(f"noise needs three values, got {noise!r}")
            deviation = np.array(
                [float(units.read(p, k, "noise")) for p, k in zip(parts, kinds, strict=True)]
            )
        stage = None if step is None else float(units.read(step, Kind.LENGTH, "step"))
        rod: Branch | Setup
        if estimate:
            heights = _pulled_if_possible(
                lambda pull: respond_between(
                    theta, height, contact, pull, _progress(NODES + 1, "solving the rod")
                ),
                needed=backward,
            )
            rod = calibrate(
                heights,
                height,
                series_.footpoint,
                series_.readings,
                noise_for(series_, deviation),
                estimate,
            )
            if rod.message:
                typer.echo(f"{recording}: {rod.message}", err=True)
                raise typer.Exit(1)
        else:
            rod = _pulled_if_possible(
                lambda pull: respond(theta, height, contact, pull), needed=backward
            )
        tell = _progress(len(series_.footpoint), "identifying")
        periods = identify(rod, series_, deviation, method, stage, law, kinetic_ratio, tell)
        unit, name = units.unit(Kind.LENGTH), units.name(Kind.LENGTH)
        columns = {
            "status": Column([s.value for s in periods.status], "", ", ".join(Found)),
            "contact": Column(periods.contact * unit, name, "position of the tip"),
            "mu0": Column(periods.mu0, "1", "static friction there"),
            "deviation": Column(periods.deviation, "1", "its standard deviation"),
            "low": Column(periods.low, "1", "lower end of its central 95 %"),
            "high": Column(periods.high, "1", "upper end of its central 95 %"),
            "common": Column(periods.common, "1", "part of it that all periods share"),
            "first_line": Column(series_.line[periods.first], "1", "line of the first sample"),
            "last_line": Column(series_.line[periods.last], "1", "line of the last sample"),
            "doubt": Column(periods.doubt, "", "why its friction is in doubt; empty if it is not"),
        }
        series.write(output, columns)
        if picture is not None:
            _save(_friction_map(periods, unit, name), picture)
    for note in periods.notes:
        typer.echo(note, err=True)
    if isinstance(rod, Setup):
        for text in _estimated(rod, units):
            typer.echo(text)
    typer.echo(
        f"{output}: {len(periods.status)} periods, "
        f"friction of {periods.status.count(Found.SLIP)} of them"
    )


T = TypeVar("T")


def _pulled_if_possible(solved: Callable[[bool], T], needed: bool) -> T:
    """Solve with pulling where there is one: a long slip may end there, too."""
    try:
        return solved(True)
    except NoResponse:
        if needed:
            raise
        return solved(False)


def _estimated(setup: Setup, units: Units) -> Iterator[str]:
    """Say what was estimated, how well, and how much of that hangs together."""
    kinds = (Kind.LENGTH, Kind.FORCE, Kind.FORCE, Kind.MOMENT)
    values = (setup.eta, *setup.offset)
    names = []
    for label, kind, value, deviation in zip(NAMES, kinds, values, setup.deviation, strict=True):
        if deviation > 0.0:
            what = label if label == "eta" else f"offset of {label}"
            unit, name = units.unit(kind), units.name(kind)
            yield f"{what} = {value * unit:.6g} ± {deviation * unit:.2g} {name} (one deviation)"
            names.append(NAMES.index(label))
    for i, j in combinations(names, 2):
        yield f"correlation of {NAMES[i]} and {NAMES[j]}: {setup.correlation[i, j]:+.2f}"


def _friction_map(periods: Periods, unit: float, name: str) -> Figure:
    figure = Figure(figsize=(7.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    bars = np.stack([periods.mu0 - periods.low, periods.high - periods.mu0])
    axes.errorbar(periods.contact * unit, periods.mu0, np.maximum(bars, 0.0), fmt=".", markersize=4)
    axes.set(xlabel=f"position of the tip / {name}", ylabel="static friction μ0, 95 %")
    return figure


@app.command(
    name="design",
    epilog="Examples: `vibrissa design --material music-wire --transducer nano17-si-12-0.12 --step "
    "'50 um' --mu0 '0.2 to 0.4'`; a rod that is given is checked: `vibrissa design --material "
    "steel-s235 --diameter '5 mm' --length '100 mm' --theta 2 --eta 0.85 --transducer "
    "nano17-si-12-0.12 --step '50 um' --mu0 '0.2 to 0.4'`",
)
def design_(
    step: Annotated[str, typer.Option(help="Step of the stage: '20 um'.")],
    mu0: Annotated[str, typer.Option(help="Friction to be measured: '0.2 to 0.4'.")],
    material: Annotated[
        str | None, typer.Option(help=f"Made of: {', '.join(materials.MATERIALS)}.")
    ] = None,
    modulus: Modulus = None,
    yield_strain: Annotated[
        float | None,
        typer.Option(help="Strain up to which it is elastic; in units of d0/L without a modulus."),
    ] = None,
    density: Annotated[str | None, typer.Option(help="Of the material: '7800 kg/m^3'.")] = None,
    transducer_name: Annotated[
        str | None,
        typer.Option("--transducer", help=f"Measured by: {', '.join(transducer.PRESETS)}."),
    ] = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Instead: standard deviation of one reading of force_x, force_y and moment_z: "
            "'3 mN, 3 mN, 10 uN*m'."
        ),
    ] = None,
    range_: Annotated[
        str | None,
        typer.Option("--range", help="Largest force_x, force_y and moment_z it measures."),
    ] = None,
    method: Annotated[Method, typer.Option(help="What friction is read from.")] = Method.FORCES,
    theta: Annotated[str, typer.Option(help="Tapers to choose from, or the one.")] = "1 to 10",
    eta: Annotated[
        str,
        typer.Option(
            help="Heights to choose from: in L, or '85 mm' for the one of a known length."
        ),
    ] = "0.5 to 0.98",
    diameter: Annotated[
        str | None, typer.Option(help="Diameters at the clamp: '0.1 to 10 mm' if not given.")
    ] = None,
    length: Annotated[
        str | None, typer.Option(help="Lengths of the rod: '20 to 200 mm' if not given.")
    ] = None,
    tip: Annotated[
        str | None, typer.Option(help="Least diameter of the tip: '0.1 mm' if not given.")
    ] = None,
    safety: Annotated[
        float, typer.Option(help="The strain stays below the yield strain by this factor.")
    ] = 1.5,
    lock_factor: Annotated[
        float, typer.Option(help="The locking friction exceeds the largest friction by this.")
    ] = 1.1,
    steps: Annotated[
        float, typer.Option(help="Least number of steps of the stage in a period.")
    ] = 10.0,
    weight: Annotated[
        float, typer.Option(help="Largest weight of the rod, relative to the normal force.")
    ] = 0.1,
    spacing: Annotated[
        str | None, typer.Option(help="Largest travel between two measurements: '5 mm'.")
    ] = None,
    contact: Touch = Contact.POINT,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Also write it: .csv or .parquet.")
    ] = None,
    picture: Picture = None,
) -> None:
    """Find the rod that measures friction best, and say what limits it.

    Chooses taper, height, diameter and length for the smallest standard deviation of mu0 from one
    period of sticking, the largest in the range of mu0, within limits: no yielding, no locking,
    enough steps, forces within the transducer's range. `--theta`, `--eta`, `--diameter` and
    `--length` take one value or a range; with four values that rod is checked. Without material
    and modulus everything is nondimensional and theta and eta alone are sought. If no rod keeps to
    all limits, it shows the one that exceeds them least, and the exit code is 1.
    """
    with _plain_messages():
        _check_picture(picture)
        if output is not None:
            series.check_ending(output)
        chosen = {"theta": theta, "eta": eta, "diameter": diameter, "length": length, "tip": tip}
        readings = {"transducer": transducer_name, "noise": noise, "range": range_}
        asked, units = _requirements(
            {"material": material, "modulus": modulus, "density": density},
            yield_strain,
            readings,
            chosen,
            {"step": step, "mu0": mu0, "spacing": spacing},
            {
                "safety": safety,
                "lock_factor": lock_factor,
                "steps": steps,
                "weight": weight,
                "method": method,
                "contact": contact,
            },
        )
        curves = curves_to_solve(asked)
        tell = _progress(curves, "solving")
        found = design(asked, lambda done: tell(min(done, curves - 1)))
        tell(curves)
        if found.verdict is Verdict.FAILED:
            raise ValueError(found.message)
        columns = _design_columns(found, units)
        _show_design(found, units)
        if output is not None:
            series.write(output, columns)
        if picture is not None:
            _save(_design_picture(found, units), picture)
    if found.verdict is not Verdict.FOUND:
        raise typer.Exit(1)


def _requirements(
    made_of: dict[str, str | None],
    yield_strain: float | None,
    readings: dict[str, str | None],
    chosen: dict[str, str | None],
    lengths: dict[str, str | None],
    others: dict[str, Any],
) -> tuple[Requirements, Units]:
    """Read the options of a design; units of its results."""
    for name, text in (("mu0", lengths["mu0"]), ("theta", chosen["theta"])):
        ends = (Units().read(end, Kind.NUMBER, name) for end in range_of(text or ""))
        others[name] = tuple(float(end) for end in ends)
    if made_of["material"] is None and made_of["modulus"] is None:
        return _without_units(made_of, yield_strain, readings, chosen, lengths, others), Units()
    if made_of["material"] is not None:
        if made_of["modulus"] is not None or yield_strain is not None:
            raise ValueError("give the material, or its modulus and yield strain, not both")
        stuff = materials.material(made_of["material"])
        others |= {"modulus": stuff.modulus, "yield_strain": stuff.yield_strain}
        others |= {"density": stuff.density}
    elif yield_strain is None:
        raise ValueError("a modulus needs a yield strain: give --yield-strain")
    else:
        others |= {"modulus": float(in_si(made_of["modulus"] or "", Kind.STRESS, "modulus"))}
        others |= {"yield_strain": yield_strain}
    if made_of["density"] is not None:
        others["density"] = float(in_si(made_of["density"], Kind.DENSITY, "density"))

    def in_metres(name: str, text: str) -> tuple[float, float]:
        low, high = (float(in_si(part, Kind.LENGTH, name)) for part in range_of(text))
        return low, high

    for name in ("diameter", "length"):
        if (text := chosen[name]) is not None:
            others[name] = in_metres(name, text)
    if chosen["tip"] is not None:
        others["tip"] = float(in_si(chosen["tip"], Kind.LENGTH, "tip"))
    # Sizes that are given also tell what a bare number means.
    sizes = [others.get(name, (0.0, 1.0)) for name in ("diameter", "length")]
    thick, long = (low if low == high else None for low, high in sizes)

    def read(text: str, kind: Kind, name: str) -> float:
        if long is None or (thick is None and kind is not Kind.LENGTH):
            return float(in_si(text, kind, name))
        units = Units(Rod(others["modulus"], thick or 1.0, long))
        return float(units.read(text, kind, name)) * units.unit(kind)

    others["step"] = read(lengths["step"] or "", Kind.LENGTH, "step")
    if lengths["spacing"] is not None:
        others["spacing"] = read(lengths["spacing"], Kind.LENGTH, "spacing")
    height = Units(None if long is None else Rod(others["modulus"], 1.0, long))
    others["eta"] = tuple(
        float(height.read(text, Kind.LENGTH, "eta")) for text in range_of(chosen["eta"] or "")
    )
    others |= _readings(readings, read)
    return Requirements(**others), Units(Rod(others["modulus"], 1.0, 1.0))


def _without_units(
    made_of: dict[str, str | None],
    yield_strain: float | None,
    readings: dict[str, str | None],
    chosen: dict[str, str | None],
    lengths: dict[str, str | None],
    others: dict[str, Any],
) -> Requirements:
    """Read the options of a design in units of the rod."""
    surplus = [name for name in ("diameter", "length", "tip") if chosen[name] is not None]
    surplus += [name for name in ("transducer",) if readings[name] is not None]
    surplus += [name for name in ("density",) if made_of[name] is not None]
    if surplus:
        raise ValueError(
            f"{', '.join(surplus)} cannot be used without the material: give --material, or "
            "--modulus and --yield-strain"
        )
    units = Units()

    def read(text: str, kind: Kind, name: str) -> float:
        return float(units.read(text, kind, name))

    others["step"] = read(lengths["step"] or "", Kind.LENGTH, "step")
    if lengths["spacing"] is not None:
        others["spacing"] = read(lengths["spacing"], Kind.LENGTH, "spacing")
    others["eta"] = tuple(read(text, Kind.LENGTH, "eta") for text in range_of(chosen["eta"] or ""))
    if yield_strain is not None:
        others["yield_strain"] = yield_strain
    return without_units(**others, **_readings(readings, read))


def _readings(
    readings: dict[str, str | None], read: Callable[[str, Kind, str], float]
) -> dict[str, tuple[float, ...]]:
    """Noise and range of the transducer."""
    if readings["transducer"] is not None:
        if readings["noise"] is not None or readings["range"] is not None:
            raise ValueError("give the transducer, or its noise and range, not both")
        sensor = transducer.preset(readings["transducer"])
        return {"noise": sensor.deviation, "range": sensor.limit}
    if readings["noise"] is None:
        raise ValueError("give a transducer or the noise of its readings")
    result = {}
    for name in ("noise", "range"):
        if (text := readings[name]) is None:
            continue
        parts = text.split(",")
        if len(parts) != 3:
            raise ValueError(f"{name} needs three values, got {text!r}")
        kinds = (Kind.FORCE, Kind.FORCE, Kind.MOMENT)
        result[name] = tuple(read(p, k, name) for p, k in zip(parts, kinds, strict=True))
    return result


def _design_columns(found: Design, units: Units) -> dict[str, Column]:
    """One row: the rod, its limits, and what would help."""
    length, number = units.name(Kind.LENGTH), units.name(Kind.NUMBER)
    columns = {
        "verdict": Column([found.verdict.value], "", "found, or none keeps to all limits"),
        "message": Column([found.message], "", "the verdict in words"),
        "limited_by": Column([" ".join(found.limited_by)], "", "limits used up or exceeded"),
        "theta": Column([found.theta], number, "taper"),
        "eta": Column([found.eta], "L", "height of the surface"),
        "diameter": Column([found.diameter], length, "diameter at the clamp"),
        "length": Column([found.length], length, "length"),
        "mu_lock": Column([found.mu_lock], number, "largest friction at which the tip slips"),
        "deviation": Column([found.deviation], number, "standard deviation of mu0, the largest"),
    }
    for check in found.checks:
        unit = units.name(check.kind)
        columns |= {
            f"{check.name}_value": Column([check.value], unit, check.meaning),
            f"{check.name}_bound": Column(
                [check.bound], unit, "the most allowed" if check.upper else "the least allowed"
            ),
            f"{check.name}_use": Column([check.use], number, "how much of it is used"),
        }
    for name, deviation in found.helps.items():
        columns[f"relaxed_{name}"] = Column(
            [deviation], number, "deviation with half the noise or step, or twice that limit"
        )
    return columns


def _show_design(found: Design, units: Units) -> None:
    """Print a design."""

    def shown(value: float, kind: Kind, digits: int = 4) -> str:
        return f"{value:.{digits}g} {units.name(kind)}".removesuffix(" 1")

    typer.echo(found.message)
    rod = {
        "theta": shown(found.theta, Kind.NUMBER),
        "eta": f"{found.eta:.4g} L",
        "diameter": shown(found.diameter, Kind.LENGTH),
        "length": shown(found.length, Kind.LENGTH),
        "mu_lock": shown(found.mu_lock, Kind.NUMBER),
    }
    if units.rod is None:
        del rod["diameter"], rod["length"]
    for name, text in rod.items():
        typer.echo(f"{name:<12} {text}")
    typer.echo("\nstandard deviation of mu0 from one period, by the step, by the readings; travel")
    for mu0, step, reading, slip in zip(
        found.mu0, found.by_step, found.by_reading, found.x0_slip, strict=True
    ):
        if np.isnan(slip):
            typer.echo(f"{mu0:<12.4g} the tip locks")
        else:
            deviation = np.hypot(step, reading)
            typer.echo(
                f"{mu0:<12.4g} {deviation:<9.2g} {step:<9.2g} {reading:<9.2g} "
                f"{shown(slip, Kind.LENGTH, 3)}"
            )
    typer.echo("\nlimit        value         bound           used")
    for check in sorted(found.checks, key=lambda check: -check.use):
        sign = "<" if check.upper else ">"
        value, bound = shown(check.value, check.kind, 3), shown(check.bound, check.kind, 3)
        used = f"{check.use:.1%}" if check.use < 2.0 else f"{check.use:.3g} times"
        typer.echo(f"{check.name:<12} {value:<13} {sign} {bound:<13} {used}")
    if found.helps:
        typer.echo("\nlargest standard deviation with")
    for name, deviation in found.helps.items():
        what = {
            "noise": "half the noise",
            "step": "half the step",
            "lock": "no margin to the lock",
        }.get(name, f"twice the room at the limit {name}")
        typer.echo(f"{deviation:<12.2g} {what}")


def _design_picture(found: Design, units: Units) -> Figure:
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for values, label in (
        (np.hypot(found.by_step, found.by_reading), "together"),
        (found.by_step, "by the step"),
        (found.by_reading, "by the readings"),
    ):
        left.plot(found.mu0, values, label=label)
    left.set(xlabel="static friction μ0", ylabel="standard deviation of μ0", ylim=(0.0, None))
    left.legend()
    shapes = found.shapes
    if shapes is not None:
        good = np.isfinite(found.worst)
        right.plot(shapes.theta[~good], shapes.eta[~good], ".", color="0.8", label="no rod")
        dots = right.scatter(
            shapes.theta[good], shapes.eta[good], c=found.worst[good], norm="log", s=18
        )
        if good.any():
            figure.colorbar(dots, ax=right, label="standard deviation of μ0, the largest")
        right.plot(found.theta, found.eta, "*", color="C3", markersize=12, label="the rod")
    right.set(xlabel="taper θ", ylabel="height η / L")
    right.legend(loc="lower right")
    return figure
