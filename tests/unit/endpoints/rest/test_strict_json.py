"""Strict JSON: what two parsers could read differently is rejected."""

import pytest

from endpoints.rest.strict_json import parse
from ppaas.errors import MalformedMessage


def test_duplicate_keys_are_refused_at_any_depth() -> None:
    assert parse(b'{"a": {"b": 1}, "c": {"b": 1}}') == {"a": {"b": 1}, "c": {"b": 1}}
    with pytest.raises(MalformedMessage, match="'b' twice"):
        parse(b'{"a": [{"b": 1, "c": 2, "b": 1}]}')
