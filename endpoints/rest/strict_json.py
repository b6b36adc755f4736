"""Routes with strict JSON bodies: declared as JSON, without repeated keys, and within the limits of this module.

A body is read only after its caller was authenticated, if the route wants a token.
"""

import json
from collections.abc import Callable, Coroutine, Iterable
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

from endpoints.accounts.authentication import authenticate
from endpoints.audit.requests import note_body
from endpoints.rest.dependencies import any_user, services_of
from ppaas.errors import MalformedMessage, MessageTooLarge


def media_type_of(request: Request) -> str:
    """Return the media type of a body in lower case, without its parameters; empty if it is not declared."""
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


def is_format(media_type: str, name: str) -> bool:
    """Return whether a media type is a format such as ``json``, or is based on it (RFC 6838, 4.2.8)."""
    return media_type == f"application/{name}" or (
        media_type.startswith("application/") and media_type.endswith(f"+{name}")
    )


# Nesting of JSON values: objects and lists within each other.

MAX_NESTING = 32
"""Largest number of objects and lists within each other in free-form values, such as parameters."""

MAX_SHOWN = 200
"""Largest number of these that is shown of a stored value; pydantic writes no more than some 250."""

HIDDEN = {"error": "this value is nested too deeply to be shown: replace it"}
"""Stands for a stored value that cannot be shown."""


def is_deeper(value: Any, depth: int) -> bool:
    """Return whether a JSON value has more than ``depth`` objects and lists within each other."""
    level = [value] if isinstance(value, dict | list) else []
    for _ in range(depth):
        level = [child for parent in level for child in _children(parent) if isinstance(child, dict | list)]
    return bool(level)


def showable(value: Any) -> Any:
    """Return a stored value, or `HIDDEN` if an earlier release stored one that is nested too deeply."""
    return HIDDEN if is_deeper(value, MAX_SHOWN) else value


def _children(parent: Any) -> Iterable[Any]:
    return parent.values() if isinstance(parent, dict) else parent


MERGE_PATCH = "application/merge-patch+json"
MAX_KEY_SHOWN = 64

MAX_CONTAINERS = 20_000
"""Largest number of objects and lists in a body; a path of 16,384 poses has as many lists."""

MAX_KEYS = 1024
"""Largest number of keys of an object."""

MAX_DEPTH = 512
"""Largest number of objects and lists within each other; a schema may allow fewer."""


class StrictRequest(Request):
    """Request whose body is parsed as strict JSON."""

    async def json(self) -> Any:
        """Return the parsed body.

        Raises
        ------
        MalformedMessage
            The body is not JSON, is nested too deeply, or repeats a key.
        MessageTooLarge
            The body has too many objects and lists, or an object has too many keys.
        """
        if not hasattr(self, "_json"):
            self._json = parse(await self.body())
            note_body(self.scope, self._json)
        return self._json


class StrictRoute(APIRoute):
    """Route that authenticates its caller, then rejects a body whose content type is not JSON."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of requests."""
        serve = super().get_route_handler()
        takes_body = self.body_field is not None
        # FastAPI parses a body before it calls the dependency that authenticates.
        wants_token = takes_body and _depends_on(self.dependant, any_user)

        async def strict(request: Request) -> Response:
            if wants_token:
                await authenticate(request, (await services_of(request)).accounts)
            if takes_body and _has_body(request) and not is_format(media_type_of(request), "json"):
                raise HTTPException(415, "send JSON with the header 'Content-Type: application/json'")
            return await serve(StrictRequest(request.scope, request.receive))

        return strict


def parse(body: bytes) -> Any:
    """Return the value of a JSON text; raises as ``StrictRequest.json``."""
    openings = body.count(b"[") + body.count(b"{")  # at least as many as objects and lists: texts may have some
    if openings > MAX_CONTAINERS:
        raise MessageTooLarge(f"the body has too many objects and lists: at most {MAX_CONTAINERS} are allowed")
    try:
        value = _decoder.decode(body.decode(json.detect_encoding(body), "surrogatepass"))
    except RecursionError as error:
        raise _too_deep() from error
    except ValueError as error:
        raise MalformedMessage(f"the body is not JSON: {error}") from error
    if openings > MAX_DEPTH and is_deeper(value, MAX_DEPTH):
        raise _too_deep()
    return value


def _too_deep() -> MalformedMessage:
    return MalformedMessage(f"the body is nested too deeply: at most {MAX_DEPTH} levels are allowed")


def _has_body(request: Request) -> bool:
    return "transfer-encoding" in request.headers or request.headers.get("content-length", "0") != "0"


def _depends_on(dependant: Dependant, function: Callable[..., Any]) -> bool:
    return dependant.call is function or any(_depends_on(inner, function) for inner in dependant.dependencies)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(pairs) > MAX_KEYS:
        raise MessageTooLarge(f"an object of the body has {len(pairs)} keys: at most {MAX_KEYS} are allowed")
    found = dict(pairs)
    if len(found) < len(pairs):
        raise MalformedMessage(f"the body has the key {_repeated(pairs)[:MAX_KEY_SHOWN]!r} twice in one object")
    return found


def _repeated(pairs: list[tuple[str, Any]]) -> str:
    seen = set[str]()
    return next(name for name, _ in pairs if name in seen or seen.add(name))  # type: ignore[func-returns-value]


_decoder = json.JSONDecoder(object_pairs_hook=_object)
"""A single decoder: ``json.loads`` would build one per call with this hook."""


def merge(target: Any, patch: Any) -> Any:
    """Return a JSON value with a patch applied: objects are merged, null removes a key, other values replace.

    This is the algorithm of RFC 7396, section 2; the arguments are not modified.
    """
    if not isinstance(patch, dict):
        return patch
    merged = dict(target) if isinstance(target, dict) else {}
    for name, value in patch.items():
        if value is None:
            merged.pop(name, None)
        else:
            merged[name] = merge(merged.get(name), value)
    return merged
