"""Page of the REST service, from its OpenAPI document."""

from collections.abc import Iterator, Mapping
from typing import Any

from docs.site.reference.markdown import cell, code, table
from docs.site.reference.markdown import page as joined
from docs.site.reference.schema_types import type_of
from endpoints.app import description

INTRODUCTION = """
All operations of the REST service. A running cloud shows the same at `/docs`, where requests can be tried, and as
OpenAPI at `/openapi.json`. [REST](../rest.md) describes what all operations have in common; the bodies are on the page
of [schemas](schemas.md).
"""


def page() -> str:
    """Return the page."""
    document = description()
    operations = [
        (path, method, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    ]
    sections = (
        part
        for tag in document["tags"]
        for part in (
            f"## {tag['name'].capitalize()}",
            tag["description"],
            *(part for each in operations if each[2]["tags"][:1] == [tag["name"]] for part in _operation(*each)),
        )
    )
    return joined("# Operations of REST", INTRODUCTION, *sections)


def _operation(path: str, method: str, operation: Mapping[str, Any]) -> Iterator[str]:
    yield f"### {code(f'{method.upper()} {path}')}"
    yield operation.get("description", "")
    parameters = operation.get("parameters", ())
    yield table(
        ("parameter", "in", "type", "meaning"),
        (
            (
                code(each["name"]) + (" (required)" if each.get("required") else ""),
                each["in"],
                type_of(each["schema"]),
                each.get("description") or each["schema"].get("description", ""),
            )
            for each in parameters
        ),
    )
    body = operation.get("requestBody", {}).get("content", {})
    yield from (f"Body, {code(kind)}: {type_of(content.get('schema', {}))}" for kind, content in body.items())
    answers = {status: each for status, each in sorted(operation["responses"].items()) if status < "400"}
    yield table(("status", "answer", "body"), _answers(answers))
    refusals = ", ".join(sorted(operation["responses"].keys() - answers.keys()))
    yield f"[Problems](schemas.md#problem): {refusals}." if refusals else ""


def _answers(responses: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    for status, response in responses.items():
        kinds = response.get("content", {})
        bodies = dict.fromkeys(
            type_of(content["schema"]) if content.get("schema") else code(kind) for kind, content in kinds.items()
        )
        yield status, cell(response.get("description", "")), ", ".join(bodies)
