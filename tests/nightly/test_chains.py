"""A chain of links in space has the energies of the planar states, and swings where they say."""

import numpy as np
import pytest

from validation import chains
from validation.rod_chain import Chain


@pytest.mark.slow
def test_the_energies_of_a_tip_ahead_of_the_clamp_and_behind_it_are_those_of_the_planar_rod():
    found = chains.compare((1.0, 0.85, "point"), 0.1, 1, np.random.default_rng(3), (10, 20, 40))
    assert found.off < 1e-5
    assert found.aside < 1e-3
    # Kept in its plane, the rod is bent more.
    assert found.straight_on > 1.1 * found.rod


@pytest.mark.slow
def test_so_are_those_of_a_rod_whose_tail_lies_on_the_surface():
    found = chains.compare((4.0, 0.6, "line"), 0.1, 1, np.random.default_rng(3), (8, 16, 32))
    assert found.off < 1e-5 and found.aside < 1e-3
    assert found.straight_on > 1.1 * found.rod


def test_the_tail_of_a_relaxed_chain_is_straight_and_in_the_plane_of_the_surface():
    chain = Chain(3.0, 8, 0.6, tail=True)
    assert chain.lengths.sum() == pytest.approx(1.0)
    bent = chain.planar(lambda s: np.pi / 2 - 1.2 * s)
    relaxed, _ = chain.minimum(np.array([0.2, 0.5, 0.0]), bent)
    contact, tangents, *_ = chain.links(relaxed)
    assert contact == pytest.approx([0.2, 0.5, 0.0], abs=1e-7)
    assert tangents[8:, 1] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(relaxed[8:]).max() < 1e-6


@pytest.mark.parametrize("tail", [False, True])
def test_the_conditions_change_as_their_derivatives_say(tail):
    chain = Chain(4.0, 5, 0.7, tail=tail)
    random, target = np.random.default_rng(0), np.array([0.1, 0.6, 0.0])
    v, change = (0.3 * random.normal(size=(len(chain.stiffness), 3)) for _ in range(2))
    plus, minus = (chain.misses(v + h * change, target)[0] for h in (1e-6, -1e-6))
    slopes = np.einsum("ijk,jk->i", chain.misses(v, target)[1], change)
    assert (plus - minus) / 2e-6 == pytest.approx(slopes, abs=1e-8)


def test_a_series_in_the_square_of_the_links_length_is_extrapolated_to_its_limit():
    values = [2.0 + 3.0 / n**2 - 5.0 / n**4 for n in (10, 20, 40)]
    assert chains.extrapolated(values) == pytest.approx(2.0, abs=1e-13)
