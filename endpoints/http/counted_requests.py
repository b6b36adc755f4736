"""ASGI middleware that counts requests by the class of their status, and the time until their answer begins."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from engine.control.counts import REQUEST_SECONDS, BucketCounts
from engine.control.master_calls.interface import RequestCounts
from ppaas.clock import Clock, monotonic

FAILED = 500
"""Status that stands for a request without an answer."""


class CountedRequests:
    """Counts the requests by HTTP of an application; WebSockets are not counted.

    Parameters
    ----------
    app : ASGI application
        Serves them.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, app: ASGIApp, clock: Clock = monotonic) -> None:
        self._app = app
        self._clock = clock
        self._statuses = [0] * 5
        self._seconds = BucketCounts(REQUEST_SECONDS)

    def counts(self) -> RequestCounts:
        """Return the counts since the start."""
        first, second, third, fourth, fifth = self._statuses
        counted = self._seconds
        return RequestCounts((first, second, third, fourth, fifth), list(counted.counts), counted.total)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        began, answered = self._clock(), False

        async def watch(message: Message) -> None:
            nonlocal answered
            if message["type"] == "http.response.start" and not answered:
                answered = True
                self._count(message["status"], began)
            await send(message)

        try:
            await self._app(scope, receive, watch)
        finally:
            if not answered:
                self._count(FAILED, began)

    def _count(self, status: int, began: float) -> None:
        self._statuses[status // 100 - 1] += 1
        self._seconds.add(self._clock() - began)
