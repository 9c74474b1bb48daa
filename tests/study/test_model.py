"""A study file: what it says, and what is said of one that cannot be run."""

import math
from pathlib import Path

import jsonschema
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from vibrissa.errors import StudyError
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.outcomes import Contact, Solver
from vibrissa.study.axes import MOUNTING_AXES, Theta
from vibrissa.study.chunks import points_of
from vibrissa.study.json_schema import study_schema
from vibrissa.study.model import Study
from vibrissa.study.reading import read_study

ROOT = Path(__file__).parents[2]

# Every value stands once, so that a test can put another in its place.
STUDY = """
study: demo
contact: point
method: collocation
chunk: {theta: 5}
grids:
  main:
    theta: [1, 2.5]
    mu0: {start: 0.1, stop: 0.4, step: 0.1}
    eta: [0.85]
    dx0: [0.001]
scans:
  runs:
    theta: [3]
    mu0: [0.32, 0.34]
    eta: [0.8]
    dx0: [0.002, 0.004]
    cycles: 9
states:
  single: {theta: 1.5, eta: 0.55, x1: 0.15}
comparisons:
  models: {theta: [1], mu0: [0.33], eta: [0.75]}
figures:
  taper: {kind: taper, grid: main, caption: Some words.}
  friction: {kind: friction, grid: main, theta: 2.5}
  scan: {kind: scan, scan: runs, theta: 3, mu0: 0.32, dx0: 0.002}
  period: {kind: period, scan: runs, theta: 3, mu0: 0.34, dx0: 0.004}
  state: {kind: state, state: single}
"""
SMALLEST = "study: s\ngrids: {g: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.001]}}\n"
MOUNTED = SMALLEST.replace("[0.001]", "[0.001], curvature: [-0.1, [0, -0.3]], clamp_angle: [0, 1]")


@pytest.fixture
def read(tmp_path):
    def read(text, changes=None):
        path = tmp_path / "my.yaml"
        path.write_text(text, encoding="utf-8")
        return read_study(path, changes)

    return read


def edited(*edits, text=STUDY):
    for old, new in edits:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def mistakes(read, text):
    """Mistakes of a file without its name, each with its line."""
    with pytest.raises(StudyError) as error:
        read(text)
    return [one.partition("my.yaml:")[2] or one for one in str(error.value).splitlines()]


def test_the_study_is_what_is_written(read):
    study = read(STUDY)
    assert (study.name, study.contact, study.method) == ("demo", Contact.POINT, Solver.COLLOCATION)
    assert study.grids["main"].axes == {
        "theta": (1.0, 2.5),
        "mu0": (0.1, 0.2, 0.3, 0.4),
        "eta": (0.85,),
        "dx0": (0.001,),
        **dict.fromkeys(MOUNTING_AXES, (0.0,)),
    }
    assert study.scans["runs"].cycles == 9 and len(points_of(study.scans["runs"].axes)) == 4
    state = {"theta": 1.5, "eta": 0.55, "x1": 0.15, "contact": "line"}
    assert study.states["single"].params(Contact.LINE) == state
    figures = {name: figure.params() for name, figure in study.figures.items()}
    assert figures["taper"]["selection"] == {"grid": ["main"]}
    assert figures["taper"]["table"] == "stiction"
    assert figures["state"]["selection"] == {"state": ["single"]}
    shown = {"scan": "runs", "theta": [3.0], "mu0": [0.32], "dx0": [0.002]}
    assert figures["scan"]["selection"] == shown


@pytest.mark.parametrize(
    "written", ["[2.50, 1.0, 2.5, 1]", "{start: 1, stop: 2.5, step: 1.5}", "[1e0, '25e-1']"]
)
def test_the_order_and_the_spelling_of_values_do_not_matter(read, written):
    assert read(edited(("[1, 2.5]", written))).grids["main"].theta == (1.0, 2.5)


def test_a_single_value_needs_no_list(read):
    study = read(MOUNTED.replace("[0.85]", "0.85").replace("[-0.1, [0, -0.3]]", "-0.1"))
    assert study.grids["g"].eta == (0.85,) and study.grids["g"].curvature == (-0.1,)


def test_steps_are_decimal(read):
    mu0 = read(edited(("stop: 0.4, step: 0.1", "stop: 2e0, step: 1e-1"))).grids["main"].mu0
    assert mu0[2] == 0.3 and mu0[-1] == 2.0 and len(mu0) == 20


def test_a_curvature_may_be_a_polynomial(read):
    assert read(MOUNTED).grids["g"].curvature == (-0.1, (0.0, -0.3))
    assert read(MOUNTED.replace("-0.3]", "-0.3, 0, 0]")).grids["g"].curvature[1] == (0.0, -0.3)
    assert read(MOUNTED.replace("[0, -0.3]", "[0.2, 0]")).grids["g"].curvature == (-0.1, 0.2)


def test_the_results_are_what_the_study_asks_for(read):
    few = ["tables/stiction.parquet", "summary.txt", "report.html"]
    assert read(SMALLEST).results == few
    made = read(STUDY).results
    assert {*few, "tables/scans.parquet", "tables/states.parquet"} < set(made)
    assert {"figures/taper.pdf", "figures/taper.svg", "figures/captions.md"} < set(made)
    assert {"claims.md", "tables/claims.parquet"}.isdisjoint(made)


@pytest.mark.parametrize("path", [ROOT / "config.yaml", *sorted((ROOT / "studies").glob("*.yaml"))])
def test_our_own_studies_are_valid(path):
    study = read_study(path)
    assert (study.chunks or study.reading_chunks) and study.figures
    jsonschema.Draft202012Validator(study_schema()).validate(yaml.safe_load(path.read_text()))


def test_a_section_may_be_empty_and_anchors_may_have_a_place(read):
    study = read(SMALLEST + "x-axes: &a [1]\nscans:\nfigures: {}\nstates: ~\n")
    assert (study.scans, study.states, study.figures) == ({}, {}, {})


def test_captions_have_the_values_that_are_shown(read):
    told = read(edited(("Some words.", "'{theta}, {mu0}: {{x}}'"))).figure_params
    assert told["taper"]["caption"] == "1, 2.5, 0.1, 0.2, 0.3, 0.4: {x}"
    chosen = edited(("grid: main, caption: Some words.", "grid: main, mu0: [0.1, 0.3]"))
    assert read(chosen).figure_params["taper"]["caption"] == (
        "Clamp displacement x0,max over theta, a series for each mu0; theta = 1, 2.5, "
        "mu0 = 0.1, 0.3, eta = 0.85, dx0 = 0.001."
    )
    assert told["state"]["caption"] == (
        "Shapes of one or more states of the same eta; theta = 1.5, eta = 0.55, x1 = 0.15."
    )


def test_a_script_is_a_file_of_the_user(read, tmp_path):
    (tmp_path / "mine.py").touch()
    study = read(edited(("kind: taper, grid: main", "kind: script, script: mine.py, grid: main")))
    assert study.figure_params["taper"]["script"] == (tmp_path / "mine.py").as_posix()
    assert study.figure_params["taper"]["selection"] == {"grid": ["main"]}


def test_a_figure_makes_its_formats_and_the_png_of_the_report(read):
    made = read(edited(("caption:", "formats: [pdf], caption:"))).figure_files
    assert made[:2] == ["figures/taper.pdf", "figures/taper.png"]


def test_keys_may_be_merged(read):
    text = STUDY + "  more:\n    <<: {kind: friction, grid: main}\n    theta: 1\n"
    assert read(text).figures["more"].theta == (1.0,)


# What is put in place of what, where the message says it is, and words of it.
WRONG = {
    "unknown key": ("chunk: {", "chunks: {", "5: chunks", "'chunks' is not a valid key; allowed: "),
    "in a grid": ("  main:", "  main:\n    cycles: 2", "8: grids.main.cycles", "clamp_angle, cl"),
    "in a range": ("step: 0.1", "step: 0.1, n: 4", "9: grids.main.mu0.n", "start, step, stop"),
    "in a figure": ("caption:", "title:", "24: figures.taper.title", "not a valid key"),
    "of another kind": ("{kind: state,", "{kind: state, grid: main,", "28: figures.state.grid", ""),
    "no study": ("study: demo", "", "", "missing 'study'"),
    "no axis": ("    dx0: [0.001]\n", "", "7: grids.main", "missing 'dx0'"),
    "no cycles": ("    cycles: 9\n", "", "13: scans.runs", "missing 'cycles'"),
    "no kind": ("kind: state, ", "", "28: figures.state", "missing 'kind'"),
    "no scan": ("kind: scan, scan: runs,", "kind: scan,", "26: figures.scan", "the key 'scan'"),
    "contact": ("contact: point", "contact: tip", "3: contact", "'point' or 'line'"),
    "method": ("method: collocation", "method: magic", "4: method", "'shooting'"),
    "chunk 0": ("theta: 5", "theta: 0", "5: chunk.theta", "greater than or equal to 1"),
    "chunk of mu0": ("theta: 5", "mu0: 5", "5: chunk.mu0", "should be 'theta', 'eta'"),
    "cycles 0": ("cycles: 9", "cycles: 0", "18: scans.runs.cycles", "0 is not allowed"),
    "cycles text": ("cycles: 9", "cycles: nine", "18: scans.runs.cycles", "'nine'"),
    "theta < 1": ("[1, 2.5]", "[1, 0.99]", "8: grids.main.theta[1]", "0.99 is not allowed: input"),
    "theta 51": ("[1, 2.5]", "[1, 51]", "8: grids.main.theta[1]", "less than or equal to 50"),
    "theta text": ("[1, 2.5]", "[thin]", "8: grids.main.theta[0]", "'thin'"),
    "theta true": ("[1, 2.5]", "[true]", "8: grids.main.theta[0]", "True"),
    "theta list": ("[1, 2.5]", "[[1]]", "8: grids.main.theta[0]", "[1] is not allowed"),
    "theta nothing": ("[1, 2.5]", "", "8: grids.main.theta[0]", "None is not allowed"),
    "theta empty": ("[1, 2.5]", "[]", "8: grids.main.theta", "[] is not allowed"),
    "on lines": ("[1, 2.5]", "\n    - 1\n    - 0", "10: grids.main.theta[1]", "or equal to 1"),
    "mu0 0": ("[0.32, 0.34]", "[0]", "15: scans.runs.mu0[0]", "greater than 0"),
    "mu0 from 0": ("start: 0.1", "start: 0.0", "9: grids.main.mu0[0]", "greater than 0"),
    "eta 1": ("[0.85]", "[0.5, 1]", "10: grids.main.eta[1]", "less than 1"),
    "dx0 0": ("[0.001]", "[0.0]", "11: grids.main.dx0[0]", "0.000000001"),
    "step 0": ("step: 0.1", "step: 0", "9: grids.main.mu0.step", "greater than 0"),
    "stop": ("stop: 0.4", "stop: 0.45", "9: grids.main.mu0", "a whole number of steps of 0.1"),
    "stop < start": ("stop: 0.4", "stop: 0.05", "9: grids.main.mu0", "start 0.1 plus"),
    "stop huge": ("stop: 0.4", "stop: 1.0e+30", "9: grids.main.mu0", "more than 1,000,000"),
    "state x1": ("x1: 0.15", "x1: .nan", "20: states.single.x1", "finite"),
    "reach": ("x1: 0.15", "x1: -0.84", "20: states.single", "x1^2 + eta^2 < 1"),
    "nan": ("[0.001]", "[0.001, .nan]", "11: grids.main.dx0[1]", "nan is not allowed"),
    "inf": ("[1, 2.5]", "[1, .inf]", "8: grids.main.theta[1]", "inf is not allowed"),
    "nothing": (STUDY[STUDY.index("grids:") :], "grids: {}", "", "nothing to solve; add an entry"),
    "points": ("method: collocation", "max_points: 44", "4: max_points", "has 45 points, c"),
    "kind": ("kind: state,", "kind: stait,", "28: figures.state.kind", "'taper', 'friction',"),
    "unknown state": ("state: single", "state: x", "28: figures.state.state", "allowed: single"),
    "unknown grid": ("grid: main, cap", "grid: x, cap", "24: figures.taper.grid", "'x' is not"),
    "foreign theta": (", theta: 2.5", ", theta: 2", "25: figures.friction.theta", "has 1, 2.5"),
    "taper theta": ("caption:", "theta: [1, 9], caption:", "24: figures.taper.theta", "9 is not"),
    "part": ("Some words.", "'{theta[a]}'", "24: figures.taper.caption", "placeholder is wrong"),
    "placeholder": ("Some words.", "'{tau}'", "24: figures.taper.caption", "allowed: {theta}"),
    "open brace": ("Some words.", "'x{'", "24: figures.taper.caption", "for a brace write {{"),
    "limits": ("caption:", "axes: {x: [.nan, 1]}, caption:", "24: figures.taper.axes.x", "finite"),
    "format": ("caption:", "formats: [jpg], caption:", "24: figures.taper.formats", "'jpg'"),
    "film": ("caption:", "formats: [apng], caption:", "24: figures.taper.formats", "kind scan"),
    "grids": ("taper, grid: main", "taper, grid: [main, main]", "24: figures.taper", "one grid"),
    "slopes": ("taper, grid: main", "slopes, grid: main", "24: figures.taper", "no axis of the"),
    "size": ("caption:", "size: [0, 3], caption:", "24: figures.taper.size", "0 is not"),
    "no script": ("kind: taper,", "kind: script,", "24: figures.taper", "missing 'script'"),
    "lost script": ("taper, grid: main", "script, script: x.py, grid: main", "24:", "no file x.py"),
    "far script": ("taper, grid: main,", "script, script: ../x.py, grid: main,", "24:", "below"),
    "sources": ("taper, grid: main", "script, script: x.py, grid: main, scan: runs", "24:", "one"),
    "several": (", theta: 2.5", "", "25: figures.friction", "friction shows one value of theta"),
    "several etas": ("[0.85]", "[0.85, 0.9]", "24: figures.taper", "one value of eta, but 'main'"),
    "name": ("study: demo", "study: a b", "2: study", "letters, digits, _ and -"),
    "key as a name": ("  main:", "  a b:", "7: grids.a b", "letters, digits, _ and -"),
    "shot": ("point\nmethod: collocation", "line\nmethod: shooting", "4: method", "allowed here"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_is_told_with_its_line_its_key_and_what_is_allowed(read, name):
    old, new, place, words = WRONG[name]
    told = mistakes(read, edited((old, new)))
    assert any(one.startswith(place) and words in one for one in told), told


def test_all_mistakes_are_told_at_once(read):
    text = edited(
        ("contact: point", "contact: tip"),
        ("[1, 2.5]", "[0, thin]"),
        ("cycles: 9", "cycle: 9"),
        ("state: single", "state: x"),
        ("x1: 0.15", "x1: 0.15, x2: 1"),
    )
    told = mistakes(read, text)
    places = [
        "3: contact",
        "8: grids.main.theta[0]",
        "8: grids.main.theta[1]",
        "18: scans.runs.cycle",
    ]
    places += ["20: states.single.x2"]
    assert [one.split(": ")[0] + ": " + one.split(": ")[1] for one in told[:5]] == places


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has keys with values"),
        ("[]", "has keys with values"),
        ("just words", "has keys with values"),
        ("study: [", "not valid YAML"),
        ("study: a\nstudy: b\n", "2: not valid YAML: found duplicate key"),
    ],
)
def test_a_file_that_is_no_study_is_refused(read, text, words):
    assert words in " ".join(mistakes(read, text))


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(StudyError, match=r"none\.yaml cannot be read: No such file"):
        read_study(tmp_path / "none.yaml")
    with pytest.raises(StudyError, match="Is a directory"):
        read_study(tmp_path)
    (tmp_path / "latin").write_bytes("study: ü".encode("latin-1"))
    with pytest.raises(StudyError, match="not a text in UTF-8"):
        read_study(tmp_path / "latin")


def test_the_command_line_changes_keys_and_its_mistakes_are_its_own(read):
    study = read(STUDY, {"contact": "line", "strict": True})
    assert study.contact is Contact.LINE and study.strict
    assert study.text.endswith("# --config contact=line\n# --config strict=True\n")
    with pytest.raises(StudyError, match=r"^--config: contact: 'tip'"):
        read(STUDY, {"contact": "tip"})


def test_mountings_are_refused_where_nothing_solves_or_shows_them(read):
    (told,) = mistakes(read, MOUNTED + "method: shooting\n")
    assert "allowed here: collocation" in told
    told = mistakes(read, MOUNTED + "figures: {f: {kind: taper, grid: g}}\n")
    assert any("taper shows one value of clamp_angle" in one for one in told)
    change = "figures: {f: {kind: change, grid: g, over: curvature, clamp_angle: 0}}\n"
    assert any("lists of coefficients" in one for one in mistakes(read, MOUNTED + change))


def test_states_in_one_figure_have_one_surface(read):
    states = "states: {a: {theta: 1, eta: 0.5, x1: 0.2}, b: {theta: 1, eta: 0.6, x1: 0.2}}\n"
    (told,) = mistakes(read, SMALLEST + states + "figures: {f: {kind: state, state: [a, b]}}\n")
    assert "states of one eta" in told


@pytest.mark.parametrize(
    ("kind", "angles", "words"),
    [
        ("mounting", 1, "clamp_angle has 1; allowed: two values or more"),
        ("change", 1, "clamp_angle has 1; allowed: two values, one of them 0"),
        ("change", "[0, 0.5, 1]", "clamp_angle has 0, 0.5, 1; allowed: two values, one of them 0"),
        ("versus", "[0, 1]", "versus needs two values of theta or more"),
    ],
)
def test_a_figure_over_a_mounting_needs_values_to_compare(read, kind, angles, words):
    data = MOUNTED.replace("[-0.1, [0, -0.3]]", "[0]").replace("[0, 1]", "[0, 0.5, 1]")
    text = data + "figures: {f: {kind: change, grid: g, over: clamp_angle, clamp_angle: [0, 1]}}\n"
    assert read(text).figures
    (told,) = mistakes(
        read, edited(("change", kind), ("clamp_angle: [0, 1]", f"clamp_angle: {angles}"), text=text)
    )
    assert words in told


def test_claims_need_the_papers_points_and_say_what_to_remove(read):
    text = (ROOT / "config.yaml").read_text()
    for old, new, needed in (
        ("mu0: [0.2, 0.3, 0.4]", "mu0: [0.2, 0.3]", "need 0.2, 0.3, 0.4 and no smaller or larger"),
        ("cycles: 9", "cycles: 1", "'nine_cycles' needs cycles: 2 or more"),
        ("theta: [2]", "theta: [2, 3]", "theta = 2, 3, but the paper's statements need 2 alone"),
        ("mu0: [0.2, 0.3, 0.4]", "mu0: [0.2, 0.3, 0.4, 0.5]", "0.4 and no smaller or larger value"),
        ("theta: [2]", "theta: [2]\n    clamp_angle: [0.1]", "clamp_angle = 0.1, but"),
        ("contact: point", "contact: line", "`method: collocation`: set all, or"),
        ("collocation", "shooting", "`method: collocation`: set all, or"),
    ):
        (told,) = [one for one in mistakes(read, text.replace(old, new, 1)) if needed in one]
        assert "claims" in told and told.endswith("or remove the optional key `claims`")


def test_a_table_answers_a_part_of_the_study(read):
    study = read(STUDY)
    assert yaml.safe_load(study.study_part("periods")).keys() == {
        "study",
        "contact",
        "method",
        "scans",
    }
    assert yaml.safe_load(study.study_part("scans"))["with_shapes"] == ["runs"]
    assert study.study_part("scans") == read(STUDY + "# a comment\n").study_part("scans")
    longer = read(edited(("[1, 2.5]", "[1, 2.5, 3]")))
    assert longer.study_part("scans") == study.study_part("scans")
    assert longer.study_part("stiction") != study.study_part("stiction")


def paths_of(config, path=()):
    if path:
        yield path
    items = config.items() if isinstance(config, dict) else enumerate(config)
    for key, value in items:
        if isinstance(value, dict | list):
            yield from paths_of(value, (*path, key))
        else:
            yield (*path, key)


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 1000),
    st.floats(-1, 1),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e300, 1e-300, 0.3, 0.85, 2.0]),
    st.sampled_from(["", "1e-3", "point", "line", "main", "runs", "state", "a b", "a\n"]),
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["start", "stop", "step", "theta", 1, None]), inner)
    ),
    max_leaves=5,
)


@pytest.mark.slow
@settings(max_examples=50, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(sorted(paths_of(yaml.safe_load(STUDY)), key=str)),
    values,
    st.one_of(st.none(), st.sampled_from(["x", "theta", 1, 2.5, None, True])),
)
def test_whatever_is_written_the_answer_is_a_study_or_its_mistakes(path, value, key):
    config = yaml.safe_load(STUDY)
    *above, last = path
    target = config
    for part in above:
        target = target[part]
    if key is not None and isinstance(target, dict):
        target[key] = value
    target[last] = value
    try:
        study = read_study(None, config)
    except StudyError as error:
        assert all(str(error).split("\n"))
    else:
        assert isinstance(study, Study) and study.chunks


def test_the_largest_taper_of_a_study_is_that_of_the_solver():
    taper = TypeAdapter(Theta)
    assert taper.validate_python(MOST_TAPER) == MOST_TAPER
    with pytest.raises(ValidationError, match="less than or equal to 50"):
        taper.validate_python(math.nextafter(MOST_TAPER, math.inf))


@pytest.mark.parametrize(
    ("axis", "said"),
    [
        ("stiffening: [0.1, -1]", "1 + c1*s + c2*s^2 + ... is 0 at s = 1 L, got -1"),
        ("stiffening: [[-4, 3.5]]", "is -0.1429 at s = 0.5714 L, got -4, 3.5"),
        ("bore: [0.2, 0.6]", "below the diameter of the tip, 1/theta = 0.5 d0, got 0.6"),
        ("bore: [1]", "bore"),
    ],
)
@pytest.mark.parametrize("section", ["grids", "scans"])
def test_a_rod_that_cannot_be_made_is_refused_before_any_work(read, axis, said, section):
    more = ", cycles: 1" if section == "scans" else ""
    text = SMALLEST.replace("grids", section).replace("[1]", "[1, 2]")
    (found,) = mistakes(read, text.replace("[0.001]", f"[0.001], {axis}{more}"))
    assert said in found
