"""The container's end of the machine link."""

import asyncio
import itertools
import logging
from collections.abc import Callable

import msgspec

from engine import machine_link
from engine.framing import FrameStream
from engine.model import Launch
from ppaas.errors import Unavailable, rebuild
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

REQUEST_TIMEOUT = 5.0

INDEX_TIMEOUT = 600.0
"""Seconds in which an index must have been made; who waits for it gives up when it has no more time itself."""


class MachineClient:
    """Asks the agent of the machine for what a container may not reach itself."""

    def __init__(self, stream: FrameStream[machine_link.ToContainer]) -> None:
        self._stream = stream
        self._requests: dict[int, asyncio.Future[None]] = {}
        self._numbers = itertools.count(1)

    @classmethod
    async def connect(cls, launch: Launch) -> "MachineClient":
        """Dial the machine and say who we are."""
        reader, writer = await asyncio.open_unix_connection(launch.machine)
        client = cls(FrameStream(reader, writer, machine_link.ToContainer))
        client._stream.write(machine_link.Attach(launch.spec.id, launch.secret))
        return client

    async def serve(self, shared: Callable[[machine_link.Shared], None]) -> None:
        """Take frames until the machine goes; ``shared`` gets what other robots publish."""
        while (frame := await self._stream.receive()) is not None:
            if isinstance(frame, machine_link.Shared):
                shared(frame)
            else:
                self._finish(frame)

    def _finish(self, done: machine_link.Done) -> None:
        future = self._requests.pop(done.request, None)
        if future is None or future.done():
            return
        if done.refusal is None:
            future.set_result(None)
        else:
            future.set_exception(rebuild(done.refusal.slug, done.refusal.text))

    async def _request(self, make: Callable[[int], msgspec.Struct], within: float | None = None) -> None:
        within = REQUEST_TIMEOUT if within is None else within
        number = next(self._numbers)
        future = self._requests[number] = asyncio.get_running_loop().create_future()
        self._stream.write(make(number))
        try:
            async with asyncio.timeout(within):
                await future
        except TimeoutError as error:
            raise Unavailable(f"the machine did not answer within {within:.0f} s") from error
        finally:
            self._requests.pop(number, None)

    async def save_clone(self, nodes: dict[str, bytes]) -> None:
        """Keep the clone's checkpoint.

        Raises
        ------
        Unavailable
            The machine or its store does not answer; try again.
        """
        await self._request(lambda number: machine_link.SaveClone(number, nodes))

    async def keep_plan(self, plan: PlanRecord) -> None:
        """Keep a plan in the path plan database.

        Raises
        ------
        Unavailable
            The machine or its store does not answer.
        """
        await self._request(lambda number: machine_link.KeepPlan(number, plan))

    async def prepare_index(self, planner: str) -> None:
        """Have the machine put what a planner prepares of the map beside its layers, and wait until it is there.

        Raises
        ------
        InvalidPlanner
            The planner cannot prepare this map.
        Unavailable
            The machine does not answer, or has no room.
        """
        await self._request(lambda number: machine_link.PrepareIndex(number, planner), INDEX_TIMEOUT)

    def share(self, topic: str, payload: bytes) -> None:
        """Publish for the robots of the same map; it may be lost."""
        self._stream.write(machine_link.Share(topic, payload))

    async def close(self) -> None:
        """Hang up."""
        await self._stream.close()
