"""The states of the rod nearest to the readings, and detection of columns that are mixed up."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from vibrissa.errors import MixedColumnsError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.scanning.response_over_eta import check_range
from vibrissa.sensor.identification.forward import kept_responses
from vibrissa.sensor.identification.recording import FORCES
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# Number of states of the rod in the table.
STATES_IN_TABLE = 4001
# Number of samples with which a mix-up is tested.
TESTED_SAMPLES = 300
# Squared residual, in standard deviations, above which a sample is no state of the rod.
MISFIT = 36.0
# Factor by which the squared residuals must fall if a mix-up is undone: residuals fall by 15.
UNDONE_FALL = 225.0
# Ratio of two units that are confused, such as mN and N.
THOUSAND = 1e3


class Nearest(NamedTuple):
    """States of the rod that are nearest to n readings.

    Attributes
    ----------
    x0, squares : ndarray, shape (n,)
        Displacements of the states (L), and their squared distances in standard deviations.
    """

    x0: FloatArray
    squares: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class StateTable:
    """States of the rod at one height, among which the nearest to readings is found.

    Attributes
    ----------
    x0 : ndarray, shape (m,)
        Displacements of m states (L).
    loads : ndarray, shape (m, 3)
        Clamp reactions of the states.
    """

    task: Task
    x0: FloatArray
    loads: FloatArray

    @cached_property
    def _by_noise(self) -> KDTree:
        return KDTree(self.task.weighted(self.loads))

    def nearest(self, readings: FloatArray) -> Nearest:
        """Find the states nearest to n readings, in standard deviations of the readings."""
        distance, place = self._by_noise.query(self.task.weighted(readings))
        return Nearest(x0=self.x0[place], squares=distance**2)

    @cached_property
    def _largest(self) -> FloatArray:
        return np.asarray(np.abs(self.loads[:, self.task.used]).max(axis=0))

    @cached_property
    def _by_size(self) -> KDTree:
        return KDTree(self.loads[:, self.task.used] / self._largest)

    def misfit(self, readings: FloatArray) -> float:
        """Median distance of n readings from the nearest states, as a part of the readings.

        Each channel counts in units of its largest load.
        """
        parts = readings[:, self.task.used] / self._largest
        return float(np.median(self._by_size.query(parts)[0] / np.linalg.norm(parts, axis=1)))

    def least_misfit(self, readings: FloatArray) -> float:
        """Return a lower bound of `misfit`, by the distances from a box around all states."""
        parts = readings[:, self.task.used] / self._largest
        states = self._by_size
        beyond = np.maximum(np.maximum(states.mins - parts, parts - states.maxes), 0.0)
        return float(np.median(np.linalg.norm(beyond, axis=1) / np.linalg.norm(parts, axis=1)))


def table_of_states(task: Task, whisker: Whisker) -> StateTable:
    """Make a table of the states of the rod.

    The table is made at one height, the mean of the least and the largest height on the stage.

    Raises
    ------
    NoResponseError
        If the rod has no response, or the stage brings the clamp too near to the surface or too far
        from it.
    """
    heights = whisker.distance(task.recording.clamp)
    low, high = float(heights.min()), float(heights.max())
    check_range(whisker, low, high)
    (branch,) = kept_responses(whisker.level(0.5 * (low + high)))
    x0 = np.linspace(branch.x0_pull, branch.x0_end, STATES_IN_TABLE)
    loads = branch.reactions(x0)
    if len(task.used) == 1:
        # One channel distinguishes the states only as long as it grows.
        back = np.flatnonzero(np.diff(task.weighted(loads)[:, 0]) <= 0.0)
        x0 = x0[: int(back[0]) + 1] if len(back) else x0
    return StateTable(task=task, x0=x0, loads=loads[: len(x0)])


def check_columns(task: Task, table: StateTable) -> None:
    """Refuse a recording that fits the rod much better if a mix-up of columns is undone.

    Raises
    ------
    MixedColumnsError
        If columns seem to be mixed up; the message names the likeliest mix-up.
    """
    rows = np.linspace(0, len(task.recording) - 1, TESTED_SAMPLES).astype(int)
    sample = np.nan_to_num(task.recording.readings[rows])

    def misfits(mixed: FloatArray) -> FloatArray:
        return table.nearest(sample @ mixed.T).squares

    unmixed = float(np.median(misfits(np.eye(3))))
    if unmixed <= MISFIT:
        return
    mix_ups = dict(_mix_ups(task.used))
    least = {text: float(np.median(misfits(mixed))) for text, mixed in mix_ups.items()}
    text = min(least, key=lambda text: least[text])
    size = (task.weighted(sample @ mix_ups[text].T) ** 2).sum(axis=1)
    # If the rod is the wrong one, no mix-up brings the readings near to its states.
    if least[text] < min(unmixed, float(np.median(size))) / UNDONE_FALL:
        raise MixedColumnsError(
            f"the columns or their units seem to be mixed up: {text}. Correct that by vibrissa "
            "import --column 'CHANNEL=TITLE [UNIT]'; a minus before the title turns the sign"
        )


def _mix_ups(used: list[int]) -> Iterator[tuple[str, FloatArray]]:
    """Mix-ups of the used channels, each with the matrix that undoes it, (3, 3)."""
    orders = {"": np.eye(3)}
    if set(FORCES) <= set(used):
        orders["force_x and force_y are swapped"] = np.eye(3)[[1, 0, 2]]
    for (swap, order), signs in product(orders.items(), product((1.0, -1.0), repeat=3)):
        wrong = ", ".join(CHANNELS[i] for i in used if signs[i] < 0.0)
        texts = [swap, f"the sign of {wrong} is wrong" if wrong else ""]
        mix_up = "; after swapping them, ".join(filter(None, texts))
        if mix_up:
            yield mix_up, np.diag(signs) @ order
    for name, channels in (("force_x and force_y", FORCES), ("moment_z", [2])):
        for factor, size in ((THOUSAND, "small"), (1.0 / THOUSAND, "large")):
            each = np.ones(3)
            each[channels] = factor
            if set(channels) <= set(used):
                yield f"the stated unit of {name} is 1000 times too {size}", np.diag(each)
