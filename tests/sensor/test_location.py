"""Contact points from the loads on the clamp."""

import numpy as np
import pytest
from typer.testing import CliRunner

import profiles
from profiles import EXACT, STEEL, recorded
from responses import respond
from vibrissa import Mounting
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.scanning import surfaces, textures
from vibrissa.sensor import Setup, Whisker, identify, locate, scan
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
    whisker = Setup.read(theta=2, eta="85 mm", **STEEL).whisker
    wave = textures.wave(2e-4, 0.02)
    surface = surfaces.constant(0.3).with_texture(wave)
    signals = scan(whisker, surface, step="100 um", to="6 mm")
    found = locate(whisker, signals.to_pandas())
    assert found.x == pytest.approx(signals.truth.contact, abs=1e-7)
    assert 0.85 - found.y == pytest.approx(wave.height(signals.truth.contact), abs=1e-7)
    assert np.abs(found.s_c - 1.0).max() < 1e-6


@pytest.mark.slow
def test_noise_of_the_profile_is_what_it_is_said_to_be():
    setup = Setup.read(theta=2, eta="85 mm", **STEEL, **EXACT)
    table, truth = recorded(setup.whisker, noise=1.0)
    found = identify(setup, table, profile=True).profile
    rows = found.line - found.line[0]
    for values, true, sizes in (
        (found.located.x, truth.contact, found.x_noise),
        (found.height, truth.height, found.height_noise),
    ):
        off = (values - true[rows]) / sizes
        assert 0.8 < off.std() < 1.2 and abs(off.mean()) < 0.4
    assert found.height_deviation == pytest.approx(found.height_noise)
    assert 1e-6 < np.median(found.height_noise) < 1e-3


@pytest.mark.slow
def test_friction_on_an_uneven_surface_is_called_apparent():
    setup = Setup.read(
        theta=2, eta="85 mm", **STEEL, **EXACT, tolerances={"surface_slope": "0.2 deg"}
    )
    table, truth = recorded(setup.whisker, noise=1.0)
    periods = identify(setup, table).periods
    assert all("mu0 is the apparent friction, with the slopes" in one for one in periods.doubt)
    slipped = truth.periods.ends_by == "slip"
    assert np.abs(truth.periods.apparent_friction[slipped] - 0.3).max() > 0.02
    assert periods.mu0[slipped][1:] == pytest.approx(
        truth.periods.apparent_friction[slipped][1:], abs=0.02
    )


# A night has a case for each parameter of the set-up.
@pytest.mark.slow
@pytest.mark.parametrize("name", ["eta"])
def test_a_set_up_that_is_off_by_its_tolerance_shifts_the_profile_by_its_deviation(name):
    for shift, deviation in profiles.shifts(name):
        assert shift == pytest.approx(deviation, rel=0.05, abs=2e-6)


def test_a_profile_needs_the_rod_and_all_channels():
    setup = Setup.read(theta=2, eta="85 mm", **STEEL, **EXACT)
    table, _ = recorded(setup.whisker)
    with pytest.raises(ArgumentError, match="needs the rod"):
        identify(Setup.read(**EXACT), table, method="ratio", profile=True)
    with pytest.raises(RecordingError, match="all three channels"):
        identify(setup, table.drop(columns="moment_z"), profile=True)


@pytest.mark.slow
def test_the_command_writes_profile_and_picture(tmp_path):
    setup = Setup.read(theta=2, eta="85 mm", **STEEL, **EXACT)
    table, truth = recorded(setup.whisker, noise=1.0)
    told = "identify scan.csv --theta 2 --eta 85mm --modulus 210GPa --diameter 1mm --length 100mm"
    names = {name: f"{name} [{unit}]" for name, unit in table.attrs["units"].items()}
    table.rename(columns=names).to_csv(tmp_path / "scan.csv", index=False)
    told = told.replace("scan.csv", str(tmp_path / "scan.csv"))
    noise = ["--noise", EXACT["noise"], "--tolerance", "exact"]
    profile = ["--profile", str(tmp_path / "profile.csv")]
    picture = ["--picture", str(tmp_path / "profile.png")]
    result = CliRunner().invoke(app, [*told.split(), *noise, *profile, *picture])
    assert result.exit_code == 0, result.output
    written = series.read(tmp_path / "profile.csv", ["x", "height", "height_deviation"])
    assert written.units["height"] == "m"
    off = written.columns["height"] - 0.1 * truth.height[: len(written.columns["x"])]
    assert (np.abs(off) < 5.0 * written.columns["height_deviation"]).all()
    assert (tmp_path / "profile.png").stat().st_size > 5000
