"""Container of a robot with real sessions, whose clone is played by the test."""

import asyncio
from typing import Any, cast

from engine.protocols import control_link, robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.session_frames import SessionToContainer
from engine.sessions.host import SessionHost
from tests.support.endpoints.still_place import StillClone, StillPlace
from tests.support.engine.engine_links import HELLO_TOPICS, dial_link, hello
from tests.support.engine.fake_machine import FakeMachine
from tests.support.waiting import patience

SESSION_FRAMES = SessionToContainer.__args__  # type: ignore[attr-defined]


class _Clone(StillClone):
    """Clone within the container: what sessions give it, the test receives."""

    def __init__(self, received: "asyncio.Queue[robot_link.ToContainer | None]") -> None:
        super().__init__()
        self._received = received

    def topics(self) -> list[robot_link.TopicInfo]:
        return [*HELLO_TOPICS]

    def write(self, frame: robot_link.ToContainer) -> None:
        self._received.put_nowait(frame)


class PlayedStream:
    """Writes frames of the clone to the sessions and to the endpoint."""

    def __init__(self, place: StillPlace, stream: FrameStream[robot_link.ToContainer]) -> None:
        self._place = place
        self._stream = stream

    def write(self, frame: robot_link.FromContainer) -> None:
        """Say something as the clone."""
        self._place.say(frame)
        self._stream.write(frame)

    async def close(self) -> None:
        """Close the link to the endpoint."""
        await self._stream.close()


class PlayedContainer:
    """Container with the sessions of its clients.

    ``next`` returns what its clone receives, of sessions and of the endpoint itself.
    """

    def __init__(
        self,
        order: control_link.StartContainer,
        stream: FrameStream[robot_link.ToContainer],
        *,
        pid: int = 42,
        applied: int = 0,
        sessions: bytes = b"",
    ) -> None:
        self.spec = order.spec
        self._received: asyncio.Queue[robot_link.ToContainer | None] = asyncio.Queue()
        self.place = StillPlace(_Clone(self._received), order.spec.id)
        self.host = SessionHost(self.place)
        if sessions:
            self.host.restore(sessions)
        self.stream = PlayedStream(self.place, stream)
        self.host.link_up(stream)
        stream.write(hello(order.spec.id, order.secret, pid, applied))
        self._serving = asyncio.create_task(self._serve(stream))
        self._attending = asyncio.create_task(self.host.attend())

    async def _serve(self, stream: FrameStream[robot_link.ToContainer]) -> None:
        while (frame := await stream.receive()) is not None:
            if isinstance(frame, SESSION_FRAMES):
                self.host.take(stream, cast(Any, frame))
            else:
                self._received.put_nowait(frame)
            if isinstance(frame, robot_link.Shutdown):
                self.host.close()
        self.host.link_lost(stream)
        self._attending.cancel()
        self.host.close()
        self._received.put_nowait(None)

    async def next(self) -> robot_link.ToContainer | None:
        """Return the next message for the clone, or None once the endpoint has closed the connection."""
        async with patience(10):
            return await self._received.get()

    async def die(self) -> None:
        """Close the link, as the exit of the process does."""
        await self.stream.close()
        await self._serving


class PlayingMachine(FakeMachine):
    """A machine whose containers have real sessions."""

    def __init__(self, stream: FrameStream[control_link.ToAgent]) -> None:
        super().__init__(stream)
        self.containers: list[PlayedContainer] = []

    async def boot(  # type: ignore[override]
        self, order: control_link.StartContainer, pid: int = 42, applied: int = 0, sessions: bytes = b""
    ) -> PlayedContainer:
        """Act as the process of the ordered container; ``sessions`` are those of its checkpoint."""
        self.tell(control_link.Launched(order.spec.id, pid))
        stream = await dial_link(order.link)
        made = PlayedContainer(order, stream, pid=pid, applied=applied, sessions=sessions)
        self.containers.append(made)
        return made

    @property
    def away(self) -> int:
        """Number of detached sessions in all containers."""
        return sum(container.host.away for container in self.containers)
