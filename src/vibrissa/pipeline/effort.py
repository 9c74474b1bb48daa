"""What a study will take, estimated before it is begun."""

from collections.abc import Callable
from dataclasses import dataclass

from vibrissa.pipeline.blocks import Blocks
from vibrissa.study import boxes, costs
from vibrissa.study.model import TRAVEL, Study
from vibrissa.wording import counted


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a study has, and what of it is to be done.

    Attributes
    ----------
    points, curves : int
        Of the study, each once.
    new : int
        Curves that are not solved yet.
    jobs : int
        Blocks that these curves are in: one job solves each.
    seconds : float
        Until the report is there (s), by as many cores as were given.
    size : float
        Of the results when all is done (bytes).
    """

    points: int
    curves: int
    new: int
    jobs: int
    seconds: float
    size: float

    def __str__(self) -> str:
        """Return one line for the screen."""
        counts = f"{counted(self.points, 'point')}, {counted(self.curves, 'curve')}"
        if not self.new:
            return f"{counts} (all solved), {_size(self.size)}"
        time = f"about {_time(self.seconds)}"
        return (
            f"{counts} ({self.new:,} new), {counted(self.jobs, 'job')}, {time}, {_size(self.size)}"
        )


def effort(study: Study, blocks: Blocks, is_solved: Callable[[str], bool], cores: int) -> Effort:
    """Estimate what a study takes.

    Parameters
    ----------
    study : Study
    blocks : dict
        Its blocks, by name.
    is_solved : callable
        Tells by its name whether a block has been solved.
    cores : int
        Jobs that run at the same time.

    Returns
    -------
    Effort
    """
    unsolved = [block for name, block in blocks.items() if not is_solved(name)]
    new = sum(map(boxes.size, unsolved))
    points = sum(map(boxes.size, boxes.disjoint(vars(grid) for grid in study.point_grids.values())))
    curves = sum(map(boxes.size, study.curves))
    scans = study.scan_steps(TRAVEL)
    work = (
        2 * len(unsolved) * costs.USUAL_JOB
        + sum(costs.usual_curve_seconds(block, study.method, study.contact) for block in unsolved)
        + points * (new / max(curves, 1)) * costs.POINT
        + len(study.scans) * costs.USUAL_JOB
        + scans * costs.USUAL_STEP
        + len(study.figures) * costs.FIGURE
        + (costs.CLAIMS if study.claims else 0.0)
    )
    size = (
        curves * costs.CURVE_BYTES
        + points * costs.POINT_BYTES
        + scans * costs.STEP_BYTES
        + len(study.figures) * costs.FIGURE_BYTES
    )
    return Effort(
        points=points,
        curves=curves,
        new=new,
        jobs=len(unsolved),
        seconds=costs.USUAL_START + work / max(cores, 1) + costs.REPORT,
        size=size,
    )


def _time(seconds: float) -> str:
    for unit, length in (("d", 86_400), ("h", 3_600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"


def _size(size: float) -> str:
    for unit, length in (("TB", 1e12), ("GB", 1e9)):
        if size >= length:
            return f"{size / length:.1f} {unit}"
    return f"{max(size / 1e6, 1.0):.0f} MB"
