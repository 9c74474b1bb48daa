"""Profiles that are read under the tip, from simulated scans over a wave."""

import numpy as np

from vibrissa.scanning import surfaces, textures
from vibrissa.sensor import Setup, identify, scan

STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
GIVEN = {"theta": 2, "eta": "85 mm", **STEEL}
NOISE = np.array([1e-4, 1e-4, 5e-6])  # N, N, N·m
EXACT = {"noise": "0.1 mN, 0.1 mN, 5 uN*m", "assume": False}
# A tolerance of each parameter, and what the set-up is if it is off by as much.
OFF = {
    "theta": ("0.01", {"theta": 2.01}),
    "eta": ("0.05 mm", {"eta": "85.05 mm"}),
    "length": ("0.05 mm", {"length": "100.05 mm"}),
    "modulus": ("0.5 %", {"modulus": "211.05 GPa"}),
    "clamp_angle": ("0.02 deg", {"clamp_angle": "0.02 deg"}),
    "curvature": ("0.05 m^-1", {"curvature": "0.05 m^-1"}),
    "zero_force_y": ("2 mN", {}),
}


def recorded(whisker, noise=0.0, **change):
    """Signals of a scan over a wave, with noise."""
    surface = surfaces.constant(0.3).with_texture(textures.wave(2e-4, 0.02))
    signals = scan(whisker, surface, step="100 um", to="8 mm")
    table = signals.to_pandas()[["footpoint", "force_x", "force_y", "moment_z"]]
    generator = np.random.default_rng(3)
    for name, size in zip(("force_x", "force_y", "moment_z"), NOISE, strict=True):
        table[name] += change.get(name, 0.0) + noise * size * generator.standard_normal(len(table))
    table.attrs["units"] = signals.to_pandas().attrs["units"]
    return table, signals.truth


def shifts(name):
    """Errors of x and height if one parameter is off by its tolerance, and their deviations."""
    size, true = OFF[name]
    setup = Setup.read(**GIVEN, **EXACT, tolerances={name: size})
    change = {} if true else {"force_y": 2e-3}
    table, truth = recorded(Setup.read(**GIVEN | true).whisker, **change)
    found = identify(setup, table, profile=True).profile
    rows, length = found.line - found.line[0], 0.10005 if name == "length" else 0.1
    # A rod of another length has the same surface in m.
    for values, true_values, both, noise in (
        (found.located.x, truth.contact, found.x_deviation, found.x_noise),
        (found.height, truth.height, found.height_deviation, found.height_noise),
    ):
        shift = np.abs(values - true_values[rows] * length / 0.1)
        yield shift, np.sqrt(both**2 - noise**2)
