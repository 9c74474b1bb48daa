"""Contact points from the loads on the clamp."""

import numpy as np
import pytest

from responses import respond
from vibrissa import Mounting
from vibrissa.scanning import surfaces, textures
from vibrissa.sensor import Whisker, locate, scan
from vibrissa.sensor.location import located

CASES = [
    (2.0, 0.85, "point", Mounting()),
    (2.0, 0.85, "point", Mounting(clamp_angle=0.05, clamp_compliance=0.02, curvature=(-0.1, 0.2))),
    (3.0, 0.7, "line", Mounting()),
]


@pytest.mark.parametrize(("theta", "eta", "contact", "mounting"), CASES)
def test_the_contact_point_is_that_of_the_solver(theta, eta, contact, mounting):
    whisker = Whisker(theta=theta, eta=eta, mounting=mounting)
    curve = respond(theta, eta, contact, mounting).curve
    x0 = np.linspace(0.0, 0.8 * curve.x0_lock, 7)
    states = curve.state(x0)
    loads = np.stack([states.reaction_fx, states.reaction_fy, states.reaction_m], axis=1)
    found = located(whisker, x0, loads)
    assert found.y == pytest.approx(np.full(7, eta), abs=1e-9)
    assert found.s_c == pytest.approx(states.s_c, abs=1e-8)
    assert found.phi == pytest.approx(states.phi1, abs=1e-8)
    if contact == "point":
        assert found.x == pytest.approx(np.full(7, curve.x1_init), abs=1e-9)
    force = np.hypot(states.reaction_fx, states.reaction_fy)
    assert np.hypot(found.along, found.across) == pytest.approx(force)
    # The surface pushes across the rod, away from the side to which it is bent.
    assert (found.across < 0.0).all()


def test_the_profile_under_the_tip_is_read_from_the_loads():
    steel = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
    whisker = Whisker.read(2, "85 mm", **steel)
    wave = textures.wave(2e-4, 0.02)
    surface = surfaces.constant(0.3).with_texture(wave)
    signals = scan(whisker, surface, step="100 um", to="6 mm")
    found = locate(whisker, signals.to_pandas())
    assert found.x == pytest.approx(signals.truth.contact, abs=1e-7)
    assert 0.85 - found.y == pytest.approx(wave.height(signals.truth.contact), abs=1e-7)
    assert np.abs(found.s_c - 1.0).max() < 1e-6
