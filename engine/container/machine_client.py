"""The container's end of the machine link."""

import asyncio
import itertools
import logging
from collections.abc import Callable

import msgspec

from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import Launch
from ppaas.errors import Unavailable, rebuild
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.plans.stored import PlanQuery
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

REQUEST_TIMEOUT = 5.0

HISTORY_TIMEOUT = 0.5
"""Seconds that a container that is otherwise ready waits for the history of planning."""

INDEX_TIMEOUT = 600.0
"""Seconds in which an index must have been made; who waits for it gives up when it has no more time itself."""


class MachineClient:
    """Asks the agent of the machine for what a container may not reach itself."""

    def __init__(self, stream: FrameStream[machine_link.ToContainer]) -> None:
        self._stream = stream
        self._requests: dict[int, asyncio.Future[machine_link.Answer]] = {}
        self._numbers = itertools.count(1)

    @classmethod
    async def connect(cls, launch: Launch) -> "MachineClient":
        """Dial the machine and say who we are."""
        reader, writer = await asyncio.open_unix_connection(launch.machine)
        client = cls(FrameStream(reader, writer, machine_link.ToContainer))
        client._stream.write(machine_link.Attach(launch.spec.id, launch.secret))
        return client

    async def serve(
        self,
        shared: Callable[[machine_link.Shared], None],
        resized: Callable[[int], None] = lambda _: None,
        endpoint_came: Callable[[], None] = lambda: None,
    ) -> None:
        """Take frames until the machine goes.

        Parameters
        ----------
        shared : callable
            Gets what other robots publish.
        resized : callable
            Told how many threads kernels may use from then on.
        endpoint_came : callable
            Told that there is an endpoint again, which awaits this container.
        """
        while (frame := await self._stream.receive()) is not None:
            match frame:
                case machine_link.Shared():
                    shared(frame)
                case machine_link.Resized():
                    resized(frame.threads)
                case machine_link.EndpointCame():
                    endpoint_came()
                case _:
                    self._finish(frame)

    def _finish(self, answer: machine_link.Answer) -> None:
        future = self._requests.pop(answer.request, None)
        if future is None or future.done():
            return
        if isinstance(answer, machine_link.Done) and answer.refusal is not None:
            future.set_exception(rebuild(answer.refusal.slug, answer.refusal.text))
        else:
            future.set_result(answer)

    async def _request(self, make: Callable[[int], msgspec.Struct], within: float | None = None) -> machine_link.Answer:
        within = REQUEST_TIMEOUT if within is None else within
        number = next(self._numbers)
        future: asyncio.Future[machine_link.Answer] = asyncio.get_running_loop().create_future()
        self._requests[number] = future
        self._stream.write(make(number))
        try:
            async with asyncio.timeout(within):
                return await future
        except TimeoutError as error:
            raise Unavailable(f"the machine did not answer within {within:g} s") from error
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

    async def find_plans(self, query: PlanQuery) -> list[machine_link.Candidate]:
        """Return plans on the container's map that are worth a look, the best first.

        Raises
        ------
        Unavailable
            The machine or its store does not answer.
        """
        asked = machine_link.FindPlans(
            0, query.start[:2], query.goal[:2], query.planner, query.parameters, query.robot_radius,
            query.tolerance, query.kinematic,
        )  # fmt: skip
        answer = await self._request(lambda number: msgspec.structs.replace(asked, request=number))
        return answer.plans if isinstance(answer, machine_link.PlansFound) else []

    async def history(self) -> machine_link.PlanningHistory:
        """Return what is known of planning on the container's map.

        Raises
        ------
        Unavailable
            The machine or its store does not answer.
        """
        answer = await self._request(machine_link.AskHistory, HISTORY_TIMEOUT)
        if not isinstance(answer, machine_link.PlanningHistory):
            raise Unavailable("the machine answered something else")
        return answer

    def note_history(self, rows: list[PlannerHistory], link: LinkHistory | None) -> None:
        """Add to the history; it may be lost."""
        self._stream.write(machine_link.NoteHistory(rows, link))

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
