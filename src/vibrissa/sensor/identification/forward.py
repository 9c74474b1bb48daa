"""The forward model: from a set-up p and the state of each period to readings and friction.

The clamp is at X on its way, at an angle δ to the surface, so that the height is

    h(X) = η − X·sin δ.

A tip at the place x_c has the displacement x0(X) = X·cos δ + x1_init(h) − x_c from the α = 0 state
of that height. Each period has one unknown of its own, u: x0 in its last sample. The loads R(x0, h)
are those of the rod; the transducer shows (1 + Σ p_k·M_k)·R and its zeros.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.parameters import OF_ROD, Parameter
from vibrissa.sensor.identification.slips import Ends, speed_of
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.response.branch import Response, responses
from vibrissa.sensor.response.heights import HIGHEST, LOWEST, HeightRange, Heights, HeightStates
from vibrissa.sensor.whisker import Whisker

# Heights per part of the range of a stage, the widest part, and how much farther it is known, as
# parts of the gap 1 − η between the surface and an upright rod.
FEW, WIDE, ROOM = 4, 0.3, 0.03
# Step of a derivative: relative, in rad, or in units of the rod; a height moves by this part of
# the gap, downwards, as forces are singular at η = 1.
STEP, STEP_IN_GAP = 1e-4, 1e-3


class Way(NamedTuple):
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

    def height(self, clamp: FloatArray) -> FloatArray:
        """Height of the surface above the clamp (L)."""
        return self.eta - self.scale * clamp * np.sin(self.angle)

    def along(self, clamp: FloatArray) -> FloatArray:
        """Way along the surface (L)."""
        return self.scale * clamp * np.cos(self.angle)


@dataclass(frozen=True, eq=False, kw_only=True)
class Forward:
    """Forward model of a recording of a rod, which is that of the given set-up."""

    task: Task
    whisker: Whisker
    _solved: dict[Any, HeightRange] = field(default_factory=dict)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Deviations from the given set-up."""
        return self.task.parameters

    @property
    def blocks(self) -> Blocks:
        """The recording condensed."""
        return self.task.blocks

    @property
    def ends(self) -> Ends:
        """How the periods end."""
        return self.task.slipped.ends

    @cached_property
    def clamp(self) -> FloatArray:
        """Positions of the clamp that the readings of the blocks show, shape (n,)."""
        speed = speed_of(self.task.slipped.recording.clamp)
        return self.blocks.clamp - self.task.delay * speed[self.blocks.row.astype(int)]

    @cached_property
    def number(self) -> dict[str, int]:
        """Number of each parameter, by its name."""
        return {one.name: k for k, one in enumerate(self.parameters)}

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

    def _rod(self, p: FloatArray) -> Whisker:
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

    def at(self, *sets: FloatArray) -> list["SetUp"]:
        """Solve the rods of several set-ups together, at the heights that they pass.

        Raises
        ------
        NoResponseError
            If one of them has no response.
        """
        ways = [self.way(p) for p in sets]
        plans = [(self._rod(p), self._nodes(way)) for p, way in zip(sets, ways, strict=True)]
        keys = [(rod.theta, rod.mounting, nodes.tobytes()) for rod, nodes in plans]
        new = {key: plan for key, plan in zip(keys, plans, strict=True) if key not in self._solved}
        rods = [
            replace(rod, eta=eta) for rod, nodes in new.values() for eta in nodes.ravel().tolist()
        ]
        solved = iter(responses(rods, partly=True) if rods else ())
        for key, (_, nodes) in new.items():
            parts = tuple(_part(part, [next(solved) for _ in part]) for part in nodes)
            self._solved[key] = HeightRange(parts=parts)
        return [
            SetUp(forward=self, p=p, way=way, heights=self._solved[key])
            for p, way, key in zip(sets, ways, keys, strict=True)
        ]

    def _nodes(self, way: Way) -> FloatArray:
        """Heights at which a rod is solved, a row for each part of their range (L)."""
        height = way.height(np.append(self.blocks.clamp, self.ends.clamp + self.ends.gap))
        room = ROOM * (1.0 - float(height.max()))
        low = max(float(height.min()) - room, LOWEST)
        high = min(float(height.max()) + room, HIGHEST)
        number = max(1, int(np.ceil((high - low) / (WIDE * (1.0 - high)))))
        edges = np.linspace(low, high, number + 1)
        return np.asarray(edges[:-1, None] + np.diff(edges)[:, None] * chebyshev_nodes(FEW))


@dataclass(frozen=True, eq=False, kw_only=True)
class SetUp:
    """A set-up p, and the rod at all heights that its stage passes.

    Contacts `u`, shape (p,), are displacements x0 in the last samples of the periods (L).
    """

    forward: Forward
    p: FloatArray
    way: Way
    heights: HeightRange

    def contact(self, u: FloatArray) -> FloatArray:
        """Position of the tip in each period, along the surface (L)."""
        clamp = self.forward.ends.clamp
        x1_init = self.heights.states(self.way.height(clamp)).x1_init
        return np.asarray(self.way.along(clamp) + x1_init - u)

    def _at(self, clamp: FloatArray, contact: FloatArray) -> tuple[HeightStates, FloatArray]:
        """States at clamp positions, and displacements, with the tip at given places."""
        states = self.heights.states(self.way.height(clamp))
        return states, self.way.along(clamp) + states.x1_init - contact

    def states(self, u: FloatArray) -> tuple[HeightStates, FloatArray]:
        """States of the rod in all blocks, and their displacements x0 (L)."""
        return self._at(self.forward.clamp, self.contact(u)[self.forward.blocks.period])

    def onset(self, u: FloatArray) -> tuple[HeightStates, FloatArray]:
        """States and displacements with the clamp on its way to the slip, shape (p, 3)."""
        ends = self.forward.ends
        clamp = ends.clamp[:, None] + ends.gap[:, None] * np.array([0.0, 0.5, 1.0])
        return self._at(clamp, self.contact(u)[:, None])

    def friction(self, u: FloatArray) -> FloatArray:
        """Friction that the tip needs on the way to its slip, shape (p, 3); up to the lock."""
        states, x0 = self.onset(u)
        x0 = np.clip(x0, states.x0_pull, states.x0_lock)
        return np.asarray(self.forward.ends.sign[:, None] * states.demand(x0))

    def loads(self, states: HeightStates, x0: FloatArray, order: int = 0) -> FloatArray:
        """Give the loads in units of the given rod, or their slopes over x0, (n, 3)."""
        at, length = states.clip(x0), self.way.length
        return states.derivative(at, order) * np.array([length**-2, length**-2, 1.0 / length])

    @property
    def _rows(self) -> tuple[FloatArray, int]:
        """Part of the recording before each block, shape (n, 1), and the number of the last row."""
        last = self.forward.task.slipped.last
        return self.forward.blocks.row[:, None] / last, last

    def readings(self, loads: FloatArray) -> FloatArray:
        """Return the readings that the transducer gives for the loads of the blocks, (n, 3)."""
        shown, rows = loads.copy(), self._rows
        for one, size in zip(self.forward.parameters, self.p, strict=True):
            if one.effect is not None and size:
                shown += size * one.effect(loads, *rows)
        return shown

    def changes(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Differentiate readings and friction over each parameter, with the u of each period.

        Returns
        -------
        ndarray, shape (k, n, 3)
        ndarray, shape (k, p)
            Friction in the middle of the step to the slip.
        """
        forward, loads = self.forward, self.loads(*self.states(u))
        parameters, rows = forward.parameters, self._rows
        before, friction = self.readings(loads), self.friction(u)[:, 1]
        readings = np.zeros((len(parameters), *before.shape))
        frictions = np.zeros((len(parameters), len(u)))
        step = np.full(len(parameters), STEP)
        step[forward.number["eta"]] = -STEP_IN_GAP * (1.0 - forward.whisker.eta)
        moved = self.p + np.diag(step)
        of_rod = [k for k, one in enumerate(parameters) if one.name in OF_ROD]
        solved = dict(zip(of_rod, forward.at(*moved[of_rod]), strict=True))
        for k, one in enumerate(parameters):
            if one.effect is not None:
                readings[k] = one.effect(loads, *rows)
                continue
            near = solved.get(k) or replace(self, p=moved[k], way=forward.way(moved[k]))
            after = near.loads(*near.states(u))
            readings[k] = (near.readings(after) - before) / step[k]
            frictions[k] = (near.friction(u)[:, 1] - friction) / step[k]
        return readings, frictions


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
