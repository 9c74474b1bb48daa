"""Scans and readings of a study file as the data of figures."""

from collections.abc import Mapping
from typing import Any

from vibrissa.outcomes import SlipLaw
from vibrissa.study.axes import Values
from vibrissa.study.readings import ReadingSection
from vibrissa.study.scans import ScanSection
from vibrissa.study.surfaces import PLANE, SurfaceSection


class ScanData:
    """Scans as the data of a figure: their axes include those of their surfaces."""

    def __init__(self, scan: ScanSection, surfaces: Mapping[str, SurfaceSection]) -> None:
        self._scan, self._surfaces = scan, surfaces
        self.axes = self.narrowed(None, None)

    def narrowed(
        self, surface: list[str] | None, law: Values | None
    ) -> dict[str, Values | tuple[str, ...]]:
        """Return the axes that bear on scans over some surfaces, by some laws."""
        scan, axes = self._scan, dict(self._scan.axes)
        if law and set(law) <= {SlipLaw.FREE}:
            axes.pop("kinetic_ratio", None)
        if law and {SlipLaw.DAMPED}.isdisjoint(law):
            axes.pop("damping", None)
        found: dict[str, set[Any]] = {}
        known = scan.surface or []
        for name in set(surface or known) & set(known):
            for axis, values in self._surfaces[name].axes.items():
                found.setdefault(axis, set()).update(values)
        merged: dict[str, Values] = {axis: tuple(sorted(found[axis])) for axis in found}
        return {**axes, **merged, "surface": tuple(known or [PLANE])}


class ReadingData(ScanData):
    """Readings as the data of a figure: their axes include those of their scan."""

    def __init__(
        self,
        section: ReadingSection,
        scan: ScanSection,
        surfaces: Mapping[str, SurfaceSection],
    ) -> None:
        self._section = section
        super().__init__(scan, surfaces)

    def narrowed(
        self, surface: list[str] | None, law: Values | None
    ) -> dict[str, Values | tuple[str, ...]]:
        """Return the axes that bear on readings over some surfaces, by some laws."""
        own = {"transducer": self._section.transducer, "read_by": self._section.method}
        axes = super().narrowed(surface, law)
        return {**axes, **{name: tuple(sorted(values)) for name, values in own.items()}}
