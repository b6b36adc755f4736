"""Parsed JSON body of a request, noted in its ASGI scope."""

from collections.abc import MutableMapping
from typing import Any

_KEY = "ppaas.body"


def note_body(scope: MutableMapping[str, Any], body: Any) -> None:
    """Note the parsed body of a request."""
    scope[_KEY] = body


def parsed_body(scope: MutableMapping[str, Any]) -> Any:
    """Return the parsed body of a request; None if it was not read as JSON."""
    return scope.get(_KEY)
