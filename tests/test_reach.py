"""Shapes that the model cannot describe are named, not returned."""

import numpy as np
import pytest

from vibrissa import Status, solve_curve, solve_state
from vibrissa.equilibrium import ContactStates, shape
from vibrissa.reach import BELOW, CROSSES_ITSELF, CROSSES_SURFACE, REASONS, violations
from vibrissa.spectral import gauss_rule
from vibrissa.status import Contact, End


def rod(slope, nodes=64):
    """A cylinder with the slope phi(s) given as a function."""
    s = gauss_rule(nodes).nodes
    one = np.ones(1)
    return ContactStates(one, slope(s)[None], 0 * one, -one, one)


def seen(states, eta, contact=Contact.LINE):
    flags = violations(states, np.array([eta]), contact)[0]
    return [reason for reason, flag in zip(REASONS, flags, strict=True) if flag]


def test_an_upright_rod_is_fine():
    assert seen(rod(lambda s: np.pi / 2 - 0.3 * s), 0.99) == []


def test_a_rod_that_hangs_below_its_clamp():
    assert BELOW in seen(rod(lambda s: np.pi / 2 - 1.6 * np.pi * s), 0.5, Contact.POINT)


def test_a_rod_that_rises_above_the_surface_before_it_touches():
    # Up over the line, down through it and up to it again.
    arch = rod(lambda s: np.pi / 2 + 3.5 * np.sin(2 * np.pi * s) * s)
    top = shape(arch, np.linspace(0, 1, 401))[1].max()
    assert CROSSES_SURFACE in seen(arch, top - 1e-3)
    assert CROSSES_SURFACE not in seen(arch, top + 1e-3)


def test_a_loop_crosses_itself_and_an_open_bow_does_not():
    loop = rod(lambda s: np.pi / 2 + 2.6 * np.pi * s)
    bow = rod(lambda s: np.pi / 2 + 1.1 * np.pi * s)
    assert CROSSES_ITSELF in seen(loop, 0.9, Contact.POINT)
    assert CROSSES_ITSELF not in seen(bow, 0.9, Contact.POINT)


def test_where_a_rod_begins_to_cross_itself_agrees_with_its_drawn_shape():
    curve = solve_curve(15.0, 0.5)
    assert curve.end is End.OUT_OF_REACH and CROSSES_ITSELF in curve.end_message

    def crossings(x0):
        state = solve_state(15.0, 0.5, curve.x1_init - x0)
        if state.status is not Status.SOLVED:
            return None
        x, y, _ = state.shape(np.linspace(0, 1, 801))
        return count_crossings(x, y)

    assert crossings(0.995 * curve.x0_end) == 0
    beyond = solve_state(15.0, 0.5, curve.x1_init - 1.01 * curve.x0_end)
    assert beyond.status is Status.OUT_OF_REACH and CROSSES_ITSELF in beyond.message
    assert np.isnan(beyond.f)
    with pytest.raises(ValueError, match="out_of_reach"):
        beyond.shape()


def count_crossings(x, y):
    """By orientation of triangles, which has nothing to do with intersecting segments."""
    p = np.stack([x, y], axis=-1)
    a, b = p[:-1], p[1:]

    def side(u, v, w):
        along, away = v - u, w - u
        return np.sign(along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0])

    i, j = np.triu_indices(len(a), 2)
    return int(
        (
            (side(a[i], b[i], a[j]) * side(a[i], b[i], b[j]) < 0)
            & (side(a[j], b[j], a[i]) * side(a[j], b[j], b[i]) < 0)
        ).sum()
    )


def test_a_curve_that_is_out_of_reach_from_the_start_has_no_numbers():
    curve = solve_curve(3.1, 0.15)
    assert curve.status is Status.OUT_OF_REACH and "crosses itself" in curve.message
    assert np.isnan(curve.mu_lock) and not curve.pieces
    with pytest.raises(ValueError, match="status out_of_reach"):
        curve.state(0.0)
