"""Surfaces with heights: textures, traced profiles, and scans over them."""

from functools import cache

import numpy as np
import pytest
from scipy.ndimage import grey_dilation

import texture_scan
from responses import by_law, respond
from vibrissa import Mounting
from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.outcomes import Contact, SlipLaw
from vibrissa.scanning import surfaces, textures
from vibrissa.scanning.phase_locking import locking_of, settled_rests, travel_on_slope
from vibrissa.scanning.scan import Outcome, TipPhase
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.slide import Slide
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.stage import path, stage_of
from vibrissa.sensor import Whisker

THETA, ETA, FIRST = 2.0, 0.85, (0.55, 1.16)
SPREAD = 6e-4
WHISKER = Whisker(theta=THETA, eta=ETA)


@cache
def rod():
    return texture_scan.Rod.solved(THETA, ETA, SPREAD, FIRST, 0.026, 0.14)


def scanned(texture, positions, mu0=0.3, law="free", ratio=0.8, whisker=WHISKER):
    stage = stage_of(whisker, positions, texture=texture)
    friction = mu0 if isinstance(mu0, surfaces.Surface) else surfaces.constant(mu0)
    return simulate(stage, friction.with_texture(texture), positions, by_law(law, ratio))


def resolved(fx, fy, inclination):
    """Tangential and normal force on the tip."""
    cos, sin = np.cos(inclination), np.sin(inclination)
    return fx * cos + fy * sin, fx * sin - fy * cos


# 20 um on 2 mm for a rod of 100 mm; and slopes up to 10 degrees.
WAVES = ((2e-4, 0.02, 0.3), (np.tan(np.radians(10.0)) * 0.02 / (2.0 * np.pi), 0.02, 0.2))


@pytest.mark.slow
@pytest.mark.parametrize("law", SlipLaw)
@pytest.mark.parametrize(("amplitude", "wavelength", "mu0"), WAVES)
def test_slips_on_a_wave_are_those_of_brute_force(amplitude, wavelength, mu0, law):
    positions = path("0.0005", ["0.1"])
    wave = texture_scan.Wave(ETA, amplitude, 2.0 * np.pi / wavelength)
    zeta = by_law(law).damping or 0.0
    contact, period = texture_scan.scan(rod(), wave, mu0, positions, law, 0.8, zeta)
    found = scanned(textures.wave(amplitude, wavelength), positions, mu0, law)
    assert found.outcome is Outcome.COMPLETE and found.message == ""
    assert found.period.tolist() == period.tolist() and period[-1] > 2
    assert np.abs(found.contact - contact).max() < 1e-6


@pytest.mark.slow
def test_slips_lock_to_the_wavelength():
    """Free slips: one for each wave; kinetic ones: two, of unequal lengths."""
    positions = path("0.0005", ["0.4"])
    for law, lengths in (("free", [0.02, 0.02]), ("kinetic", [0.0115, 0.0085])):
        found = scanned(textures.wave(2e-4, 0.02), positions, law=law)
        slips = found.clamp[found.phase == TipPhase.SLIP]
        last = np.diff(slips)[-8:]
        assert sorted(set(last.round(9))) == sorted(set(lengths))


@pytest.mark.slow
@pytest.mark.parametrize("slope", [0.08, -0.05])
@pytest.mark.parametrize("law", ["free", "kinetic"])
def test_a_plane_of_constant_slope_is_an_oblique_stage_with_a_leaning_clamp(slope, law):
    gamma, positions = -np.arctan(slope), path("0.004", ["0.1"])
    found = scanned(textures.incline(slope, -0.06, 0.06), positions, law=law)
    # In the frame of the plane, the clamp leans and the stage moves at the opposite angle.
    mounting = Mounting(clamp_angle=-gamma, stage_angle=-gamma)
    leaning = Whisker(theta=THETA, eta=ETA * np.cos(gamma), mounting=mounting)
    stage = stage_of(leaning, positions)
    expected = simulate(stage, surfaces.constant(0.3), positions, by_law(law))
    assert found.outcome is expected.outcome is Outcome.COMPLETE
    assert found.period.tolist() == expected.period.tolist() and found.period[-1] > 2
    along = found.contact / np.cos(gamma) + ETA * np.sin(gamma)
    assert along == pytest.approx(expected.contact, abs=1e-8)
    tangential, normal = resolved(*found.reactions.T[:2], gamma)
    assert tangential == pytest.approx(expected.reactions[:, 0], abs=1e-7)
    assert normal == pytest.approx(-expected.reactions[:, 1], abs=1e-7)
    assert found.reactions[:, 2] == pytest.approx(expected.reactions[:, 2], abs=1e-7)
    assert found.height == pytest.approx(slope * found.contact)
    assert found.inclination == pytest.approx(gamma)


def test_a_slip_consumes_its_energy_on_its_way_over_crests():
    found = scanned(textures.wave(1e-4, 0.006), path("0.0005", ["0.2"]), law="energy")
    row = int(np.argmax(np.diff(found.contact))) + 1
    begin, end = found.contact[row - 1 : row + 1]
    assert end - begin > 0.02  # it passes three crests
    texture, clamp = textures.wave(1e-4, 0.006), found.clamp[row]
    nodes, weights = np.polynomial.legendre.leggauss(80)
    x = begin + (end - begin) * 0.5 * (1.0 + nodes)
    states, x0 = found.stage.states(np.full(80, clamp), x, 1, texture.height(x))
    fx, fy, _ = states.reactions(x0).T
    gamma = -np.arctan(texture.slope(x))
    tangential, normal = resolved(fx, fy, gamma)
    left = (-tangential - 0.8 * 0.3 * normal) / np.cos(gamma)
    assert 0.5 * (end - begin) * weights @ left == pytest.approx(0.0, abs=1e-11)
    # What the surface has done on the rod is the energy that the rod has lost.
    assert weights @ np.abs(left) > 0.1


def test_at_the_onset_the_ratio_of_forces_is_friction_and_slope_together():
    slope = 0.1
    for mu0, ratio in ((0.3, np.tan(np.arctan(0.3) + np.arctan(slope))), (0.2, 0.3061224489795918)):
        found = scanned(textures.incline(slope, -0.06, 0.06), path("0.00005", ["0.08"]), mu0)
        last = int(np.argmax(found.phase == TipPhase.SLIP)) - 1
        fx, fy, _ = found.reactions[last]
        assert ratio - 2e-3 < fx / fy <= ratio


def test_the_slope_alone_decides_where_a_tip_rests_and_slips():
    """A V of 20 degrees holds a tip of little friction in its corner until it climbs out."""
    wall, mu0 = np.radians(20.0), 0.05
    corner = 0.43
    width, depth = 0.01, 0.005 * np.tan(wall)
    vee = textures.grooves(width, depth, 0.5, wall, offset=corner - 0.5 * width)
    found = scanned(vee, path("0.0002", ["0.15"]), mu0, "kinetic")
    rows = np.flatnonzero(np.abs(found.contact - corner) < 1e-12)
    assert len(rows) > 50
    fx, fy, _ = found.reactions[rows].T
    # It climbs the far wall where the force leaves the friction cone of that wall.
    steepest = np.tan(np.arctan(mu0) + wall)
    assert (fx / fy).max() == pytest.approx(steepest, abs=2e-3) and (fx / fy).max() <= steepest
    assert found.contact[-1] > corner + 0.5 * width
    assert found.inclination[rows] == pytest.approx(-wall)


def test_a_wall_steeper_than_friction_holds_the_tip_until_it_locks():
    texture = textures.measured([0.0, 0.45, 0.4501, 2.0], [0.0, 0.0, 4e-4, 4e-4])
    planar = Whisker(theta=THETA, eta=ETA, section="planar")
    found = scanned(texture, path("0.001", ["1"]), 0.3, "free", whisker=planar)
    assert found.outcome is Outcome.LOCK and found.contact[-1] == 0.45
    assert "the tip locks at x = 0.45 L, where mu0 = 0.3 on a slope of 75.96 deg" in found.message


def test_a_tip_that_lifts_off_at_an_edge_lands_with_a_word():
    """Into a gap with steep walls: it lifts off at the edge and lands at the foot of the wall."""
    gap = textures.measured([0, 0.44, 0.44001, 0.49, 0.5, 2.0], [0, 0, -1e-3, -1e-3, 0, 0])
    for law in SlipLaw:
        found = scanned(gap, path("0.0005", ["0.08"]), 0.3, law)
        assert "time in a slip the tip lifts off, first at x = 0.44 L" in found.message
        assert found.message.endswith("first at x = 0.44001 L")
        assert found.height.min() == pytest.approx(-1e-3)


def test_a_tip_that_lifts_off_and_never_lands_ends_the_scan_with_its_place():
    """Past an edge the surface falls away, and is not known as far as it would push the tip."""
    cliff = textures.measured([0.0, 0.44, 0.4400005], [0.0, 0.0, -0.0015])
    for law in SlipLaw:
        found = scanned(cliff, path("0.0005", ["0.08"]), 0.3, law)
        assert found.outcome is Outcome.LOST and 50 < len(found) < 90
        assert "the tip lifts off the surface at x = 0.44 L, and nowhere ahead" in found.message
        assert found.ends[-1].ends_by == "lost"


@pytest.mark.slow
def test_a_slope_that_leads_too_deep_ends_the_scan_with_its_place():
    falling = textures.measured([0, 0.44, 1.44, 3.0], [0, 0, -0.3, -0.3])
    found = scanned(falling, path("0.004", ["1.2"]), 0.3, "kinetic")
    assert found.outcome is Outcome.OUT_OF_REACH and 150 < len(found) < 300
    # 0.14 L deep the rod would be almost upright.
    assert "comes at x = 0.906667 L to a height that the rod does not reach" in found.message


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        "energy",
        *(pytest.param(law, marks=pytest.mark.nightly) for law in SlipLaw if law != "energy"),
    ],
)
def test_on_rough_surfaces_friction_is_never_exceeded_and_no_scan_ends_silently(law):
    rng = np.random.default_rng(7)
    for seed in range(4):
        correlation = 10.0 ** rng.uniform(-2.5, -1.5)
        texture = textures.rough(0.1 * correlation, correlation, seed)
        if seed % 2:
            texture = texture.traced(0.5 * correlation, -0.5, 1.5)
        positions = path("0.001", ["0.2", "0.1"])
        found = scanned(texture, positions, 0.3, law)
        assert len(found) == len(positions) or found.message
        fx, fy, _ = found.reactions.T
        tangential, normal = resolved(fx, fy, found.inclination)
        smooth = np.array([abs(one) > 0.0 for one in found.contact])
        for row in np.flatnonzero(np.abs(tangential) > 0.3 * normal * (1.0 + 1e-6)):
            foot = surfaces.constant(0.3).with_texture(texture).footing(found.contact[row], 1)
            smooth[row] = foot.ahead.slope == pytest.approx(foot.behind.slope, abs=1e-9)
            assert not smooth[row]  # only a corner holds more


def test_a_step_on_the_onset_sticks_up_to_the_error_of_interpolated_heights():
    """It exceeds friction by the little that the force changes in 1e-8 L."""
    texture, forth = textures.rough(1e-3, 0.01, 3), path("0.001", ["0.03"])
    onset = float(scanned(texture, forth).periods.onset[0])
    for beyond, sticks in ((0.99e-8, True), (1.01e-8, False)):
        found = scanned(texture, np.append(forth[forth < onset - 1e-3], onset + beyond))
        assert (found.phase[-1] == TipPhase.STICK) == sticks
        if sticks:
            tangential, normal = resolved(*found.reactions[-1, :2], found.inclination[-1])
            assert 1e-9 < -tangential / (0.3 * normal) - 1.0 < 2e-6


def test_no_feature_is_too_narrow_to_be_seen():
    """A ridge of 1e-6 L on a long flat stops the tip as a wall does."""
    for width in (1e-4, 1e-6):
        ridge = textures.measured([0, 0.45, 0.45 + width, 0.45 + 2 * width, 2], [0, 0, width, 0, 0])
        found = scanned(ridge, path("0.001", ["0.2"]), 0.3, "kinetic")
        held = np.flatnonzero(found.contact == 0.45)
        assert len(held) > 20
        # Its wall of 45 degrees asks for tan(45° + atan 0.3) > mu_lock: it is held until it locks.
        assert found.contact[-1] == 0.45


@pytest.mark.slow
def test_scans_of_similar_textures_share_the_solved_rods():
    positions = path("0.0005", ["0.01"])
    stages = [stage_of(WHISKER, positions, texture=textures.wave(a, 0.02)) for a in (1e-4, 1.9e-4)]
    first, second = (stage.response.parts for stage in stages)
    assert all(one is other for one, other in zip(first, second, strict=True))
    high = stage_of(WHISKER, positions, texture=textures.wave(1e-3, 0.02))
    assert high.room(0.0, 1e-3) > 0.0 and high.room(0.0, -1e-3) > 0.0


def test_slips_that_repeat_are_counted():
    """Three slips for two waves, with the rounding of steps; and slips that do not repeat."""
    ways = np.array([0.5, 0.7, 0.8] * 4)
    jitter = 0.01 * np.sin(np.arange(13.0))
    places = 0.3 + np.append(0.0, np.cumsum(ways)) + jitter
    assert locking_of(0.02 * places, 0.02) == (3, 2)
    assert locking_of(0.02 * places, 0.02 * np.sqrt(2.0)) is None
    assert locking_of(0.02 * places[:3], 0.02) is None


def test_rests_in_the_first_part_of_a_scan_are_left_out():
    clamp, places = np.array([0.1, 0.3, 0.31, 1.0]), np.arange(4.0)
    assert settled_rests(clamp, places).tolist() == [2.0, 3.0]
    assert not len(settled_rests(np.array([]), np.array([])))


@pytest.mark.slow
def test_the_travel_between_locked_slips_follows_from_the_slope_of_rest():
    """One slip for each wave, and a travel of one wavelength, on a slope that the tip chooses."""
    wavelength, positions = 0.025, path("0.00002", ["0.45"])
    found = scanned(textures.wave(1e-4, wavelength), positions)
    assert locking_of(found.periods.contact_rest[-6:-1], wavelength) == (1, 1)
    slope, lift = -np.tan(found.inclination[-1]), found.height[-1]
    states = Whisker(theta=THETA, eta=ETA - lift).response
    assert travel_on_slope(states, 0.3, slope) == pytest.approx(wavelength, abs=4e-5)  # two steps
    assert abs(travel_on_slope(states, 0.3, 0.0) - wavelength) > 1e-3
    with pytest.raises(ArgumentError, match="before it locks"):
        travel_on_slope(states, 0.3, 0.5)


@pytest.mark.slow
def test_short_kinetic_slips_lock_to_short_waves_in_the_same_way():
    wavelength, kappa, positions = 0.0086, 0.8, path("0.00002", ["0.25"])
    found = scanned(textures.wave(5e-6, wavelength), positions, law="kinetic", ratio=kappa)
    assert locking_of(found.periods.contact_rest[-6:-1], wavelength) == (1, 1)
    slope, lift = -np.tan(found.inclination[-1]), found.height[-1]
    states = Whisker(theta=THETA, eta=ETA - lift).response
    travel = travel_on_slope(states, 0.3, slope, kappa * 0.3)
    assert travel == pytest.approx(wavelength, abs=4e-5)  # two steps
    assert abs(travel_on_slope(states, 0.3, 0.0, kappa * 0.3) - wavelength) > 1e-4


def test_a_ball_is_traced_once_for_paths_that_end_in_the_same_part():
    surface = surfaces.constant(0.3).with_texture(textures.wave(2e-4, 0.02))
    one, other = (surface.traced(1e-3, np.array([0.0, end])).texture for end in (0.1, 0.2))
    assert one is other and one.start == -1.0 and one.stop == 1.5


# --- Textures ---


def test_grooves_have_the_depth_width_and_walls_that_were_asked_for():
    one = textures.grooves(width=0.01, depth=1e-3, pitch=0.03, wall=np.radians(45.0), offset=0.2)
    x = np.array([0.19, 0.2, 0.2005, 0.201, 0.205, 0.2095, 0.21, 0.22, 0.2305])
    height = [0.0, 0.0, -5e-4, -1e-3, -1e-3, -5e-4, 0.0, 0.0, -5e-4]
    assert one.height(x) == pytest.approx(height, abs=1e-15)
    assert one.breaks(0.19, 0.225) == pytest.approx([0.2, 0.201, 0.209, 0.21])
    assert one.slope(np.array([0.19, 0.2005, 0.205, 0.2095])) == pytest.approx([0, -1, 0, 1])
    vee = textures.grooves(width=0.01, depth=1.0, pitch=0.03, wall=np.radians(45.0))
    assert vee.low == pytest.approx(-0.005) and vee.height(0.005) == pytest.approx(-0.005)


def test_a_ball_bridges_narrow_grooves_and_reaches_into_wide_ones():
    r, deep = 1e-3, textures.grooves(1e-3, 5e-3, 0.01, np.radians(89.9), offset=0.0)
    traced = deep.traced(r, -0.02, 0.05)
    # Between edges at 0 and w it sinks by r − √(r² − (w/2)²), at a kink.
    w = 1e-3
    assert traced.height(0.5 * w) == pytest.approx(np.sqrt(r**2 - 0.25 * w**2) - r, rel=1e-5)
    assert traced.height(0.25 * w) == pytest.approx(np.sqrt(r**2 - w**2 / 16) - r, rel=1e-5)
    beside = traced.slope(np.array([0.5 * w - 1e-7, 0.5 * w + 1e-7]))
    assert beside == pytest.approx([-0.57735, 0.57735], rel=1e-3)
    wide = textures.grooves(0.006, 5e-4, 0.01, np.radians(89.9)).traced(r, -0.02, 0.05)
    assert wide.height(0.003) == pytest.approx(-5e-4, abs=1e-12)
    assert wide.low == pytest.approx(-5e-4, abs=1e-9)


def test_a_traced_wave_is_the_parallel_curve():
    """Where the valleys are wider than the ball it touches once, and tracing loses nothing."""
    a, k, r = 2e-4, 2.0 * np.pi / 0.02, 0.02
    assert 1.0 / (a * k**2) > r  # radius of curvature in the valley
    p = np.linspace(0.0, 0.04, 301)
    slope = a * k * np.cos(k * p)
    root = np.sqrt(1.0 + slope**2)
    traced = textures.wave(a, 0.02).traced(r, -0.02, 0.06)
    centre = p - r * slope / root
    assert traced.height(centre) == pytest.approx(a * np.sin(k * p) + r / root - r, abs=1e-9)
    assert traced.slope(centre) == pytest.approx(slope, abs=1e-5)
    assert textures.wave(a, 0.02).traced(0.0, 0.0, 1.0).slope(0.0) == a * k


def test_a_traced_profile_is_the_dilation_by_a_disc():
    rough = textures.rough(4e-4, 2e-3, 3)
    r, step = 3e-3, 2e-6
    x = np.arange(-0.005, 0.025, step)
    u = np.arange(-int(r / step), int(r / step) + 1) * step
    ball = np.sqrt(np.maximum(r**2 - u**2, 0.0)) - r
    dilated = grey_dilation(rough.height(x), structure=ball)
    traced = rough.traced(r, 0.0, 0.02)
    inside = (x > 0.0) & (x < 0.02)
    error = np.abs(traced.height(x[inside]) - dilated[inside])
    assert error.max() < 2e-6 and np.median(error) < 1e-9
    # Its slope is the derivative of its height.
    fine = x[inside] + 0.3 * step
    rise = traced.height(fine + 1e-9) - traced.height(fine - 1e-9)
    off = np.abs(rise / 2e-9 - traced.slope(fine)) > 1e-4
    assert off.mean() < 1e-2  # kinks


def test_a_rough_texture_has_its_deviation_and_correlation():
    rough = textures.rough(1e-4, 1e-3, 5)
    x = np.arange(0.0, 2.0, 1e-4)
    heights = rough.height(x)
    assert heights.std() == pytest.approx(1e-4, rel=0.05)
    shifted = np.corrcoef(heights, rough.height(x + 1e-3))[0, 1]
    assert shifted == pytest.approx(np.exp(-0.5), abs=0.03)
    assert rough.slope(x).std() == pytest.approx(0.1, rel=0.05)
    assert rough.low < heights.min() < heights.max() < rough.high
    assert (textures.rough(1e-4, 1e-3, 5).height(x) == heights).all()


def test_sums_and_lay():
    both = textures.wave(1e-4, 0.02) + textures.grooves(0.01, 1e-3, 0.03, np.radians(45.0))
    assert both.height(0.0005) == pytest.approx(1e-4 * np.sin(np.pi * 0.05) - 5e-4)
    assert {0.001, 0.009} <= set(both.breaks(0.0, 0.012)) and both.low == pytest.approx(-1.1e-3)
    along = textures.wave(1e-4, 0.02).with_lay(np.radians(60.0))
    x = np.linspace(0.0, 0.1, 50)
    assert along.height(x) == pytest.approx(textures.wave(1e-4, 0.04).height(x))
    assert along.slope(x) == pytest.approx(textures.wave(1e-4, 0.04).slope(x))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: textures.wave(1e-4, 0.0), "wavelength must be positive"),
        (lambda: textures.grooves(0.02, 1e-3, 0.01), "pitch larger than width"),
        (lambda: textures.grooves(0.01, 1e-3, 0.02, np.pi / 2), "at most 89.9 deg"),
        (lambda: textures.rough(-1.0, 1e-3), "deviation must not be negative"),
        (lambda: textures.measured([0.0, 0.0], [1.0, 1.0]), "number 2 is not above"),
        (lambda: textures.measured([0.0, 1.0], [1.0, np.nan]), "number 2 has no position or no"),
        (lambda: textures.measured([0.0], [1.0]), "at least 2 positions"),
        (lambda: textures.wave(1e-4, 0.1).with_lay(2.0), "between -90 and 90"),
        (lambda: textures.wave(1e-4, 0.1).traced(-1.0, 0.0, 1.0), "tip_radius"),
        (lambda: textures.measured([0, 0.1], [0, 0]).traced(0.1, 0.0, 1.0), "shorter than the"),
        (lambda: textures.incline(0.0, 0.0, 1.0), "slope must not be 0"),
    ],
)
def test_impossible_textures_are_refused(make, message):
    with pytest.raises(ArgumentError, match=message):
        make()


def test_scans_that_make_no_sense_are_refused():
    wave, positions = textures.wave(1e-4, 0.02), path("0.001", ["0.1"])
    surface = surfaces.constant(0.3).with_texture(wave)
    with pytest.raises(ArgumentError, match="over a range of distances"):
        simulate(respond(THETA, ETA), surface, positions)
    lying = Whisker(theta=THETA, eta=ETA, contact=Contact.LINE)
    with pytest.raises(ArgumentError, match="must be 'point', not 'line'"):
        stage_of(lying, positions, texture=wave)
    with pytest.raises(NoResponseError, match="must lie between"):
        stage_of(Whisker(theta=THETA, eta=0.99999), positions, texture=wave)
    short = textures.measured([0.0, 0.46], [0.0, 0.0])
    with pytest.raises(ArgumentError, match=r"from x = 0 L to 0\.46 L, .*extend it"):
        scanned(short, positions)


def test_a_slide_to_the_end_of_a_profile_needs_more_of_it_and_not_of_the_rod():
    # Uphill the tip may slide farther than the rod has states at the height where it begins.
    begin = WHISKER.curve.x1_init - 0.16
    x = np.linspace(begin - 0.02, begin + 0.2, 30)
    texture = textures.measured(x, np.tan(np.radians(20.0)) * (x - begin))
    slide = Slide(
        stage=stage_of(WHISKER, np.zeros(1), texture=texture),
        surface=surfaces.constant(0.3).with_texture(texture),
        model=SlipModel.of("free", 1.0),
        begin=float(begin),
        direction=1,
    )
    with pytest.raises(ArgumentError, match=r"surface is known from .* extend it to there"):
        slide.end()
