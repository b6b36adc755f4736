"""Types of JSON schemas in words."""

from collections.abc import Mapping
from typing import Any

from docs.site.reference.markdown import code, slug

Schema = Mapping[str, Any]

BOUNDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
    "minLength": "length at least",
    "maxLength": "length at most",
    "minItems": "items at least",
    "maxItems": "items at most",
}
"""Words for the bounds of a schema."""


def type_of(schema: Schema) -> str:
    """Return the type of a schema: a link, or words."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{code(name)}](schemas.md#{slug(name)})"
    for several in ("anyOf", "oneOf", "allOf"):
        if several in schema:
            return " or ".join(dict.fromkeys(type_of(each) for each in schema[several]))
    if "const" in schema:
        return code(str(schema["const"]))
    if "enum" in schema:
        return " or ".join(code(str(each)) for each in schema["enum"])
    return _plain(schema)


def _plain(schema: Schema) -> str:
    kind = schema.get("type", "any")
    if kind == "array":
        if "prefixItems" in schema:
            return f"array of ({', '.join(type_of(each) for each in schema['prefixItems'])})"
        return f"array of {type_of(schema.get('items', {}))}"
    if kind == "object" and isinstance(schema.get("additionalProperties"), Mapping):
        return f"object of {type_of(schema['additionalProperties'])}"
    return str(kind)


def bounds_of(schema: Schema) -> str:
    """Return the bounds of the values of a schema, in words."""
    parts = [schema, *schema.get("anyOf", ())]
    return ", ".join(f"{words} {part[name]:g}" for part in parts for name, words in BOUNDS.items() if name in part)
