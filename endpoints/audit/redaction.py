"""Redaction: the parts of a request that the audit log may keep, without secrets and without bulk."""

from collections.abc import Mapping
from typing import Any

from starlette.types import Scope

from endpoints.accounts.accounts import ME
from endpoints.accounts.caller import caller_of
from endpoints.accounts.tokens import TOKEN_PREFIX
from endpoints.audit.notes import noted_object

PREFIX = "/v1/"
MAX_TEXT = 100
"""Largest length of a text [characters]."""

MAX_ITEMS = 20
"""Largest number of items of a list or an object."""

MAX_DEPTH = 3
"""Largest number of lists and objects within each other."""

SECRET = "(changed)"
"""Text in place of a secret, and of a text with the prefix of tokens."""

TOKEN_SHOWN = 12
"""Number of characters of a token's id that are recorded."""

FIELDS: Mapping[str, tuple[str, ...]] = {
    "create_token": ("name", "robots", "role", "publish", "subscribe", "expires_in"),
    "create_user": ("id", "role", "groups"),
    "change_user": ("role", "password", "limits", "rapyuta_password", "groups"),
    "put_group": ("members",),
    "share_robot": ("role", "publish", "subscribe"),
    "change_map": ("readers", "description", "traffic"),
    "roll_back_map": ("version", "message"),
    "put_robot": ("map", "cores"),
    "change_robot": ("map", "cores"),
    "put_people_settings": ("rule", "targets", "history", "retention_hours"),
    "change_people_settings": ("rule", "targets", "history", "retention_hours"),
    "follow_people": ("people",),
    "add_task": ("kind", "places", "rounds", "priority", "deadline", "labels"),
    "resize_container": ("cores",),
    "change_machine": ("labels", "max_containers", "max_memory", "oversubscription", "draining"),
}
"""Fields of the bodies of operations that are kept."""

SECRETS = frozenset({"password", "old_password", "rapyuta_password", "token"})


def recorded_fields(action: str, body: Any) -> dict[str, Any]:
    """Return the fields of a body that are recorded."""
    if not isinstance(body, dict):
        return {}
    kept = {name: body[name] for name in FIELDS.get(action, ()) if name in body}
    return {name: SECRET if name in SECRETS else _bounded(value) for name, value in kept.items()}


def named_object(scope: Scope) -> str | None:
    """Return the object of a request: noted by its route, else the part of its path up to its last parameter."""
    noted = noted_object(scope)
    if noted is not None:
        return noted
    segments = scope["path"].partition(PREFIX)[2].split("/")
    values = {str(value) for value in scope.get("path_params", {}).values()}
    last = max((at for at, segment in enumerate(segments) if segment in values), default=0)
    return "/".join(_segment(scope, segments, at) for at in range(last + 1)) or None


def _segment(scope: Scope, segments: list[str], at: int) -> str:
    caller, name = caller_of(scope), segments[at]
    kind = segments[at - 1] if at else ""
    if kind == "users" and name == ME and caller is not None:
        return caller.user
    if kind == "tokens":
        return caller.token[:TOKEN_SHOWN] if name == "current" and caller is not None else plain(name)[:TOKEN_SHOWN]
    return plain(name)


def plain(text: str) -> str:
    """Return a text without control characters, bounded, and replaced if it looks like a token."""
    if TOKEN_PREFIX in text:
        return SECRET
    shown = "".join(character if character.isprintable() else " " for character in text[:MAX_TEXT])
    return shown.encode("utf-8", "replace").decode()


def _bounded(value: Any, depth: int = 0) -> Any:
    match value:
        case str():
            return plain(value)
        case list() | dict() if depth >= MAX_DEPTH:
            return "…"
        case list():
            return [_bounded(one, depth + 1) for one in value[:MAX_ITEMS]]
        case dict():
            items = list(value.items())[:MAX_ITEMS]
            return {plain(str(name)): _bounded(one, depth + 1) for name, one in items if name not in SECRETS}
        case bool() | int() | float() | None:
            return value
        case _:
            return plain(str(value))
