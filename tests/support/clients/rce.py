"""Robot of 2013: client of the RoboEarth Cloud Engine, written from its protocol and for Python 3.

The client of 2013 is for Python 2 and cannot run here. What this one sends and takes is what that one does: see
``rce/comm/client.py`` and ``rce/comm/assembler.py`` of ``rapyuta/rce``, of which nothing is copied.
"""

import asyncio
import hashlib
import itertools
import json
import urllib.error
import urllib.parse
import urllib.request
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

VERSION = "20130902"


def robot_url(master: str, user: str, version: str = VERSION) -> dict[str, str]:
    """Return the master's answer; raises `urllib.error.HTTPError`."""
    query = urllib.parse.urlencode((("userID", user), ("version", version)))
    with urllib.request.urlopen(f"{master}?{query}", timeout=10) as answer:
        assert answer.headers.get_content_type() == "application/json"
        found: dict[str, str] = json.loads(answer.read())
    return found


def login_query(user: str, robot: str, password: str) -> str:
    """Return the query with which a robot logs in."""
    digest = hashlib.sha256(password.encode()).hexdigest()
    return urllib.parse.urlencode((("userID", user), ("robotID", robot), ("password", digest)))


Receive = Callable[[str, str, Any], None]
"""Called with the class of a message, its id and the message."""


@dataclass
class RceRobot:
    """Connected robot of 2013."""

    socket: ClientConnection
    errors: list[str] = field(default_factory=list)
    statuses: list[tuple[str, bool]] = field(default_factory=list)
    received: list[dict[str, Any]] = field(default_factory=list)
    _receivers: dict[str, Receive] = field(default_factory=dict)
    _waiting: dict[str, tuple[dict[str, Any], Any, Any]] = field(default_factory=dict)
    _numbers: "itertools.count[int]" = field(default_factory=itertools.count)

    # -- what the client of 2013 offers --------------------------------------------------------------------------------

    async def create_container(self, tag: str) -> None:
        await self._send("CC", {"containerTag": tag})

    async def destroy_container(self, tag: str) -> None:
        await self._send("DC", {"containerTag": tag})

    async def add_node(self, container: str, tag: str, pkg: str, exe: str, args: str = "", name: str = "") -> None:
        given = {"args": args, "name": name}
        node = {"containerTag": container, "nodeTag": tag, "pkg": pkg, "exe": exe}
        await self._send("CN", {"addNodes": [node | {key: value for key, value in given.items() if value}]})

    async def remove_node(self, container: str, tag: str) -> None:
        await self._send("CN", {"removeNodes": [{"containerTag": container, "nodeTag": tag}]})

    async def add_parameter(self, container: str, name: str, value: Any) -> None:
        await self._send("CN", {"setParam": [{"containerTag": container, "name": name, "value": value}]})

    async def remove_parameter(self, container: str, name: str) -> None:
        await self._send("CN", {"deleteParam": [{"containerTag": container, "name": name}]})

    async def add_interface(self, endpoint: str, tag: str, kind: str, cls: str, addr: str = "") -> None:
        interface = {"endpointTag": endpoint, "interfaceTag": tag, "interfaceType": kind, "className": cls}
        await self._send("CN", {"addInterfaces": [interface | ({"addr": addr} if addr else {})]})

    async def remove_interface(self, endpoint: str, tag: str) -> None:
        await self._send("CN", {"removeInterfaces": [{"endpointTag": endpoint, "interfaceTag": tag}]})

    async def add_connection(self, one: str, other: str) -> None:
        await self._send("CX", {"connect": [{"tagA": one, "tagB": other}]})

    async def remove_connection(self, one: str, other: str) -> None:
        await self._send("CX", {"disconnect": [{"tagA": one, "tagB": other}]})

    async def send(self, interface: str, cls: str, message: Any, message_id: str = "") -> str:
        """Send a message; ``bytes`` in it are binary parts. Return its id."""
        message_id = message_id or f"m{next(self._numbers)}"
        await self._send("DM", {"iTag": interface, "type": cls, "msgID": message_id, "msg": message})
        return message_id

    def on(self, interface: str, receive: Receive) -> None:
        """Call ``receive`` with the messages of an interface."""
        self._receivers[interface] = receive

    # -- frames --------------------------------------------------------------------------------------------------------

    async def _send(self, kind: str, data: dict[str, Any]) -> None:
        parts: list[bytes] = []
        await self.socket.send(json.dumps({"type": kind, "data": _without_parts(data, parts)}))
        for part in parts:
            await self.socket.send(part)

    async def run(self) -> None:
        """Take frames until the connection ends."""
        async for frame in self.socket:
            if isinstance(frame, bytes):
                uid, data = frame[:32].decode("ascii"), frame[32:]
                message, container, key = self._waiting.pop(uid)
                container[key] = data
                if not any(waiting is message for waiting, _, _ in self._waiting.values()):
                    self._take(message)
                continue
            message = json.loads(frame)
            references = list(_references(message))
            for uid, container, key in references:
                self._waiting[uid] = message, container, key
            if not references:
                self._take(message)

    def _take(self, message: dict[str, Any]) -> None:
        self.received.append(message)
        assert message.keys() == {"type", "data"}, message
        data = message["data"]
        match message["type"]:
            case "ER":
                assert isinstance(data, str), message
                self.errors.append(data)
            case "ST":
                assert data.keys() == {"topic", "iTag", "status"} and data["topic"] == "iu", message
                self.statuses.append((data["iTag"], data["status"]))
            case "DM":
                assert data.keys() == {"iTag", "type", "msgID", "msg"} and len(data["msgID"]) <= 255, message
                self._receivers.get(data["iTag"], lambda *_: None)(data["type"], data["msgID"], data["msg"])
            case kind:
                raise AssertionError(f"a robot of 2013 does not know the type {kind!r}")


def _without_parts(value: dict[str, Any], parts: list[bytes]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, item in value.items():
        if isinstance(item, bytes):
            uid = uuid.uuid4().hex
            parts.append(uid.encode() + item)
            found[f"{key}*"] = uid
        else:
            found[key] = _without_parts(item, parts) if isinstance(item, dict) else item
    return found


def _references(value: dict[str, Any]) -> list[tuple[str, Any, Any]]:
    found: list[tuple[str, Any, Any]] = []
    for key in list(value):
        if key.endswith("*"):
            uid = value.pop(key)
            assert isinstance(uid, str) and len(uid) == 32
            found.append((uid, value, key[:-1]))
        elif isinstance(value[key], dict):
            found += _references(value[key])
    return found


@asynccontextmanager
async def rce_robot(master: str, user: str, robot: str, password: str) -> AsyncIterator[RceRobot]:
    """Connect a robot by its master, as the client of 2013 does."""
    url = (await asyncio.to_thread(robot_url, master, user))["url"]
    async with connect(f"{url}?{login_query(user, robot, password)}", max_size=None, open_timeout=30) as socket:
        client = RceRobot(socket)
        running = asyncio.create_task(client.run())
        try:
            yield client
        finally:
            running.cancel()
            outcome = (await asyncio.gather(running, return_exceptions=True))[0]
            if isinstance(outcome, Exception) and not isinstance(outcome, ConnectionClosed):
                raise outcome
