"""Limits of size and time of request bodies, checked by Content-Length and while a body arrives."""

import asyncio
from collections.abc import Coroutine, Generator, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from fastapi import HTTPException
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.http.problems import problem_response
from ppaas.errors import MessageTooLarge

# Coroutines that finish without waiting need no timeout or task: most bodies arrive with their head.

T = TypeVar("T")


class EagerCoroutine(Generic[T]):
    """Coroutine that runs at once up to its first suspension; if it suspends, the task that created it must await it.

    Parameters
    ----------
    work : coroutine
        The coroutine to run.

    Attributes
    ----------
    done : bool
        Whether it finished; awaiting it then returns at once.
    """

    def __init__(self, work: Coroutine[Any, Any, T]) -> None:
        self._work = work
        self._result: T
        self._awaited: object = None
        self.done = False
        self._step(None)

    def _step(self, sent: object) -> None:
        try:
            self._awaited = self._work.send(sent)
        except StopIteration as end:
            self._result, self.done = end.value, True

    def _throw(self, error: BaseException) -> None:
        try:
            self._awaited = self._work.throw(error)
        except StopIteration as end:
            self._result, self.done = end.value, True

    def __await__(self) -> Generator[object, object, T]:
        """Return the result of the coroutine, or raise its exception."""
        while not self.done:
            try:
                sent = yield self._awaited
            except BaseException as error:  # noqa: BLE001  # passed into the coroutine, which handles it
                self._throw(error)
            else:
                self._step(sent)
        return self._result


MAX_DIGITS = 18
"""Largest number of digits of a Content-Length that is parsed."""


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Largest size of a body [bytes], and time limit for receiving it [s]."""

    size: int
    seconds: float


class BodyLimit:
    """ASGI middleware that rejects request bodies that are too large or arrive too slowly.

    Parameters
    ----------
    app : ASGI application
        Wrapped application.
    limits : BodyLimits
        Limits of all requests except these.
    posts : mapping of str to BodyLimits
        Limits of requests by POST, by path: of uploads, and of logins, which anybody may send.
    """

    def __init__(self, app: ASGIApp, limits: BodyLimits, posts: Mapping[str, BodyLimits]) -> None:
        self._app = app
        self._limits = limits
        self._posts = posts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limits = self._posts.get(scope["path"], self._limits) if scope["method"] == "POST" else self._limits
        announced = Headers(scope=scope).get("content-length", "")
        if announced.isdecimal() and (len(announced) > MAX_DIGITS or int(announced) > limits.size):
            await problem_response(_too_large(limits))(scope, receive, send)
            return
        await self._app(scope, _LimitedBody(receive, limits).receive, send)


class _LimitedBody:
    """Body that is received within its limits."""

    def __init__(self, receive: Receive, limits: BodyLimits) -> None:
        self._receive = receive
        self._limits = limits
        self._read = 0
        self._deadline: float | None = None
        self._complete = False

    async def receive(self) -> Message:
        """Return the next message; after the last one of the body, wait without limit for the disconnect."""
        if self._complete:
            return await self._receive()
        reading = EagerCoroutine(cast(Coroutine[Any, Any, Message], self._receive()))
        message = await (reading if reading.done else self._in_time(reading))
        self._complete = not message.get("more_body", False)
        self._read += len(message.get("body", b""))
        if self._read > self._limits.size:
            raise _too_large(self._limits)
        return message

    async def _in_time(self, reading: EagerCoroutine[Message]) -> Message:
        if self._deadline is None:
            self._deadline = asyncio.get_running_loop().time() + self._limits.seconds
        try:
            async with asyncio.timeout_at(self._deadline):
                return await reading
        except TimeoutError as error:
            detail = f"the body did not arrive within {self._limits.seconds:g} s: send it again, faster"
            # Later parts of the body would be taken for the next request.
            raise HTTPException(408, detail, {"Connection": "close"}) from error


def _too_large(limits: BodyLimits) -> MessageTooLarge:
    return MessageTooLarge(f"the body of this request must have at most {limits.size} bytes")
