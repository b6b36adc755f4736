"""Path requests over the wire: WebSocket frames, minimal HTTP clients, and distant starts and goals."""

import asyncio
import json
import select
import socket
from collections.abc import Callable, Iterator, Mapping
from typing import cast
from urllib.parse import urlsplit

from ppaas.errors import Unavailable
from ppaas.maps.grid import GridMap
from robots.sim.courses import CoursePlanner, GoalRules


def ends(grid: GridMap) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return a start and a goal that are far apart."""
    rules = GoalRules(shortest=0.8, preferred=0.9)
    course = CoursePlanner(grid, 1, rules).choose(1, 1)[0]
    (a, b) = course.start, course.goals[0]
    return (a.x, a.y, a.theta), (b.x, b.y, b.theta)


def make_plan_call(start: tuple[float, float, float], goal: tuple[float, float, float]) -> str:
    """Return the frame of a ``nav_msgs/GetPlan`` call, whose answer is the path as in ROS."""
    ends = ({"header": {"frame_id": "map"}, "pose": _pose(end)} for end in (start, goal))
    return _call("/move_base/make_plan", *ends)


def compute_path_call(
    start: tuple[float, float, float], goal: tuple[float, float, float], **more: str | float | bool
) -> str:
    """Return the frame of a ``ppaas_msgs/ComputePath`` call, whose answer includes the planner's time."""
    return _call("/move_base/compute_path", _pose(start), _pose(goal), **more)


def _pose(end: tuple[float, float, float]) -> dict[str, object]:
    return {"position": {"x": end[0], "y": end[1]}, "orientation": {"z": 0.0, "w": 1.0}}


def _call(service: str, start: dict[str, object], goal: dict[str, object], **more: str | float | bool) -> str:
    arguments = {"start": start, "goal": goal, **more}
    return json.dumps({"op": "call_service", "id": "1", "service": service, "args": arguments})


class RestAsker:
    """HTTP connection that posts a body repeatedly, each time in one packet.

    It parses only the length of an answer, to add little to the measured time: ``http.client`` takes longer for a
    request than the server.
    """

    def __init__(self, url: str, token: str, path: str) -> None:
        address = urlsplit(url)
        self._address = address.hostname, address.port
        self._socket = self._connected()
        self._head = (
            f"POST {path} HTTP/1.1\r\nHost: {address.netloc}\r\nAuthorization: Bearer {token}\r\n"
            "Content-Type: application/json\r\nContent-Length: {}\r\n\r\n"
        )

    def _connected(self) -> socket.socket:
        opened = socket.create_connection(self._address, timeout=30.0)
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return opened

    def _is_closed(self) -> bool:
        """Return whether the server has closed the connection, as it does with one that was idle for seconds."""
        readable, _, _ = select.select([self._socket], [], [], 0.0)
        return bool(readable)

    def exchange(self, body: bytes) -> bytes:
        """Return the answer to a body; raise ``Unavailable`` if the server closes the connection meanwhile."""
        if self._is_closed():
            self._socket.close()
            self._socket = self._connected()
        self._socket.sendall(self._head.format(len(body)).encode() + body)
        answer = self._read(b"", lambda read: b"\r\n\r\n" in read)
        head, _, begun = answer.partition(b"\r\n\r\n")
        length = int(head.lower().split(b"content-length:", 1)[1].split(b"\r\n", 1)[0])
        return self._read(begun, lambda read: len(read) >= length)

    def _read(self, begun: bytes, enough: Callable[[bytes], bool]) -> bytes:
        read = begun
        while not enough(read):
            more = self._socket.recv(1 << 18)
            if not more:
                raise Unavailable("the server closed the connection of the bench")
            read += more
        return read

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


# -- HTTP clients that send requests at once, each as soon as its last one is answered ---------------------------------

_LENGTH, _END = b"content-length:", b"\r\n\r\n"


class RouteRequests:
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

    def __init__(self, requests: RouteRequests) -> None:
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
