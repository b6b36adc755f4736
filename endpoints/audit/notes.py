"""Notes of routes for the audit log, in the ASGI scope of a request: what neither path nor body contains."""

from collections.abc import MutableMapping
from typing import Any

_OBJECT, _DETAILS, _REFUSAL = "ppaas.audit.object", "ppaas.audit.details", "ppaas.audit.refusal"


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


def note_refusal(scope: MutableMapping[str, Any], status: int) -> None:
    """Note the status of a WebSocket that is accepted only to report why it is refused."""
    scope[_REFUSAL] = status


def noted_refusal(scope: MutableMapping[str, Any]) -> int | None:
    """Return the status of a refused WebSocket; None if it is not refused."""
    return scope.get(_REFUSAL)
