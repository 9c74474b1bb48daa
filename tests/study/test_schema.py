"""The schema and the reference page are made from the model, and say what it says."""

import importlib.util
from pathlib import Path

import jsonschema
import pytest
import yaml

from vibrissa.pipeline.run import STUDY_NAME
from vibrissa.study.figures import KINDS
from vibrissa.study.schema import study_schema
from vibrissa.tables import schemas

ROOT = Path(__file__).parents[2]
STUDIES = [ROOT / "config.yaml", *sorted((ROOT / "studies").glob("*.yaml"))]
VALIDATOR = jsonschema.Draft202012Validator(study_schema())


@pytest.fixture(scope="module")
def made():
    spec = importlib.util.spec_from_file_location("study_file", ROOT / "docs/study_file.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_and_the_schema_are_those_of_the_model(made):
    assert made.PAGE.read_text(encoding="utf-8") == made.page(), "run make schema"
    assert made.CATALOGUE.read_text(encoding="utf-8") == made.catalogue_page(), "run make schema"
    assert made.SCHEMA.read_text(encoding="utf-8") == made.schema_text(), "run make schema"


def test_the_schema_is_one():
    VALIDATOR.check_schema(study_schema())


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.name)
def test_studies_are_as_the_schema_says(path):
    assert not list(VALIDATOR.iter_errors(yaml.safe_load(path.read_text())))


@pytest.mark.parametrize(
    ("path", "wrong"),
    [
        (("study",), "a b"),
        (("study",), 7),
        (("contact",), "plane"),
        (("contact",), None),
        (("method",), "magic"),
        (("block_size",), 0),
        (("block_size",), None),
        (("grids",), {}),
        (("grids", "a b"), {"theta": [1], "mu0": [0.3], "eta": [0.85], "dx0": [0.001]}),
        (("grids", "taper"), 3),
        (("grids", "taper"), {"theta": [1]}),
        (("grids", "taper", "cycles"), 3),
        (("grids", "taper", "theta"), []),
        (("grids", "taper", "theta"), 2),
        (("grids", "taper", "theta"), [0.9]),
        (("grids", "taper", "theta"), ["1"]),
        (("grids", "taper", "theta"), {"start": 1, "stop": 2}),
        (("grids", "taper", "mu0"), [0]),
        (("grids", "taper", "eta"), {"start": 0.5, "stop": 1, "step": 0.1}),
        (("grids", "taper", "dx0"), [1e-10]),
        (("scans", "nine_cycles", "cycles"), 1.5),
        (("states", "penetrating", "x1"), -1),
        (("states", "penetrating", "contact"), "tip"),
        (("figures", "fig6", "kind"), "stait"),
        (("figures", "fig6", "theta"), 2),
        (("figures", "fig6", "eta"), None),
        (("figures", "fig8", "state"), []),
        (("claims", "scan"), 3),
        (("caption",), "words"),
    ],
)
def test_what_is_wrong_is_wrong_by_the_schema(path, wrong):
    config = yaml.safe_load((ROOT / "config.yaml").read_text())
    section = config
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = wrong
    assert list(VALIDATOR.iter_errors(config))


def test_a_run_knows_a_name_when_it_sees_one():
    assert study_schema()["properties"]["study"]["pattern"] == f"^{STUDY_NAME}$"


def test_every_key_is_described():
    parts = (study_schema(), *study_schema()["$defs"].values())
    keys = [item for part in parts for item in part.get("properties", {}).items()]
    assert len(keys) > 60
    assert [key for key, part in keys if key != "kind" and not part.get("description")] == []


def test_tables_have_what_figures_are_selected_by():
    for kind in KINDS:
        columns = schemas.TABLES[kind.table].names
        source = {"grid": "grids"}.get(kind.source, kind.source)
        assert {source, *kind.fixed_axes()} <= set(columns)
