"""The public functions, as a person uses them in a notebook."""

import subprocess
import sys
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibrissa
from vibrissa import Mounting, Status, friction_from_travel, solve_curve, solve_onset, solve_state
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.sticking.solving import collocation

STEPS = st.sampled_from(["0.0005", "0.001", "0.004"]).map(float)


@pytest.mark.parametrize("theta", [1.0, 2.5, 4.0])
def test_a_state_lies_on_its_sticking_curve(theta):
    curve = solve_curve(theta, 0.85)
    x0 = 0.6 * curve.x0_lock
    state, on_curve = solve_state(theta, 0.85, curve.x1_init - x0), curve.state(x0)
    for name in ("f", "alpha", "phi1", "reaction_fx", "reaction_fy", "reaction_m"):
        assert getattr(state, name) == pytest.approx(float(getattr(on_curve, name)), abs=1e-11)


def test_a_curve_is_solved_once_and_cannot_be_changed(monkeypatch):
    """Each argument that a curve depends on makes another one."""
    solved, solve = [], collocation.solve_curves
    spy = lambda *args: solved.append(args) or solve(*args)  # noqa: E731
    monkeypatch.setattr(collocation, "solve_curves", spy)
    first, second = (solve_onset(2, mu0, eta=0.6) for mu0 in (0.2, 0.3))
    assert len(solved) == 1 and first.x0_slip < second.x0_slip
    curve = solve_curve(2.0, 0.6)
    assert curve is solve_curve(theta=2, eta=0.6, contact="point", section="round")
    with pytest.raises(ValueError, match="read-only"):
        curve.pieces.states.x0[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        curve.retraction.states.s_c[-1, 0] = 1.0
    others = (
        {"theta": 2.5},
        {"eta": 0.8},
        {"contact": "line"},
        {"section": "planar"},
        {"mounting": Mounting(clamp_angle=0.01)},
        {"mounting": Mounting(clamp_angle=-0.01)},
    )
    found = [solve_curve(**{"theta": 2, "eta": 0.6, **other}) for other in others]
    assert len(solved) == 1 + len(others)
    assert len({(c.mu_lock, c.x0_end, c.section, c.mounting) for c in [curve, *found]}) == 7


def test_an_onset_is_printed_as_a_table_of_what_is_known():
    slips, locks = (solve_onset(2, mu0, eta=0.85, dx0=0.001) for mu0 in (0.4, 0.6))
    lines = str(slips).splitlines()
    assert lines[0] == "status       slip: the tip slips at x0 = 0.052838"
    assert lines[1] == "x0_slip      0.052838    L        exact onset of slip"
    assert "x0_end" in str(locks) and "x0_slip" not in str(locks)
    assert "nan" not in str(slips) + str(locks)


def test_shape_ends_at_the_contact_point():
    x, y, phi = (state := solve_state(2.0, 0.85, 0.4)).shape(np.array([0.0, 1.0]))
    assert (x[-1], y[-1], phi[-1]) == pytest.approx((0.4, 0.85, state.phi1), abs=1e-10)
    assert (x[0], y[0], phi[0]) == pytest.approx((0.0, 0.0, np.pi / 2))


@pytest.mark.parametrize(("theta", "part"), [(8.0, 0.85), (2.0, -0.5)])
def test_a_state_far_from_the_first_one_is_reached(theta, part):
    state = solve_state(theta, 0.3, part * np.sqrt(1.0 - 0.3**2), "line")
    assert state.status is Status.SOLVED and state.residual < 1e-12


def test_state_beyond_the_branch_is_failed_and_says_so():
    state = solve_state(1.0, 0.85, -0.5)
    assert state.status is Status.FAILED
    assert "no state at this x1" in state.message
    assert np.isnan(state.f)
    with pytest.raises(ValueError, match="no shape"):
        state.shape()


def test_a_surface_does_not_pull():
    assert -0.2 < (last := solve_state(2.0, 0.85, 0.443)).reaction_fy < 0.0
    assert "unknowns" not in repr(last)
    for x1 in (0.445, 0.5):
        state = solve_state(2.0, 0.85, x1)
        assert state.status is Status.OUT_OF_REACH and "would have to pull" in state.message


def test_a_shape_has_no_places_beyond_the_rod():
    with pytest.raises(ArgumentError, match=r"between 0 and 1 \(L\), got \[1\.5\]"):
        solve_state(2.0, 0.85, 0.4).shape(np.array([1.5]))


def test_a_tip_that_is_never_pushed_forward_is_out_of_reach():
    mounting = Mounting(stage_angle=np.radians(-40.0))
    curve = solve_curve(1.0, 0.85, mounting=mounting, section="planar")
    assert curve.status is Status.OUT_OF_REACH and "never pushed forward" in curve.message


def test_onset_that_slips():
    onset = solve_onset(theta=3, mu0=0.4, eta=0.85, dx0=0.001)
    assert onset.status is Status.SLIP
    assert (onset.n_steps, onset.x0_max) == (76, 0.076)
    assert onset.x0_slip == pytest.approx(0.076423, abs=5e-7)
    assert -np.tan(onset.slip.alpha) == pytest.approx(0.4)
    assert onset.residual <= 1e-12


def test_onset_without_a_step_has_no_steps():
    onset = solve_onset(theta=3, mu0=0.4, eta=0.85)
    assert onset.n_steps is None and np.isnan(onset.x0_max)


def test_onset_that_locks_names_the_limit():
    onset = solve_onset(theta=2, mu0=0.48, eta=0.85, dx0=0.001)
    assert onset.status is Status.LOCK
    assert "mu_lock = 0.477571" in onset.message
    assert np.isnan(onset.x0_slip) and onset.n_steps is None


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_the_largest_taper_is_solved():
    onset = solve_onset(theta=MOST_TAPER, mu0=0.3, eta=0.85)
    assert onset.status is Status.SLIP and onset.residual < 1e-11


@pytest.mark.slow
def test_onset_out_of_reach_says_why():
    onset = solve_onset(theta=3.1, mu0=5.0, eta=0.15, section="planar")
    assert onset.status is Status.OUT_OF_REACH
    assert "crosses itself" in onset.message and np.isnan(onset.x0_slip)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"theta": 0.99}, "theta"),
        ({"theta": float("nan")}, "theta"),
        ({"theta": 50.1}, "theta .* between 1 and 50, got 50.1"),
        ({"theta": 1e300}, "theta .* between 1 and 50, got 1e.300"),
        ({"eta": 0.0}, "eta"),
        ({"eta": 1.0}, "eta"),
        ({"mu0": 0.0}, "mu0"),
        ({"mu0": -0.1}, "mu0"),
        ({"mu0": float("inf")}, "mu0 must be finite, got inf"),
        ({"mu0": Decimal("nan")}, "mu0 must be finite, got Decimal"),
        ({"theta": 10**400}, "theta must be finite, got 1000"),
        ({"dx0": float("inf")}, "dx0 must be finite, got inf"),
        ({"dx0": 0.0}, "dx0"),
        ({"method": "magic"}, "method"),
        ({"section": "square"}, "section"),
        ({"method": "shooting", "dx0": None}, "shooting needs a positive step dx0"),
    ],
)
def test_arguments_out_of_range_are_refused_by_name(arguments, named):
    good = {"theta": 2.0, "mu0": 0.3, "eta": 0.85, "dx0": 0.001}
    with pytest.raises(ValueError, match=named):
        solve_onset(**(good | arguments))


@pytest.mark.parametrize("name", ["theta", "mu0", "eta", "dx0"])
@pytest.mark.parametrize("value", ["0.4", np.array([0.4]), [0.4], True])
def test_what_is_no_number_is_refused_by_name(name, value):
    good = {"theta": 2.0, "mu0": 0.3, "eta": 0.85, "dx0": 0.001}
    with pytest.raises(ArgumentError, match=f"{name} must be one number"):
        solve_onset(**(good | {name: value}))


@pytest.mark.slow
def test_a_state_at_the_limit_point_says_so():
    curve = solve_curve(1.0, 0.85, section="planar")
    # Where the limit point is, rounding decides: this is just beyond it.
    state = solve_state(1.0, 0.85, curve.x1_init - curve.x0_end - 1e-14)
    assert state.status is Status.FAILED
    assert "the branch turns back here" in state.message and "eta" not in state.message
    assert solve_state(1.0, 0.85, curve.x1_init - curve.x0_end + 1e-9).status is Status.SOLVED


def test_contact_point_out_of_reach_is_refused():
    with pytest.raises(ValueError, match="out of reach"):
        solve_state(1.0, 0.8, 0.7)


def test_every_public_name_exists():
    for name in vibrissa.__all__:
        assert getattr(vibrissa, name).__module__.startswith("vibrissa.")
    with pytest.raises(AttributeError, match="nothing_like_it"):
        vibrissa.nothing_like_it  # noqa: B018


def test_parsing_the_workflow_imports_nothing_heavy():
    # Every cluster job parses the Snakefile again.
    code = (
        "import sys, vibrissa.study.reading, vibrissa.pipeline.ownership\n"
        "print(*{'scipy', 'pandas', 'pyarrow', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


@pytest.mark.slow
@given(theta=st.floats(1.0, 4.0), eta=st.floats(0.7, 0.95), share=st.floats(0.01, 0.98), dx0=STEPS)
@settings(max_examples=25)
def test_friction_comes_back_from_the_travel_that_it_allows(theta, eta, share, dx0):
    mu0 = share * solve_curve(theta, eta).mu_lock
    onset = solve_onset(theta, mu0, eta, dx0)
    found = friction_from_travel(theta, eta, onset.x0_max, dx0)
    assert found.low - 1e-9 <= mu0 <= found.high
    # The range is that of one step: at its ends the period is as long, or one step longer.
    inside = 0.5 * (found.low + found.high)
    assert solve_onset(theta, inside, eta, dx0).x0_max == onset.x0_max


@pytest.mark.slow
def test_a_travel_that_no_period_of_this_rod_has_is_refused():
    curve = solve_curve(2.0, 0.85)
    with pytest.raises(ArgumentError, match=r"x0_max must lie below 0\.14533"):
        friction_from_travel(2.0, 0.85, 0.2, 0.001)
    with pytest.raises(ArgumentError, match="x0_max must not be negative and dx0 must be positive"):
        friction_from_travel(2.0, 0.85, 0.1, 0.0)
    with pytest.raises(ArgumentError, match=r"lock of this rod is not known: .* not press on"):
        friction_from_travel(1.0, 0.85, 0.001, 0.001, mounting=Mounting(clamp_angle=-1.2))
    mounting = Mounting(stage_angle=-0.36, curvature=-0.3)
    with pytest.raises(ArgumentError, match=r"no friction lets the tip slip in .* x0_max = 0\.2"):
        friction_from_travel(2.0, 0.85, 0.2, 0.01, mounting=mounting)
    # Over a largest −tan α within the step: these coefficients, and no others, slip in it.
    low, high = friction_from_travel(2.0, 0.85, 0.0771, 0.1, mounting=mounting)
    curve_of_it = solve_curve(2.0, 0.85, mounting=mounting)
    inside = curve_of_it.onset(np.array([low + 1e-9, high - 1e-9, high + 1e-9]))
    assert 0.0771 < inside[0] < inside[1] < 0.12 and inside[2] > 0.2
    # Within the last step the tip may lock.
    assert friction_from_travel(2.0, 0.85, 0.145, 0.001).high == curve.mu_lock


def test_what_no_real_rod_does_is_marked():
    """As the tables of a study mark it."""
    through = solve_onset(5, 0.3, 0.85, 0.001)
    assert through.penetrates and "warning      the rod passes through the surface" in str(through)
    lying = solve_onset(5, 0.3, 0.85, 0.001, contact="line")
    assert not lying.penetrates and not lying.marks and "warning" not in str(lying)
    state = solve_state(1, 0.55, 0.15)
    assert state.marks and "the rod passes through the surface" in str(state)
    assert not solve_state(1, 0.85, 0.4).marks


def test_a_number_gives_a_number_and_an_array_an_array():
    curve = solve_curve(2, 0.85)
    for mu0 in (0.4, np.float64(0.4), np.array(0.4)):
        onset = curve.onset(mu0)
        assert isinstance(onset, float)
        assert isinstance(curve.state(onset).f, float)
        assert isinstance(curve.mobilised_friction(onset), float)
        assert friction_from_travel(2, 0.85, onset, 0.001).low == pytest.approx(0.4)
        assert solve_onset(2, mu0, 0.85).x0_slip == onset
    assert curve.onset([0.4]).shape == (1,) and curve.state([[0.01]]).f.shape == (1, 1)
    assert curve.contact(0.01) == "point" and curve.contact([[0.01, np.nan]]).tolist() == [
        ["point", ""]
    ]
    assert curve.shapes(0.01, [0.0, 1.0]).x.shape == (2,)
    assert curve.frequencies(0.01).shape == (2,) and curve.frequencies([[0.01]]).shape == (1, 1, 2)
    assert curve.shapes([[0.01]], [0.0, 1.0]).x.shape == (1, 1, 2)
    for states in (curve.trailing_end, lambda mu0: curve.motion_end(mu0)[1]):
        assert isinstance(states(0.9).x0, float) and states([[0.9, 2.0]]).x0.shape == (1, 2)
    assert curve.motion_end(0.9)[0] == "swings_aside"
    assert curve.motion_end([0.9, 2.0])[0].tolist() == ["swings_aside"] * 2
