"""Scans in which a round rod swings aside, and is dragged."""

from decimal import Decimal

import numpy as np
import pytest
from typer.testing import CliRunner

from vibrissa import stick_slip
from vibrissa.cli.app import app
from vibrissa.sensor import Whisker, scan, surfaces
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.scanning import Outcome, TipPhase, TipSide, path, simulate
from vibrissa.sensor.simulation.slips import SlipLaw

MIRROR = np.array([-1.0, 1.0, -1.0])


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


@pytest.fixture(scope="module")
def flat():
    """In line contact: the tail of the rod lies on the surface."""
    return respond(3.0, 0.7, "line")


def swing_of(result):
    (row,) = np.flatnonzero(result.phase == TipPhase.SWING)
    return int(row)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["response", "flat"])
def test_free_slips_on_one_friction_are_those_of_a_study(name, request):
    response = request.getfixturevalue(name)
    study = stick_slip(response.curve, Decimal("0.9"), Decimal("0.009"), cycles=4)
    result = simulate(response, surfaces.constant(0.9), study.footpoint)
    assert result.outcome is Outcome.COMPLETE and "swings aside" in result.message
    assert (result.phase == TipPhase.SLIP).tolist() == [phase == "slip" for phase in study.phase]
    assert result.contact == pytest.approx(study.x1, abs=1e-12)
    state = study.state
    expected = np.array([state.reaction_fx, state.reaction_fy, state.reaction_m]).T
    assert result.reactions == pytest.approx(expected, abs=2e-7 * np.abs(expected).max())
    assert set(result.side[swing_of(result) :]) == {TipSide.BEHIND}


@pytest.mark.slow
def test_it_swings_without_a_jump_to_the_mirror_image_of_the_strip_s_states(response):
    result = simulate(response, surfaces.constant(0.9), path("1e-5", ["0.8"]))
    swing = response.x0_end
    row = swing_of(result)
    assert result.clamp[row - 1] <= swing < result.clamp[row]
    # Forces and moment turn round with the plane of the rod; one step changes them by 1e-5 or so.
    jump = result.reactions[row] - result.reactions[row - 1] * MIRROR
    assert np.abs(jump).max() < 2e-4
    strip = respond(2.0, 0.85, section="planar")
    behind = slice(row, None)
    mirrored = strip(2.0 * swing - result.clamp[behind]) * MIRROR
    assert result.reactions[behind] == pytest.approx(mirrored, abs=1e-7)
    assert result.period[-1] == 1 and np.ptp(result.contact) < 1e-14
    # The clamp has done no work on the way from a state to its mirror image.
    work = -np.cumsum(0.5 * (result.reactions[1:, 0] + result.reactions[:-1, 0]) * 1e-5)
    before, after = np.searchsorted(result.clamp, [swing - 0.3, swing + 0.3])
    assert work[after - 1] - work[before - 1] == pytest.approx(0.0, abs=1e-4)
    assert result.x0[behind] == pytest.approx(result.clamp[behind] - 2.0 * swing, abs=1e-14)


@pytest.mark.parametrize("law", list(SlipLaw))
def test_on_any_surface_it_is_the_mirror_image_of_a_tip_that_is_pulled_back(response, law):
    # Held by a rough patch until the rod has swung aside, then over random friction and stripes.
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
    result = simulate(response, patched, forth, law, 0.7)
    expected = simulate(response, turned, np.where(over, 2.0 * swing - forth, forth), law, 0.7)
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


def test_signals_and_the_command_go_on_past_the_swing(tmp_path):
    asked = {"step": 0.002, "to": [1.0], "law": "energy"}
    signals = scan(Whisker(theta=2.0, eta=0.85), surfaces.constant(0.8), **asked)
    table = signals.to_pandas()
    behind = table["side"] == "behind"
    # A clamp that moves forward is held back, whether it pushes the tip or drags it.
    assert (table["force_x"][behind].iloc[[0, -1]] > [0.0, -1.0]).all()
    assert (table["force_y"] < 0.0).all()
    out = tmp_path / "scan.csv"
    words = ["--theta", "2", "--eta", "0.85", "--mu0", "0.8", "--step", "0.002", "--to", "1"]
    result = CliRunner().invoke(app, ["scan", *words, "--law", "energy", "-o", str(out)])
    assert result.exit_code == 0 and "complete" in result.output
    assert "with the clamp at 0.418 L the rod swings aside" in result.output
    assert out.read_text().splitlines()[-1].endswith(",behind")
