"""The key `refine` of a grid: what it says, and what is refused in one message."""

from decimal import Decimal
from pathlib import Path

import pyarrow as pa
import pytest
import yaml

from vibrissa.errors import StudyError
from vibrissa.study.codec import decode_refinement, encode_refinement
from vibrissa.study.grid import Refinement
from vibrissa.study.model import most_added
from vibrissa.study.parsing import examine, parse_study
from vibrissa.study.values import REFINED_COLUMNS
from vibrissa.tables import schemas

PAPER = Path(__file__).parents[2] / "config.yaml"
REFINE = {"tolerance": 0.001, "closest": {"mu0": 0.005}}
MU0 = [0.1, 0.2, 0.5]


def config(refine=None, mu0=MU0, **more):
    axes = {"theta": [1, 2], "mu0": mu0, "eta": [0.85], "dx0": [0.001, 0.002]}
    plain = {**axes, "theta": [3]}
    grids = {"main": axes if refine is None else {**axes, "refine": refine}, "plain": plain}
    return {"study": "a", "grids": grids, **more}


def test_a_refinement_is_what_is_written():
    expected = Refinement(column="x0_slip", tolerance=Decimal("0.001"), closest=Decimal("0.005"))
    assert parse_study(config(REFINE)).refinements == {"main": expected}
    study = parse_study(config({**REFINE, "column": "f_slip"}))
    assert study.refinements["main"].column == "f_slip"
    assert parse_study(config()).refinements == {}


def test_a_refinement_comes_back_from_its_plain_form():
    refinement = Refinement(column="f_end", tolerance=Decimal("1e-7"), closest=Decimal("0.005"))
    texts = encode_refinement(refinement)
    assert texts == {"column": "f_end", "tolerance": "0.0000001", "closest": "0.005"}
    assert decode_refinement(texts) == refinement


def test_the_columns_are_the_numbers_that_change_with_friction():
    numbers = {f.name for f in schemas.STICTION if f.type in (schemas.NUMBER, schemas.WHOLE)}
    given = {column.name for column in (*schemas.AXES, *schemas.MOUNTING)}
    # Of a curve as a whole.
    same = {"mu_lock", "x0_lock", "x1_init", "residual"}
    same |= {name for name in numbers if name.endswith("_init")}
    assert set(REFINED_COLUMNS) == numbers - given - same
    assert len(REFINED_COLUMNS) == len(set(REFINED_COLUMNS))
    assert pa.types.is_integer(schemas.WHOLE)


@pytest.mark.parametrize(
    ("gap", "closest", "expected"),
    [
        ("0.1", "0.05", 1),
        ("0.1", "0.051", 0),
        ("0.1", "0.025", 3),
        ("0.1", "0.0251", 1),
        ("1", "1e-6", 2**19 - 1),
    ],
)
def test_most_points_that_halving_adds(gap, closest, expected):
    assert most_added(Decimal(gap), Decimal(closest)) == expected


def test_points_that_may_be_added_count():
    """Of 0.1 to 0.2 fifteen, of 0.2 to 0.5 thirty-one."""
    study = parse_study(config(REFINE))
    assert study.grids["main"].most_mu0 == 3 + 15 + 31
    assert study.grids["main"].count == 2 * 2 * 49
    assert study.points_on_curve == 2 * 49 + 2 * 3
    assert parse_study(config()).points_on_curve == 2 * 3 + 2 * 3
    with pytest.raises(StudyError, match=r"grids\.main: 196 points, of 202 of the study"):
        parse_study(config(REFINE, max_points=201))
    parse_study(config(REFINE, max_points=202))


NUMBER = "number without quotes"
REFUSED = {
    "nothing": (None, "grids.main.refine: None is not allowed; allowed: the keys column, tol"),
    "number": (0.001, "grids.main.refine: 0.001 is not allowed; allowed: the keys column, tol"),
    "column": (
        {**REFINE, "column": "x0_slop"},
        "refine.column: 'x0_slop' is not allowed; allowed: c",
    ),
    "text": ({**REFINE, "column": "status"}, "'status' is not allowed; allowed: column of the tab"),
    "constant": ({**REFINE, "column": "mu_lock"}, "'mu_lock' is not allowed; allowed: column of t"),
    "list": ({**REFINE, "column": ["x0_slip"]}, "refine.column: ['x0_slip'] is not allowed; allow"),
    "tolerance 0": ({**REFINE, "tolerance": 0}, "refine.tolerance: 0 is not allowed; allowed: how"),
    "tolerance -": (
        {**REFINE, "tolerance": -1},
        "refine.tolerance: -1 is not allowed; allowed: ho",
    ),
    "tolerance text": ({**REFINE, "tolerance": "1e-3"}, NUMBER),
    "no tolerance": (
        {"closest": {"mu0": 0.01}},
        "grids.main.refine: missing 'tolerance'; allowed: how",
    ),
    "no closest": (
        {"tolerance": 0.1},
        "grids.main.refine: missing 'closest'; allowed: the keys mu0",
    ),
    "closest": (
        {**REFINE, "closest": 0.01},
        "refine.closest: 0.01 is not allowed; allowed: the keys",
    ),
    "closest 0": (
        {**REFINE, "closest": {"mu0": 0}},
        "closest.mu0: 0 is not allowed; allowed: least",
    ),
    "closest small": ({**REFINE, "closest": {"mu0": 9e-7}}, "9e-07 is not allowed; allowed: least"),
    "axis": (
        {**REFINE, "axis": "mu0"},
        "refine: unknown key 'axis'; allowed: closest, column, tol",
    ),
    "wide": (
        {**REFINE, "closest": {"mu0": 0.16}},
        "grids.main.refine.closest.mu0: 0.16 is not allowed, as no point would be added; allowed: "
        "up to 0.15, half of the widest gap of mu0 in the grid",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_refinement_that_cannot_be_done_is_refused_in_one_message(name):
    refine, message = REFUSED[name]
    study = config()
    study["grids"]["main"]["refine"] = refine
    _, mistakes = examine(study)
    (mistake,) = map(str, mistakes)
    assert message in mistake


def test_the_widest_that_adds_a_point_is_allowed():
    parse_study(config({**REFINE, "closest": {"mu0": 0.15}}))


def test_between_one_value_there_is_nothing():
    message = r"grids\.main\.refine: mu0 has one value, 0\.3; allowed: two or more in the grid"
    with pytest.raises(StudyError, match=message):
        parse_study(config(REFINE, mu0=[0.3, 0.3]))


def test_scans_are_not_refined():
    scan = {"theta": [1], "mu0": [0.1, 0.3], "eta": [0.85], "dx0": [0.01], "cycles": 1}
    with pytest.raises(StudyError, match=r"scans\.a: unknown key 'refine'"):
        parse_study(config(scans={"a": {**scan, "refine": REFINE}}))


def test_the_papers_statements_are_judged_by_the_points_of_the_axes_alone():
    paper_config = yaml.safe_load(PAPER.read_text())
    parse_study(paper_config)
    paper_config["grids"]["friction"]["refine"] = {"tolerance": 0.001, "closest": {"mu0": 0.001}}
    message = r"claims\.friction: 'friction' has refine; allowed: a grid without it"
    with pytest.raises(StudyError, match=message):
        parse_study(paper_config)
