"""Target of webhooks on a real socket, which verifies deliveries by the library of Standard Webhooks."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from standardwebhooks import Webhook as Receiver
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from tests.support.endpoints.serving import serve
from tests.support.waiting import until


@dataclass
class Target:
    """What a target has received, and how it answers."""

    port: int = 0
    secrets: list[str] = field(default_factory=list)
    status: Callable[[int], int] = lambda _number: 204
    """Returns the status of an answer by the number of the request, from 1."""
    hangs: bool = False
    hanging: int = 0
    """Number of requests that wait for an answer, because the target hangs."""
    events: list[dict[str, Any]] = field(default_factory=list)
    """Verified bodies of the deliveries that were answered with 2xx."""
    ids: Counter[str] = field(default_factory=Counter)
    """Number of requests by ``webhook-id``."""

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/hook?a=1"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        request = Request(scope, receive)
        body = await request.body()
        headers = dict(request.headers)
        self.ids[headers["webhook-id"]] += 1
        self.hanging += 1
        while self.hangs:
            await asyncio.sleep(0.01)
        self.hanging -= 1
        status = self.status(self.ids.total())
        if status < 300 and self.secrets:
            [event] = {repr(found): found for found in self._verified(body, headers)}.values()
            self.events.append(event)
        headers_of_answer = {"location": f"{self.url}&redirected"} if 300 <= status < 400 else {}
        await Response(status_code=status, headers=headers_of_answer)(scope, receive, send)

    @asynccontextmanager
    async def serving(self) -> AsyncIterator["Target"]:
        """Serve on a free port."""
        async with serve(self) as self.port:
            yield self

    def _verified(self, body: bytes, headers: dict[str, str]) -> list[Any]:
        return [Receiver(secret).verify(body, headers) for secret in self.secrets]

    async def has(self, count: int) -> None:
        """Wait until a number of deliveries have arrived."""
        await until(lambda: len(self.events) >= count)
