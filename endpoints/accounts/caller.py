"""Caller of a connection, noted in its ASGI scope by whatever authenticated it."""

from collections.abc import MutableMapping
from typing import Any, NamedTuple

_KEY = "ppaas.caller"


class Caller(NamedTuple):
    """User of a connection, and id of the token that authenticated it."""

    user: str
    token: str


def note_caller(scope: MutableMapping[str, Any], user: str, token: str) -> None:
    """Note the user of a connection, and the id of the token."""
    scope[_KEY] = Caller(user, token)


def caller_of(scope: MutableMapping[str, Any]) -> Caller | None:
    """Return the caller of a connection; None if it is not authenticated."""
    return scope.get(_KEY)
