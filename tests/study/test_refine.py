"""The key `refine` of a grid: what it says, and what is refused in one message."""

from decimal import Decimal
from itertools import pairwise
from pathlib import Path

import pyarrow as pa
import pytest
import yaml

from vibrissa.errors import StudyError
from vibrissa.study.codec import decode_gaps, decode_refinement, encode_gaps, encode_refinement
from vibrissa.study.grid import Refinement
from vibrissa.study.model import most_added
from vibrissa.study.parsing import examine, parse_study
from vibrissa.study.values import CURVE_COLUMNS, REFINED_COLUMNS
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
    expected = Refinement(
        column="x0_slip", tolerance=Decimal("0.001"), closest={"mu0": Decimal("0.005")}
    )
    assert parse_study(config(REFINE)).refinements == {"main": expected}
    study = parse_study(config({**REFINE, "column": "f_slip"}))
    assert study.refinements["main"].column == "f_slip"
    assert parse_study(config()).refinements == {}


def test_a_refinement_comes_back_from_its_plain_form():
    refinement = Refinement(
        column="f_end", tolerance=Decimal("1e-7"), closest={"mu0": Decimal("0.005")}
    )
    texts = encode_refinement(refinement)
    assert texts == {"column": "f_end", "tolerance": "0.0000001", "closest": {"mu0": "0.005"}}
    assert decode_refinement(texts) == refinement


def test_the_columns_are_the_computed_numbers():
    numbers = {f.name for f in schemas.STICTION if f.type in (schemas.NUMBER, schemas.WHOLE)}
    given = {column.name for column in (*schemas.AXES, *schemas.MOUNTING)}
    assert set(REFINED_COLUMNS) == numbers - given - {"residual"}
    of_curve = {name for name in numbers if name.endswith("_init")}
    assert set(CURVE_COLUMNS) == of_curve | {"mu_lock", "x0_lock"}
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
    assert study.grids["main"].most("mu0") == 3 + 15 + 31
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
    "constant": (
        {**REFINE, "column": "mu_lock"},
        "refine.column: mu_lock does not change with mu0; allowed: theta and eta in closest",
    ),
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
    "closest empty": (
        {**REFINE, "closest": {}},
        "closest: {} is not allowed; allowed: one or more",
    ),
    "closest nothing": ({**REFINE, "closest": {"eta": None}}, "closest.eta: None is not allowed"),
    "closest dx0": (
        {**REFINE, "closest": {"dx0": 0.01}},
        "unknown key 'dx0'; allowed: eta, mu0, theta",
    ),
    "one eta": (
        {**REFINE, "closest": {"eta": 0.01}},
        "grids.main.refine: eta has one value, 0.85; allowed: two or more in the grid",
    ),
    "wide theta": (
        {**REFINE, "closest": {"theta": 0.6}},
        "closest.theta: 0.6 is not allowed, as no",
    ),
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
    # A scan may have the name of a grid with refine.
    del paper_config["grids"]["friction"]["refine"]
    name = paper_config["claims"]["scan"]
    theirs = paper_config["grids"][name] = {**paper_config["grids"]["friction"], "eta": [0.5]}
    theirs["refine"] = {"tolerance": 0.01, "closest": {"mu0": 0.001}}
    parse_study(paper_config)


def curves(theta, eta, closest=None, **more):
    axes = {"theta": theta, "eta": eta, "mu0": [0.2, 0.3], "dx0": [0.001], **more}
    return axes if closest is None else {**axes, "refine": {"tolerance": 0.01, "closest": closest}}


def study(**grids):
    return {"study": "a", "grids": grids}


def test_curves_that_may_be_added_count():
    """Of θ one in each gap, of η three: 5 values of θ at 2 of η, and 3 more of η at 3 of θ."""
    grid = curves([1, 2, 4], [0.8, 0.9], {"theta": 0.5, "eta": 0.025, "mu0": 0.05})
    (section,) = parse_study(study(main=grid)).grids.values()
    assert (section.most("theta"), section.most("eta"), section.most("mu0")) == (3 + 1 + 3, 5, 3)
    assert section.most_curves == 7 * 2 + 3 * 3
    assert section.count == 23 * 3
    grid["clamp_angle"] = [0, 0.1]
    (section,) = parse_study(study(main=grid)).grids.values()
    assert section.count == 2 * 23 * 3


def test_of_a_curve_as_a_whole_any_number_may_be_refined_over_theta():
    grid = curves([1, 2], [0.85], {"theta": 0.1})
    grid["refine"]["column"] = "mu_lock"
    assert parse_study(study(main=grid)).refinements["main"].curve_axes == ("theta",)


def test_curves_by_shooting_are_not_added():
    config = {**study(main=curves([1, 2], [0.85], {"theta": 0.1})), "method": "shooting"}
    message = r"grids\.main\.refine\.closest\.theta: 'theta' is not allowed with method: shooting"
    with pytest.raises(StudyError, match=message):
        parse_study(config)


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (curves([1, 1.5, 2], [0.85]), r"main\.refine\.closest\.theta: theta = 1.5 of the grid 'b'"),
        (curves([1.7], [0.85, 0.9]), r"theta = 1\.7 of the grid 'b' lies between values"),
        (curves([1, 2, 4], [0.85, 0.9]), None),
        (curves([0.5 + 0.5, 3, 5], [0.85]), None),
        (curves([1.5], [0.9]), None),
        (curves([1.5], [0.85], clamp_angle=[0.1]), None),
        (curves([1.5], [0.8, 0.9], {"eta": 0.01}), r"theta = 1\.5 of the grid 'b' lies between"),
    ],
)
def test_no_curve_is_added_where_another_grid_may_have_it(other, message):
    """It would have two rows."""
    config = study(main=curves([1, 2], [0.85], {"theta": 0.1}), b=other)
    if message is None:
        parse_study(config)
        return
    with pytest.raises(StudyError, match=message):
        parse_study(config)


def test_gaps_come_back_from_their_plain_form():
    values = [Decimal(i) / 10 for i in (1, 2, 3, 4, 5, 9)]
    gaps = {"theta": list(pairwise(values)), "eta": [(Decimal(1), Decimal(2))]}
    assert decode_gaps(encode_gaps(gaps)) == gaps
    with pytest.raises(ValueError, match="shorter"):
        decode_gaps({"theta": [["1", "2"], ["2"]]})
