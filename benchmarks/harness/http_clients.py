"""HTTP clients that send requests at once, each as soon as its last one is answered; cheap beside any server."""

import asyncio
from collections.abc import Iterator, Mapping
from typing import cast
from urllib.parse import urlsplit

from ppaas.errors import Unavailable

_LENGTH, _END = b"content-length:", b"\r\n\r\n"


class Requests:
    """Requests of one route of a server, which clients take one after the other.

    Parameters
    ----------
    url : str
        Address of the server and path of the route.
    token : str
        Bearer token.
    bodies : iterator of bytes
        JSON; the clients end with it.
    headers : mapping of str to str
        Further headers.
    """

    def __init__(self, url: str, token: str, bodies: Iterator[bytes], headers: Mapping[str, str] | None = None) -> None:
        address = urlsplit(url)
        self._address = address.hostname or "", address.port or 80
        route = f"{address.path or '/'}{f'?{address.query}' * bool(address.query)}"
        more = "".join(f"{name}: {value}\r\n" for name, value in (headers or {}).items())
        self._head = (
            f"POST {route} HTTP/1.1\r\nHost: {address.netloc}\r\nAuthorization: Bearer {token}\r\n"
            f"Content-Type: application/json\r\n{more}Content-Length: "
        ).encode()
        self._bodies = bodies
        self.answers: list[bytes] = []
        """Bodies of the first and the last answer."""
        self.size = 0
        """Size of all answers, without their heads [bytes]."""

    def next(self) -> bytes | None:
        """Return the next request, or None after the last."""
        body = next(self._bodies, None)
        return None if body is None else b"%b%d\r\n\r\n%b" % (self._head, len(body), body)

    def take(self, answer: bytes) -> None:
        """Count an answer."""
        self.size += len(answer)
        self.answers[1:] = [answer]

    async def run(self, clients: int) -> None:
        """Send all requests from some clients at once.

        Raises
        ------
        Unavailable
            The server refuses a request, or closes a connection.
        """
        loop = asyncio.get_running_loop()
        made = [await loop.create_connection(lambda: _Client(self), *self._address) for _ in range(clients)]
        try:
            async with asyncio.TaskGroup() as group:
                for _, client in made:
                    group.create_task(client.run())
        finally:
            for transport, _ in made:
                transport.close()


class _Client(asyncio.Protocol):
    """One connection. It parses the status and the length of an answer, and nothing else."""

    def __init__(self, requests: Requests) -> None:
        self._requests = requests
        self._over: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._read = b""
        self._length = -1

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport."""
        self._transport = cast(asyncio.Transport, transport)

    async def run(self) -> None:
        """Send requests until there are no more."""
        self._send()
        await self._over

    def _send(self) -> None:
        request = self._requests.next()
        if request is not None:
            self._transport.write(request)
        elif not self._over.done():
            self._over.set_result(None)

    def data_received(self, data: bytes) -> None:
        """Take an answer once it is complete, and send the next request."""
        self._read += data
        if self._length < 0 and _END in self._read:
            head, _, self._read = self._read.partition(_END)
            if not head.startswith(b"HTTP/1.1 2"):
                self._fail(f"the server refuses a request of the bench: {(head + _END + self._read)[:500]!r}")
                return
            self._length = int(head.lower().split(_LENGTH, 1)[1].split(b"\r\n", 1)[0])
        if 0 <= self._length <= len(self._read):
            answer, self._read, self._length = self._read, b"", -1
            self._requests.take(answer)
            self._send()

    def connection_lost(self, exc: Exception | None) -> None:
        """Fail if an answer is missing."""
        self._fail("the server closed a connection of the bench")

    def _fail(self, text: str) -> None:
        if not self._over.done():
            self._over.set_exception(Unavailable(text))
