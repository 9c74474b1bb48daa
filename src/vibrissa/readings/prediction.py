"""The uncertainty of μ0 that `vibrissa design` predicts for the rod of a point."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrissa.design import Requirements, design
from vibrissa.errors import VibrissaError
from vibrissa.quantities.units import Kind
from vibrissa.readings.reading import Stated
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.surfaces import HEIGHT_KEYS

# Without a stated yield strain the rod may be strained as much as it likes.
ANY_STRAIN = 1.0


def predicted_of(point: Mapping[str, Any], stated: Stated) -> float:
    """Return the standard deviation of μ0 from one period that a design predicts; NaN if none.

    A design is for a plane of one friction, an ideal mounting and a transducer with noise. It
    takes the law ``free``, and 30 periods in a recording.
    """
    mu0 = point.get("mu0", point.get("mean"))
    uneven = any(key.split("_")[0] in HEIGHT_KEYS for key in point)
    if mu0 is None or uneven or any(point[name] for name in MOUNTING_AXES):
        return np.nan
    rod = stated.rod
    if not {"material", "yield_strain"} & rod.keys():
        rod = {**rod, "yield_strain": ANY_STRAIN}
    try:
        found = design(
            Requirements.read(
                mu0=f"{mu0!r}",
                step=f"{point['dx0'] * Kind.LENGTH.read(rod['length'], 'length')!r} m",
                theta=f"{point['theta']!r}",
                eta=f"{point['eta']!r}",
                transducer=point.get("card", point["transducer"]),
                contact=stated.contact,
                section=stated.section,
                tolerances=dict(stated.tolerances),
                assume=stated.assume,
                **rod,
            )
        )
    except VibrissaError:
        return np.nan
    return float(found.best.whole[0])
