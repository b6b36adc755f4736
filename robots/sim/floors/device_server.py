"""Server of simulated lifts and doors over HTTP, as a vendor's gateway is one: ``docs/lifts.md`` has the JSON.

``GET`` returns the state of a device, ``POST`` takes an order. The server has threads of its own; states are read and
orders are obeyed in the event loop, between two steps of the building.
"""

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Literal, Self
from urllib.parse import quote, urlsplit

import msgspec

from ppaas.buildings.building import Building
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.decoding import from_json
from robots.sim.floors.building import SimulatedBuilding

LARGEST = 4096
"""Largest order that is read [bytes]."""

PATIENCE = 5.0
"""Time for which an answer waits for the event loop [s]."""

IDLE = 30.0
"""Time after which a connection without a request is closed [s]."""


class _LiftOrder(msgspec.Struct, forbid_unknown_fields=True):
    session: str
    floor: str = ""
    door: Literal["open"] = "open"
    end: bool = False


class _DoorOrder(msgspec.Struct, forbid_unknown_fields=True):
    session: str
    mode: Literal["open", "closed"]


Answer = tuple[HTTPStatus, bytes]
"""Status and JSON of an answer."""


class DeviceServer:
    """Serves the lifts and doors of a simulated building while its context is open.

    Parameters
    ----------
    building : SimulatedBuilding
    host : str
        Address at which it listens.
    port : int
        Port at which it listens; by default one that is free.

    Attributes
    ----------
    url : str
        Root of the URLs of the devices.
    """

    def __init__(self, building: SimulatedBuilding, host: str = "127.0.0.1", port: int = 0) -> None:
        self._building = building
        self._server = _Server((host, port), partial(_Requests, self._answered))
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lifts = {f"/lifts/{quote(name, safe='')}": name for name in building.lifts}
        self._doors = {f"/doors/{quote(floor, safe='')}/{quote(door, safe='')}": (floor, door)
                       for floor, door in building.doors}  # fmt: skip
        self.url = f"http://{host}:{self._server.server_address[1]}"

    async def __aenter__(self) -> Self:
        """Begin to serve."""
        self._loop = asyncio.get_running_loop()
        self._thread.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await asyncio.to_thread(self._server.shutdown)
        await asyncio.to_thread(self._server.end_connections)
        self._server.server_close()

    def served(self, record: Building) -> Building:
        """Return the record of the building with the URLs of the devices that are served here."""
        lifts = {lift.lift: lift for lift in record.lifts}
        for path, name in self._lifts.items():
            lifts[name] = msgspec.structs.replace(record.lift(name), device=self.url + path)
        doors = {(door.floor, door.door): door for door in record.doors}
        for path, key in self._doors.items():
            doors[key] = msgspec.structs.replace(record.door(*key), device=self.url + path)
        return msgspec.structs.replace(record, lifts=tuple(lifts.values()), doors=tuple(doors.values()))

    def _answered(self, method: str, target: str, body: bytes) -> Answer:
        """Answer a request of another thread, in the event loop."""
        assert self._loop is not None
        return asyncio.run_coroutine_threadsafe(self._answer(method, target, body), self._loop).result(PATIENCE)

    async def _answer(self, method: str, target: str, body: bytes) -> Answer:
        path = urlsplit(target).path
        if path not in self._lifts and path not in self._doors:
            return _problem(HTTPStatus.NOT_FOUND, f"there is no device at {path}")
        if method == "GET":
            state = self._lift_state(path) if path in self._lifts else self._door_state(path)
            return HTTPStatus.OK, msgspec.json.encode(state)
        try:
            self._obey(path, body)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            return _problem(HTTPStatus.BAD_REQUEST, f"no order of a device: {error!s:.200}")
        return HTTPStatus.NO_CONTENT, b""

    def _lift_state(self, path: str) -> dict[str, Any]:
        state = msgspec.structs.asdict(self._building.lifts[self._lifts[path]].state(self._building.time()))
        del state["lift"]
        return state

    def _door_state(self, path: str) -> dict[str, Any]:
        return {"mode": self._building.doors[self._doors[path]].state(self._building.time()).mode}

    def _obey(self, path: str, body: bytes) -> None:
        now = self._building.time()
        if path in self._doors:
            key, door = self._doors[path], from_json(body, _DoorOrder)
            self._building.doors[key].request(DoorRequest(*key, door.session, door.mode), now)
            return
        name, order = self._lifts[path], from_json(body, _LiftOrder)
        if order.end:
            self._building.lifts[name].end(EndSession(name, order.session), now)
        else:
            self._building.lifts[name].request(LiftRequest(name, order.session, order.floor), now)


def _problem(status: HTTPStatus, text: str) -> Answer:
    return status, msgspec.json.encode({"detail": text})


class _Server(ThreadingHTTPServer):
    """Listener with a thread for each connection."""

    daemon_threads = True

    def __init__(self, address: tuple[str, int], handler: Callable[..., BaseHTTPRequestHandler]) -> None:
        super().__init__(address, handler)
        self._connections: dict[socket.socket, threading.Event] = {}

    def process_request(self, request: Any, client_address: Any) -> None:
        """Begin to serve a connection, in a thread."""
        self._connections[request] = threading.Event()
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a connection until it ends."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._connections.pop(request).set()

    def end_connections(self) -> None:
        """End all connections, and wait until their threads have."""
        for request, ended in list(self._connections.items()):
            with contextlib.suppress(OSError):  # the peer was first
                request.shutdown(socket.SHUT_RDWR)
            ended.wait(PATIENCE)


class _Requests(BaseHTTPRequestHandler):
    """Reads the requests of one connection, and writes the answers."""

    protocol_version = "HTTP/1.1"
    timeout = IDLE

    def __init__(self, answered: Any, *arguments: Any) -> None:
        self._answered = answered
        super().__init__(*arguments)

    def do_GET(self) -> None:
        self._write(self._answered("GET", self.path, b""))

    def do_POST(self) -> None:
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdecimal() and int(length) <= LARGEST):
            self.close_connection = True
            self._write(_problem(HTTPStatus.BAD_REQUEST, f"an order has a Content-Length of up to {LARGEST} bytes"))
            return
        self._write(self._answered("POST", self.path, self.rfile.read(int(length))))

    def _write(self, answer: Answer) -> None:
        status, body = answer
        self.send_response(status)
        if status != HTTPStatus.NO_CONTENT:
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *values: Any) -> None:  # noqa: A002 - the name of the library
        """Log nothing: devices are asked twice a second."""
