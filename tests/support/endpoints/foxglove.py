"""Viewer of Foxglove without a socket, at places whose containers the test plays."""

import asyncio
import json
import struct
from typing import Any

from endpoints.foxglove.viewer import Viewer, ViewerLogin, ViewerRequests
from endpoints.resources.services import Services
from tests.support.endpoints.rapyuta import StillSessions
from tests.support.network.still_socket import BINARY, sent


class StillViewer:
    """Viewer without a socket.

    Attributes
    ----------
    channels : dict
        Ids of its channels by topic.
    statuses : list of str
    answers : list of dict
        Other operations that it received.
    messages : list
        Subscriptions and contents of the messages that it received.
    """

    def __init__(self, services: Services, sessions: StillSessions, token: str, *named: str) -> None:
        self.viewer = Viewer(services, sessions, ViewerLogin("ann", token, named), _answers)  # type: ignore[arg-type]
        self.requests = ViewerRequests(self.viewer)
        self.channels: dict[str, int] = {}
        self.statuses: list[str] = []
        self.answers: list[dict[str, Any]] = []
        self.messages: list[tuple[int, bytes]] = []
        self.services: dict[str, int] = {}

    async def look(self) -> None:
        """Look at the robots once, and read what comes."""
        await asyncio.gather(self.requests.refresh(), self.read_soon())
        self.read()

    async def read_soon(self) -> None:
        """Read while the viewer waits for that."""
        for _ in range(20):
            await asyncio.sleep(0.005)
            self.read()
            self.viewer.flush()

    def say(self, op: str, **fields: Any) -> None:
        """Send an operation, and read what comes at once."""
        self.requests.take(json.dumps({"op": op} | fields))
        self.read()

    def send(self, frame: bytes) -> None:
        """Send a binary frame, and read what comes at once."""
        self.requests.take(frame)
        self.read()

    def subscribe(self, topic: str, subscription: int = 1) -> None:
        """Subscribe to a channel by its topic."""
        self.say("subscribe", subscriptions=[{"id": subscription, "channelId": self.channels[topic]}])

    def advertise(self, topic: str, schema: str, encoding: str = "json", channel: int = 1) -> None:
        """Advertise a channel of the viewer."""
        described = {"id": channel, "topic": topic, "encoding": encoding, "schemaName": schema}
        self.say("advertise", channels=[described])

    def publish(self, data: bytes, channel: int = 1) -> None:
        """Publish a message on a channel of the viewer."""
        self.send(struct.pack("<BI", 1, channel) + data)

    def call(self, service: str, payload: bytes, encoding: bytes = b"json") -> None:
        """Call a service by its name, as call 9."""
        self.send(struct.pack("<BIII", 2, self.services.get(service, 0), 9, len(encoding)) + encoding + payload)

    def read(self) -> None:
        """Read all frames that wait."""
        for frame in sent(self.viewer.outbox):
            if frame.startswith("{"):
                self._take(json.loads(frame))
                continue
            data = frame.encode(errors=BINARY)
            if data[0] == 1:
                self.messages.append((struct.unpack_from("<I", data, 1)[0], data[13:]))
            elif data[0] == 3:
                self.answers.append({"op": "serviceCallResponse", "data": json.loads(data[13 + 4 :])})

    def _take(self, operation: dict[str, Any]) -> None:
        match operation["op"]:
            case "advertise":
                self.channels |= {channel["topic"]: channel["id"] for channel in operation["channels"]}
            case "unadvertise":
                closed = set(operation["channelIds"])
                self.channels = {topic: number for topic, number in self.channels.items() if number not in closed}
            case "advertiseServices":
                self.services |= {service["name"]: service["id"] for service in operation["services"]}
            case "status":
                self.statuses.append(operation["message"])
            case _:
                self.answers.append(operation)


async def _answers(_timeout: float) -> bool:
    return True
