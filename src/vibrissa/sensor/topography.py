"""Heights from the files of profilometers: one row of a measured area, levelled.

The files are read by surfalize. Its lengths are in micrometres.
"""

import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.wording import counted

# Group of optional packages with the library.
EXTRA = "profilometer"
MICROMETRE = 1e-6
# Endings of files that are read as tables instead.
OF_TABLES = (".csv", ".parquet")


class MeasuredRow(NamedTuple):
    """A row of a measured area.

    Attributes
    ----------
    x, height : ndarray, shape (n,)
        Positions from the first measured point of the row on, and heights, in m.
    about : str
        What was done: the row, levelling, filter, and how many points were missing.
    """

    x: FloatArray
    height: FloatArray
    about: str


def is_topography(path: Path) -> bool:
    """Whether a file of heights is one of a profilometer, by its ending."""
    return path.suffix.lower() not in OF_TABLES and path != Path("-")


def read_row(path: Path, row: int | None = None, cutoff: float = 0.0) -> MeasuredRow:
    """Read a row of a measured area.

    The area is levelled: its least-squares plane is subtracted. Missing points inside the row are
    linear between their neighbours.

    Parameters
    ----------
    row : int, optional
        Number of the row, from 1; the middle one by default.
    cutoff : float
        Cutoff wavelength of a Gaussian low-pass filter over the area (m); 0: no filter.

    Raises
    ------
    RecordingError
        If the file cannot be read, or the row has fewer than two measured points.
    ArgumentError
        If there is no such row, or the cutoff is negative.
    MissingExtraError
        If surfalize is not installed.
    """
    require(EXTRA, "surfalize")
    from surfalize import Surface

    if not 0.0 <= cutoff < np.inf:
        raise ArgumentError(f"the cutoff must be a length from 0 on, got {cutoff!r} m")
    if not path.is_file():
        raise RecordingError(f"there is no file {path}")
    with warnings.catch_warnings():
        # Pixels that are not square matter for parameters of areas, not for a row.
        warnings.simplefilter("ignore")
        try:
            area = Surface.load(path).level()
        # A damaged file may raise any error in any of the readers.
        except Exception as error:
            text = f"{path} cannot be read as a file of a profilometer: {error}"
            raise RecordingError(text) from error
        rows = area.data.shape[0]
        number = (rows + 1) // 2 if row is None else row
        if not 1 <= number <= rows:
            raise ArgumentError(f"{path} has {counted(rows, 'row')}, but row {number} is chosen")
        missing = int(np.isnan(area.data[number - 1]).sum())
        if cutoff:
            # The filter needs all points of the area.
            filled = area.fill_nonmeasured() if np.isnan(area.data).any() else area
            area = filled.filter("lowpass", cutoff / MICROMETRE)
    values = np.asarray(area.data[number - 1], dtype=float)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2:
        raise RecordingError(f"row {number} of {path} has fewer than two measured points")
    inside = np.arange(known[0], known[-1] + 1)
    height = np.asarray(np.interp(inside, known, values[known]) * MICROMETRE)
    spacing = float(area.step_x)
    about = [
        f"{path.name}, row {number} of {rows}",
        f"spacing {spacing:.6g} um",
        "levelled by a least-squares plane",
        f"Gaussian low-pass filter, cutoff {cutoff / MICROMETRE:g} um" if cutoff else "no filter",
    ]
    if missing:
        about.append(f"{counted(missing, 'point')} of the row missing")
    return MeasuredRow(
        x=np.asarray(np.arange(len(inside)) * (spacing * MICROMETRE), dtype=np.float64),
        height=height,
        about="; ".join(about),
    )
