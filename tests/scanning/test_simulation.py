"""Scans over surfaces, and where a slip ends."""

from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from scipy.optimize import brentq

from responses import by_law, respond
from steel import SENSOR
from vibrissa import Mounting, stick_slip
from vibrissa.errors import ArgumentError, EndedScanError
from vibrissa.outcomes import RodSection, SlipLaw
from vibrissa.quantities.units import Units
from vibrissa.scanning import surfaces
from vibrissa.scanning.cycles import steady_travel
from vibrissa.scanning.response import Response
from vibrissa.scanning.scan import Outcome, TipPhase, TipSide
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.slip import Slip
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.stage import Stage, path
from vibrissa.sensor import Whisker, scan
from vibrissa.sensor.surface_texts import read_surface
from vibrissa.sticking.periods import read_curve
from vibrissa.sticking.piece import NO_PIECES


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


def slips(result):
    return result.phase == TipPhase.SLIP


def test_free_slips_on_one_friction_are_the_paper_s_cycles(response):
    paper = stick_slip(response.curve, Decimal("0.4"), Decimal("0.004"), cycles=3)
    result = simulate(response, surfaces.constant(0.4), path("0.004", ["0.168"]))
    assert slips(result).tolist() == [phase == "slip" for phase in paper.phase]
    assert result.contact == pytest.approx(paper.contact, abs=1e-13)
    assert result.reactions[:, 0] == pytest.approx(paper.state.reaction_fx, abs=1e-8)
    assert result.reactions[:, 2] == pytest.approx(paper.state.reaction_m, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("law", list(SlipLaw))
def test_friction_is_never_exceeded_and_would_be_without_the_slip(response, law):
    surface = surfaces.random(3, 0.3, 0.05, 0.02)
    positions = path("0.0005", ["0.5", "0.2", "0.4"])
    result = simulate(response, surface, positions, by_law(law, 0.6))
    assert result.outcome is Outcome.COMPLETE
    fx, fy, _ = result.reactions.T
    assert (np.abs(fx / fy) <= result.mu0 * (1 + 1e-9)).all()
    at = np.flatnonzero(slips(result))
    assert len(at) > 15
    stuck = result.x0[at - 1] + result.clamp[at] - result.clamp[at - 1]
    inside = stuck > response.x0_pull
    assert (np.abs(response.demand(stuck[inside])) > result.mu0[at - 1][inside]).all()
    # The tip moves only when it slips, pushed the way the clamp moves.
    moved = np.diff(result.contact)
    assert (moved[~slips(result)[1:]] == 0.0).all()
    assert set(np.sign(result.x0[at - 1])) == {-1.0, 1.0}
    assert (result.mu0 == surface(result.contact)).all()


def slip_of(response, mu0, law, ratio, damping=0.0):
    stage, surface = Stage(response=response, eta=response.curve.eta), surfaces.constant(mu0)
    return Slip(stage=stage, surface=surface, model=by_law(law, ratio, damping))


@pytest.mark.parametrize("mu0", [0.1, 0.4])
def test_a_tip_at_rest_may_use_up_all_friction(response, mu0):
    onset = float(response.curve.onset(mu0))
    pulled = brentq(
        lambda x0: response.reactions(x0) @ [1.0, mu0, 0.0], response.x0_pull, 0.0, xtol=1e-14
    )
    for start, end in ((onset + 0.01, onset), (1.2 * pulled, pulled)):
        slip = slip_of(response, mu0, SlipLaw.KINETIC, 1.0)
        rest = slip.follow(response.contact(0.0, start, 1))
        assert rest.x0 == pytest.approx(end, abs=1e-9)
        assert rest.contact == pytest.approx(response.contact(0.0, end, 1), abs=1e-9)


def test_a_slip_that_goes_to_and_fro_too_often_is_refused_with_its_place(response, monkeypatch):
    monkeypatch.setattr(Slip, "_settled", lambda self, contact, slide: False)
    slip = replace(slip_of(response, 0.1, SlipLaw.ENERGY, 0.5), clamp=0.25)
    with pytest.raises(ArgumentError, match=r"the clamp at 0\.25 L a slip has over 100 slides"):
        slip.follow(response.contact(0.25, 0.02, 1))


# --- Damping ---


@pytest.mark.parametrize("ratio", [0.4, 0.8, 1.0])
@pytest.mark.parametrize("mu0", [0.1, 0.4])
def test_a_slip_without_damping_is_one_of_energy_and_with_much_of_it_kinetic(response, mu0, ratio):
    begin = response.contact(0.0, float(response.curve.onset(mu0)) + 1e-3, 1)
    for law, damping in ((SlipLaw.ENERGY, 0.0), (SlipLaw.KINETIC, 50.0)):
        found = slip_of(response, mu0, SlipLaw.DAMPED, ratio, damping).follow(begin)
        assert found == slip_of(response, mu0, law, ratio).follow(begin)


@pytest.mark.parametrize("mu0", [0.1, 0.3, 0.45])
def test_more_damping_shortens_a_slip_and_takes_its_part_of_the_energy(response, mu0):
    begin = response.contact(0.0, float(response.curve.onset(mu0)), 1)
    kinetic = slip_of(response, mu0, SlipLaw.KINETIC, 0.8).follow(begin)
    fastest = kinetic.released - kinetic.dissipated
    zetas = [0.0, 1e-6, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0]
    rests = [slip_of(response, mu0, SlipLaw.DAMPED, 0.8, zeta).follow(begin) for zeta in zetas]
    contacts = [rest.contact for rest in rests] + [kinetic.contact]
    assert (np.diff(contacts) < 0.0).all()
    for zeta, rest in zip(zetas, rests, strict=True):
        loss = rest.released - rest.dissipated
        assert loss == pytest.approx((1.0 - np.exp(-2.0 * np.pi * zeta)) * fastest, abs=1e-13)


def test_a_tip_that_is_driven_again_on_its_way_loses_a_part_of_its_largest_energy(response):
    """Over a rough stripe that slows it, and on over a smooth patch that it leaves faster."""
    begin = response.contact(0.0, float(response.curve.onset(0.4)), 1)
    edges = [begin - 1.0, begin + 0.002, begin + 0.004, begin + 0.02]
    friction = [0.4, 0.7, 0.1, 0.6]
    surface = surfaces.patches(edges, friction)
    slip = replace(slip_of(response, 0.4, SlipLaw.DAMPED, 0.5, 0.05), surface=surface)
    found = slip.follow(begin)
    assert found.contact > begin + 0.02
    # The energy by the trapezoidal rule, patch by patch.
    energy, largest = 0.0, 0.0
    ends = [*edges[1:], found.contact]
    for low, high, mu0 in zip([begin, *edges[1:]], ends, friction, strict=True):
        contact = np.linspace(low, high, 4001)
        fx, fy, _ = response.reactions(response.x1_init - contact).T
        steps = np.diff(contact) * ((-fx + 0.5 * mu0 * fy)[1:] + (-fx + 0.5 * mu0 * fy)[:-1]) / 2
        along = energy + np.cumsum(steps)
        energy, largest = along[-1], max(largest, along.max())
    assert energy == pytest.approx((1.0 - np.exp(-0.1 * np.pi)) * largest, rel=1e-4)


def test_a_slip_that_lifts_the_tip_off_has_no_travel_and_damping_keeps_it_down():
    uniform = respond(1.0, 0.85)
    assert np.isnan(steady_travel(uniform, 0.4, by_law("energy", 0.2)))
    # 0.8814 x0,slip by a chain of links with mass (validation/records/slip-dynamics.md).
    travel = steady_travel(uniform, 0.4, by_law("damped", 0.5, 0.02))
    assert travel / uniform.curve.onset(0.4) == pytest.approx(0.8814, abs=0.02)


@pytest.mark.parametrize(
    ("law", "damping", "message"),
    [
        ("damped", None, "the law 'damped' needs damping, the damping ratio"),
        ("damped", -0.1, "damping must be a number from 0, got -0.1"),
        ("damped", np.nan, "damping must be a number from 0, got nan"),
        ("damped", np.inf, "damping must be a number from 0, got inf"),
        ("energy", 0.1, "the law 'energy' has no damping: remove damping, or take the law"),
        ("lossy", 0.1, "law"),
    ],
)
def test_a_law_gets_the_damping_that_it_needs(response, law, damping, message):
    with pytest.raises(ArgumentError, match=message):
        stick_slip(response.curve, 0.3, 0.001, 1, law, damping=damping)
    with pytest.raises(ArgumentError, match=message):
        SlipModel.of(law, damping=damping)


def released(response, start, rest):
    """Bending energy that the rod loses from start to rest: while the tip is held, dE = −fx·dx0."""
    return integral(response, start, rest)[0]


def integral(response, start, stop):
    """Integrals of fx, fy and m over x0, on one smooth stretch."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    half = 0.5 * (stop - start)
    return half * (weights @ response.reactions(start + half * (1.0 + nodes)))


def unretracted(response):
    """The response of a rod whose retraction was not resolved."""
    return Response(curve=replace(response.curve, retraction=NO_PIECES))


@pytest.mark.parametrize(
    ("whisker", "pull"),
    [
        (Whisker(theta=2.0, eta=0.85, section=RodSection.PLANAR), True),
        (Whisker(theta=2.0, eta=0.85, mounting=Mounting(clamp_angle=0.03)), True),
        (Whisker(theta=2.0, eta=0.85), False),
    ],
)
def test_a_lock_ends_the_scan_where_nothing_further_is_computed(whisker, pull):
    response = whisker.response
    if not pull:
        response = unretracted(response)
    contact = response.x1_init
    result = simulate(response, surfaces.constant(0.8), path("0.001", ["3"]))
    assert result.outcome is Outcome.LOCK
    assert f"locks at x = {contact:.6g} L, where mu0 = 0.8 and mu_lock = 0.4" in result.message
    assert result.message.endswith("the motion after that is not computed")
    assert result.phase[-1] == TipPhase.LOCK and set(result.side) == {TipSide.AHEAD}
    end = float(response.curve.motion_end(0.8)[1].x0)
    assert end - 0.001 < result.x0[-1] <= end


def test_a_tip_that_slips_on_a_second_rise_of_its_demand_comes_to_rest_at_its_foot():
    mounting = Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=0.042)
    response = respond(1.77, 0.9665, mounting=mounting, section=RodSection.PLANAR)
    result = simulate(response, surfaces.constant(0.3), path("0.001", ["0.52"]))
    assert result.outcome is Outcome.COMPLETE
    slip = int(np.argmax(slips(result)))
    assert result.x0[slip - 1] < 0.474485888 < result.x0[slip - 1] + 0.001
    # The nearest state with α = 0; another one is at x0 = 0.
    assert result.x0[slip] == pytest.approx(0.457759, abs=1e-6)
    assert slips(result).sum() == 3


def test_turned_back_in_time_a_locked_tip_is_free_again(response):
    surface = surfaces.patches([0.0, 0.6], [0.3, 0.5])
    result = simulate(response, surface, path("0.001", ["0.5", "-0.1"]))
    assert result.outcome is Outcome.COMPLETE
    assert TipPhase.LOCK in result.phase and result.phase[-1] != TipPhase.LOCK
    assert result.contact[-1] < 0.6


def test_slip_from_high_to_no_friction_lifts_the_tip_off(response):
    # Let go near the lock, onto ice: more energy than the branch can take up to where fy = 0.
    surface = surfaces.patches([0.0, 0.4174], [0.47, 0.01])
    result = simulate(response, surface, path("0.001", ["0.3"]), by_law("energy", 0.5))
    assert result.outcome is Outcome.LOST and "lifts off" in result.message
    start = result.x0[-1] + 0.001
    spare = released(response, start, response.x0_pull)
    pressed = -integral(response, response.x0_pull, start)[1]
    assert spare > 0.5 * 0.01 * pressed > 0.0


@pytest.mark.parametrize("width", [2e-4, 1e-7, 1e-13])
@pytest.mark.parametrize("law", ["kinetic", "energy"])
def test_no_stripe_is_too_narrow_to_stop_a_slip(response, width, law):
    # Of so narrow a stripe only an extreme friction stops a tip that has kinetic energy.
    rough = 2.0 if law == "kinetic" else 1e-3 / width
    surface = surfaces.patches([0.0, 0.4213, 0.4213 + width], [0.3, rough, 0.3])
    positions = path("0.0002", ["0.04"])
    result = simulate(response, surface, positions, by_law(law, 0.6))
    assert 0.4213 <= result.contact[-1] < 0.4213 + width
    assert result.mu0[-1] == rough and result.outcome is Outcome.COMPLETE


def test_surface_is_asked_no_further_than_the_tip_comes(response):
    ends = surfaces.profile([0.0, 0.45], [0.3, 0.3])
    both = ends, surfaces.constant(0.3)
    energy = by_law("energy")
    runs = [simulate(response, one, path("0.001", ["0.04"]), energy) for one in both]
    assert runs[0].contact == pytest.approx(runs[1].contact, abs=1e-14)
    with pytest.raises(ValueError, match=r"from x = 0 L to 0\.45 L, .* touches it at x = 0\.4887"):
        simulate(response, ends, path("0.001", ["0.2"]), energy)


@pytest.mark.parametrize("k", [1, 2, 8, 29, 64, 120])
def test_a_step_that_ends_on_the_onset_sticks_everywhere(response, k):
    dx0 = Decimal("0.001")
    mu0 = float(response.curve.mobilised_friction(k * float(dx0)))
    stiction = read_curve(response.curve, [Decimal(repr(mu0))], [dx0])
    assert stiction.n_steps[0] == k
    assert list(stick_slip(response.curve, mu0, dx0, 1).phase).index("slip") == k + 1
    positions = path(dx0, [(k + 2) * dx0])
    scan = simulate(response, surfaces.constant(mu0), positions)
    assert np.flatnonzero(slips(scan))[0] == k + 1


def test_step_longer_than_a_period_slips_every_time():
    signals = scan(Whisker(theta=2.0, eta=0.85), surfaces.constant(0.1), step=0.01, to=0.05)
    assert slips(signals.truth).tolist() == [False, *[True] * 5]
    assert repr(signals) == "6 steps, 6 periods, complete"


def test_path_goes_to_each_turn():
    positions = path("0.1", ["0.35", "-0.2", "0"])
    assert positions.tolist() == [0.0, 0.1, 0.2, 0.3, 0.2, 0.1, 0.0, -0.1, -0.2, -0.1, 0.0]


@pytest.mark.parametrize("length", [0.1, 0.11, 0.15, 0.18, 0.2])
@pytest.mark.parametrize("step", [1e-3, 5e-5, 2e-5])
def test_path_in_units_of_a_rod_has_all_its_steps(length, step):
    positions = path(step / length, [0.04 / length, 0.01 / length])
    ends = np.array([positions.max(), positions[-1]]) * length
    assert ends == pytest.approx([0.04, 0.01], abs=1e-9 * step)
    assert len(positions) == 1 + round(0.07 / step)


@pytest.mark.parametrize(("step", "turns"), [("0", ["1"]), ("0.1", ["0.05"]), ("-1", ["1"])])
def test_impossible_paths_are_refused(step, turns):
    with pytest.raises(ValueError, match="step"):
        path(step, turns)


def test_pulling_needs_a_response_with_it():
    response = unretracted(respond(2.0, 0.85))
    with pytest.raises(ValueError, match="backward"):
        simulate(response, surfaces.constant(0.3), path("0.001", ["0.2", "0.1"]))
    for law in ("energy", "damped"):
        with pytest.raises(ValueError, match=f"'{law}'"):
            simulate(response, surfaces.constant(0.3), path("0.001", ["0.2"]), by_law(law))


def test_a_transducer_of_any_resolution_gives_what_it_reads():
    fine = SENSOR.model_copy(update={"resolution": (0.0,) * 3, "noise": (0.0,) * 3})
    loads = np.array([[1.0, -2.0, 0.03]]) / 7.0
    assert (fine.measured(loads, np.random.default_rng(1)) == loads).all()


@pytest.mark.slow
def test_surfaces():
    patched = surfaces.patches([0.0, 0.5], [0.2, 0.4])
    assert patched(np.array([-1.0, 0.49, 0.5, 3.0])).tolist() == [0.2, 0.2, 0.4, 0.4]
    measured = surfaces.profile([0.0, 1.0], [0.2, 0.4])
    assert measured(0.25) == pytest.approx(0.25)
    x = np.linspace(0.0, 400.0, 20001)
    one, same, other = (surfaces.random(seed, 0.3, 0.02, 0.05)(x) for seed in (1, 1, 2))
    assert (one == same).all() and (one != other).any()
    by_default = read_surface(Units(), texture="0.3, 0.02, 0.05")(x)
    assert (by_default == surfaces.random(0, 0.3, 0.02, 0.05)(x)).all()
    assert one.mean() == pytest.approx(0.3, abs=0.002)
    assert one.std() == pytest.approx(0.02, rel=0.1)
    apart = surfaces.random(1, 0.3, 0.02, 5.0)(np.arange(0.0, 20000.0, 5.0))
    assert np.corrcoef(apart[:-1], apart[1:])[0, 1] == pytest.approx(np.exp(-0.5), abs=0.1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: surfaces.constant(0.0)(1.0), "mu0 must be positive"),
        (lambda: surfaces.patches([0.5, 0.1], [0.2, 0.3]), "positions of patches must increase"),
        (lambda: surfaces.profile([0, 1, 1, 0], [0.2] * 4), "number 3 is not above the one"),
        (lambda: surfaces.patches([0.5], [0.2, 0.3]), "have at least 1 positions"),
        (lambda: surfaces.profile([0.0], [0.2]), "have at least 2 positions"),
        (lambda: surfaces.random(1, 0.3, 0.1, 0.0), "correlation"),
        (lambda: surfaces.random(1, 0.0, 0.1, 0.1), "mean"),
        (lambda: surfaces.random(1, 0.3, -0.1, 0.1), "deviation"),
        (lambda: surfaces.random(1, 0.3, 0.1, 0.1, 0.0), "least"),
        (lambda: surfaces.profile([0.0, 1.0], [0.2, 0.3])(1.5), "known from"),
        (lambda: surfaces.patches([0.0], [-0.2])(1.5), "positive everywhere"),
    ],
)
def test_impossible_surfaces_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_path_has_so_many_steps_at_most(monkeypatch):
    monkeypatch.setattr("vibrissa.scanning.stage.MOST_STEPS", 6)
    assert path("0.1", ["0.5", "0.4"]) == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.4])
    with pytest.raises(ArgumentError, match="too small: the path has 7 steps, more than 6"):
        path("0.1", ["0.5", "0.3"])


# --- A round rod that buckles laterally, and is dragged ---

MIRROR = np.array([-1.0, 1.0, -1.0])


@pytest.fixture(scope="module")
def flat():
    """In line contact: the tail of the rod lies on the surface."""
    return respond(3.0, 0.7, "line")


def swing_of(result):
    (row,) = np.flatnonzero(result.phase == TipPhase.SWING)
    return int(row)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["response", "flat"])
def test_free_slips_of_a_dragged_rod_are_those_of_a_study(name, request):
    response = request.getfixturevalue(name)
    study = stick_slip(response.curve, Decimal("0.9"), Decimal("0.009"), cycles=4)
    result = simulate(response, surfaces.constant(0.9), study.clamp)
    assert result.outcome is Outcome.COMPLETE and "buckles laterally" in result.message
    assert (result.phase == TipPhase.SLIP).tolist() == [phase == "slip" for phase in study.phase]
    assert result.contact == pytest.approx(study.contact, abs=1e-12)
    state = study.state
    expected = np.array([state.reaction_fx, state.reaction_fy, state.reaction_m]).T
    assert result.reactions == pytest.approx(expected, abs=2e-7 * np.abs(expected).max())
    assert set(result.side[swing_of(result) :]) == {TipSide.BEHIND}


@pytest.mark.parametrize("law", list(SlipLaw))
def test_on_any_surface_it_is_the_mirror_image_of_a_tip_that_is_pulled_back(response, law):
    # Held by a rough patch until lateral buckling, then over random friction and stripes.
    rough, swing = response.x1_init + 0.001, response.x0_end
    edges = [0.0, rough, 0.45, 0.455, 0.47, 0.4701, 0.5]
    patched = surfaces.patches(edges, [1.5, 0.2, 0.6, 0.1, 0.3, 4.0, 0.25])
    turned = surfaces.Surface(
        name="mirrored",
        mu0=lambda x: patched.mu0(2.0 * swing - x),
        edges=np.sort(2.0 * swing - patched.edges),
    )
    forth = path("0.0007", ["1.0"])
    over = forth > swing
    back = np.where(over, 2.0 * swing - forth, forth)
    result = simulate(response, patched, forth, by_law(law, 0.7))
    expected = simulate(response, turned, back, by_law(law, 0.7))
    assert result.outcome is expected.outcome is Outcome.COMPLETE
    assert (result.side == np.where(over, TipSide.BEHIND, TipSide.AHEAD)).all()
    assert (result.period == expected.period).all() and result.period[-1] > 10
    there = np.where(over[:, None], expected.reactions * MIRROR, expected.reactions)
    assert result.reactions == pytest.approx(there, abs=1e-9)
    contact = np.where(over, 2.0 * swing - expected.contact, expected.contact)
    assert result.contact == pytest.approx(contact, abs=1e-10)
    assert result.mu0 == pytest.approx(patched(result.contact))


def test_a_stage_that_turns_back_swings_the_rod_back(response):
    result = simulate(response, surfaces.constant(0.9), path("0.001", ["0.7", "0.1"]))
    assert (result.phase == TipPhase.SWING).sum() == 2 and result.period[-1] == 1
    forth, back = result.reactions[:701], result.reactions[700:][::-1]
    assert forth[100:] == pytest.approx(back, abs=1e-12)
    assert result.side[-1] == TipSide.AHEAD


def test_a_long_step_swings_and_slips_at_once(response):
    result = simulate(response, surfaces.constant(0.9), np.array([0.0, 0.4, 0.9, 0.901]))
    assert result.phase.tolist() == ["stick", "lock", "slip", "stick"]
    assert result.side.tolist() == ["ahead", "ahead", "behind", "behind"]
    assert result.x0 == pytest.approx([0.0, 0.4, 0.0, 0.001]) and result.period[-1] == 2
    assert (np.signbit(result.x0) == [False] * 4).all()


def test_a_rod_that_swings_off_the_known_surface_keeps_its_steps():
    rod, positions = respond(3.0, 0.85, "line"), path("0.01", ["0.85"])
    whole = simulate(rod, surfaces.constant(0.9), positions)
    (swing,) = np.flatnonzero(whole.phase == TipPhase.SWING)
    edge = whole.contact[swing - 1 : swing + 1].mean()
    with pytest.raises(EndedScanError, match="extend it") as ended:
        simulate(rod, surfaces.profile([edge, 2.0], [0.9, 0.9]), positions)
    found = ended.value.scan
    assert found.outcome is Outcome.OUT_OF_REACH and "buckles laterally" in found.message
    assert found.contact.tolist() == whole.contact[:swing].tolist()
    assert found.periods.ends_by.tolist() == ["unknown"]


def test_signals_go_on_past_the_swing():
    asked = {"step": 0.002, "to": [1.0], "law": "energy"}
    signals = scan(Whisker(theta=2.0, eta=0.85), surfaces.constant(0.8), **asked)
    table = signals.to_pandas()
    behind = table["side"] == "behind"
    # A clamp that moves forward is held back, whether it pushes the tip or drags it.
    assert (table["force_x"][behind].iloc[[0, -1]] > [0.0, -1.0]).all()
    assert (table["force_y"] < 0.0).all()
