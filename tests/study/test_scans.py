"""Surfaces and scans of a study file: how often they are multiplied, their chunks and mistakes."""

import pytest

from vibrissa.errors import StudyError
from vibrissa.study.reading import read_study
from vibrissa.study.scans import MOST_PERIODS, ScanSection, scan_chunks

# Every value stands once, so that a test can put another in its place.
STUDY = """
study: demo
grids:
  main: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.001]}
surfaces:
  flat: {mu0: [0.2, 0.4]}
  stripes: {patches: [[0.0, 0.25], [0.5, 0.45]]}
  random: {mean: 0.3, deviation: 0.05, correlation: 0.02, seed: [1, 2, 3]}
  measured: {profile: friction.csv}
scans:
  laws:
    theta: [1, 2, 3]
    eta: 0.8
    dx0: [0.002, 0.004]
    surface: [flat, random]
    law: [free, kinetic, energy, damped]
    kinetic_ratio: [0.6, 0.75]
    damping: [0.0, 0.02, 0.1]
    cycles: 20
  path: {theta: 2, eta: 0.7, dx0: 0.01, surface: [stripes, measured], to: [0.5, -0.1]}
figures:
  shapes: {kind: scan, scan: laws, mu0: 0.2, dx0: 0.002, surface: flat, law: free}
"""
PROFILE = "# a line of a remark\nx, mu0\n0, 0.3\n0.5, 0.35\n\n1, 0.32\n"


@pytest.fixture
def read(tmp_path):
    def read(text, profile=PROFILE):
        (tmp_path / "friction.csv").write_text(profile)
        path = tmp_path / "my.yaml"
        path.write_text(text)
        return read_study(path)

    return read


def scans_of(study, name):
    """Rod, surface and law of each scan of an entry."""
    return [
        (theta, dx0, variant, law)
        for chunk in study.scan_chunks.values()
        if chunk.scan_name == name
        for theta in chunk.axes["theta"]
        for dx0 in chunk.axes["dx0"]
        for variant in chunk.surfaces
        for law in chunk.laws
    ]


def test_axes_that_do_not_bear_on_each_other_are_not_multiplied(read):
    scans = scans_of(read(STUDY), "laws")
    # 3 rods, 2 steps, 2 planes and 3 random surfaces; free, each other law with two ratios, and
    # damped with three dampings, too.
    assert len(scans) == 3 * 2 * (2 + 3) * (1 + 2 * 2 + 2 * 3)
    assert {tuple(law.items()) for *_, law in scans} == {
        (("law", "free"),),
        *(
            (("law", law), ("kinetic_ratio", r))
            for law in ("kinetic", "energy")
            for r in (0.6, 0.75)
        ),
        *(
            (("law", "damped"), ("kinetic_ratio", r), ("damping", zeta))
            for r in (0.6, 0.75)
            for zeta in (0.0, 0.02, 0.1)
        ),
    }
    planes = [variant for *_, variant, _ in scans if variant["surface"] == "flat"]
    assert all(variant.keys() == {"surface", "mu0"} for variant in planes)


def test_a_surface_that_stands_twice_is_scanned_once(read):
    twice = read(STUDY.replace("[stripes, measured]", "[stripes, measured, stripes]"))
    assert scans_of(twice, "path") == scans_of(read(STUDY), "path")


def test_mu0_is_short_for_a_plane(read):
    short = STUDY.replace("surface: [flat, random]", "mu0: [0.2, 0.4]")
    used = short.replace("[stripes, measured]", "[stripes, measured, flat, random]")
    used = used.replace("surface: flat, law: free", "law: free")
    variants = [variant for *_, variant, _ in scans_of(read(used), "laws")]
    assert {tuple(variant.items()) for variant in variants} == {
        (("surface", "plane"), ("mu0", 0.2)),
        (("surface", "plane"), ("mu0", 0.4)),
    }


@pytest.mark.parametrize(
    ("law", "retracts"),
    [
        ({"law": "free"}, False),
        ({"law": "kinetic", "kinetic_ratio": 0.7}, False),
        ({"law": "energy", "kinetic_ratio": 0.7}, True),
        ({"law": "damped", "kinetic_ratio": 0.7, "damping": 0.1}, True),
    ],
)
def test_slips_with_inertia_need_states_in_which_the_clamp_is_pulled_back(law, retracts):
    rod = {"theta": 2, "eta": 0.85, "dx0": 0.001, "mu0": 0.3, "cycles": 2}
    assert ScanSection.model_validate(rod | law).retracts is retracts


def test_shapes_are_kept_where_a_figure_or_the_file_asks_for_them(read):
    assert read(STUDY).with_shapes == {"laws"}
    assert read(STUDY.replace("to: [0.5", "shapes: true, to: [0.5")).with_shapes == {"laws", "path"}
    signals = "kind: signals, theta: 2, kinetic_ratio: 0.6, mu0: 0.2, law: energy"
    text = STUDY.replace("kind: scan", signals).replace(" mu0: 0.2, dx0", " dx0")
    assert read(text.replace(", law: free", "")).with_shapes == set()


@pytest.mark.parametrize("longer", ["theta", "eta", "dx0", "seed"])
def test_values_appended_leave_whole_chunks_as_they_are(read, longer):
    base = STUDY.replace("cycles: 20", "cycles: 100").replace("eta: 0.8", "eta: [0.8, 0.9]")
    base = base.replace("law: free}", "law: free, eta: 0.8}")
    more = {"theta": ("[1, 2, 3]\n", "[1, 2, 3, 4]\n"), "eta": ("[0.8, 0.9]", "[0.8, 0.9, 0.95]")}
    more |= {
        "dx0": ("[0.002, 0.004]", "[0.002, 0.004, 0.005]"),
        "seed": ("1, 2, 3]}", "1, 2, 3, 4]}"),
    }
    before = {name: one.params for name, one in read(base).scan_chunks.items()}
    after = {
        name: one.params for name, one in read(base.replace(*more[longer])).scan_chunks.items()
    }
    kept = [name for name, params in before.items() if after.get(name) == params]
    assert len(kept) >= len(before) / 2
    # Only chunks that were not full get the seed.
    assert all(len(before[name]["surfaces"]) < 4 for name in before if name not in kept)


def test_a_chunk_has_no_more_periods_than_its_limit(read):
    study = read(STUDY)
    scan = study.scans["laws"]
    seeds = [{"surface": "s", "seed": seed} for seed in range(500)]
    chunks = list(scan_chunks("laws", scan, seeds, fixed={}, shapes=False))
    sizes = [len(one.surfaces) * len(one.axes["theta"]) * len(one.axes["dx0"]) for one in chunks]
    assert max(sizes) * len(scan.laws) * scan.cycles <= MOST_PERIODS
    assert sum(sizes) == 500 * 3 * 2
    assert len({one.name for one in chunks}) == len(chunks)
    assert all(one.minutes() < 60 for one in chunks)


def test_the_content_of_a_profile_decides_what_runs_again(read):
    def parts(profile):
        study = read(STUDY, profile)
        tables = {name: study.study_part(name) for name in study.tables}
        return tables | {name: one.study_part({}) for name, one in study.scan_chunks.items()}

    before, after = parts(PROFILE), parts(PROFILE.replace("0.32", "0.33"))
    changed = {name.partition("/")[0] for name in before if before[name] != after[name]}
    assert changed == {"scans", "periods", "path"}
    assert read(STUDY).data_files == ["friction.csv"]


HEIGHTS = """
  wavy:
    mu0: 0.3
    wave: {amplitude: [1e-4, 2e-4], wavelength: 0.02}
    rough: {deviation: 1e-5, correlation: 0.001, seed: [1, 2]}
    heights: heights.csv
    lay: [0, 0.5]
    tip_radius: [0, 0.001]
"""


@pytest.fixture
def read_heights(read, tmp_path):
    def read_with(change=("", ""), heights="x, height\n0, 0\n1, 1e-4\n"):
        (tmp_path / "heights.csv").write_text(heights)
        section = HEIGHTS.replace(*change) if change[0] else HEIGHTS
        text = STUDY.replace("\nscans:", section + "scans:")
        return read(text.replace("[stripes, measured]", "[stripes, measured, wavy]"))

    return read_with


def test_heights_of_a_surface_are_axes_of_its_scans(read_heights):
    study = read_heights()
    variants = [one for *_, one, _ in scans_of(study, "path") if one["surface"] == "wavy"]
    assert len(variants) == 2 * 2 * 2 * 2
    assert {(one["wave_amplitude"], one["rough_seed"]) for one in variants} == {
        (1e-4, 1),
        (1e-4, 2),
        (2e-4, 1),
        (2e-4, 2),
    }
    assert all(one["wave_phase"] == 0.0 and one["mu0"] == 0.3 for one in variants)
    assert study.data_files == ["friction.csv", "heights.csv"]
    assert study.study_part("scans") != read_heights(heights="x,height\n0, 0\n1, 0\n").study_part(
        "scans"
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("amplitude: [1e-4, 2e-4], ", "", "wavy.wave: missing 'amplitude'"),
        ("amplitude: [1e-4, 2e-4]", "amplitude: -1", "wavy.wave.amplitude"),
        ("wavelength: 0.02", "wavelength: 0", "greater than 0"),
        ("wavelength: 0.02", "wavelength: 0.02, length: 1", "wavy.wave.length"),
        ("rough: {", "grooves: {width: 0.2, depth: 1, pitch: 0.1, wall: 1}\n    rough: {", "above"),
        ("seed: [1, 2]", "seed: 1.5", "wavy.rough.seed"),
        ("tip_radius: [0, 0.001]", "tip_radius: -1", "wavy.tip_radius"),
        ("lay: [0, 0.5]", "lay: 90", "wavy.lay"),
        ("heights.csv", "far.csv", "no file far.csv in the study file's folder"),
        (HEIGHTS[HEIGHTS.index("    wave") : HEIGHTS.index("    lay")], "", "needs heights (wave"),
    ],
)
def test_a_mistake_in_heights_is_told_with_its_place(read_heights, old, new, words):
    with pytest.raises(StudyError) as told:
        read_heights((old, new))
    assert words in str(told.value), str(told.value)


def test_a_wrong_file_of_heights_is_told_with_its_line(read_heights):
    with pytest.raises(StudyError, match=r"wavy\.heights: .*heights\.csv:3: x must increase"):
        read_heights(heights="x, height\n0, 0\n0, 1e-4\n")


def test_heights_need_a_tip_alone_and_collocation(read):
    text = STUDY.replace("{mu0: [0.2, 0.4]}", "{mu0: [0.2, 0.4], grooves: GROOVES}")
    text = text.replace("GROOVES", "{width: 0.001, depth: 1e-4, pitch: 0.01, wall: 1}")
    with pytest.raises(StudyError, match=r"laws\.surface: .*heights, which need `contact: point`"):
        read(text.replace("study: demo", "study: demo\ncontact: line"))
    with pytest.raises(StudyError, match=r"heights, which need `method: collocation`"):
        read(text.replace("study: demo", "study: demo\nmethod: shooting"))


# What is put in place of what, where the message says it is, and words of it.
WRONG = {
    "unused": ("[flat, random]", "[flat]", "7: surfaces.random", "no scan uses it; remove it, or"),
    "unknown": ("[flat, random]", "[flat, x]", "14: scans.laws.surface", "allowed: flat, measured"),
    "no file": ("friction.csv", "x.csv", "8: surfaces.measured.profile", "no file x.csv in the"),
    "far file": ("friction.csv", "../x.csv", "8: surfaces.measured.profile", "or below it"),
    "no seed": (", seed: [1, 2, 3]", "", "7: surfaces.random", "missing 'seed'"),
    "seed 1.5": ("seed: [1, 2, 3]", "seed: [1.5]", "7: surfaces.random.seed[0]", "1.5"),
    "two kinds": ("{patches:", "{mu0: 1, patches:", "6: surfaces.stripes", "mu0 and patches"),
    "no kind": ("{mu0: [0.2, 0.4]}", "{}", "5: surfaces.flat", "exactly one of the keys mu0, pat"),
    "foreign": ("{mu0: [0.2", "{seed: 1, mu0: [0.2", "5: surfaces.flat.seed", "remove it"),
    "falling": ("[0.5, 0.45]", "[-1, 0.45]", "6: surfaces.stripes.patches[1]", "must increase"),
    "patch 0": ("[0.5, 0.45]", "[0.5, 0]", "6: surfaces.stripes.patches[1][1]", "greater than 0"),
    "ratio 0": ("[0.6, 0.75]", "[0, 0.75]", "16: scans.laws.kinetic_ratio[0]", "greater than 0"),
    "ratio 1.1": ("[0.6, 0.75]", "[1.1]", "16: scans.laws.kinetic_ratio[0]", "equal to 1"),
    "no ratio": ("    kinetic_ratio: [0.6, 0.75]\n", "", "15: scans.laws.law", "needs it"),
    "idle ratio": (
        "[free, kinetic, energy, damped]",
        "free",
        "16: scans.laws.kinetic_ratio",
        "remove",
    ),
    "no damping": (
        "    damping: [0.0, 0.02, 0.1]\n",
        "",
        "15: scans.laws.law",
        "missing 'damping'",
    ),
    "damping -1": ("[0.0, 0.02, 0.1]", "[-1]", "17: scans.laws.damping[0]", "equal to 0"),
    "damping nan": ("[0.0, 0.02, 0.1]", "[.nan]", "17: scans.laws.damping[0]", "finite number"),
    "idle damping": (", damped]", "]", "17: scans.laws.damping", "the law damped alone has"),
    "law": (
        "[free, kinetic, energy, damped]",
        "[quick]",
        "15: scans.laws.law[0]",
        "'free', 'kinetic'",
    ),
    "both ends": ("cycles: 20", "cycles: 20\n    to: 1", "19: scans.laws.to", "remove one of them"),
    "no end": ("    cycles: 20\n", "", "10: scans.laws", "missing 'cycles' or 'to'"),
    "both": (
        "eta: 0.7",
        "eta: 0.7, mu0: 0.3",
        "19: scans.path.surface",
        "both 'mu0' and 'surface'",
    ),
    "short": ("to: [0.5, -0.1]", "to: [0.5, 0.499]", "19: scans.path.to[1]", "at least one step"),
    "to text": ("to: [0.5, -0.1]", "to: far", "19: scans.path.to", "'far'"),
    "figure": ("surface: flat, law", "surface: random, law", "21: figures.shapes", "mu0"),
    "figure law": (", law: free", "", "21: figures.shapes", "shows one value of law"),
    "no steps": (
        "cycles: 20",
        "cycles: 20\n    each_step: false",
        "22: figures.shapes.scan",
        "its table `scans` has no steps",
    ),
    "no surface": ("[stripes, measured]", "[]", "19: scans.path.surface", "at least 1 item"),
    "no name": ("friction.csv", "", "8: surfaces.measured", "it has none of them"),
    "flat": ("{mu0: [0.2, 0.4]}", "0.3", "5: surfaces.flat", "keys with their values"),
    "shapes": ("to: [0.5, -0.1]", "to: 1, shapes: maybe", "19: scans.path.shapes", "boolean"),
    "key": ("    damping:", "    dampin:", "17: scans.laws.dampin", "allowed: bore, clamp_angle"),
    "shot": ("study: demo", "study: demo\nmethod: shooting", "11: scans.laws", "collocation"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_is_told_with_its_line_and_a_remedy(read, name):
    old, new, place, words = WRONG[name]
    assert STUDY.count(old) == 1, "the value stands once"
    # The text begins with an empty line, which an editor would not show.
    with pytest.raises(StudyError) as told:
        read(STUDY.replace(old, new)[1:])
    lines = [line.partition("my.yaml:")[2] for line in str(told.value).splitlines()]
    assert any(line.startswith(place) and words in line for line in lines), lines


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        (PROFILE.replace("1, 0.32", "0.5, 0.32"), "friction.csv:6: x must increase; 0.5 is not"),
        (PROFILE.replace("0.35", "0"), "friction.csv:4: mu0 must be above 0, got 0"),
        (PROFILE.replace("0.35", "rough"), "friction.csv:4: mu0 must be a number, got 'rough'"),
        (PROFILE.replace("0.5, 0.35", "0.5"), "friction.csv:4: mu0 must be a number, got ''"),
        (PROFILE.replace("x, mu0", "x, mu"), "has no column mu0; its first line has x, mu"),
        (PROFILE.replace("0.35", "nan"), "friction.csv:4: mu0 must be a number, got 'nan'"),
        (PROFILE.replace("0.5, 0.35", "0,5, 0,35"), "friction.csv:4: 4 values for 2 columns"),
        (PROFILE.replace("x, mu0", "x, mu0, mu0"), "has the column mu0 twice; remove one of them"),
        ("x, mu0\n0, 1\n", "a profile needs two rows or more"),
        ("", "has no column x, mu0; its first line has nothing"),
    ],
)
def test_a_wrong_profile_is_told_with_its_line(read, profile, words):
    with pytest.raises(StudyError, match=r"surfaces\.measured\.profile") as told:
        read(STUDY, profile)
    assert words in str(told.value)
