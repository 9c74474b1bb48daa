"""The JSON Schema of study files, for editors, and the keys that a section may have."""

from typing import Any

from vibrissa.study.model import Study


def study_schema() -> dict[str, Any]:
    """JSON Schema of study files (draft 2020-12)."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Study.model_json_schema(),
        "patternProperties": {"^x-": {"description": "anything, such as YAML anchors"}},
        "title": "Study file",
    }


def allowed_at(location: tuple[str | int, ...]) -> str:
    """Return the keys allowed in the section at a location; the whole file is at ``()``."""
    root = schema = study_schema()
    for step in location:
        if (kind := str(step)[1:-1]) in root["$defs"]:
            # One of several kinds of a section, as in "[GridSection]".
            schema = root["$defs"][kind]
            continue
        named = [*schema.get("patternProperties", {}).values(), schema.get("additionalProperties")]
        schema = schema.get("properties", {}).get(step) or named[0] or {}
        # An optional section is a choice between the section and null.
        (schema,) = [one for one in schema.get("anyOf", ()) if "$ref" in one] or [schema]
        if "$ref" in schema:
            schema = root["$defs"][schema["$ref"].rpartition("/")[2]]
    return ", ".join(sorted(schema.get("properties", {})))
