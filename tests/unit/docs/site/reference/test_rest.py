"""The pages of REST have each operation and each schema."""

import re

from docs.site.reference import rest, schemas
from docs.site.reference.schema_types import bounds_of, type_of
from endpoints.app import OPERATIONS, description

TEXT, SCHEMAS = rest.page(), schemas.page()


def test_each_operation_and_each_schema_has_a_section() -> None:
    headings = re.findall(r"^### `(.*)`$", TEXT, re.MULTILINE)
    assert sorted(headings) == sorted(f"{method} {path}" for path, methods in OPERATIONS for method in methods)
    assert re.findall(r"^## `(.*)`$", SCHEMAS, re.MULTILINE) == sorted(description()["components"]["schemas"])


def test_types_are_words_and_links() -> None:
    assert type_of({"$ref": "#/components/schemas/Pose"}) == "[`Pose`](schemas.md#pose)"
    assert type_of({"anyOf": [{"type": "string"}, {"type": "null"}]}) == "string or null"
    assert type_of({"type": "array", "items": {"type": "number"}}) == "array of number"
    assert type_of({"type": "array", "prefixItems": [{"type": "number"}, {"const": "a"}]}) == "array of (number, `a`)"
    assert type_of({"type": "object", "additionalProperties": {"type": "integer"}}) == "object of integer"
    assert type_of({"enum": ["a", "b"]}) == "`a` or `b`"
    assert bounds_of({"type": "integer", "minimum": 1, "maximum": 20}) == "at least 1, at most 20"


def test_an_operation_has_its_parameters_bodies_and_problems() -> None:
    text = TEXT.partition("### `POST /v1/maps/{map_id}/plans`\n")[2].partition("\n### ")[0]
    assert "`map_id` (required) | path | string" in text
    assert "Body, `application/json`: [`" in text
    assert re.search(r"\[Problems\]\(schemas\.md#problem\): .*404, .*422", text)
