import math
import re
from decimal import Decimal
from pathlib import Path

import jsonschema
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vibrissa.decimals import spell
from vibrissa.errors import StudyError
from vibrissa.outcomes import Contact, Solver
from vibrissa.study.model import Study, default_block_size
from vibrissa.study.parsing import parse_study
from vibrissa.study.schema import study_schema

ROOT = Path(__file__).parents[2]

# Every value stands once, so that a test can put another in its place.
STUDY = """
study: demo
contact: point
method: collocation
block_size: 5
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
figures:
  taper: {kind: taper, grid: main, caption: Some words.}
  friction: {kind: friction, grid: main, theta: 2.5}
  scan: {kind: scan, scan: runs, theta: 3, mu0: 0.32, dx0: 0.002}
  period: {kind: period, scan: runs, theta: 3, mu0: 0.34, dx0: 0.004}
  state: {kind: state, state: single}
"""


def parse(text):
    return parse_study(yaml.safe_load(text))


def edited(*edits):
    text = STUDY
    for old, new in edits:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def refusal(text):
    with pytest.raises(StudyError) as error:
        parse(text)
    message = str(error.value)
    assert "\n" not in message
    return message


def test_the_study_is_what_is_written():
    study = parse(STUDY)
    assert (study.name, study.contact, study.method) == (
        "demo",
        Contact.POINT,
        Solver.COLLOCATION,
    )
    assert (study.curves_per_job, study.blocks_name) == (5, "point-collocation")
    main = study.point_grids["main"]
    assert [spell(v) for v in main.mu0] == ["0.1", "0.2", "0.3", "0.4"]
    assert [spell(v) for v in main.theta] == ["1", "2.5"]
    assert study.scans["runs"].cycles == 9
    assert [spell(v) for v in study.scan_grids["runs"].dx0] == ["0.002", "0.004"]
    single = study.states["single"]
    assert (single.theta, single.eta, single.x1) == tuple(map(Decimal, ("1.5", "0.55", "0.15")))
    assert single.contact is None
    taper = study.figures["taper"]
    assert (taper.kind, taper.table, taper.caption) == ("taper", "stiction", "Some words.")
    assert taper.selection() == {"grid": "main"}
    assert study.figures["scan"].selection() == {
        "scan": "runs",
        "theta": 3.0,
        "mu0": 0.32,
        "dx0": 0.002,
    }


def test_the_results_are_what_the_study_asks_for():
    few = ["tables/stiction.parquet", "report.html"]
    assert parse(SMALLEST).results == few
    made = parse(STUDY).results
    assert len(made) == 3 + 3 * 5 + 2
    assert {*few, "tables/scans.parquet", "tables/states.parquet"} < set(made)
    assert {"figures/taper.pdf", "figures/taper.svg", "figures/captions.md"} < set(made)
    assert {"claims.md", "tables/claims.parquet", "tables/comparisons.parquet"}.isdisjoint(made)
    paper = parse((ROOT / "config.yaml").read_text())
    assert {"claims.md", "tables/claims.parquet"} < set(paper.results)


def test_the_order_and_the_spelling_of_values_do_not_matter():
    axes = [
        parse(edited(("[1, 2.5]", theta))).point_grids["main"].theta
        for theta in (
            "[1, 2.5]",
            "[2.50, 1.0, 2.5, 1]",
            "{start: 1, stop: 2.5, step: 1.5}",
            "{start: 1.0, stop: 2.50, step: 1.50}",
        )
    ]
    assert axes == [(Decimal(1), Decimal("2.5"))] * 4


SMALLEST = "study: s\ngrids: {g: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.001]}}\n"


@pytest.mark.parametrize(
    ("more", "method", "block_size"),
    [
        ("", "collocation", 64),
        ("method: collocation", "collocation", 64),
        ("method: shooting", "shooting", 1),
    ],
)
def test_what_is_not_written_has_a_default(more, method, block_size):
    study = parse(SMALLEST + more)
    assert (study.contact, study.method) == ("point", method)
    assert (study.block_size, study.curves_per_job) == (None, block_size)
    assert study.method.by_step == (method == "shooting")
    assert (study.scans, study.states, study.figures) == ({}, {}, {})


def test_the_papers_study_is_valid():
    study = parse((ROOT / "config.yaml").read_text())
    assert [len(axis) for axis in study.grids["taper"].axes.values()] == [21, 3, 1, 1]
    assert study.figures.keys() >= {"fig3", "fig6", "fig7", "fig8"}


# What is put in place of what, the key's path, how the value is shown, and words of what is allowed
REFUSED = {
    "unknown key": ("block_size", "blocksize", "the study file", "'blocksize'", "block_size, "),
    "in a grid": ("  main:", "  main:\n    cycles: 2", "grids.main", "'cycles'", "dx0, eta, mu0"),
    "in a range": ("step: 0.1", "step: 0.1, n: 4", "grids.main.mu0", "'n'", "start, step, stop"),
    "in a scan": ("  runs:", "  runs:\n    x1: 2", "scans.runs", "'x1'", "cycles, dx0, eta, mu0"),
    "in a state": ("x1: 0.15", "x1: 0.15, x: 1", "states.single", "'x'", "eta, theta, x1"),
    "in a figure": ("caption:", "title:", "figures.taper", "'title'", "caption, dx0, eta, grid"),
    "of another kind": (
        "{kind: state,",
        "{kind: state, grid: main,",
        "figures.state",
        "'grid'",
        "",
    ),
    "no study": ("study: demo", "", "the study file", "'study'", ""),
    "no axis": ("    dx0: [0.001]\n", "", "grids.main", "'dx0'", "a list of numbers"),
    "no step": (", step: 0.1", "", "grids.main.mu0", "'step'", ""),
    "no cycles": ("    cycles: 9\n", "", "scans.runs", "'cycles'", "number of stick-slip cycles"),
    "no x1": (", x1: 0.15", "", "states.single", "'x1'", "contact point's distance"),
    "no kind": ("kind: state, ", "", "figures.state", "'kind'", "taper or versus"),
    "no scan": (
        "kind: scan, scan: runs,",
        "kind: scan,",
        "figures.scan",
        "'scan'",
        "name of the scan",
    ),
    "contact plane": ("contact: point", "contact: plane", "contact", "'plane'", "point"),
    "contact": ("contact: point", "contact: tip", "contact", "'tip'", "point"),
    "method": ("method: collocation", "method: magic", "method", "'magic'", "or shooting"),
    "block_size 0": ("block_size: 5", "block_size: 0", "block_size", "0", "whole number from 1"),
    "block_size 1.5": ("block_size: 5", "block_size: 1.5", "block_size", "1.5", "whole number"),
    "block_size yes": ("block_size: 5", "block_size: yes", "block_size", "True", "whole number"),
    "cycles 0": ("cycles: 9", "cycles: 0", "scans.runs.cycles", "0", "whole number from 1"),
    "cycles text": ("cycles: 9", "cycles: nine", "scans.runs.cycles", "'nine'", "whole number"),
    "theta < 1": ("[1, 2.5]", "[1, 0.99]", "grids.main.theta[1]", "0.99", "theta >= 1"),
    "theta text": ("[1, 2.5]", "[thin]", "grids.main.theta[0]", "'thin'", "theta >= 1"),
    "theta true": ("[1, 2.5]", "[true]", "grids.main.theta[0]", "True", "a number theta >= 1"),
    "theta list": ("[1, 2.5]", "[[1]]", "grids.main.theta[0]", "[1]", "a number theta >= 1"),
    "theta single": ("[1, 2.5]", "2", "grids.main.theta", "2", "a list of numbers"),
    "theta nothing": ("[1, 2.5]", "", "grids.main.theta", "None", "a list of numbers"),
    "theta empty": ("[1, 2.5]", "[]", "grids.main.theta", "[]", "at least one number"),
    "mu0 0": ("[0.32, 0.34]", "[0]", "scans.runs.mu0[0]", "0", "mu0 > 0"),
    "mu0 -": ("[0.32, 0.34]", "[-0.3]", "scans.runs.mu0[0]", "-0.3", "mu0 > 0"),
    "mu0 from 0": ("start: 0.1", "start: 0.0", "grids.main.mu0.start", "0.0", "mu0 > 0"),
    "eta 0": ("[0.85]", "[0]", "grids.main.eta[0]", "0", "0 < eta < 1"),
    "eta 1": ("[0.85]", "[0.5, 1]", "grids.main.eta[1]", "1", "0 < eta < 1"),
    "dx0 0": ("[0.001]", "[0.0]", "grids.main.dx0[0]", "0.0", "dx0 >= 1.0e-9"),
    "dx0 -": ("[0.001]", "[-0.001]", "grids.main.dx0[0]", "-0.001", "dx0 >= 1.0e-9"),
    "step 0": ("step: 0.1", "step: 0", "grids.main.mu0.step", "0", "a number > 0"),
    "step -": ("step: 0.1", "step: -0.1", "grids.main.mu0.step", "-0.1", "a number > 0"),
    "stop": ("stop: 0.4", "stop: 0.45", "grids.main.mu0", "0.45", "whole number of steps of 0.1"),
    "stop < start": ("stop: 0.4", "stop: 0.05", "grids.main.mu0", "0.05", "be start 0.1 plus"),
    "stop huge": ("stop: 0.4", "stop: 1.0e+30", "grids.main.mu0", "1e+30", "at most 1000000"),
    "state theta": ("theta: 1.5", "theta: 0.5", "states.single.theta", "0.5", "theta >= 1"),
    "state eta": ("eta: 0.55", "eta: 1.0", "states.single.eta", "1.0", "0 < eta < 1"),
    "state x1": ("x1: 0.15", "x1: -1", "states.single.x1", "-1", "-1 < x1 < 1"),
    "reach": ("x1: 0.15", "x1: -0.84", "states.single", "-0.84", "x1^2 + eta^2 < 1"),
    "nan": ("[0.001]", "[0.001, .nan]", "grids.main.dx0[1]", "nan", "finite number"),
    "inf": ("[1, 2.5]", "[1, .inf]", "grids.main.theta[1]", "inf", "finite number"),
    "stop inf": ("stop: 0.4", "stop: .inf", "grids.main.mu0.stop", "inf", "finite number"),
    "-inf": ("x1: 0.15", "x1: -.inf", "states.single.x1", "-inf", "-1 < x1 < 1"),
    "1e-3": ("[0.001]", "[1e-3]", "grids.main.dx0[0]", "'1e-3'", "write a number without quotes"),
    "quoted": ("eta: 0.55", "eta: '0.5'", "states.single.eta", "'0.5'", "without quotes"),
    "no grids": (STUDY[STUDY.index("grids:") :], "grids: {}", "grids", "{}", "named grids"),
    "points": (
        "method: collocation",
        "max_points: 11",
        "grids.main",
        "8 points, of 12 of the study",
        "up to 11 in all",
    ),
    "steps": (
        "method: collocation",
        "max_points: 1000",
        "scans",
        "some 1,352 steps",
        "up to 1,000",
    ),
    "kind": ("kind: state,", "kind: stait,", "figures.state.kind", "'stait'", "taper or versus"),
    "unknown state": ("state: single", "state: x", "figures.state.state", "'x'", "allowed: single"),
    "unknown grid": ("grid: main, cap", "grid: x, cap", "figures.taper.grid", "'x'", "main"),
    "unknown scan": (
        "scan: runs, theta: 3, mu0: 0.32",
        "scan: main, theta: 3, mu0: 0.32",
        "figures.scan.scan",
        "'main'",
        "allowed: runs",
    ),
    "foreign theta": (", theta: 2.5", ", theta: 2", "figures.friction.theta", "2", "has 1, 2.5"),
    "foreign mu0": ("mu0: 0.32,", "mu0: 0.3,", "figures.scan.mu0", "0.3", "has 0.32, 0.34"),
    "foreign dx0": ("dx0: 0.002}", "dx0: 0.001}", "figures.scan.dx0", "0.001", "0.002, 0.004"),
    "foreign eta": ("caption:", "eta: 0.8, caption:", "figures.taper.eta", "0.8", "has 0.85"),
    "taper theta": ("caption:", "theta: 2.5, caption:", "figures.taper", "'theta'", "eta, grid"),
    "several thetas": (", theta: 2.5", "", "figures.friction", "'theta'", "several: 1, 2.5"),
    "several steps": (", dx0: 0.004}", "}", "figures.period", "'dx0'", "several: 0.002, 0.004"),
    "several etas": ("[0.85]", "[0.85, 0.9]", "figures.taper", "'eta'", "several: 0.85, 0.9"),
    "small steps": ("[0.001]", "[1.0e-7, 2.0e-7]", "figures.taper", "'dx0'", "0.0000001, 0.0"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_study_that_cannot_be_run_is_refused_in_one_message(name):
    old, new, path, value, allowed = REFUSED[name]
    message = refusal(edited((old, new)))
    assert message.startswith(f"{path}: ")
    assert value in message.removeprefix(path)
    assert allowed in message


@pytest.mark.parametrize("kind", ["grids", "scans", "states", "figures"])
@pytest.mark.parametrize(
    "name", ["a" * 101, "a b", "../up", "-x", "_x", "", "é", "a.b", '"x\\n"', "1", "no"]
)
def test_a_name_has_letters_digits_underscore_and_dash(kind, name):
    shown = {"1": "1", "no": "False"}.get(name, repr(yaml.safe_load(name or "''")))
    key = {"grids": "main", "scans": "runs", "states": "single", "figures": "taper"}[kind]
    message = refusal(edited((f"  {key}:", f"  {name or repr('')}:")))
    assert message.startswith(f"{kind}: {shown[:60]}")
    assert " is not allowed; " in message
    assert "letters, digits, _ and -" in message


@pytest.mark.parametrize("name", ["a b", "../up", "-x", "''", "7", "", "é", '"x\\n"', "[a]"])
def test_a_bad_name_of_a_study_is_refused(name):
    message = refusal(edited(("study: demo", f"study: {name}")))
    assert message.startswith(f"study: {yaml.safe_load(name)!r} is not allowed")
    assert "letters, digits, _ and -" in message


@pytest.mark.parametrize("text", ["", "[]", "just words", "5"])
def test_a_file_without_keys_is_refused(text):
    message = refusal(text)
    assert message.startswith(f"the study file: {yaml.safe_load(text)!r} is not allowed")


def test_of_several_mistakes_the_one_nearest_to_the_top_of_the_file_is_told():
    mistakes = [("[1, 2.5]", "[0]"), ("x1: 0.15", "x1: 5"), ("block_size: 5", "block_size: yes")]
    message = refusal(edited(*mistakes))
    assert message.startswith("block_size: True is not allowed")
    assert "theta" not in message and "x1" not in message


def test_all_mistakes_are_known():
    mistakes = [("[1, 2.5]", "[0]"), ("x1: 0.15", "x1: 5"), ("block_size: 5", "block_size: yes")]
    with pytest.raises(StudyError) as error:
        parse(edited(*mistakes))
    starts = ["block_size: True", "states.single.x1: 5", "grids.main.theta[0]: 0"]
    assert [told.partition(" is not")[0] for told in error.value.mistakes] == starts
    assert str(error.value) == error.value.mistakes[0]


def test_all_names_that_nothing_has_are_known():
    with pytest.raises(StudyError) as error:
        parse(edited(("state: single", "state: x"), ("grid: main, cap", "grid: y, cap")))
    assert [told.partition(":")[0] for told in error.value.mistakes] == [
        "figures.taper.grid",
        "figures.state.state",
    ]


@pytest.mark.parametrize("entry", ["3", "{theta: [0]}", "{kind: taper, grid: 3}"])
@pytest.mark.parametrize("section", ["grids", "scans", "states", "comparisons", "figures"])
def test_no_name_is_taken_for_something_else(section, entry):
    for name in ("[key]", "array", "object", "taper", "kind", "theta", 0, 1.5, None, True, "a\n"):
        text = yaml.safe_load(SMALLEST) | {section: {name: yaml.safe_load(entry)}}
        with pytest.raises(StudyError) as error:
            parse_study(text)
        assert all(told.lstrip("'").startswith(section) for told in error.value.mistakes)
        assert not any("\n" in told for told in error.value.mistakes)


def test_several_unknown_keys_are_told_together():
    message = refusal(edited(("study: demo", "study: demo\ngrid: 1\nscan: 2\n3: 4")))
    assert message.startswith("the study file: unknown key")
    assert all(key in message for key in ("'grid'", "'scan'", "3"))


def test_a_long_value_is_cut():
    message = refusal(edited(("[1, 2.5]", f"[{list(range(1000))}]")))
    assert message.startswith("grids.main.theta[0]: [0, 1, 2,")
    assert len(message) < 250


@pytest.mark.parametrize(
    ("old", "new", "get"),
    [
        ("block_size: 5", "block_size: 5.0", lambda study: study.block_size),
        ("cycles: 9", "cycles: 5.0", lambda study: study.scans["runs"].cycles),
    ],
)
def test_a_whole_number_with_a_point_is_a_whole_number_or_refused(old, new, get):
    try:
        value = get(parse(edited((old, new))))
    except StudyError as error:
        assert "5.0 is not allowed" in str(error)
    else:
        assert (value, type(value)) == (5, int)


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
@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(sorted(paths_of(yaml.safe_load(STUDY)), key=str)),
    values,
    st.one_of(st.none(), st.sampled_from(["x", "theta", 1, 2.5, None, True])),
)
def test_whatever_is_written_the_answer_is_a_study_or_one_message(path, value, key):
    config = yaml.safe_load(STUDY)
    *above, last = path
    target = config
    for part in above:
        target = target[part]
    if key is not None and isinstance(target, dict):
        target[key] = value
    target[last] = value
    try:
        study = parse_study(config)
    except StudyError as error:
        assert error.mistakes
        assert all(told and "\n" not in told for told in error.mistakes)
    else:
        jsonschema.validate(config, study_schema())
        assert isinstance(study, Study)
        assert all(map(str.isprintable, (study.name, *study.grids, *study.figures)))


def test_a_state_may_have_a_contact_of_its_own_and_a_comparison_three_axes():
    states = "states: {a: {theta: 1, eta: 0.5, x1: 0.2, contact: line}}\n"
    comparisons = "comparisons: {c: {theta: [1, 2], mu0: [0.3], eta: [0.85]}}\n"
    study = parse(SMALLEST + states + comparisons)
    assert study.states["a"].contact == "line" and study.contact == "point"
    assert study.comparisons["c"].axes["theta"] == (Decimal(1), Decimal(2))


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ("comparisons: {c: {theta: [1], mu0: [0.3]}}", "comparisons.c: missing 'eta'"),
        ("comparisons: {c: {theta: [0], mu0: [0.3], eta: [0.8]}}", "comparisons.c.theta[0]: 0"),
        ("figures: {f: {kind: models, comparison: d}}", "'d' is not the name of a comparison"),
        ("figures: {f: {kind: state, state: [d]}}", "'d' is not the name of a state"),
        ("figures: {f: {kind: state, state: []}}", "figures.f.state: [] is not allowed"),
        ("figures: {f: {kind: law, grid: h}}", "'h' is not the name of a grid"),
        ("states: {a: {theta: 1, eta: 0.5, x1: 0.2, contact: plane}}", "states.a.contact: 'plane'"),
    ],
)
def test_mistakes_in_comparisons_and_states_are_named(more, named):
    assert named in refusal(SMALLEST + more + "\n")


PAPER = (ROOT / "config.yaml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("contact: point", "contact: line", "claims: contact: 'line' is not allowed with it"),
        ("taper: taper,", "taper: other,", "claims.taper: 'other' is not the name of a grid"),
        ("scan: nine_cycles, state", "scan: taper, state", "claims.scan: 'taper' is not the name"),
        ("taper: taper,", "taper: friction,", "claims.taper: 'friction' has theta = 2; .* 1, 2, 3"),
        ("theta: 1, eta: 0.55", "theta: 1, eta: 0.5", "claims.state: .* eta = 0.5; .* 0.55"),
        (
            "eta: [0.85]\n    dx0: [0.001]\n    cycles",
            "eta: [0.8]\n    dx0: [0.001]\n    cycles",
            "claims.scan: .* eta = 0.8; .* only 0.85",
        ),
        (", state: penetrating}", "}", "claims: missing 'state'"),
    ],
)
def test_the_papers_statements_need_the_papers_points(old, new, message):
    assert PAPER.count(old) == 1
    assert re.match(message, refusal(PAPER.replace(old, new)))


def test_other_studies_leave_the_papers_statements_alone():
    assert parse(STUDY).claims is None
    assert set(dict(parse(PAPER).claims)) == {"taper", "friction", "scan", "state"}


@pytest.mark.parametrize(
    ("curves", "size"), [(1, 64), (400, 64), (1600, 200), (10_000, 1250), (100_000, 6000)]
)
def test_a_job_has_an_eighth_of_the_curves_but_no_more_than_ten_minutes_of_them(curves, size):
    assert default_block_size(Solver.COLLOCATION, curves, 0.1 * curves) == size
    assert default_block_size(Solver.COLLOCATION, curves, 100 * curves) == 64
    assert default_block_size(Solver.SHOOTING, curves, 120 * curves) == 1
