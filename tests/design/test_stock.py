"""Diameters that can be had: how they are given, and which of them is taken."""

import numpy as np
import pytest

from vibrissa.design import DesignStatus, design, read_requirements
from vibrissa.design.stock import R20, near, read_stock
from vibrissa.errors import ArgumentError

ASKED = {
    "material": "carbon-rod",
    "transducer": "nano17-si-12-0.12",
    "step": "50 um",
    "mu0": "0.2 to 0.4",
    "theta": "1.5",
    "eta": "0.87",
    "length": "80 to 200 mm",
}


def test_a_series_is_geometric_and_from_a_tenth_of_a_millimetre_to_ten():
    assert np.array(R20) == pytest.approx(10.0 ** (np.arange(20) / 20), rel=0.015)
    sizes = read_stock("R20")
    assert (len(sizes), sizes[0], sizes[-1]) == (40, 1e-4, 9e-3)
    assert read_stock(" r10") == sizes[::2]


def test_a_list_of_ones_own_is_sorted():
    assert read_stock("1 mm, 0.5 mm, 800 um") == pytest.approx((0.0005, 0.0008, 0.001))
    for text in ("1", "1 mm, big", "0 mm", "", "R7"):
        with pytest.raises(ArgumentError, match="stock must be"):
            read_stock(text)


def test_the_nearest_on_both_sides_are_tried():
    stock = (1.0, 2.0, 3.0, 4.0, 5.0)
    assert near(stock, 3.5) == (2.0, 3.0, 4.0, 5.0)
    assert near(stock, 0.5) == (1.0, 2.0) and near(stock, 9.0) == (4.0, 5.0)
    assert near(stock, 3.0) == (2.0, 3.0, 4.0, 5.0)


def test_the_best_of_the_stock_is_taken_and_what_it_costs_is_said():
    free = design(read_requirements(**ASKED))
    found = design(read_requirements(**ASKED, stock="1 mm, 1.5 mm, 3 mm"))
    assert found.status is DesignStatus.FOUND and found.diameter == pytest.approx(1.5e-3)
    assert found.any_size is not None
    assert found.any_size.diameter == pytest.approx(free.diameter, rel=1e-6)
    assert found.deviation >= free.deviation and max(c.use for c in found.checks) <= 1 + 1e-5
    # The other size that keeps to the limits is worse.
    other = design(read_requirements(**ASKED, diameter="1 mm"))
    assert other.status is not DesignStatus.FOUND or other.deviation > found.deviation
    text = repr(found)
    assert "base         1.5 mm diameter, of the stock; the best is" in text
    assert "tip          1 mm diameter" in text and "mm from the clamp to the surface" in text


@pytest.mark.slow
def test_each_pair_has_its_deviation_with_the_size_that_was_taken():
    asked = ASKED | {"material": "music-wire", "eta": "0.8 to 0.95", "length": "20 to 200 mm"}
    found = design(read_requirements(**asked, stock="1 mm, 1.5 mm"))
    # Those too that were solved for other sizes.
    assert len(found.pair_deviation) == len(found.pairs)
    found.plot()


def test_where_no_stock_size_will_do_the_best_rod_is_shown():
    found = design(read_requirements(**ASKED, stock="6 mm, 8 mm"))
    assert found.status is DesignStatus.NONE and "(6, 8 mm)" in found.message


def test_a_diameter_and_a_stock_are_not_given_together():
    with pytest.raises(ArgumentError, match="stock must not be given with a diameter"):
        read_requirements(**ASKED, diameter="1 mm", stock="R20")
    with pytest.raises(ArgumentError, match="stock cannot be used without the material"):
        read_requirements(step="0.001", mu0="0.3", noise="1, 1, 1", stock="R20")


def test_a_rod_with_hardly_any_taper_is_said_to_be_a_cylinder():
    asked = {**ASKED, "diameter": "1 mm", "length": "100 mm"}
    assert "a cylinder will do" in repr(design(read_requirements(**asked | {"theta": "1.04"})))
    assert "cylinder" not in repr(design(read_requirements(**asked | {"theta": "1.06"})))
