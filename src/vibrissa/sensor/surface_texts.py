"""Surfaces described by texts with units, or measured in a table."""

from pathlib import Path

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.quantities.units import Kind, Quantity, Units
from vibrissa.scanning.surfaces import Surface, constant, patches, profile, random


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
    mu0 = [float(units.read_positive(one, Kind.NUMBER, "mu0 of a patch")) for *_, one in pairs]
    return patches(starts, mu0)


def _read_profile(path: Path, units: Units) -> Surface:
    table = series.read(path, ["x", "mu0"])
    missing = np.isnan(table.columns["x"] + table.columns["mu0"])
    if missing.any():
        raise RecordingError(f"{table.place(int(np.argmax(missing)))}: x or mu0 is missing")
    factor = units.column_factor(table.units.get("x", "L"), Kind.LENGTH, f"{path}: x")
    return profile(table.columns["x"] * factor, table.columns["mu0"])


def _read_texture(text: str, seed: int, units: Units) -> Surface:
    parts = text.split(",")
    if len(parts) != 3:
        raise ArgumentError(f"texture needs 'mean, deviation, correlation length', got {text!r}")
    mean, deviation = (float(units.read(part, Kind.NUMBER, "texture")) for part in parts[:2])
    correlation = float(units.read(parts[2], Kind.LENGTH, "correlation length of the texture"))
    return random(seed, mean, deviation, correlation)
