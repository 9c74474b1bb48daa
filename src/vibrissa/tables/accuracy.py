"""Accuracy of friction that was read from recordings: bias, errors and coverage at each point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.outcomes import ReadingStatus
from vibrissa.study.axes import AXES, LAW_AXES, POWERS, SURFACE_AXES
from vibrissa.wording import counted

if TYPE_CHECKING:
    import pandas as pd

# What identifies a point of readings.
POINT = (
    "readings",
    *AXES,
    *POWERS.values(),
    "surface",
    *SURFACE_AXES,
    *LAW_AXES,
    "transducer",
    "read_by",
)
# Columns of the table of friction from which accuracy is computed.
COLUMNS = (
    "status",
    "grade",
    "mu0_true",
    "mu0_read",
    "mu0_deviation",
    "mu0_random",
    "mu0_common",
    "inside",
    "period_error",
    "period_deviation",
    "predicted",
    "way",
)
# Stated coverage of the intervals.
STATED = 0.95


def accuracy(rows: pd.DataFrame, by: Sequence[str] = POINT) -> pd.DataFrame:
    """Compare the friction that was read with the truth, at each point.

    Parameters
    ----------
    rows : DataFrame
        Rows of the table of friction, with `COLUMNS` and those of `by`.
    by : sequence of str
        Columns that identify a point.

    Returns
    -------
    DataFrame
        A row for each point, with the columns of `by` and:

        - ``recordings``, ``estimates``: number of recordings, and of those with an estimate;
        - ``refused``, ``doubted``: part without an estimate, and part with an estimate in doubt;
        - ``bias``, ``bias_error``: mean error of the estimates, and its standard error;
        - ``rms``, ``rms_error``: root mean square of the errors, and its standard error;
        - ``stated``, ``random``, ``common``: root mean squares of the standard deviations that the
          method states, and of their parts;
        - ``coverage``, ``coverage_error``: part of the 95 % intervals that contain the truth, and
          the binomial standard error √(0.95·0.05/n) of n intervals that do so with probability
          0.95;
        - ``period_error``, ``period_stated``: root mean squares over single periods of the error,
          and of the stated standard deviation;
        - ``predicted``: standard deviation of a single period that a design predicts;
        - ``way``: mean way of the clamp (m).
    """
    error = rows["mu0_read"] - rows["mu0_true"]
    estimated = rows["status"] == ReadingStatus.READ
    squares = rows.assign(
        recordings=1,
        estimates=estimated.astype(int),
        refused=(~estimated).astype(float),
        doubted=(estimated & rows["grade"].notna()).astype(float),
        bias=error,
        bias_error=error,
        rms=error**2,
        rms_error=0.0,
        stated=rows["mu0_deviation"] ** 2,
        random=rows["mu0_random"] ** 2,
        common=rows["mu0_common"] ** 2,
        coverage=rows["inside"].astype(float),
        coverage_error=0.0,
        period_error=rows["period_error"] ** 2,
        period_stated=rows["period_deviation"] ** 2,
    )
    kept = {name: "mean" for name in squares if name in ("refused", "doubted", "predicted", "way")}
    kept |= dict.fromkeys(("bias", "coverage", "coverage_error", "rms_error"), "mean")
    kept |= dict.fromkeys(("recordings", "estimates"), "sum") | {"bias_error": "std"}
    roots = ("rms", "stated", "random", "common", "period_error", "period_stated")
    kept |= dict.fromkeys(roots, "mean")
    found = squares.groupby(list(by), dropna=False, sort=False).agg(kept).reset_index()
    number = found["estimates"].where(found["estimates"] > 0)
    found[list(roots)] = np.sqrt(found[list(roots)])
    # The standard error of a root mean square of n normal errors.
    found["rms_error"] = found["rms"] / np.sqrt(2.0 * number)
    found["bias_error"] /= np.sqrt(number)
    found["coverage_error"] = np.sqrt(STATED * (1.0 - STATED) / number)
    return found


def sentences(rows: pd.DataFrame) -> list[str]:
    """Write the accuracy of each of the readings by each method as a line."""
    found = accuracy(rows, ("readings", "read_by"))
    lines = []
    for one in found.itertuples():
        told = f"{one.readings}, by {one.read_by}: {counted(one.recordings, 'recording')}"
        told += f", {one.refused:.0%} without an estimate, {one.doubted:.0%} in doubt"
        if one.estimates:
            told += (
                f"; error of mu0 {one.rms:.2g} (rms), stated {one.stated:.2g}, bias {one.bias:+.1g}"
                f"; {one.coverage:.1%} ± {one.coverage_error:.1%} of the 95 % intervals hold the "
                "truth"
            )
        lines.append(told)
    return lines
