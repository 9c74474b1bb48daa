"""Set-ups beside the given one, and derivatives with respect to their parameters."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from vibrissa.numerics.arrays import FloatArray
from vibrissa.scanning.rods import MountedRod
from vibrissa.sensor.identification.parameters import OF_MOUNTING

AnyRod = TypeVar("AnyRod", bound=MountedRod)


def moved(rod: AnyRod, size: Mapping[str, float]) -> AnyRod:
    """Return a rod after a change.

    The height of the result is in units of its own length.

    Parameters
    ----------
    size : mapping
        Deviations by the names of their parameters; others are 0.
    """
    return replace(
        rod,
        theta=rod.theta + size.get("theta", 0.0),
        eta=(rod.eta + size.get("eta", 0.0) - size.get("tip_radius", 0.0))
        / (1.0 + size.get("length", 0.0)),
        mounting=rod.mounting.shifted(**{name: size.get(name, 0.0) for name in OF_MOUNTING}),
    )


def scale_of(size: Mapping[str, float]) -> float:
    """Return true travel in true lengths of the rod, over recorded travel in given lengths."""
    return (1.0 + size["stage_scale"]) / (1.0 + size["length"])


def derivatives(
    values: FloatArray | float,
    changed: Mapping[str, FloatArray],
    steps: Mapping[str, float],
) -> dict[str, FloatArray]:
    """Differentiate quantities of a set-up with respect to parameters, by difference quotients.

    Parameters
    ----------
    values : ndarray
        The quantities in one set-up.
    changed : mapping
        The quantities in set-ups in each of which one parameter has another value, by its name.
    steps : mapping
        Changes of these parameters; see `Parameter.step`.
    """
    return {name: (there - values) / steps[name] for name, there in changed.items()}
