"""Whole designs as they were: pairs, limits, sizes, the mesh of the search, and what is told."""

from dataclasses import replace

import numpy as np
import pytest

from known import Known
from vibrissa import Rod
from vibrissa.design import Requirements, design, read_requirements
from vibrissa.design.limits import limits_of
from vibrissa.design.materials import MATERIALS
from vibrissa.design.pairs import Pairs, survey
from vibrissa.design.sizes import best_sizes, deviations, nearest_sizes
from vibrissa.design.tolerances import tolerance_limits
from vibrissa.outcomes import Contact
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.recording import WITH_ROD

KNOWN = Known(__file__)
USUAL = {
    "material": "music-wire",
    "transducer": "nano17-si-12-0.12",
    "mu0": "0.2 to 0.4",
    "step": "50 um",
}
# A search ends on a mesh of lengths; linear programs and adjustments end with a remainder.
SEARCHED = 2e-6


@pytest.fixture(scope="module", params=list(Contact))
def pairs(request):
    """Some rods; the last locks within the range of friction."""
    eta = np.array([0.9, 0.85, 0.8, 0.95])
    found, failures = survey(np.array([1.0, 2.0, 4.0, 1.5]), eta, asked().frictions, request.param)
    assert not failures
    return request.param, found


def asked(**others):
    return read_requirements(**USUAL | others)


def columns(batch):
    return {name: getattr(batch, name) for name in batch.names()}


def test_pairs_have_the_same_columns(pairs):
    contact, found = pairs
    KNOWN.check(f"pairs, {contact}", columns(found))


@pytest.mark.parametrize(("method", "room"), [("forces", 1.0), ("forces", 2.0), ("moment", 1.0)])
def test_limits_have_the_same_bounds_and_values(pairs, method, room):
    contact, found = pairs
    names = ("strain", "force_x", "lock", "steps", "tip", "thickest", "shortest", "weight", "touch")
    wanted = replace(
        asked(method=method, spacing="5 mm", density="7800 kg/m^3"),
        contact=contact,
        room=dict.fromkeys(names, room),
    )
    size = np.full(len(found), 1e-3), np.linspace(0.05, 0.15, len(found))
    limits = {
        limit.name: {
            "what": f"{limit.kind}, {limit.meaning}",
            "bound": limit.bound,
            "upper": limit.upper,
            "powers": [float(limit.p), float(limit.q)],
            "size": [limit.size, limit.given],
            "room": limit.room,
            "value": limit.value(*size),
            "line": [*limit.line.constant.tolist(), float(limit.line.p), float(limit.line.q)],
        }
        for limit in limits_of(wanted, found)
    }
    KNOWN.check(f"limits, {contact}, {method}, room {room:g}", limits)


@pytest.mark.parametrize("method", WITH_ROD)
def test_the_best_and_the_nearest_sizes_are_the_same(pairs, method):
    contact, found = pairs
    wanted = replace(asked(method=method), contact=contact)
    diameter = np.full((len(found), 2), 1e-3)
    parts = deviations(wanted, found, diameter, np.array([0.05, 0.15]) * np.ones_like(diameter))
    strict = replace(wanted, yield_strain=0.001)
    KNOWN.check(
        f"sizes, {contact}, {method}",
        {
            "by_step": parts.by_step,
            "by_reading": parts.by_reading,
            "total": parts.total,
            "largest": parts.largest,
            "best": columns(best_sizes(wanted, found)),
            "none": columns(best_sizes(strict, found)),
            "nearest": columns(nearest_sizes(strict, found)),
        },
        SEARCHED,
    )


def whole(found):
    names = ("theta", "eta", "diameter", "length", "mu_lock", "x0_slip", "mu0", "deviation")
    result = {
        "message": found.message,
        **{name: getattr(found, name) for name in names},
        "by_step": found.deviations.by_step,
        "by_reading": found.deviations.by_reading,
        "active": found.active_constraints,
        "relaxed": found.relaxed,
        "uses": {check.name: [check.value, check.bound, check.use] for check in found.checks},
        # Of limits that are both used up, rounding decides which comes first.
        "told": sorted(repr(found).splitlines()),
        "columns": {
            name: [column.values[0], column.unit] for name, column in found.columns().items()
        },
    }
    if isinstance(found.pairs, Pairs):
        # Where the mesh was refined.
        result |= {"pairs": found.pairs.theta, "heights": found.pairs.eta}
        result["pair_deviation"] = np.where(
            np.isfinite(found.pair_deviation), found.pair_deviation, -1.0
        )
    if found.any_size is not None:
        result["any_size"] = [found.any_size.diameter, found.any_size.deviation]
    return result


DESIGNS = {
    "heights are searched": {"theta": "2", "length": "50 to 150 mm"},
    "tapers are searched": {"eta": "0.88", "method": "moment"},
    "a stock": {"theta": "1.5", "eta": "0.87", "stock": "1 mm, 1.5 mm, 3 mm"},
    "a stock that will not do": {"theta": "1.5", "eta": "0.87", "stock": "6 mm, 8 mm"},
    "none": {"theta": "2", "eta": "0.8 to 0.9", "material": "steel-s235", "length": "50 mm"},
    "a friction that locks": {
        "theta": "2",
        "eta": "0.85",
        "mu0": "0.3 to 0.6",
        "length": "100 mm",
        "diameter": "1 mm",
    },
    "a rod that is given": {"theta": "2", "eta": "0.9", "length": "150 mm", "diameter": "1 mm"},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_is_the_same_from_the_mesh_to_its_text(name):
    told = []
    found = design(asked(**DESIGNS[name]), lambda *done: told.append(list(done)))
    KNOWN.check(name, {**whole(found), "progress": told[:: max(1, len(told) // 5)]}, SEARCHED)


@pytest.mark.slow
def test_a_design_without_units_is_the_same():
    wanted = Requirements.nondimensional(
        mu0=(0.2, 0.3), step=5e-4, noise=(0.003, 0.003, 0.0002), theta=(1.0, 3.0), eta=(0.9, 0.9)
    )
    KNOWN.check("without units", whole(design(wanted)), SEARCHED)


def test_materials_have_the_same_values():
    KNOWN.check(
        "materials",
        {
            name: [one.modulus, one.yield_strain, one.density, one.name]
            for name, one in MATERIALS.items()
        },
    )


@pytest.mark.slow
def test_tolerances_cost_the_same():
    whisker = Whisker(theta=1.2, eta=0.88, rod=Rod(200e9, 1.2e-3, 0.18))
    wanted = asked(theta="1.2", eta="0.88", diameter="1.2 mm", length="180 mm")
    found = tolerance_limits(wanted, whisker.tolerating({"theta": 0.01}), 0.3, 0.002)
    KNOWN.check(
        "tolerances",
        {
            "common": found.common,
            "periods": found.periods,
            "parts": {
                one.name: [one.tolerance, one.alone, one.halved, one.stated] for one in found.parts
            },
            "told": str(found).splitlines(),
        },
        1e-4,
    )
