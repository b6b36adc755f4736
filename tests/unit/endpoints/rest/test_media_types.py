"""Media types of request bodies."""

import pytest
from starlette.requests import Request

from endpoints.rest.media_types import is_format, media_type_of


@pytest.mark.parametrize(
    ("header", "found"),
    [
        (b"application/json", "application/json"),
        (b" Application/JSON ; charset=utf-8", "application/json"),
        (b"", ""),
        (None, ""),
    ],
)
def test_the_media_type_has_no_parameters(header: bytes | None, found: str) -> None:
    headers = [] if header is None else [(b"content-type", header)]
    assert media_type_of(Request({"type": "http", "headers": headers})) == found


@pytest.mark.parametrize(
    ("media_type", "is_json"),
    [
        ("application/json", True),
        ("application/merge-patch+json", True),
        ("text/json", False),
        ("image/svg+json", False),
        ("application/jsonx", False),
        ("", False),
    ],
)
def test_a_format_is_named_alone_or_after_a_plus(media_type: str, is_json: bool) -> None:
    assert is_format(media_type, "json") == is_json
