"""Chunks: every point of a grid once, and the same chunks when an axis grows."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.study.axes import AXES, MOUNTING_AXES, sortable
from vibrissa.study.chunks import (
    MOST_RODS,
    ROW_ORDER,
    SIZES,
    chunks_of,
    columns_at,
    number_of_points,
    sizes_of,
)

IDEAL = dict.fromkeys(MOUNTING_AXES, (0.0,))


def axis(low, n):
    return tuple(low + i / 16 for i in range(n))


def grid(theta=3, mu0=2, eta=2, dx0=1, angles=1):
    return {
        "theta": axis(1.0, theta),
        "mu0": axis(0.1, mu0),
        "eta": axis(0.1, eta),
        "dx0": axis(0.001, dx0),
        **IDEAL,
        "clamp_angle": axis(0.0, angles),
    }


lengths = st.integers(1, 5)


@given(lengths, lengths, lengths, lengths, lengths, st.integers(1, 4), st.integers(1, 4))
def test_each_point_is_in_one_chunk(theta, mu0, eta, dx0, angles, by_theta, by_eta):
    axes = grid(theta, mu0, eta, dx0, angles)
    chunks = list(chunks_of("g", axes, {"theta": by_theta, "eta": by_eta}))
    found = [point for chunk in chunks for point in product(*chunk.axes.values())]
    assert sorted(found) == sorted(product(*axes.values())) and len(set(found)) == len(found)
    assert len({chunk.name for chunk in chunks}) == len(chunks)
    assert sum(number_of_points(chunk.axes) for chunk in chunks) == number_of_points(axes)


@pytest.mark.parametrize("longer", ["theta", "eta", "clamp_angle"])
def test_values_appended_to_an_axis_leave_the_whole_chunks_as_they_are(longer):
    axes = grid(theta=130, eta=17, angles=9)
    sizes = sizes_of(axes)
    before = {chunk.name: chunk for chunk in chunks_of("g", axes, sizes)}
    axes |= {longer: (*axes[longer], 9.0)}
    after = {chunk.name: chunk for chunk in chunks_of("g", axes, sizes_of(axes))}
    changed = [name for name, chunk in before.items() if after[name].axes != chunk.axes]
    # Only those that were not full get the value.
    assert all(len(before[name].axes[longer]) < sizes[longer] for name in changed)
    assert len(changed) < len(before)


@given(st.integers(1, 200), st.integers(1, 40), st.integers(1, 40))
def test_a_chunk_is_what_a_stopped_run_may_lose(theta, eta, angles):
    axes = grid(theta=theta, mu0=1, eta=eta, angles=angles) | {"curvature": axis(0.0, 5)}
    rods = [number_of_points(chunk.axes) for chunk in chunks_of("g", axes, sizes_of(axes))]
    assert max(rods) <= MOST_RODS
    # Not one job for each rod either.
    assert sum(rods) < 200 or sum(rods) / len(rods) > 50


def test_names_are_readable():
    (chunk,) = chunks_of("taper", grid(theta=2, eta=1), SIZES)
    assert chunk.name == "taper/theta1_eta0.1"
    curved = grid(theta=1, eta=1) | {"curvature": ((-0.1, 1e-5),), "stage_angle": (-0.2,)}
    (chunk,) = chunks_of("g", curved, SIZES)
    assert chunk.name == "g/theta1_eta0.1_curvature-0.1,0.00001_stage_angle-0.2"


def test_rows_are_in_one_order():
    axes = grid(theta=2, mu0=3, eta=2, dx0=2) | {"curvature": (-0.1, (0.0, 0.2, -0.3))}
    rows = np.arange(number_of_points(axes))
    columns = columns_at(axes, rows)
    expected = list(product(*(axes[name] for name in ROW_ORDER)))
    for place, name in enumerate(ROW_ORDER):
        assert columns[name].tolist() == [sortable(row[place])[0] for row in expected]
    curvature = ROW_ORDER.index("curvature")
    wanted = ["0.2, -0.3" if isinstance(row[curvature], tuple) else None for row in expected]
    assert columns["curvature_powers"].tolist() == wanted
    assert set(ROW_ORDER) == set(AXES)


def test_what_a_cluster_is_asked_for_grows_with_the_chunk():
    (few,) = chunks_of("g", grid(), {})
    (many,) = chunks_of("g", grid(theta=200, eta=10), {})
    assert few.minutes(False) < many.minutes(False) < many.minutes(True)
    mounted = grid(theta=20) | dict.fromkeys(MOUNTING_AXES, axis(0.0, 8))
    assert max(chunk.minutes(False) for chunk in chunks_of("g", mounted, sizes_of(mounted))) < 60
