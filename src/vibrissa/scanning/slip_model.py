"""Slip laws: where a slip ends, and what it needs."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.outcomes import SlipLaw as SlipLaw
from vibrissa.outcomes import chosen


@dataclass(frozen=True, kw_only=True)
class SlipModel:
    """A slip law, with the values that it needs.

    Attributes
    ----------
    law : SlipLaw
    kinetic_ratio : float
        Kinetic over static friction μk/μ0, above 0 and at most 1; the law ``free`` has none.
    damping : float or None
        Damping ratio ζ of the rod, from 0: the law ``damped`` needs it, and no other law has it.

    Raises
    ------
    ArgumentError
        If a value is out of range, or the law lacks what it needs.
    """

    law: SlipLaw = SlipLaw.FREE
    kinetic_ratio: float = 0.8
    damping: float | None = None

    def __post_init__(self) -> None:
        """Check all values."""
        if not 0.0 < self.kinetic_ratio <= 1.0:
            raise ArgumentError(
                f"kinetic_ratio must be above 0 and at most 1, got {self.kinetic_ratio!r}"
            )
        if self.law is not SlipLaw.DAMPED:
            if self.damping is not None:
                raise ArgumentError(
                    f"the law '{self.law}' has no damping: remove damping, or take the law 'damped'"
                )
        elif self.damping is None:
            raise ArgumentError("the law 'damped' needs damping, the damping ratio of the rod")
        elif not 0.0 <= self.damping < np.inf:
            raise ArgumentError(f"damping must be a number from 0, got {self.damping!r}")

    @classmethod
    def of(
        cls, law: SlipLaw | str, kinetic_ratio: float = 0.8, damping: float | None = None
    ) -> Self:
        """Make the model of a law that is given by its name; see `SlipModel`."""
        return cls(law=chosen(SlipLaw, law, "law"), kinetic_ratio=kinetic_ratio, damping=damping)

    @property
    def loss(self) -> float:
        """Part of the largest kinetic energy that the rod's vibration loses by its damping.

        A damped vibration keeps the part e^(−2πζ) of its energy in half a wave. A slip that inertia
        plays no part in loses all of its kinetic energy, and one by the law ``energy`` nothing.
        """
        if self.damping is not None:
            return float(-np.expm1(-2.0 * np.pi * self.damping))
        return 0.0 if self.law is SlipLaw.ENERGY else 1.0


FREE_SLIP = SlipModel()
