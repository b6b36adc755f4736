"""TCP proxy before the endpoints of a cloud, which sends each new connection to one that is ready."""

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator, Coroutine, Sequence
from typing import Any

from ppaas.errors import PPaaSError
from robots.client.rest import RestClient

PERIOD = 0.5
"""Period at which each address is asked [s]."""

TIMEOUT = 1.0
"""Time limit of an answer [s]."""

LOCAL = "127.0.0.1"
BLOCK = 1 << 16


class Front:
    """Forwards connections to addresses whose ``/v1/health/ready`` answers 200, or did last, as a load balancer does.

    Parameters
    ----------
    ports : sequence of int
        Ports of the processes that may lead, on loopback. Only one of them serves; earlier ones are preferred.
    others : sequence of int
        Ports of endpoints of joined machines, which take their turns with that one.

    Attributes
    ----------
    url : str
        URL for clients.
    changes : int
        Number of times that another port than before became ready.
    """

    def __init__(self, ports: Sequence[int], others: Sequence[int] = ()) -> None:
        self._leading, self._others = tuple(ports), tuple(others)
        self._ready = dict.fromkeys((*ports, *others), False)
        self._turn = itertools.count()
        self._chosen: int | None = None
        self.url = ""
        self.changes = 0

    @contextlib.asynccontextmanager
    async def serving(self) -> AsyncIterator[None]:
        """Forward connections until the end of the block."""
        server = await asyncio.start_server(self._forward, LOCAL, 0)
        self.url = f"http://{LOCAL}:{server.sockets[0].getsockname()[1]}"
        watching = [asyncio.create_task(self._watch(port)) for port in self._ready]
        try:
            yield
        finally:
            server.close()
            for task in watching:
                task.cancel()
            await asyncio.gather(*watching, return_exceptions=True)

    async def is_ready(self) -> None:
        """Wait until an address is ready."""
        while self._chosen is None:  # noqa: ASYNC110 - asked anyway
            await asyncio.sleep(PERIOD)

    async def _watch(self, port: int) -> None:
        rest = RestClient(f"http://{LOCAL}:{port}", timeout=TIMEOUT)
        while True:
            try:
                self._ready[port] = bool((await rest.get("/v1/health/ready"))["ready"])
            except PPaaSError:
                self._ready[port] = False
            self._count_changes()
            await asyncio.sleep(PERIOD)

    def _count_changes(self) -> None:
        ready = next((port for port in self._leading if self._ready[port]), None)
        if ready is not None and ready != self._chosen:
            self.changes += self._chosen is not None
            self._chosen = ready

    def _next(self) -> int | None:
        ready = [self._chosen, *(port for port in self._others if self._ready[port])]
        return ready[next(self._turn) % len(ready)]

    async def _forward(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Forward a connection to the address that was ready last, in both directions until one side ends it."""
        with contextlib.suppress(OSError):
            far_reader, far_writer = await asyncio.open_connection(LOCAL, self._next())
            with contextlib.closing(far_writer):
                await _either(_pass(reader, far_writer), _pass(far_reader, writer))
        writer.close()


async def _either(one: Coroutine[Any, Any, None], other: Coroutine[Any, Any, None]) -> None:
    tasks = [asyncio.create_task(one), asyncio.create_task(other)]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _pass(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while data := await reader.read(BLOCK):
            writer.write(data)
            await writer.drain()
