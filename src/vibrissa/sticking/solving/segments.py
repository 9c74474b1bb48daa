"""Branches of equilibria, and segments of them: states at equal steps of one parameter."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import Closure, advance, contact_position
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Parameter


@dataclass(frozen=True, eq=False, kw_only=True)
class Branches(Batch):
    """A batch of branches: what they belong to and the α = 0 states in which they begin.

    Attributes
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    scale, force : ndarray, shape (n,)
        Contact point (L) and contact force (E·I0/L²) in the α = 0 state of the same rod in the
        ideal mounting: the units of steps and of the advance.
    stage_angle : ndarray, shape (n,), or None
        Angle δ of the clamp's way to the surface (rad); None where it moves along the surface.
    """

    theta: FloatArray
    eta: FloatArray
    x1_init: FloatArray
    scale: FloatArray
    force: FloatArray
    stage_angle: FloatArray | None = None

    @property
    def height(self) -> FloatArray:
        """Right side of E2."""
        if self.stage_angle is None:
            return self.eta
        return self.eta - np.tan(self.stage_angle) * self.x1_init

    def closure(self, parameter: Parameter, contact: Contact, value: FloatArray) -> Closure:
        """Conditions that hold at given values of the parameter."""
        if parameter is Parameter.X0:
            return self.tilted(Closure.at_offset(self.offset(value), contact))
        return self.tilted(Closure.at_advance(value, self.x1_init, self.force, contact, self.scale))

    def tilted(self, closure: Closure) -> Closure:
        """Conditions with E2 for the way of the clamp."""
        if self.stage_angle is None:
            return closure
        return replace(closure, tilt=np.tan(self.stage_angle))

    def value_of(self, parameter: Parameter, states: RodStates) -> FloatArray:
        """Value of the parameter in given states."""
        if parameter is Parameter.X0:
            return self.displacement(contact_position(states)[0])
        return advance(states, self.x1_init, self.force, self.scale)

    def offset(self, x0: FloatArray) -> FloatArray:
        """Contact point from the clamp after displacements of the clamp (L)."""
        return self.x1_init - (x0 if self.stage_angle is None else x0 * np.cos(self.stage_angle))

    def displacement(self, offset: FloatArray) -> FloatArray:
        """Inverse of `offset`."""
        x0 = self.x1_init - offset
        return x0 if self.stage_angle is None else x0 / np.cos(self.stage_angle)


@dataclass(frozen=True, eq=False, kw_only=True)
class Segment:
    """States at equal steps of one parameter along a batch of branches, NaN where one has ended.

    Attributes
    ----------
    parameter : Parameter
        What the steps are steps of.
    branches : Branches
    origin, step : ndarray, shape (n,)
        Parameter of the first state and its increment (x0 in L).
    steps : list of RodStates
        One batch for each step.
    line : ndarray of bool, shape (steps, n)
        Whether a state is in line contact.
    """

    parameter: Parameter
    branches: Branches
    origin: FloatArray
    step: FloatArray
    steps: list[RodStates]
    line: BoolArray

    def take(self, index: IntArray) -> "Segment":
        """Select branches."""
        return replace(
            self,
            branches=self.branches.take(index),
            origin=self.origin[index],
            step=self.step[index],
            steps=[states.take(index) for states in self.steps],
            line=self.line[:, index],
        )

    @property
    def forces(self) -> tuple[FloatArray, FloatArray]:
        """Contact forces fx and fy, each of shape (steps, n)."""
        return np.stack([s.fx for s in self.steps]), np.stack([s.fy for s in self.steps])

    @property
    def last(self) -> IntArray:
        """Index of the last state of each branch, -1 where there is none."""
        return np.isfinite(self.forces[0]).sum(axis=0) - 1

    def with_branches(self, index: IntArray, other: "Segment") -> "Segment":
        """Replace some branches by those of another segment, which may have fewer steps."""
        steps, line = [states.copy() for states in self.steps], self.line.copy()
        for number, states in enumerate(steps):
            known = number < len(other.steps)
            source = other.steps[number] if known else other.steps[0].unsolved()
            states.put(index, source)
            line[number, index] = other.line[number if known else -1]
        return replace(self, steps=steps, line=line)

    def at(self, k: IntArray) -> tuple[RodStates, BoolArray]:
        """State `k[i]` of each branch i, and whether it is in line contact."""
        states = self.steps[0].copy()
        for number in np.unique(k):
            chosen = np.flatnonzero(k == number)
            states.put(chosen, self.steps[number].take(chosen))
        return states, self.line[k, np.arange(len(k))]


# Maps a segment and a number of its last steps to whether its branches go on after each of them,
# shape (steps, branches).
GoesOn = Callable[[Segment, int], BoolArray]


class StepSizes(NamedTuple):
    """How closely branches are followed.

    Attributes
    ----------
    nodes : int
        Number of collocation nodes.
    x0 : float
        Step of the first segment, relative to x1_init.
    advance : float
        Step of the second segment.
    """

    nodes: int
    x0: float
    advance: float


# How branches are followed: more closely where the step sizes before lead nowhere, or past a change
# of the contact. The pieces have nodes and states of their own.
STEP_SIZES = (
    StepSizes(nodes=24, x0=0.05, advance=0.15),
    StepSizes(nodes=48, x0=0.02, advance=0.03),
    StepSizes(nodes=108, x0=0.01, advance=0.005),
)
