"""The forward model: readings and friction for a set-up and the x0 at the end of each period.

With the clamp at X, the distance η(X) and the displacement x0(X) are those of `Stage`. Each period
has one unknown u: x0 in its last sample. From the loads R(x0, η) of the rod the transducer makes
the readings (1 + Σ p_k·M_k)·R plus its zeros, where M_k is the matrix of the parameter p_k of the
transducer.

A tip may be a ball of the radius r that rolls on the surface. The rod ends in its centre C, at the
height η − r, which moves forward by r·φ1 as the rod turns. The rod has the energy W(C) without a
moment at its end. To first order in r its energy with the ball is that of the same C, as φ1 makes
the energy stationary. The forces on the surface are its derivatives by the contact point:

    Fx = fx·(1 + r·∂φ1/∂x),   Fy = fy + fx·r·∂φ1/∂y,

where fx, fy and φ1 are those of the rod without a ball, at C. The moment on the clamp follows from
the equilibrium of the rod.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.scanning.response import Response, States, responses
from vibrissa.scanning.response_over_eta import (
    FARTHEST,
    NEAREST,
    EtaPart,
    ResponseOverEta,
    StatesAtEta,
    check_range,
)
from vibrissa.scanning.stage import Held, Stage
from vibrissa.sensor.identification.derivatives import derivatives, moved, scale_of
from vibrissa.sensor.identification.parameters import OF_ROD, PARAMETER_STEP
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# The range of heights is cut into parts. This is the width of the widest one, over the gap 1 − η
# between the surface and an upright rod.
WIDEST_PART = 0.3
# Margin at the ends of the range, over this gap.
RANGE_MARGIN = 0.03
# Number of heights in each part.
HEIGHTS_IN_PART = 4
# Width of a narrow range, which is not cut, as a part of the gap.
NARROW_RANGE = 0.1
# Number of heights in a narrow range: loads that are interpolated in it have errors below 1e-5 of
# their size, which neighbouring set-ups share.
HEIGHTS_IN_NARROW_RANGE = 3
# Number of stated set-ups, and of their changes by single parameters, whose responses are kept for
# other recordings, a few megabytes each.
KEPT_SET_UPS = 8


class Changes(NamedTuple):
    """Derivatives with respect to k parameters of the set-up, at constant u.

    Attributes
    ----------
    readings : ndarray, shape (k, n, 3)
        Derivatives of the readings in n blocks of samples.
    friction : ndarray, shape (k, p)
        Derivatives of the friction of p periods, in the middle of the step in which the tip slips.
    """

    readings: FloatArray
    friction: FloatArray


def forward_models(
    task: Task, given: Whisker, *sets: FloatArray, keep: bool = False
) -> list["ForwardModel"]:
    """Solve the rods of several set-ups together, at the heights that the stage passes.

    Parameters
    ----------
    *sets : ndarray, shape (k,)
        Deviations p of each set-up from the given one.
    keep : bool
        Whether to keep the responses for other recordings of the same stated set-up.

    Raises
    ------
    NoResponseError
        If one of the rods has no response.
    """
    sizes = [task.sizes_of(p) for p in sets]
    rods = [moved(given, size) for size in sizes]
    ends = task.ends
    way = np.append(task.blocks.clamp, ends.clamp + ends.gap)
    nodes = [
        _nodes(rod, rod.distance(scale_of(size) * way))
        for rod, size in zip(rods, sizes, strict=True)
    ]
    levels = [
        rod.level(eta)
        for rod, heights in zip(rods, nodes, strict=True)
        for eta in heights.ravel().tolist()
    ]
    solved = iter(kept_responses(*levels) if keep else responses(levels, partly=True))
    parts = [[_part(part, [next(solved) for _ in part]) for part in heights] for heights in nodes]
    return [
        ForwardModel(task=task, given=given, p=p, heights=ResponseOverEta(parts=tuple(of_rod)))
        for p, of_rod in zip(sets, parts, strict=True)
    ]


@lru_cache(KEPT_SET_UPS)
def kept_responses(*rods: Whisker) -> list[Response]:
    """Solve the responses of rods, and keep the last ones."""
    return responses(rods, partly=True)


def _nodes(whisker: Whisker, height: FloatArray) -> FloatArray:
    """Heights at which a rod is solved, a row for each part of their range (L)."""
    low, high = float(height.min()), float(height.max())
    check_range(whisker, low, high)
    room = RANGE_MARGIN * (1.0 - high)
    low, high = max(low - room, NEAREST), min(high + room, FARTHEST)
    if high - low < NARROW_RANGE * (1.0 - high):
        return np.asarray(low + (high - low) * chebyshev_nodes(HEIGHTS_IN_NARROW_RANGE))[None]
    # From part to part the gap to an upright rod grows by the same factor.
    number = max(1, int(np.ceil(np.log((1.0 - low) / (1.0 - high)) / np.log1p(WIDEST_PART))))
    edges = 1.0 - np.geomspace(1.0 - low, 1.0 - high, number + 1)
    return np.asarray(edges[:-1, None] + np.diff(edges)[:, None] * chebyshev_nodes(HEIGHTS_IN_PART))


@dataclass(frozen=True, eq=False, kw_only=True)
class ForwardModel:
    """A set-up that deviates from the given one by p, with its rod at all heights of the stage.

    The argument `u` of its methods is x0 in the last sample of each period (L). In shapes, k
    is the number of parameters, n that of blocks of samples, and p that of periods.
    """

    task: Task
    given: Whisker
    p: FloatArray
    heights: ResponseOverEta

    @cached_property
    def size(self) -> dict[str, float]:
        """Deviation p of each parameter, by the parameter's name."""
        return self.task.sizes_of(self.p)

    @property
    def radius(self) -> float:
        """Radius of the tip (L)."""
        return self.size["tip_radius"]

    def at(self, clamp: FloatArray, contact: ArrayLike) -> Held:
        """States of the rod at clamp positions, and their x0 if the tip is at `contact` (L)."""
        rod = moved(self.given, self.size)
        clamp = scale_of(self.size) * clamp
        stage = Stage(response=self.heights, eta=rod.eta, angle=rod.mounting.stage_angle)
        return stage.states(clamp, contact, 1)

    def rolled(self, clamp: FloatArray, contact: ArrayLike) -> Held:
        """States as by `at`, where a round tip has rolled forward by r·φ1 from `contact`."""
        states, x0 = self.at(clamp, contact)
        if self.radius:
            x0 = x0 - self.radius * states.tip_angle(states.clip(x0))
        return Held(states, x0)

    def contact(self, u: FloatArray) -> FloatArray:
        """Position of the tip in each period, along the surface (L)."""
        return self.at(self.task.ends.clamp, u)[1]

    def states(self, u: FloatArray) -> Held:
        """States of the rod in all blocks of samples, and their displacements x0 (L)."""
        return self.rolled(self.task.shown, self.contact(u)[self.task.blocks.period])

    def onset(self, u: FloatArray) -> Held:
        """States of the rod, and x0 (L), in the step of the clamp in which the tip slips.

        Each period has three: at the start, middle and end of the step, shape (p, 3).
        """
        ends = self.task.ends
        clamp = ends.clamp[:, None] + ends.gap[:, None] * np.array([0.0, 0.5, 1.0])
        return self.rolled(clamp, self.contact(u)[:, None])

    def friction(self, u: FloatArray) -> FloatArray:
        """Mobilised friction in the step of the clamp in which the tip slips.

        Each period has three values: at the start, middle and end of the step, shape (p, 3). Past
        the lock the value is that at the lock, and past the end of pulling it is that at this end.
        """
        states, x0 = self.onset(u)
        at = np.clip(x0, states.x0_pull, states.x0_lock)
        fx, fy, _ = np.moveaxis(self._of_ball(states, at), -1, 0)
        return np.asarray(self.task.ends.sign[:, None] * fx / fy)

    def _of_ball(self, states: States, x0: FloatArray) -> FloatArray:
        """Return the loads on the clamp with the tip of this set-up, shape x0.shape + (3,)."""
        loads = states.derivative(x0, 0)
        if not (self.radius and isinstance(states, StatesAtEta)):
            return loads
        fx = loads[..., 0]
        ahead = states.x1_init - x0
        higher = self.heights.states(states.eta + PARAMETER_STEP)
        angle = states.tip_angle(x0)
        before = states.clip(x0 - PARAMETER_STEP)
        along = (states.tip_angle(before) - angle) / np.where(
            before < x0, x0 - before, PARAMETER_STEP
        )
        upward = (higher.tip_angle(higher.clip(higher.x1_init - ahead)) - angle) / PARAMETER_STEP
        more_x, more_y = self.radius * fx * along, self.radius * fx * upward
        moment = ahead * more_y - states.eta * more_x - self.radius * (fx + more_x)
        return np.asarray(loads + np.stack([more_x, more_y, moment], axis=-1))

    def loads(self, states: States, x0: FloatArray, order: int = 0) -> FloatArray:
        """Return the loads at x0, or their derivatives with respect to x0, shape (n, 3).

        `order` is the order of the derivatives. Units are those of the given rod.
        """
        at = states.clip(x0)
        length = 1.0 + self.size["length"]
        loads = states.derivative(at, order) if order else self._of_ball(states, at)
        return loads * np.array([length**-2, length**-2, 1.0 / length])

    def readings(self, loads: FloatArray) -> FloatArray:
        """Return the transducer's readings for the loads in n blocks of samples, shape (n, 3)."""
        return np.asarray(self.scaled(loads) + self.zeros)

    def scaled(self, loads: FloatArray) -> FloatArray:
        """Return the readings of a transducer whose zeros are right: a linear function of loads."""
        return self._shown(loads, of_zero=False)

    @cached_property
    def zeros(self) -> FloatArray:
        """Zeros of the channels in n blocks of samples, shape (n, 3)."""
        return self._shown(np.zeros((len(self.task.blocks), len(CHANNELS))), of_zero=True)

    def _shown(self, loads: FloatArray, of_zero: bool) -> FloatArray:
        """Add to loads the effects of all parameters of zeros, or of all others."""
        shown = loads
        for parameter, size in zip(self.task.parameters, self.p, strict=True):
            if parameter.effect is not None and size and parameter.of_zero is of_zero:
                shown = shown + size * parameter.effect(loads, self.task.rows)
        return shown

    def changes(self, u: FloatArray) -> Changes:
        """Differentiate readings and friction with respect to each parameter, at constant `u`."""
        parameters = self.task.parameters
        steps = {parameter.name: parameter.step for parameter in parameters}
        sets = dict(zip(steps, self.p + np.diag([*steps.values()]), strict=True))
        # The rod is solved anew where its own properties change, and only moved elsewhere.
        of_rod = [sets[name] for name in OF_ROD]
        solved = forward_models(self.task, self.given, *of_rod, keep=not self.p.any())
        near = {
            parameter.name: replace(self, p=sets[parameter.name])
            for parameter in parameters
            if parameter.effect is None
        } | dict(zip(OF_ROD, solved, strict=True))
        loads = self.loads(*self.states(u))
        near_loads = {name: model.loads(*model.states(u)) for name, model in near.items()}
        near_friction = {name: model.friction(u)[:, 1] for name, model in near.items()}
        of_loads = derivatives(loads, near_loads, steps)
        of_friction = derivatives(self.friction(u)[:, 1], near_friction, steps)
        readings = [
            self.scaled(of_loads[parameter.name])
            if parameter.effect is None
            else parameter.effect(loads, self.task.rows)
            for parameter in parameters
        ]
        # A parameter of the transducer does not change the friction under the tip.
        none = np.zeros(len(u))
        friction = [of_friction.get(parameter.name, none) for parameter in parameters]
        return Changes(readings=np.stack(readings), friction=np.stack(friction))


def _without_lock(branch: Response) -> FloatArray:
    """Return all landmarks but the lock: kinks may pass it, and reactions are smooth there."""
    return np.unique([branch.x0_pull, 0.0, *branch.kinks, branch.x0_end])


def _up_to_lock(branch: Response) -> FloatArray:
    """Return landmarks without kinks past the lock, which may exist at some heights only."""
    bounds = branch.bounds
    return bounds[(bounds <= branch.x0_lock) | (bounds == branch.x0_end)]


def _part(heights: FloatArray, branches: list[Response]) -> EtaPart:
    """Interpolate responses between a few heights."""
    low, high = float(heights[0]), float(heights[-1])
    for choose in (lambda branch: branch.bounds, _without_lock, _up_to_lock):
        bounds = [choose(branch) for branch in branches]
        if len({len(marks) for marks in bounds}) == 1:
            return EtaPart(low=low, high=high, branches=tuple(branches), bounds=np.array(bounds))
    raise NoResponseError(
        f"the kind of contact changes between the heights {low:.6g} and {high:.6g} (units of L)"
    )
