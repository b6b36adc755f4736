"""Both sides of a place link: a container over a real socket, and a client."""

import asyncio
import socket
from typing import Any

from engine.links.place_link import PlaceLink
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from ppaas.errors import PPaaSError
from tests.support.waiting import patience

TOPICS = [
    robot_link.TopicInfo("map", "nav_msgs/OccupancyGrid", True),
    robot_link.TopicInfo("goal", "std_msgs/String", False),
]
SERVICES = [robot_link.ServiceInfo("make_plan", "nav_msgs/GetPlan")]
NODES = [robot_link.NodeInfo("planner", ("map",), ("goal",), ("make_plan",))]

_opened: list[FrameStream[Any]] = []


class RecordingClient:
    """Client of a place link that records what it receives."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, bytes]] = []
        self.errors: list[PPaaSError] = []
        self.refused_numbers: list[int] = []
        self.calls: list[tuple[int, str, bytes]] = []
        self.reasons: list[PPaaSError] = []
        self.acknowledgements: list[int] = []
        self.news = asyncio.Event()

    def published(self, topic: str, payload: bytes) -> None:
        self.heard.append((topic, payload))
        self.news.set()

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        self.errors.append(error)
        self.refused_numbers.append(sequence)
        self.news.set()

    def requested(self, call: int, service: str, payload: bytes) -> None:
        self.calls.append((call, service, payload))
        self.news.set()

    def acknowledged(self, sequence: int) -> None:
        self.acknowledgements.append(sequence)

    def closed(self, reason: PPaaSError) -> None:
        self.reasons.append(reason)

    async def notified(self) -> None:
        """Wait for the next message, refusal or call."""
        async with patience(5):
            await self.news.wait()
        self.news.clear()


class FakeContainer:
    """The container's end of the link, driven frame by frame."""

    def __init__(self, stream: FrameStream[robot_link.ToContainer], serving: asyncio.Task[None]) -> None:
        self.stream = stream
        self.serving = serving

    @classmethod
    async def dial(cls, place: PlaceLink, name: str, applied: int = 0) -> "FakeContainer":
        """Connect a container to a place link; ``applied`` is the last message in its checkpoint."""
        ours, theirs = socket.socketpair()
        near: FrameStream[robot_link.FromContainer] = FrameStream(
            *await asyncio.open_connection(sock=ours), robot_link.FromContainer
        )
        far: FrameStream[robot_link.ToContainer] = FrameStream(
            *await asyncio.open_connection(sock=theirs), robot_link.ToContainer
        )
        _opened.extend((near, far))
        hello = robot_link.Hello(name, "", 42, applied, TOPICS, SERVICES, NODES)
        return cls(far, asyncio.create_task(place.serve(hello, near)))

    @classmethod
    async def ready(cls, place: PlaceLink, name: str) -> "FakeContainer":
        """Connect a container to a place link, and wait until the place is ready."""
        container = await cls.dial(place, name)
        await place.ready(5)
        return container

    async def next(self) -> robot_link.ToContainer | None:
        """Return the next frame, or None if the place link has closed the connection."""
        async with patience(5):
            return await self.stream.receive()

    async def die(self) -> None:
        """Close the connection, as the exit of the process does."""
        await self.stream.close()
        await self.serving


async def close_links() -> None:
    """Close all connections that were opened by ``FakeContainer.dial``."""
    while _opened:
        await _opened.pop().close()
