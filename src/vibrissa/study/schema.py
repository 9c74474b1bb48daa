"""The JSON Schema of study files, made from their model, and what it allows at a place."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from vibrissa.study.mistakes import Location
from vibrissa.study.model import Study

# How pydantic says that the name of an entry is wrong, and not what stands under it.
KEY = "[key]"
Schema = dict[str, Any]
# Keys at the top of the file that only hold anchors begin like this.
FOR_ANCHORS = "x-"
# Sections that may have nothing below them.
MAY_BE_EMPTY = ("scans", "states", "comparisons", "figures")


class _StudyFile(GenerateJsonSchema):
    """What may be written; pydantic's own schemas say also what Python objects may be."""

    def decimal_schema(self, schema: core_schema.DecimalSchema) -> JsonSchemaValue:
        """Take numbers, and no texts."""
        number, _ = super().decimal_schema(schema)["anyOf"]
        return number

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        """Take no null: a key that is not needed is left out."""
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Say nothing of a default that stands for a key that is left out."""
        written = super().default_schema(schema)
        return {key: value for key, value in written.items() if (key, value) != ("default", None)}

    def dict_schema(self, schema: core_schema.DictSchema) -> JsonSchemaValue:
        """Take no names but those of the pattern."""
        return super().dict_schema(schema) | {"additionalProperties": False}

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Give keys no titles beside their names."""
        return False


@cache
def study_schema() -> Schema:
    """JSON Schema of study files (draft 2020-12)."""
    schema = Study.model_json_schema(schema_generator=_StudyFile)
    for definition in schema["$defs"].values():
        # Attributes of a class are no matter of the file.
        definition["description"] = definition["description"].partition("\n\n")[0]
    for name in MAY_BE_EMPTY:
        schema["properties"][name]["type"] = ["object", "null"]
    anchors = {f"^{FOR_ANCHORS}": {"description": "anything; holds what anchors name"}}
    return {
        "$schema": _StudyFile.schema_dialect,
        **schema,
        "patternProperties": anchors,
        "title": "Study file",
    }


@dataclass(frozen=True, kw_only=True)
class Place:
    """A place in a study file.

    Attributes
    ----------
    location : tuple
        The keys and places in lists that lead there.
    schema : dict
        Schema of what may stand there.
    """

    location: Location
    schema: Schema

    @property
    def keys(self) -> Schema:
        """Schemas of what may stand under each key, by the keys that are allowed."""
        return self.schema["properties"]

    @property
    def kinds(self) -> list[str]:
        """Kinds that a section can be of, if there are several."""
        return list(self.schema.get("discriminator", {}).get("mapping", {}))

    @property
    def allowed(self) -> str:
        """What may stand there, in words."""
        if "properties" in self.schema:
            return f"the keys {', '.join(self.keys)}"
        return self.schema["description"]


def place_of(loc: Sequence[str | int]) -> Place:
    """Place that an error of pydantic is about.

    Parameters
    ----------
    loc : sequence of str or int
        As pydantic gives it: of a part that has several forms, the form is named, too.

    Returns
    -------
    Place
    """
    # A section, the wrong name of an entry, and that it is the name that is wrong.
    of_name = len(loc) == 3 and loc[-1] == KEY
    root = study_schema()
    location: Location = ()
    schema = root
    for step in loc[:1] if of_name else loc:
        if "oneOf" in schema:
            below = _form(root, schema, step)
        else:
            location, below = (*location, step), _below(schema, step)
        # What has no description of its own is described with what it is part of.
        schema = {"description": schema["description"]} | _resolved(root, below)
    return Place(location=location, schema=schema["propertyNames"] if of_name else schema)


def _form(root: Schema, schema: Schema, form: str | int) -> Schema:
    """One of several forms, by its kind or its JSON type."""
    kinds = schema.get("discriminator", {}).get("mapping", {})
    if form in kinds:
        return {"$ref": kinds[form]}
    forms = [_resolved(root, other) for other in schema["oneOf"]]
    return next(other for other in forms if other["type"] == form)


def _below(schema: Schema, step: str | int) -> Schema:
    """Find the schema of what stands under a key or at a place in a list."""
    if "items" in schema:
        return schema["items"]
    entries = schema.get("patternProperties", {})
    return schema.get("properties", {}).get(step) or next(iter(entries.values()), {})


def _resolved(root: Schema, schema: Schema) -> Schema:
    """Put what a reference refers to in its place; what stands beside it goes first."""
    if "$ref" not in schema:
        return schema
    return root["$defs"][schema["$ref"].rpartition("/")[2]] | schema
