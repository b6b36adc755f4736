"""Path requests over the wire: WebSocket frames, a minimal HTTP connection, and distant starts and goals."""

import json
import select
import socket
from collections.abc import Callable
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
