"""The JSON Schema of study files, for editors, and the keys that a section may have."""

from functools import cache
from typing import Any

from vibrissa.study.axes import AXES
from vibrissa.study.model import Study

Schema = dict[str, Any]


@cache
def study_schema() -> Schema:
    """JSON Schema of study files (draft 2020-12)."""
    schema = Study.model_json_schema()
    for definition in schema["$defs"].values():
        definition["description"] = definition.get("description", "").partition("\n\n")[0]
        for name, axis in AXES.items():
            if name in definition.get("properties", {}):
                described = definition["properties"][name]
                forms = {
                    "Figure": "the values that are shown, one or a list",
                    "StateSection": axis.allowed,
                }
                form = forms.get(definition["title"], axis.forms)
                described["description"] = f"{axis.meaning}: {form}"
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "patternProperties": {"^x-": {"description": "anything; holds what anchors name"}},
        "title": "Study file",
    }


def allowed_at(location: tuple[str | int, ...]) -> str:
    """Return the keys that are allowed in a section of the file.

    Parameters
    ----------
    location : tuple
        Keys that lead to the section; empty for the file.

    Returns
    -------
    str
    """
    root = study_schema()
    schema = root
    for step in location:
        found = schema.get("properties", {}).get(step) or next(
            iter(schema.get("patternProperties", {}).values()), schema.get("additionalProperties")
        )
        schema = _resolved(root, found or {})
    return ", ".join(sorted(schema.get("properties", {})))


def _resolved(root: Schema, schema: Schema) -> Schema:
    """Follow a reference, and choose the section where a key may be left out."""
    for option in schema.get("anyOf", ()):
        if "$ref" in option:
            schema = option
    if "$ref" in schema:
        return root["$defs"][schema["$ref"].rpartition("/")[2]]
    return schema
