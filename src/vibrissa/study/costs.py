"""What solving, reading and writing cost: at most, for jobs; usually, for what a run says first.

What a job may take was measured on one core of a busy machine, for η from 0.05 to 0.97 and θ up to
40, and rounded up: the most is at small η. Where η > 0.75 and θ <= 4, a curve takes a tenth of it.
What things usually take was measured with many curves in a job; docs/speed.md has the numbers.
"""

import math
from collections.abc import Sequence
from decimal import Decimal
from functools import cache
from statistics import fmean

from vibrissa.outcomes import Contact, Solver
from vibrissa.study.boxes import Box, size
from vibrissa.study.grid import Grid

# Seconds that a job should work at most: with room for slower machines, twice this fits in the
# half hour that short partitions allow.
LONGEST_JOB = 600
# Seconds for a curve: in line contact; in tip contact, times θ, and at most; by shooting.
LINE, TIP, TIP_MOST, SHOOTING = 0.3, 0.12, 1.0, 120
# Seconds for a point that is read off a curve; for a step of a scan, if a cycle is as long as the
# rod; and for a single state.
POINT, STEP, STATE = 15e-6, 250e-6, 1
# Usual seconds for a curve: in line contact; in tip contact, times θ²; by shooting.
USUAL_LINE, USUAL_TIP, USUAL_SHOOTING = 0.02, 0.7e-3, 10
# Usual seconds for the start of a run, and of a job; for a step that a scan really takes; for a
# figure, the claims and the report.
USUAL_START, USUAL_JOB, USUAL_STEP = 3.0, 1.0, 0.5e-3
FIGURE, CLAIMS, REPORT = 1.8, 5.0, 1.0
# Files (bytes), blocks and tables together: for a curve, a point, a step of a scan and a figure.
CURVE_BYTES, POINT_BYTES, STEP_BYTES, FIGURE_BYTES = 4_400, 260, 4_500, 1_000_000
# Minutes: for a job to start, and what requests are rounded up to (with few different ones).
START, ROUND = 5, 5
# Points from which their table is collected in several threads: with fewer, one takes a minute at
# most, and half of their memory.
LONG_TABLE = 20_000_000
# MB: three processes of Snakemake and one that solves; for each curve that this one solves.
PROCESSES, CURVE = 800, 0.1
MB_ROUND = 100


def curve_seconds(curves: Box, method: Solver, contact: Contact) -> float:
    """Return the seconds that solving some curves may take.

    Parameters
    ----------
    curves : Box
    method : Solver
    contact : Contact

    Returns
    -------
    float
    """
    if method is Solver.SHOOTING:
        return SHOOTING * size(curves)
    if contact is Contact.LINE:
        return LINE * size(curves)
    return size(curves) * _mean_seconds(curves["theta"])


def usual_curve_seconds(curves: Box, method: Solver, contact: Contact) -> float:
    """Return the seconds that solving some curves usually takes; see `curve_seconds`."""
    if method is Solver.SHOOTING:
        return USUAL_SHOOTING * size(curves)
    if contact is Contact.LINE:
        return USUAL_LINE * size(curves)
    return size(curves) * _usual_mean_seconds(curves["theta"])


# Many blocks have the same values of θ.
@cache
def _mean_seconds(thetas: tuple[Decimal, ...]) -> float:
    return fmean(min(TIP * float(theta), TIP_MOST) for theta in thetas)


@cache
def _usual_mean_seconds(thetas: tuple[Decimal, ...]) -> float:
    return USUAL_TIP * fmean(float(theta) ** 2 for theta in thetas)


def scan_seconds(grid: Grid, cycles: int) -> float:
    """Return the seconds that scans at the points of a grid may take, some cycles each.

    The clamp moves by less than the rod's length in a cycle.
    """
    scans = len(grid.theta) * len(grid.mu0) * len(grid.eta)
    return STEP * scans * cycles * float(sum(1 / step for step in grid.dx0))


def comparison_seconds(theta: Sequence[Decimal], eta: Sequence[Decimal]) -> float:
    """Return the seconds that solving curves in both kinds of contact may take."""
    curves = {"theta": tuple(theta), "eta": tuple(eta)}
    return sum(curve_seconds(curves, Solver.COLLOCATION, contact) for contact in Contact)


def minutes(seconds: float) -> int:
    """Return the minutes to ask a cluster for: twice the work, and the start of the job."""
    return ROUND * math.ceil((START + 2 * seconds / 60) / ROUND)


def megabytes(curves: int) -> int:
    """Return the memory to ask a cluster for.

    Parameters
    ----------
    curves : int
        Curves that the job holds in memory.

    Returns
    -------
    int
        MB.
    """
    return MB_ROUND * math.ceil((PROCESSES + CURVE * curves) / MB_ROUND)


def collecting_threads(points: int, cores: int) -> int:
    """Return the threads in which the table of so many points is collected."""
    return cores if points > LONG_TABLE else 1
