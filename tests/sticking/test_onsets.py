"""Many onsets at once: the same as one at a time."""

import numpy as np
import pytest

from vibrissa import Mounting, Status, solve_onset, solve_onsets
from vibrissa.errors import ArgumentError

D = 6


@pytest.fixture(scope="module")
def random():
    generator = np.random.default_rng(1)
    # Some lock, some slip; rods are shared by rows that do not follow each other.
    theta, eta = generator.uniform(1.0, 3.0, D), generator.uniform(0.7, 0.9, D)
    which = generator.integers(0, D, 4 * D)
    mu0, dx0 = generator.uniform(0.1, 0.8, 4 * D), generator.choice([0.001, 0.0007], 4 * D)
    return theta[which], mu0, eta[which], dx0


@pytest.mark.slow
def test_a_row_is_the_onset_of_its_values(random):
    table = solve_onsets(*random)
    assert len(table) == 4 * D and set(table["status"]) == {"slip", "lock"}
    for row, values in zip(table.itertuples(), zip(*random, strict=True), strict=True):
        one = solve_onset(*values)
        assert (row.theta, row.mu0, row.eta, row.dx0) == values
        assert row.status == one.status
        assert row.x0_slip == pytest.approx(one.x0_slip, abs=1e-10, nan_ok=True)
        assert row.mu_lock == pytest.approx(one.mu_lock, abs=1e-11)
        assert row.reaction_m_slip == pytest.approx(one.slip.reaction_m, abs=1e-8, nan_ok=True)
        if one.status is Status.SLIP:
            assert row.n_steps == one.n_steps and row.x0_max == one.x0_max


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rod", "kind"),
    [
        ((2.0, 0.85), {"mounting": Mounting(clamp_angle=0.1)}),
        ((2.0, 0.85), {"section": "planar"}),
        ((3.0, 0.75), {"contact": "line"}),
        # Its −tan α is largest in the kink at which the rod lies down.
        ((2.13, 0.797), {"contact": "line"}),
    ],
)
def test_other_mountings_sections_and_contacts_are_as_one_at_a_time(rod, kind):
    """Where a round rod that is not ideal buckles depends on its margin of stability."""
    theta, eta = rod
    table = solve_onsets(theta, [0.3, 3.0], eta, **kind)
    for row in table.itertuples():
        one = solve_onset(theta, row.mu0, eta, **kind)
        assert (row.status, row.message) == (one.status, "")
        assert row.mu_lock == pytest.approx(one.mu_lock, abs=1e-9)
        assert row.x0_slip == pytest.approx(one.x0_slip, abs=1e-9, nan_ok=True)


@pytest.mark.slow
def test_arguments_are_broadcast_and_rows_keep_their_order():
    table = solve_onsets([1.0, 2.0], np.array([[0.3], [0.4], [0.5]]), 0.85)
    assert table["theta"].tolist() == [1.0, 2.0] * 3
    assert table["mu0"].tolist() == [0.3, 0.3, 0.4, 0.4, 0.5, 0.5]
    assert table["x0_max"].isna().all() and table["dx0"].isna().all()
    assert (table["x0_slip"].diff(2).dropna() > 0.0).all()


@pytest.mark.slow
def test_what_has_no_onset_says_why(capsys):
    bent = Mounting(curvature=-2.0)
    table = solve_onsets([2.0], 0.3, 0.85, 0.001, mounting=bent, progress=True)
    assert table["status"].tolist() == ["out_of_reach"] and table["message"][0]
    assert table["x0_slip"].isna().all() and not capsys.readouterr().out


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"theta": [2.0, 0.9]}, r"theta must be 1 to 50, got .*0\.9\)? in element 1"),
        ({"mu0": [0.3, 0.3, np.nan]}, "mu0 must be above 0, got .*nan.* in element 2"),
        ({"eta": 85.0}, r"eta must be between 0 and 1 \(in L\)"),
        ({"dx0": [0.001, 0.0]}, "dx0 must be above 0"),
        ({"theta": "thin"}, "must be numbers or arrays that can be broadcast"),
        ({"theta": [1.0, 2.0], "mu0": [0.1, 0.2, 0.3]}, "can be broadcast"),
        ({"theta": []}, "at least one value"),
    ],
)
def test_wrong_values_are_refused_with_their_place(values, words):
    with pytest.raises(ArgumentError, match=words):
        solve_onsets(**{"theta": 2.0, "mu0": 0.3, "eta": 0.85, "dx0": 0.001} | values)
