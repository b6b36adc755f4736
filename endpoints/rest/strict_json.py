"""Routes with strict JSON bodies: declared as JSON, without repeated keys and not nested too deeply."""

import json
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute

from ppaas.errors import MalformedMessage

MERGE_PATCH = "application/merge-patch+json"
MAX_KEY_SHOWN = 64


class StrictRequest(Request):
    """Request whose body is parsed as strict JSON."""

    async def json(self) -> Any:
        """Return the parsed body.

        Raises
        ------
        MalformedMessage
            The body is not JSON, is nested too deeply, or repeats a key.
        """
        if not hasattr(self, "_json"):
            self._json = parse(await self.body())
        return self._json


class StrictRoute(APIRoute):
    """Route that rejects a body whose content type is not JSON."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of requests."""
        serve = super().get_route_handler()
        takes_body = self.body_field is not None

        async def strict(request: Request) -> Response:
            if takes_body and _has_body(request) and not is_json(request.headers.get("content-type", "")):
                raise HTTPException(415, "send JSON with the header 'Content-Type: application/json'")
            return await serve(StrictRequest(request.scope, request.receive))

        return strict


def parse(body: bytes) -> Any:
    """Return the value of a JSON text; raises as ``StrictRequest.json``."""
    try:
        return _decoder.decode(body.decode(json.detect_encoding(body), "surrogatepass"))
    except RecursionError as error:
        raise MalformedMessage("the body is nested too deeply") from error
    except ValueError as error:
        raise MalformedMessage(f"the body is not JSON: {error}") from error


def is_json(content_type: str) -> bool:
    """Return whether a media type is JSON."""
    media_type = content_type.partition(";")[0].strip().lower()
    return media_type == "application/json" or (media_type.startswith("application/") and media_type.endswith("+json"))


def _has_body(request: Request) -> bool:
    return "transfer-encoding" in request.headers or request.headers.get("content-length", "0") != "0"


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        repeated = next(name for name in names if names.count(name) > 1)
        raise MalformedMessage(f"the body has the key {repeated[:MAX_KEY_SHOWN]!r} twice in one object")
    return found


_decoder = json.JSONDecoder(object_pairs_hook=_object)
"""A single decoder: ``json.loads`` would build one per call with this hook."""
