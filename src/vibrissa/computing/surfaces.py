"""Surfaces and slip laws, as a study file describes them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrissa.scanning import surfaces as scanned
from vibrissa.scanning import textures
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.textures import Texture
from vibrissa.study.axes import FRICTION_AXES, LAW_AXES
from vibrissa.study.data_files import read_heights, read_profile
from vibrissa.study.surfaces import Variant


def surface_of(variant: Variant) -> Surface:
    """Make the surface that a variant of a study file describes."""
    friction, texture = _friction_of(variant), texture_of(variant)
    return friction if texture is None else friction.with_texture(texture)


def texture_of(variant: Variant) -> Texture | None:
    """Make the heights of a surface, the sum of all that a variant describes; None without any."""
    found = []
    for name, make in (
        ("wave", textures.wave),
        ("grooves", textures.grooves),
        ("rough", textures.rough),
    ):
        prefix = f"{name}_"
        values = {
            axis.removeprefix(prefix): variant[axis] for axis in variant if axis.startswith(prefix)
        }
        if values:
            found.append(make(**values))
    if "heights" in variant:
        found.append(textures.measured(*read_heights(Path(variant["heights"]))))
    if not found:
        return None
    return sum(found[1:], start=found[0]).with_lay(variant.get("lay", 0.0))


def _friction_of(variant: Variant) -> Surface:
    """Make a plane with the friction that a variant describes."""
    if "patches" in variant:
        starts, mu0 = zip(*variant["patches"], strict=True)
        return scanned.patches(starts, mu0)
    if "profile" in variant:
        return scanned.profile(*read_profile(Path(variant["profile"])))
    if "mean" in variant:
        return scanned.random(**{axis: variant[axis] for axis in FRICTION_AXES})
    return scanned.constant(variant["mu0"])


def slip_model_of(point: Mapping[str, Any]) -> SlipModel:
    """Make the slip law of a point of a study, with the values that bear on it."""
    return SlipModel.of(**{axis: point[axis] for axis in LAW_AXES if axis in point})
