"""Surfaces described by texts with units, or measured in a table."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.quantities.units import Kind, Quantity, Units
from vibrissa.scanning import textures
from vibrissa.scanning.surfaces import Surface, constant, patches, profile, random
from vibrissa.scanning.textures import Texture
from vibrissa.sensor import topography


class Relief(NamedTuple):
    """Heights of a surface, and what was done to those of a file; empty without a file."""

    texture: Texture
    about: str


def read_surface(
    units: Units,
    *,
    mu0: Quantity | None = None,
    patches: str | None = None,
    profile: Path | None = None,
    texture: str | None = None,
    seed: int = 0,
) -> Surface:
    """Read a surface from exactly one of mu0, patches, profile and texture.

    Parameters
    ----------
    patches : str, optional
        Start and friction of each patch: ``"0 mm: 0.3, 50 mm: 0.4"``.
    profile : Path, optional
        Table with the columns ``x`` and ``mu0``.
    texture : str, optional
        Mean, standard deviation and correlation length of a random surface: ``"0.3, 0.04, 2 mm"``.

    Raises
    ------
    ArgumentError
        If there is not exactly one description, or an argument is out of range.
    RecordingError
        If the table cannot be read.
    """
    if sum(given is not None for given in (mu0, patches, profile, texture)) != 1:
        raise ArgumentError(
            "describe the surface by exactly one of mu0, patches, profile and texture"
        )
    if mu0 is not None:
        return constant(float(units.read_positive(mu0, Kind.NUMBER, "mu0")))
    if patches is not None:
        return _read_patches(patches, units)
    if profile is not None:
        return _read_profile(profile, units)
    return _read_texture(texture or "", seed, units)


def _read_patches(text: str, units: Units) -> Surface:
    pairs = [part.partition(":") for part in text.split(",")]
    starts = [float(units.read(start, Kind.LENGTH, "start of a patch")) for start, *_ in pairs]
    mu0 = [
        float(units.read_positive(friction, Kind.NUMBER, "mu0 of a patch"))
        for *_, friction in pairs
    ]
    return patches(starts, mu0)


def _read_profile(path: Path, units: Units) -> Surface:
    table = _read_along(path, "mu0")
    factor = units.column_factor(table.units.get("x", "L"), Kind.LENGTH, f"{path}: x")
    return profile(table.columns["x"] * factor, table.columns["mu0"])


def _read_along(path: Path, name: str) -> series.Table:
    """Read a table with the columns ``x`` and `name`, in which no value is missing."""
    table = series.read(path, ["x", name])
    missing = np.isnan(table.columns["x"] + table.columns[name])
    if missing.any():
        raise RecordingError(f"{table.place(int(np.argmax(missing)))}: x or {name} is missing")
    return table


def _read_texture(text: str, seed: int, units: Units) -> Surface:
    parts = text.split(",")
    if len(parts) != 3:
        raise ArgumentError(f"texture needs 'mean, deviation, correlation length', got {text!r}")
    mean, deviation = (float(units.read(part, Kind.NUMBER, "texture")) for part in parts[:2])
    correlation = float(units.read(parts[2], Kind.LENGTH, "correlation length of the texture"))
    return random(seed, mean, deviation, correlation)


def read_heights(
    units: Units,
    *,
    heights: Path | None = None,
    wave: str | None = None,
    grooves: str | None = None,
    rough: str | None = None,
    lay: str | None = None,
    seed: int = 0,
    start: str = "0",
    row: int | None = None,
    cutoff: str | None = None,
) -> Relief | None:
    """Read the heights of a surface, the sum of all that are described; None without any.

    Parameters
    ----------
    heights : Path, optional
        Table with the columns ``x`` and ``height``, or a file of a profilometer.
    wave : str, optional
        Amplitude and wavelength: ``"20 um, 2 mm"``.
    grooves : str, optional
        Width, depth and pitch, and the angle of the walls (80 deg if it is missing):
        ``"1 mm, 50 um, 3 mm, 60 deg"``.
    rough : str, optional
        Standard deviation and correlation length of random heights: ``"5 um, 100 um"``.
    lay : str, optional
        Angle between the motion and the direction across the grooves.
    start : str
        Position on the surface of x = 0 of a file.
    row, cutoff : optional
        Row of a profilometer's file, and cutoff of its filter; see `topography.read_row`.

    Raises
    ------
    ArgumentError
        If an argument is out of range.
    RecordingError
        If the table cannot be read.
    """
    textures_read = []
    about = ""
    for name, given in (
        ("start", start != "0"),
        ("row", row is not None),
        ("cutoff", bool(cutoff)),
    ):
        if given and heights is None:
            raise ArgumentError(f"heights_{name} needs a file of heights")
    if heights is not None:
        measured = _read_measured(heights, units, row, cutoff)
        offset = float(units.read(start, Kind.LENGTH, "start of the heights"))
        textures_read.append(textures.measured(measured.x + offset, measured.height))
        about = measured.about
    if wave is not None:
        textures_read.append(
            textures.wave(*_quantities(wave, units, "wave", "amplitude, wavelength"))
        )
    if grooves is not None:
        textures_read.append(_read_grooves(grooves, units))
    if rough is not None:
        what = "deviation, correlation length"
        deviation, correlation = _quantities(rough, units, "rough", what)
        textures_read.append(textures.rough(deviation, correlation, seed))
    if not textures_read:
        if lay is not None:
            raise ArgumentError("lay needs heights, wave, grooves or rough")
        return None
    texture = sum(textures_read[1:], start=textures_read[0])
    if lay is not None:
        texture = texture.with_lay(float(units.read(lay, Kind.ANGLE, "lay")))
    return Relief(texture=texture, about=about)


def _read_measured(
    path: Path, units: Units, row: int | None, cutoff: str | None
) -> topography.MeasuredRow:
    """Read heights from a table or from a file of a profilometer, in units of the rod."""
    if topography.is_topography(path):
        if units.nondimensional:
            raise ArgumentError(
                f"{path.name} has heights in micrometres: give the rod's modulus, diameter and "
                "length, too"
            )
        length = units.unit(Kind.LENGTH)
        size = 0.0 if cutoff is None else float(units.read(cutoff, Kind.LENGTH, "cutoff")) * length
        measured = topography.read_row(path, row, size)
        return measured._replace(x=measured.x / length, height=measured.height / length)
    if row is not None or cutoff is not None:
        raise ArgumentError(f"{path.name} is a table: row and cutoff are for profilometers' files")
    table = _read_along(path, "height")
    x, height = (
        table.columns[name]
        * units.column_factor(table.units.get(name, "L"), Kind.LENGTH, f"{path}: {name}")
        for name in ("x", "height")
    )
    return topography.MeasuredRow(x=x, height=height, about=f"{path.name}, as it is")


def _read_grooves(text: str, units: Units) -> Texture:
    with_wall = text if text.count(",") == 3 else f"{text}, 80 deg"
    lengths, _, wall = with_wall.rpartition(",")
    width, depth, pitch = _quantities(lengths, units, "grooves", "width, depth, pitch")
    angle = float(units.read(wall, Kind.ANGLE, "wall of the grooves"))
    return textures.grooves(width, depth, pitch, angle)


def _quantities(text: str, units: Units, what: str, names: str) -> list[float]:
    """Read lengths that are separated by commas."""
    parts = text.split(",")
    wanted = names.split(", ")
    if len(parts) != len(wanted):
        raise ArgumentError(f"{what} needs '{names}', got {text!r}")
    return [
        float(units.read(part, Kind.LENGTH, f"{name} of {what}"))
        for part, name in zip(parts, wanted, strict=True)
    ]
