"""Refuses bodies that are too large: by what they announce, and by what they turn out to be."""

from collections.abc import Mapping

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.problems import problem_response
from ppaas.errors import MessageTooLarge

MAX_DIGITS = 18


class BodyLimit:
    """ASGI middleware that lets no request body grow beyond its limit.

    Parameters
    ----------
    app : ASGI application
        Who is served.
    limit : int
        Largest body [bytes].
    uploads : mapping of str to int
        Another limit where files are sent with POST, by path.
    """

    def __init__(self, app: ASGIApp, limit: int, uploads: Mapping[str, int]) -> None:
        self._app = app
        self._limit = limit
        self._uploads = uploads

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limit = self._uploads.get(scope["path"], self._limit) if scope["method"] == "POST" else self._limit
        announced = Headers(scope=scope).get("content-length", "")
        if announced.isdecimal() and (len(announced) > MAX_DIGITS or int(announced) > limit):
            await problem_response(_too_large(limit))(scope, receive, send)
            return
        await self._app(scope, _counting(receive, limit), send)


def _counting(receive: Receive, limit: int) -> Receive:
    read = 0

    async def receive_counted() -> Message:
        nonlocal read
        message = await receive()
        read += len(message.get("body", b""))
        if read > limit:
            raise _too_large(limit)
        return message

    return receive_counted


def _too_large(limit: int) -> MessageTooLarge:
    return MessageTooLarge(f"the body of this request may have {limit} bytes at most")
