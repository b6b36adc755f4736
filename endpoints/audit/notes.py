"""Notes of routes for the audit log, in the ASGI scope of a request: what neither path nor body says."""

from collections.abc import MutableMapping
from typing import Any

_OBJECT, _DETAILS = "ppaas.audit.object", "ppaas.audit.details"


def note_object(scope: MutableMapping[str, Any], name: str) -> None:
    """Note the object of the action, as ``maps/office``; it replaces the object that the path names."""
    scope[_OBJECT] = name


def note_details(scope: MutableMapping[str, Any], **details: Any) -> None:
    """Note what was changed; never a secret."""
    scope.setdefault(_DETAILS, {}).update(details)


def noted_object(scope: MutableMapping[str, Any]) -> str | None:
    """Return the noted object, if there is one."""
    return scope.get(_OBJECT)


def noted_details(scope: MutableMapping[str, Any]) -> dict[str, Any]:
    """Return the noted details."""
    return dict(scope.get(_DETAILS, {}))
