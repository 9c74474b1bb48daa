"""The stage that moves the clamp, along the surface or at an angle to it, and the rod on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.steps import step_position
from vibrissa.outcomes import Contact
from vibrissa.scanning.response import Response, responses
from vibrissa.scanning.response_over_eta import (
    NARROWEST_PART,
    NEAREST,
    ResponseOverEta,
    StatesAtEta,
    check_range,
    respond_over,
)
from vibrissa.scanning.rods import MountedRod, distance_at
from vibrissa.scanning.textures import Texture

# Largest number of steps; more would fill the memory.
MOST_STEPS = 10**8
# Distance up to which a rod is solved over the grooves of a surface (L): further on it is almost
# upright, and its states change fast.
NEARLY_UPRIGHT_ETA = 0.99
# Part of a step by which a turn may miss a whole number of steps, by rounding in units of L.
ROUNDED_PART_OF_STEP = 1e-6


def path(step: Decimal | float | str, turns: Sequence[Decimal | float | str]) -> FloatArray:
    """Compute positions of a stage that moves in equal steps from 0 through all turning points.

    Parameters
    ----------
    step : Decimal or float or str
        Step of the stage (L).
    turns : sequence of Decimal or float or str
        Positions at which the stage turns; at the last one it stops (L). They are rounded to
        whole steps, towards 0.

    Returns
    -------
    ndarray
        Positions (L), the start included.

    Raises
    ------
    ArgumentError
        If the step is not positive or too small, or a part of the path is shorter than a step.
    """
    size = exact(step)
    if not size > 0:
        raise ArgumentError(f"step must be positive, got {step}")
    steps = np.diff([0, *(_steps_to(turn, size) for turn in turns)])
    if (total := abs(steps).sum()) > MOST_STEPS:
        raise ArgumentError(
            f"the step is too small: the path has {total:.3g} steps, more than {MOST_STEPS:,}"
        )
    if not steps.all():
        raise ArgumentError("each part of the path must be at least one step long")
    signs = np.repeat(np.sign(steps), np.abs(steps))
    return step_position(np.append(0, np.cumsum(signs)), size)


def _steps_to(turn: Decimal | float | str, size: Decimal) -> int:
    """Count the whole steps up to a turn, robust to the rounding of converted units."""
    quotient = exact(turn) / size
    nearest = round(quotient)
    return nearest if abs(quotient - nearest) < ROUNDED_PART_OF_STEP else int(quotient)


class Held(NamedTuple):
    """A rod whose tip sticks at a place: its states as functions of x0, and its x0 (L)."""

    states: Response | StatesAtEta
    x0: FloatArray

    @property
    def reactions(self) -> FloatArray:
        """Clamp reactions fx, fy and m, shape x0.shape + (3,); beyond the last state its own."""
        return self.states.reactions(self.states.clip(self.x0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Stage:
    """A rod on a stage that moves along the surface, or at an angle δ to it.

    With the clamp at X, the clamp–surface distance is η(X) of `distance_at`. A tip at the position
    x_c has the displacement from the α = 0 state of that distance

        x0(X) = x1_init(η(X)) + side·(X·cos δ − x_c),

    where side is 1 for a tip ahead of the clamp, and −1 for a tip behind it (mirrored states). On a
    surface with heights, the height h of the surface at the tip is subtracted from η(X).

    Attributes
    ----------
    response : Response or ResponseOverEta
        Response of the rod at the one distance of a level stage, or at all distances to which an
        oblique stage or the heights of a surface take it.
    eta : float
        Clamp–surface distance with the clamp at 0 (L).
    angle : float
        δ (rad); positive: the clamp approaches the surface as it moves.
    """

    response: Response | ResponseOverEta
    eta: float
    angle: float = 0.0

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Convert clamp positions along the stage to positions along the surface (L)."""
        return np.asarray(np.asarray(clamp) * np.cos(self.angle))

    def distance(self, clamp: ArrayLike, height: ArrayLike = 0.0) -> FloatArray:
        """Distance η(X) − h of the contact point from the clamp (L), across the surface.

        On a level stage it has the shape of `height`.
        """
        if self.angle == 0.0:
            return np.asarray(self.eta - np.asarray(height))
        return distance_at(clamp, self.eta, self.angle) - np.asarray(height)

    def room(self, clamp: ArrayLike, height: ArrayLike = 0.0) -> FloatArray:
        """How far the distance is within the range at which the rod is solved (L)."""
        distance = self.distance(clamp, height)
        if isinstance(self.response, Response):
            return np.full(distance.shape, np.inf)
        return np.minimum(
            distance - self.response.parts[0].low, self.response.parts[-1].high - distance
        )

    def at(self, clamp: ArrayLike, height: ArrayLike = 0.0) -> Response | StatesAtEta:
        """Return the rod's states at the distance that belongs to each clamp position."""
        if isinstance(self.response, Response):
            return self.response
        return self.response.states(self.distance(clamp, height))

    def states(
        self, clamp: ArrayLike, contact: ArrayLike, side: ArrayLike, height: ArrayLike = 0.0
    ) -> Held:
        """Return the rod's states, and the displacement x0 of each (L).

        Parameters
        ----------
        clamp : array_like
            Positions of the clamp (L).
        contact : array_like
            Position of the tip along the surface (L).
        side : array_like
            1 for a tip ahead of the clamp, −1 for a tip behind it.
        height : array_like
            Height of the surface at the tip (L).
        """
        states, ahead = self.at(clamp, height), self.along(clamp) - np.asarray(contact)
        return Held(states, np.asarray(states.x1_init + np.asarray(side) * ahead))


def stage_of(
    rod: MountedRod, positions: FloatArray, partly: bool = False, texture: Texture | None = None
) -> Stage:
    """Solve a rod at all distances from the surface that its clamp reaches on its stage.

    Parameters
    ----------
    positions : ndarray
        Positions of the clamp along the stage (L).
    partly : bool
        Whether to accept a curve on a level stage that the solver did not follow to its end.
    texture : Texture, optional
        Heights of the surface. Where they leave the range that a rod can reach, the stage ends: see
        `Stage.room`.

    Raises
    ------
    NoResponseError
        If the sticking curve cannot be solved at one of these distances, or η comes too close to
        0 or to 1.
    ArgumentError
        If the surface has heights, and the rod may lie down on it.
    """
    angle = rod.mounting.stage_angle
    if texture is None and angle == 0.0:
        return Stage(response=responses([rod], partly)[0], eta=rod.eta)
    reached = rod.distance(np.append(positions, 0.0))
    low, high = float(reached.min()), float(reached.max())
    if texture is not None:
        if rod.contact is Contact.LINE:
            raise ArgumentError("on a surface with heights the contact must be 'point', not 'line'")
        check_range(rod, low, high)
        low = max(low - _margin(texture.high), NEAREST)
        high = max(high, min(high + _margin(-texture.low), NEARLY_UPRIGHT_ETA))
    return Stage(response=respond_over(rod.level(rod.eta), low, high), eta=rod.eta, angle=angle)


def _margin(height: float) -> float:
    """Margin of distances at which a rod is solved for crests or valleys of a height (L).

    It is a little more, and one of few values, so that a rod need not be solved for each texture.
    """
    doublings = np.ceil(np.log2(1.0 + max(height, 0.0) / NARROWEST_PART))
    return float(NARROWEST_PART * 2.0**doublings)
