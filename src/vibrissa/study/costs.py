"""What solving, reading and writing cost: at most, for jobs; usually, for what a run says first.

What a job may take was measured on one core of a busy machine, for η from 0.05 to 0.97 and θ up to
40, and rounded up: the most is at small η. Where η > 0.75 and θ <= 4, a curve takes a tenth of it.
What things usually take was measured with many curves in a job; docs/speed.md has the numbers.
"""

import math
from collections.abc import Sequence
from decimal import Decimal

from vibrissa.outcomes import Contact, Solver
from vibrissa.study.grid import CurveKey, Grid

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
# MB: three processes of Snakemake and one that solves; for each curve that this one solves; for
# each curve of the study, in the plan that Snakemake reads.
PROCESSES, CURVE, PLANNED = 800, 0.1, 0.002
MB_ROUND = 100


def curve_seconds(keys: Sequence[CurveKey], method: Solver, contact: Contact) -> float:
    """Return the seconds that solving some curves may take.

    Parameters
    ----------
    keys : sequence of CurveKey
    method : Solver
    contact : Contact

    Returns
    -------
    float
    """
    if method is Solver.SHOOTING:
        return SHOOTING * len(keys)
    if contact is Contact.LINE:
        return LINE * len(keys)
    return sum(min(TIP * float(key.theta), TIP_MOST) for key in keys)


def usual_curve_seconds(keys: Sequence[CurveKey], method: Solver, contact: Contact) -> float:
    """Return the seconds that solving some curves usually takes; see `curve_seconds`."""
    if method is Solver.SHOOTING:
        return USUAL_SHOOTING * len(keys)
    if contact is Contact.LINE:
        return USUAL_LINE * len(keys)
    return USUAL_TIP * sum(float(key.theta) ** 2 for key in keys)


def scan_seconds(grid: Grid, cycles: int) -> float:
    """Return the seconds that scans at the points of a grid may take, some cycles each.

    The clamp moves by less than the rod's length in a cycle.
    """
    scans = len(grid.theta) * len(grid.mu0) * len(grid.eta)
    return STEP * scans * cycles * float(sum(1 / step for step in grid.dx0))


def comparison_seconds(theta: Sequence[Decimal], eta: Sequence[Decimal]) -> float:
    """Return the seconds that solving curves in both kinds of contact may take."""
    keys = [CurveKey(theta=value, eta=eta[0]) for value in theta]
    kinds = (curve_seconds(keys, Solver.COLLOCATION, contact) for contact in Contact)
    return len(eta) * sum(kinds)


def minutes(seconds: float) -> int:
    """Return the minutes to ask a cluster for: twice the work, and the start of the job."""
    return ROUND * math.ceil((START + 2 * seconds / 60) / ROUND)


def megabytes(curves: int, planned: int) -> int:
    """Return the memory to ask a cluster for.

    Parameters
    ----------
    curves : int
        Curves that the job holds in memory.
    planned : int
        Curves of the study.

    Returns
    -------
    int
        MB.
    """
    return MB_ROUND * math.ceil((PROCESSES + CURVE * curves + PLANNED * planned) / MB_ROUND)
