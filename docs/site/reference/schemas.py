"""Page of the bodies of the REST service, from its OpenAPI document."""

import json
from collections.abc import Iterator

from docs.site.reference.markdown import code, table
from docs.site.reference.markdown import page as joined
from docs.site.reference.schema_types import Schema, bounds_of, type_of
from endpoints.app import description

INTRODUCTION = """
Bodies of requests and answers of the [REST service](rest.md), by name.
"""


def page() -> str:
    """Return the page."""
    schemas = description()["components"]["schemas"]
    parts = (part for name in sorted(schemas) for part in _section(name, schemas[name]))
    return joined("# Schemas of REST", INTRODUCTION, *parts)


def _section(name: str, schema: Schema) -> Iterator[str]:
    yield f"## {code(name)}"
    yield schema.get("description", "")
    properties = schema.get("properties")
    if properties is None:
        yield f"Type: {type_of(schema)}"
        return
    required = schema.get("required", ())
    rows = (
        (
            code(field) + (" (required)" if field in required else ""),
            type_of(each),
            code(json.dumps(each["default"])) if "default" in each else "",
            "; ".join(filter(None, (each.get("description", ""), bounds_of(each)))),
        )
        for field, each in properties.items()
    )
    yield table(("field", "type", "default", "meaning"), rows)
