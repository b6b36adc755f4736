"""Refuses bodies that are too large or too slow: by what they announce, and by what they turn out to be."""

import asyncio
from collections.abc import Coroutine, Mapping
from dataclasses import dataclass
from typing import Any, cast

from fastapi import HTTPException
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.http.eager_coroutine import EagerCoroutine
from endpoints.http.problems import problem_response
from ppaas.errors import MessageTooLarge

MAX_DIGITS = 18


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Most bytes that a body may have, and most seconds that it may take to come."""

    size: int
    seconds: float


class BodyLimit:
    """ASGI middleware that lets no request body grow beyond its limit, or come in drops.

    Parameters
    ----------
    app : ASGI application
        Who is served.
    limits : BodyLimits
        Of all requests but uploads.
    uploads : mapping of str to BodyLimits
        Others where files are sent with POST, by path.
    """

    def __init__(self, app: ASGIApp, limits: BodyLimits, uploads: Mapping[str, BodyLimits]) -> None:
        self._app = app
        self._limits = limits
        self._uploads = uploads

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limits = self._uploads.get(scope["path"], self._limits) if scope["method"] == "POST" else self._limits
        announced = Headers(scope=scope).get("content-length", "")
        if announced.isdecimal() and (len(announced) > MAX_DIGITS or int(announced) > limits.size):
            await problem_response(_too_large(limits))(scope, receive, send)
            return
        await self._app(scope, _Body(receive, limits).receive, send)


class _Body:
    """A body on its way: counted, and waited for no longer than it may take."""

    def __init__(self, receive: Receive, limits: BodyLimits) -> None:
        self._receive = receive
        self._limits = limits
        self._read = 0
        self._until: float | None = None
        self._whole = False

    async def receive(self) -> Message:
        """Return the next message; once the body is whole, wait for the client to go as long as it takes."""
        if self._whole:
            return await self._receive()
        reading = EagerCoroutine(cast(Coroutine[Any, Any, Message], self._receive()))
        message = await (reading if reading.done else self._in_time(reading))
        self._whole = not message.get("more_body", False)
        self._read += len(message.get("body", b""))
        if self._read > self._limits.size:
            raise _too_large(self._limits)
        return message

    async def _in_time(self, reading: EagerCoroutine[Message]) -> Message:
        if self._until is None:
            self._until = asyncio.get_running_loop().time() + self._limits.seconds
        try:
            async with asyncio.timeout_at(self._until):
                return await reading
        except TimeoutError as error:
            detail = f"the body did not come within {self._limits.seconds:g} s: send it again, faster"
            # What still comes of it would be taken for the next request.
            raise HTTPException(408, detail, {"Connection": "close"}) from error


def _too_large(limits: BodyLimits) -> MessageTooLarge:
    return MessageTooLarge(f"the body of this request may have {limits.size} bytes at most")
