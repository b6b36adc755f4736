"""Node of ROS 1 on sockets, threads and the XML-RPC of Python: independent of the bridge but for its codec."""

import contextlib
import socket
import struct
import threading
import xmlrpc.client
from collections.abc import Callable
from typing import Any, BinaryIO
from xmlrpc.server import SimpleXMLRPCServer

from benchmarks.bridge.master_stand_in import ThreadedServer
from ppaas.wire.ros import ros_types

TYPES = ros_types("noetic", ros2_times=True)
Message = dict[str, Any]


def pack(fields: dict[str, str]) -> bytes:
    parts = [f"{key}={value}".encode() for key, value in fields.items()]
    return sized(b"".join(map(sized, parts)))


def unpack(data: bytes) -> dict[str, str]:
    fields, start = {}, 0
    while start < len(data):
        (size,) = struct.unpack_from("<I", data, start)
        key, _, value = data[start + 4 : start + 4 + size].partition(b"=")
        fields[key.decode()] = value.decode()
        start += 4 + size
    return fields


def sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def frame(stream: BinaryIO) -> bytes:
    head = stream.read(4)
    data = stream.read(struct.unpack("<I", head)[0]) if len(head) == 4 else b""
    if len(head) < 4 or len(data) < struct.unpack("<I", head)[0]:
        raise ConnectionError("the other side closed the connection")
    return data


class Node:
    """Node that registers at a master.

    Parameters
    ----------
    name : str
        Name of the node, with a leading slash.
    master : str
        URI of the master.
    """

    def __init__(self, name: str, master: str) -> None:
        self.name, self.master = name, xmlrpc.client.ServerProxy(master)
        self._latched: dict[str, bytes | None] = {}
        self._published: dict[str, tuple[str, bool, list[socket.socket]]] = {}
        self._heard: dict[str, tuple[str, Callable[[Message], None]]] = {}
        self._followed: set[tuple[str, str]] = set()
        self._lock = threading.Lock()
        self._sockets: list[socket.socket] = []
        self._data = socket.create_server(("127.0.0.1", 0))
        self._server: SimpleXMLRPCServer = ThreadedServer(("127.0.0.1", 0), logRequests=False)
        self.uri = f"http://127.0.0.1:{self._server.server_address[1]}/"
        port = self._data.getsockname()[1]
        self._server.register_function(lambda *_: [1, "ready", ["TCPROS", "127.0.0.1", port]], "requestTopic")
        self._server.register_function(self._update, "publisherUpdate")
        for work in (lambda: self._server.serve_forever(0.02), self._accept):
            threading.Thread(target=work, daemon=True).start()

    def close(self) -> None:
        """End as a node that is killed: nothing is withdrawn."""
        self._server.shutdown()
        self._server.server_close()
        for one in (self._data, *self._sockets):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    # -- publishing ----------------------------------------------------------------------------------------------------

    def publisher(self, topic: str, kind: str, *, latched: bool = False, md5: str = "") -> Callable[[Message], None]:
        """Publish a topic, whose type is spelled as in ROS 1; return the function that publishes."""
        sockets: list[socket.socket] = []
        self._published[topic] = md5 or TYPES.md5(kind), latched, sockets
        self.master.registerPublisher(self.name, topic, kind, self.uri)

        def publish(message: Message) -> None:
            data = sized(TYPES.encode(kind, message))
            with self._lock:
                self._latched[topic] = data if latched else None
                for one in sockets:
                    with contextlib.suppress(OSError):
                        one.sendall(data)

        return publish

    def _accept(self) -> None:
        while True:
            try:
                one, _ = self._data.accept()
            except OSError:
                return
            self._sockets.append(one)
            threading.Thread(target=self._greet, args=(one,), daemon=True).start()

    def _greet(self, one: socket.socket) -> None:
        wanted = unpack(frame(one.makefile("rb")))
        md5, latched, sockets = self._published[wanted["topic"]]
        if wanted["md5sum"] not in (md5, "*"):
            one.sendall(pack({"error": f"Client wants {wanted['topic']} to have another md5sum"}))
            one.close()
            return
        fields = {"callerid": self.name, "md5sum": md5, "type": wanted["type"], "latching": str(int(latched))}
        with self._lock:
            one.sendall(pack(fields) + (self._latched.get(wanted["topic"]) or b""))
            sockets.append(one)

    # -- subscribing ---------------------------------------------------------------------------------------------------

    def subscribe(self, topic: str, kind: str, heard: Callable[[Message], None]) -> None:
        """Subscribe to a topic; messages arrive in a thread."""
        self._heard[topic] = kind, heard
        _, _, uris = self.master.registerSubscriber(self.name, topic, kind, self.uri)  # type: ignore[misc]
        self._update("", topic, uris)

    def _update(self, _caller: str, topic: str, uris: Any) -> list[Any]:
        for uri in uris:
            if topic in self._heard and (topic, uri) not in self._followed:
                self._followed.add((topic, uri))
                threading.Thread(target=self._receive, args=(topic, uri), daemon=True).start()
        return [1, "taken", 0]

    def _receive(self, topic: str, uri: str) -> None:
        kind, heard = self._heard[topic]
        with contextlib.suppress(OSError):
            one, _ = self.connect(topic, kind, uri)
            stream = one.makefile("rb")
            while True:
                heard(TYPES.decode(kind, frame(stream)))
        self._followed.discard((topic, uri))

    def connect(self, topic: str, kind: str, uri: str, md5: str = "") -> tuple[socket.socket, dict[str, str]]:
        """Connect to a publisher; return the socket, and the header of the publisher."""
        _, _, (_, host, port) = xmlrpc.client.ServerProxy(uri).requestTopic(self.name, topic, [["TCPROS"]])  # type: ignore[misc]
        one = socket.create_connection((host, port), timeout=20.0)
        self._sockets.append(one)
        fields = {"callerid": self.name, "topic": topic, "type": kind, "md5sum": md5 or TYPES.md5(kind)}
        one.sendall(pack(fields))
        head = b""
        while len(head) < 4 or len(head) < 4 + struct.unpack("<I", head[:4])[0]:
            head += one.recv(1) or self._closed()
        return one, unpack(head[4:])

    @staticmethod
    def _closed() -> bytes:
        raise ConnectionError("the publisher closed the connection")

    # -- services ------------------------------------------------------------------------------------------------------

    def call(self, service: str, kind: str, request: Message, md5: str = "") -> Message:
        """Call a service, whose type is spelled as in ROS 2; blocks.

        Raises
        ------
        RuntimeError
            The text of the server's failure.
        """
        _, _, uri = self.master.lookupService(self.name, service)  # type: ignore[misc]
        host, _, port = str(uri).removeprefix("rosrpc://").partition(":")
        with socket.create_connection((host, int(port)), timeout=20.0) as one:
            stream = one.makefile("rb")
            one.sendall(pack({"callerid": self.name, "service": service, "md5sum": md5 or TYPES.md5(kind)}))
            head = unpack(frame(stream))
            if "error" in head:
                raise RuntimeError(head["error"])
            one.sendall(sized(TYPES.encode(f"{kind}_Request", request)))
            done = stream.read(1) == b"\1"
            data = frame(stream)
        if not done:
            raise RuntimeError(data.decode())
        return TYPES.decode(f"{kind}_Response", data)
