"""What people write, and what is read of it or said: each text of a long list, as it was."""

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from known import Known, result_of
from vibrissa import Rod
from vibrissa.sensor import Whisker, surfaces
from vibrissa.sensor.given.rod_file import RodFile, keys_of
from vibrissa.sensor.given.tolerances import TOLERABLE, assumed_tolerances, read_tolerances, told
from vibrissa.sensor.given.values import Given
from vibrissa.sensor.importing.units import is_unit, title_of
from vibrissa.sensor.quantities import Kind, Units, in_si, range_of, read_rod, wished_units
from vibrissa.sensor.strain import strains_until
from vibrissa.sensor.transducer import PRESETS, Transducer, preset

KNOWN = Known(__file__)
STEEL = Rod(2.1e11, 1e-3, 0.1)
OF_STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
UNITS = {"own": Units(), "steel": Units(STEEL, {Kind.LENGTH: "mm"}), "SI": Units(si=True)}

TEXTS = {
    Kind.LENGTH: ["85 mm", "1e-3 m", "-.5 cm", "2 inch", "3", "1 mm ± 2 mm", "1,5 mm", "1e61 m"],
    Kind.FORCE: ["3 mN", "3 uN", "2 kg*m/s^2", "3 mm", "1e-61 N", "0 N", "N"],
    Kind.MOMENT: ["1 N*mm", "2 mN*m", "2 mN*mm", "3 uN*m", "1 N m", "5 J", "5 rad"],
    Kind.ANGLE: ["2 deg", "1 rad", "90", "1 turn"],
    Kind.COMPLIANCE: ["0.05 rad/(N*m)", "1 deg/(N*mm)", "0.05 N*m/rad"],
    Kind.CURVATURE: ["-2 m^-1", "2 1/m", "2 m^-2"],
    Kind.STRESS: ["210 GPa", "1 N/mm^2", "200 MPa", "1 bar", "1 m"],
    Kind.SPEED: ["0.1 mm/s", "1 km/h", "1 m"],
    Kind.RATE: ["50 Hz", "2 kHz", "1 s"],
    Kind.TIME: ["2 s", "3 min", "10 ms", "1 Hz"],
    Kind.NUMBER: ["2 percent", "0.3 N", "3 %", "3 dB"],
    Kind.DENSITY: ["7.8 g/cm^3", "7800 kg/m^3"],
}


@pytest.mark.parametrize("kind", TEXTS)
def test_a_quantity_is_read_in_si_units_or_refused(kind):
    KNOWN.check(
        f"in SI, {kind}", {text: result_of(in_si, text, kind, "it") for text in TEXTS[kind]}
    )


@pytest.mark.parametrize("name", UNITS)
def test_units_go_both_ways(name):
    units = UNITS[name]
    values = {Kind.LENGTH: "3 mm", Kind.FORCE: "2 mN", Kind.MOMENT: "4 N*mm", Kind.NUMBER: "0.3"}
    found = {
        kind: {
            "unit": result_of(units.unit, kind),
            "name": units.name(kind) if kind in values else "",
            "told": result_of(units.told, 0.125, kind) if kind in values else "",
            "spelled": result_of(units.spelled, 0.125, kind, 3) if kind in values else "",
            "read": result_of(units.read, values.get(kind, "0.5"), kind, "it"),
            "bare": result_of(units.read, 0.25, kind, "it"),
        }
        for kind in [*values, Kind.ANGLE, Kind.COMPLIANCE, Kind.STIFFNESS, Kind.CURVATURE]
    }
    columns = [("mm", Kind.LENGTH), ("L", Kind.LENGTH), ("E*I0 / L**2", Kind.FORCE), ("N", "force")]
    found["columns"] = [
        result_of(units.column_factor, unit, Kind(kind), "x") for unit, kind in columns
    ]
    found["channels"] = [
        result_of(units.read_channels, text, "noise")
        for text in ("1, 2, 3", "3 mN, 3 mN, 10 uN*m", "1 N, 2 N", "1 N, 2 N, 3 N")
    ]
    KNOWN.check(f"units, {name}", found)


def test_texts_are_taken_apart_in_the_same_way():
    wishes = [("85 ± 0.1 mm",), (0.85, "3 cm"), ("3 mN, 4 mN, 10 uN*m", "1 m"), ("2 %", None)]
    ranges = ["0.2 to 0.4", "20 to 200 mm", "1 um to 2 mm", "5", "1 to 2 eV"]
    tolerated = ["210 ± 5 GPa", "210 GPa +- 2 %", "(1 ± 2) mm", 3.5, "1 ± 2 ± 3", "1 mm ± 2"]
    titles = ["Fz [mN]", "Fz (mN)", "Fz / mN", "Fz in mN", "a [b] c", "[mm]", " x ", "Kraft Fx(N)"]
    units = ["mm", "[mN]", "(Nmm)", "-", "", "%", "°C", "V", "Fx", "kg", "1", "N·mm", "s", "foo"]
    rods = [(None,) * 3, ("1 GPa", None, "1 m"), ("1 GPa", "2 mm", "3 m"), ("1 m", "1 m", "1 m")]
    KNOWN.check(
        "texts",
        {
            "wished": [result_of(wished_units, list(TEXTS)[:3], *one) for one in wishes],
            "ranges": [list(range_of(one)) for one in ranges],
            "tolerated": [result_of(Given.read, one, "x") for one in tolerated],
            "titles": {one: list(title_of(one)) for one in titles},
            "units": {one: is_unit(one) for one in units},
            "rods": [result_of(read_rod, *one) for one in rods],
        },
    )


WHISKERS = {
    "own": {"theta": 2, "eta": 0.85},
    "steel": {"theta": "2", "eta": "85 mm", **OF_STEEL},
    "mounted": {
        "theta": "2 ± 1 %",
        "eta": "8.5 ± 0.01 cm",
        **OF_STEEL,
        "clamp_angle": "2 ± 0.5 deg",
        "clamp_stiffness": "20 ± 2 N*m/rad",
        "curvature": "-2 ± 0.1 m^-1",
        "stage_angle": "1 deg ± 10 %",
        "contact": "line",
        "section": "planar",
    },
    "in per cent": {"theta": 2, "eta": 0.85, "clamp_stiffness": "20 ± 5 %"},
    "compliant": {"theta": 2, "eta": 0.85, "clamp_compliance": 0.05, "curvature": "-0.2, 0.1"},
    "both": {"theta": 2, "eta": 0.85, "clamp_compliance": 0.05, "clamp_stiffness": 20},
    "soft": {"theta": 2, "eta": 0.85, "clamp_stiffness": 0},
    "loose": {"theta": 2, "eta": 0.85, "contact": "edge"},
    "half a rod": {"theta": 2, "eta": 0.85, "modulus": "1 GPa"},
}


def read_whisker(**given):
    found = Whisker.read(**given)
    return {**asdict(found), "wished": dict(found.wished), "tolerances": dict(found.tolerances)}


def test_a_whisker_is_read_with_its_tolerances_or_refused():
    KNOWN.check(
        "whiskers", {name: result_of(read_whisker, **one) for name, one in WHISKERS.items()}
    )


def test_tolerances_are_read_assumed_and_told_in_the_same_units():
    whiskers = {name: Whisker.read(**WHISKERS[name]) for name in ("own", "steel", "mounted")}
    asked = [
        *({name: "2 %"} for name in TOLERABLE),
        *({name: 0.01} for name in TOLERABLE),
        *({name: "0.1 mm"} for name in ("eta", "length", "diameter", "moment_origin_x", "theta")),
        {"modulus": "5 GPa"},
        {"clamp_angle": "0.5 deg"},
        {"eta": "exact", "theta": 0.01},
        {"eta": -0.01},
        {"etta": 0.01},
        {"eta": "nan"},
    ]
    noise = np.array([0.001, np.nan, 0.0001])
    KNOWN.check(
        "tolerances",
        {
            name: {
                "read": [result_of(read_tolerances, one.units, each, one, 0.8) for each in asked],
                "assumed": assumed_tolerances(one.units, noise),
                "told": {each: list(told(each, 0.01, one.units)) for each in TOLERABLE},
            }
            for name, one in whiskers.items()
        },
    )


ROD_FILES = {
    "whole": 'theta = "2 ± 0.02"\neta = "85 ± 0.1 mm"\nmodulus = "210 GPa"\ndiameter = "1 mm"\n'
    'length = "100 mm"\nkinetic_ratio = "0.8 ± 0.03"\nnoise = "3 mN, 3 mN, 10 N*mm"\n'
    'yield_strain = 0.006\ndensity = "7800 kg/m^3"\n[tolerances]\nclamp_angle = "0.3 deg"\n',
    "short": "theta = 2\neta = 0.85\n",
    "no height": "theta = 2\n",
    "no TOML": "theta: 2\n",
    "a key that is nearly right": "theta = 2\netta = 0.85\n",
    "a key that is far from right": "theta = 2\nqqqq = 0.85\n",
    "a list": "theta = [2]\neta = 0.85\n",
    "true": "theta = true\neta = 0.85\n",
    "no table": "theta = 2\neta = 0.85\ntolerances = 3\n",
    "a tolerance of nothing": "theta = 2\neta = 0.85\n[tolerances]\nheight = 3\n",
    "a tolerance that is a list": "theta = 2\neta = 0.85\n[tolerances]\neta = [3]\n",
}


def test_a_rod_file_is_read_or_its_line_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def read(text):
        Path("rod.toml").write_text(text, encoding="utf-8")
        keys = keys_of("rod.toml")
        found = RodFile.of(keys)
        whisker = found.whisker
        return {
            "keys": keys,
            "reading": found.reading,
            "material": found.material,
            "tolerances": dict(whisker.tolerances),
            "wished": dict(whisker.wished),
        }

    found = {name: result_of(read, text) for name, text in ROD_FILES.items()}
    Path("latin.toml").write_bytes("theta = 2 # µ".encode("latin-1"))
    for name in ("none.toml", "rod.yaml", ".", "latin.toml"):
        found[name] = result_of(keys_of, name)
    KNOWN.check("rod files", found)


def test_transducers_measure_the_same():
    own = Transducer(
        name="own",
        source="",
        limit=(1.0, 2.0, 0.1),
        resolution=(0.01, 0.0, 0.001),
        noise=(0.02, 0.03, 0.004),
        drift=(0.001, 0.0, 0.0002),
        crosstalk=0.05,
    )
    load = np.outer(np.linspace(-1.2, 1.2, 25), [1.0, -1.8, 0.09])
    names = ("limit", "resolution", "noise", "deviation")
    KNOWN.check(
        "transducers",
        {
            **{name: {n: getattr(preset(name), n) for n in names} for name in PRESETS},
            "own": {n: getattr(own, n) for n in names},
            "measured": own.measured(load, np.random.default_rng(3)),
            "saturated": own.saturated(load),
            "unknown": result_of(preset, "nano18"),
        },
    )


def test_surfaces_have_the_same_friction_and_edges():
    x = np.linspace(-0.2, 1.2, 15)
    made = {
        "constant": surfaces.constant(0.3),
        "patches": surfaces.patches([0.0, 0.3, 0.7], [0.2, 0.5, 0.3]),
        "random": surfaces.random(7, 0.3, 0.1, 0.05),
        "random, bounded": surfaces.random(7, 0.1, 0.1, 0.05, 0.08),
        "profile": surfaces.profile([-0.5, 0.3, 2.0], [0.2, 0.5, 0.3]),
    }
    steel = UNITS["steel"]
    told = [
        {"mu0": "0.3", "patches": "0:1"},
        {"patches": "0 mm: 0.3, 50 mm: 0.4"},
        {"patches": "0 mm: 0.3, 50 mm: 0.4, 20 mm: 0.3"},
        {"texture": "0.3, 0.04, 2 mm", "seed": 3},
        {"texture": "0.3, 0.04"},
        {"texture": "0.3, 0.04, -2 mm"},
        {"profile": Path("none.csv")},
        {},
    ]

    def read(one):
        found = surfaces.read_surface(steel, **one)
        return [found.name, found.edges.tolist(), found(x).tolist()]

    KNOWN.check(
        "surfaces",
        {
            "mu0": {
                name: [one(x), one.edges, one.start, one.stop, one.name]
                for name, one in made.items()
            },
            "beyond": result_of(surfaces.profile([0.0, 0.5], [0.1, 0.2]), x),
            "negative": result_of(surfaces.patches([0.0, 0.5], [0.1, -0.2]), x),
            "told": [result_of(read, one) for one in told],
        },
    )


def test_strains_of_a_period_are_the_same():
    whiskers = {
        "round": Whisker(theta=2.0, eta=0.85),
        "cylinder": Whisker(theta=1.0, eta=0.85),
        "tilted": Whisker.read(3, 0.8, clamp_angle="3 deg", curvature=-0.1),
    }
    found = {}
    for name, one in whiskers.items():
        at_end, most = strains_until(one.curve, 0.04)
        found[name] = [at_end, *most.largest.tolist(), *most.place.tolist()]
    KNOWN.check("strains", found)
