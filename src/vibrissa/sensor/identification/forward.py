"""The forward model: from a set-up p and the state of each period to readings and friction.

The clamp is at X on its way, at an angle δ to the surface, so that the height is

    h(X) = η − X·sin δ.

A tip at the place x_c has the displacement x0(X) = X·cos δ + x1_init(h) − x_c from the α = 0 state
of that height. Each period has one unknown of its own, u: x0 in its last sample. The loads R(x0, h)
are those of the rod; the transducer shows (1 + Σ p_k·M_k)·R and its zeros.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.parameters import OF_ROD, Parameter
from vibrissa.sensor.identification.slips import Ends
from vibrissa.sensor.response.branch import Response, responses
from vibrissa.sensor.response.heights import (
    HIGHEST,
    LOWEST,
    HeightRange,
    Heights,
    HeightStates,
)
from vibrissa.sensor.whisker import Whisker

# Heights per part of the range of a stage, the widest part, and how much farther it is known, as
# parts of the gap 1 − η between the surface and an upright rod.
FEW, WIDE, ROOM = 4, 0.3, 0.03
# Step of a derivative: relative, in rad, or in units of the rod; a height moves by this part of
# the gap, downwards, as forces are singular at η = 1.
STEP, STEP_IN_GAP = 1e-4, 1e-3


@dataclass(frozen=True, kw_only=True)
class Way:
    """How the clamp passes the surface, all in units of the rod.

    Attributes
    ----------
    eta, angle : float
        Height with the clamp at 0 (L), and the angle of the way to the surface (rad).
    scale : float
        Way of the clamp per unit of what was recorded.
    length : float
        Length of the rod, in units of that which was given.
    """

    eta: float
    angle: float
    scale: float
    length: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Forward:
    """Forward model of one recording.

    Attributes
    ----------
    speed : ndarray
        Way of the clamp per sample at each block (L).
    delay : float
        By which the readings are known to lag, in samples.
    """

    whisker: Whisker
    parameters: tuple[Parameter, ...]
    blocks: Blocks
    speed: FloatArray
    ends: Ends
    rows: int
    delay: float = 0.0
    _solved: dict[Any, HeightRange] = field(default_factory=dict)

    @cached_property
    def number(self) -> dict[str, int]:
        """Number of each parameter, by its name."""
        return {one.name: k for k, one in enumerate(self.parameters)}

    @property
    def last(self) -> int:
        """Number of the last row."""
        return max(self.rows - 1, 1)

    @property
    def part(self) -> FloatArray:
        """Part of the recording before each block, shape (n, 1)."""
        return self.blocks.row[:, None] / self.last

    def _size(self, p: FloatArray, name: str) -> float:
        return float(p[self.number[name]]) if name in self.number else 0.0

    def way(self, p: FloatArray) -> Way:
        """How the clamp passes the surface."""
        length = 1.0 + self._size(p, "length")
        return Way(
            eta=(self.whisker.eta + self._size(p, "eta")) / length,
            angle=self.whisker.mounting.stage_angle + self._size(p, "stage_angle"),
            scale=(1.0 + self._size(p, "stage_scale")) / length,
            length=length,
        )

    def rod(self, p: FloatArray) -> Whisker:
        """Make the rod itself; its height and its way are in `way`."""
        given = self.whisker.mounting
        first, *others = np.atleast_1d(np.asarray(given.curvature, dtype=float)).tolist()
        curvature = first + self._size(p, "curvature")
        mounting = replace(
            given,
            clamp_angle=given.clamp_angle + self._size(p, "clamp_angle"),
            clamp_compliance=given.clamp_compliance + self._size(p, "clamp_compliance"),
            curvature=(curvature, *others) if others else curvature,
            stage_angle=0.0,
        )
        theta = self.whisker.theta + self._size(p, "theta")
        return replace(self.whisker, theta=theta, mounting=mounting)

    def heights(self, *sets: FloatArray) -> list[HeightRange]:
        """Solve the rods of several sets of parameters together, at the heights that they pass."""
        plans = [(self.rod(p), self._nodes(self.way(p))) for p in sets]
        keys = [(rod.theta, rod.mounting, nodes.tobytes()) for rod, nodes in plans]
        new = {key: plan for key, plan in zip(keys, plans, strict=True) if key not in self._solved}
        rods = [
            replace(rod, eta=eta) for rod, nodes in new.values() for eta in nodes.ravel().tolist()
        ]
        solved = iter(responses(rods, partly=True) if rods else ())
        for key, (_, nodes) in new.items():
            parts = tuple(_part(part, [next(solved) for _ in part]) for part in nodes)
            self._solved[key] = HeightRange(parts=parts)
        return [self._solved[key] for key in keys]

    def _nodes(self, way: Way) -> FloatArray:
        """Heights at which a rod is solved, a row for each part of their range (L)."""
        clamp = np.append(self.blocks.clamp, self.ends.clamp + self.ends.gap)
        height = way.eta - way.scale * clamp * np.sin(way.angle)
        room = ROOM * (1.0 - float(height.max()))
        low = max(float(height.min()) - room, LOWEST)
        high = min(float(height.max()) + room, HIGHEST)
        number = max(1, int(np.ceil((high - low) / (WIDE * (1.0 - high)))))
        edges = np.linspace(low, high, number + 1)
        return np.asarray(edges[:-1, None] + np.diff(edges)[:, None] * chebyshev_nodes(FEW))

    def states(
        self, p: FloatArray, u: FloatArray, heights: HeightRange
    ) -> tuple[HeightStates, FloatArray]:
        """States of the rod in all blocks, and their displacements x0 (L)."""
        states, along = self._at(self.blocks.clamp - self.delay * self.speed, p, heights)
        place = self.contact(p, u, heights)[self.blocks.period]
        return states, along + states.x1_init - place

    def _at(
        self, clamp: FloatArray, p: FloatArray, heights: HeightRange
    ) -> tuple[HeightStates, FloatArray]:
        """States at clamp positions, and the way along the surface."""
        way = self.way(p)
        moved = way.scale * clamp
        return heights.states(way.eta - moved * np.sin(way.angle)), moved * np.cos(way.angle)

    def contact(self, p: FloatArray, u: FloatArray, heights: HeightRange) -> FloatArray:
        """Position of the tip in each period, along the surface (L)."""
        states, along = self._at(self.ends.clamp, p, heights)
        return np.asarray(along + states.x1_init - u)

    def onset(
        self, p: FloatArray, u: FloatArray, heights: HeightRange
    ) -> tuple[HeightStates, FloatArray]:
        """States and displacements with the clamp on its way to the slip, shape (p, 3)."""
        ends = self.ends
        clamp = ends.clamp[:, None] + ends.gap[:, None] * np.array([0.0, 0.5, 1.0])
        states, along = self._at(clamp, p, heights)
        return states, along + states.x1_init - self.contact(p, u, heights)[:, None]

    def loads(
        self, p: FloatArray, states: HeightStates, x0: FloatArray, order: int = 0
    ) -> FloatArray:
        """Give the loads in units of the given rod, or their slopes over x0, (n, 3)."""
        at = states.clip(x0)
        found = states.slope(at) if order else states(at)
        length = self.way(p).length
        return found * np.array([length**-2, length**-2, 1.0 / length])

    def readings(self, p: FloatArray, loads: FloatArray) -> FloatArray:
        """Return the readings that the transducer gives for the loads of the blocks, (n, 3)."""
        shown = loads.copy()
        for one, size in zip(self.parameters, p, strict=True):
            if one.effect is not None and size:
                shown += size * one.effect(loads, self.part, self.last)
        return shown

    def friction(self, p: FloatArray, u: FloatArray, heights: HeightRange) -> FloatArray:
        """Friction that the tip needs on the way to its slip, shape (p, 3); up to the lock."""
        states, x0 = self.onset(p, u, heights)
        x0 = np.clip(x0, states.x0_pull, states.x0_lock)
        return np.asarray(self.ends.sign[:, None] * states.demand(x0))

    def changes(self, p: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Differentiate readings and friction over each parameter, with the u of each period.

        Returns
        -------
        ndarray, shape (k, n, 3)
        ndarray, shape (k, p)
            Friction in the middle of the step to the slip.
        """
        names = [one.name for one in self.parameters]
        step = np.where([name == "eta" for name in names], self._eta_step, STEP)
        moved = p + np.diag(step)
        of_rod = [k for k, name in enumerate(names) if name in OF_ROD]
        heights, *others = self.heights(p, *moved[of_rod])
        solved = dict(zip(of_rod, others, strict=True))
        loads = self.loads(p, *self.states(p, u, heights))
        before, friction = self.readings(p, loads), self.friction(p, u, heights)[:, 1]
        readings, frictions = np.zeros((len(p), *before.shape)), np.zeros((len(p), len(u)))
        for k, one in enumerate(self.parameters):
            if one.effect is not None:
                readings[k] = one.effect(loads, self.part, self.last)
                continue
            near = solved.get(k, heights)
            after = self.loads(moved[k], *self.states(moved[k], u, near))
            readings[k] = (self.readings(moved[k], after) - before) / step[k]
            frictions[k] = (self.friction(moved[k], u, near)[:, 1] - friction) / step[k]
        return readings, frictions

    @property
    def _eta_step(self) -> float:
        return -STEP_IN_GAP * (1.0 - self.whisker.eta)


def _part(heights: FloatArray, branches: list[Response]) -> Heights:
    """Interpolate the branch between few heights."""
    low, high = float(heights[0]), float(heights[-1])
    found = Heights(low=low, high=high, branches=tuple(branches))
    # What ends a branch, far past its lock, may change with the height.
    if len({len(branch.bounds) for branch in branches}) > 1 or not found.finite:
        raise NoResponseError(
            f"for heights from {low:.6g} to {high:.6g} (in units of L) the kind of contact changes"
        )
    return found
