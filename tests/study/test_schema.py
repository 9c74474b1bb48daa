"""The JSON Schema of a study file says what the model says."""

from pathlib import Path

import jsonschema
import pytest
import yaml

from vibrissa.figures import draw
from vibrissa.study.figures import FIGURE_KINDS, NAMED_IN, TABLES
from vibrissa.study.json_schema import study_schema
from vibrissa.tables import schemas

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def validator():
    return jsonschema.Draft202012Validator(study_schema())


def test_the_schema_is_one_and_describes_every_key():
    jsonschema.Draft202012Validator.check_schema(study_schema())
    parts = (study_schema(), *study_schema()["$defs"].values())
    keys = [item for part in parts for item in part.get("properties", {}).items()]
    assert len(keys) > 50
    assert [key for key, part in keys if key != "kind" and not part.get("description")] == []


@pytest.mark.parametrize(
    ("path", "wrong"),
    [
        (("study",), "a b"),
        (("contact",), "plane"),
        (("chunk",), {"theta": 0}),
        (("grids", "taper", "points"), 3),
        (("grids", "taper", "cycles"), 3),
        (("grids", "taper", "theta"), 0.5),
        (("scans", "nine_cycles", "cycles"), 1.5),
        (("figures", "fig6", "kind"), "stait"),
        (("claims", "scan"), 3),
        (("caption",), "words"),
    ],
)
def test_an_editor_sees_what_is_wrong(validator, path, wrong):
    config = yaml.safe_load((ROOT / "config.yaml").read_text())
    section = config
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = wrong
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(config)


def test_every_kind_of_figure_is_drawn_from_columns_that_its_table_has():
    assert FIGURE_KINDS.keys() == draw.KINDS.keys() | {"script"}
    for name, kind in FIGURE_KINDS.items() - {("script", FIGURE_KINDS["script"])}:
        columns = set(schemas.TABLES[kind.table or TABLES[kind.source]].names)
        assert {NAMED_IN.get(kind.source, kind.source), *kind.single} <= columns
        assert set(draw.KINDS[name].columns) <= columns
