"""Machine client: the container's end of the machine link."""

import asyncio
import itertools
import logging
from collections.abc import Callable, Sequence
from functools import partial

import msgspec

from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of, refusal_of
from engine.protocols.versions import OWN
from engine.specs.containers import Launch, MapVersion
from ppaas.errors import PPaaSError, Unavailable
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.plans.stored import PlanQuery
from ppaas.tracing.spans import SpanRecord, traceparent
from storage.records import CloneLogChange, PlanRecord

logger = logging.getLogger(__name__)

REQUEST_TIMEOUT = 5.0
"""Time limit of a request [s]."""

HISTORY_TIMEOUT = 0.5
"""Time limit of the request for the planning history [s]: the container is ready otherwise."""

INDEX_TIMEOUT = 600.0
"""Time limit of making an index [s]; a planner that waits for it gives up at its own time limit."""


class MachineClient:
    """Sends requests to the machine's agent, which connects the container to stores and fabric."""

    def __init__(self, stream: FrameStream[machine_link.ToContainer]) -> None:
        self._stream = stream
        self._requests: dict[int, asyncio.Future[machine_link.Answer]] = {}
        self._numbers = itertools.count(1)

    @classmethod
    async def connect(cls, launch: Launch) -> "MachineClient":
        """Connect to the machine, and identify this container with its secret."""
        reader, writer = await asyncio.open_unix_connection(launch.machine)
        client = cls(FrameStream(reader, writer, machine_link.ToContainer))
        client._stream.write(machine_link.AttachContainer(launch.spec.id, launch.secret, OWN))
        return client

    async def serve(
        self,
        shared: Callable[..., None],
        resized: Callable[[int], None] = lambda _: None,
        endpoint_came: Callable[[], None] = lambda: None,
        use_layers: Callable[[machine_link.UseLayers], None] = lambda _: None,
        recorder_told: Callable[[machine_link.RecorderTold], None] = lambda _: None,
    ) -> None:
        """Handle frames until the machine disconnects.

        Parameters
        ----------
        shared : callable
            Called with the messages that other robots share, one or more at a time.
        resized : callable
            Called with the new number of threads of kernels.
        endpoint_came : callable
            Called when an endpoint listens again.
        use_layers : callable
            Called with other layers of the map; it calls ``map_in_use``.
        recorder_told : callable
            Called with the answers of the recorder of the machine.
        """
        while (frame := await self._stream.receive()) is not None:
            match frame:
                case machine_link.Shared():
                    shared(frame)
                case machine_link.SharedBatch():
                    shared(*frame.messages)
                case machine_link.Resized():
                    resized(frame.threads)
                case machine_link.EndpointCame():
                    endpoint_came()
                case machine_link.UseLayers():
                    use_layers(frame)
                case machine_link.RecorderTold():
                    recorder_told(frame)
                case _:
                    self._finish(frame)

    def _finish(self, answer: machine_link.Answer) -> None:
        future = self._requests.pop(answer.request, None)
        if future is None or future.done():
            return
        if isinstance(answer, machine_link.Done) and answer.refusal is not None:
            future.set_exception(error_of(answer.refusal))
        else:
            future.set_result(answer)

    async def _request(self, make: Callable[[int], msgspec.Struct], within: float | None = None) -> machine_link.Answer:
        within = REQUEST_TIMEOUT if within is None else within
        number = next(self._numbers)
        future: asyncio.Future[machine_link.Answer] = asyncio.get_running_loop().create_future()
        self._requests[number] = future
        frame = make(number)
        if (trace := traceparent()) and hasattr(frame, "trace"):
            frame.trace = trace
        self._stream.write(frame)
        try:
            async with asyncio.timeout(within):
                return await future
        except TimeoutError as error:
            raise Unavailable(f"the machine did not answer within {within:g} s") from error
        finally:
            self._requests.pop(number, None)

    async def save_clone(self, nodes: dict[str, bytes], changes: Sequence[CloneLogChange] = ()) -> None:
        """Store the clone's checkpoint, and changes of the logs of its nodes.

        Raises
        ------
        Conflict
            The machine has lost its cloud, or stops this container: another one may serve the robot now.
        Unavailable
            The machine or its store does not answer in time; try again.
        """
        await self._request(lambda number: machine_link.SaveClone(number, nodes, list(changes)))

    async def log(self, node: str) -> list[tuple[int, bytes]]:
        """Return all entries of the log of a node, sorted by number.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time.
        """
        entries: list[tuple[int, bytes]] = []
        while True:
            answer = await self._request(partial(machine_link.ReadLog, node=node, after=_last(entries)))
            if not isinstance(answer, machine_link.LogRead):
                raise Unavailable(f"the machine answered the request for a log with {type(answer).__name__}")
            if not answer.entries:
                return entries
            entries += answer.entries

    async def keep_plan(self, plan: PlanRecord) -> None:
        """Store a plan in the path plan database.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time.
        """
        await self._request(lambda number: machine_link.KeepPlan(number, plan))

    async def find_plans(self, query: PlanQuery) -> list[machine_link.PlanCandidate]:
        """Return stored plans on the container's map that may be reused, best first.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time.
        """
        asked = machine_link.FindPlans(
            0, query.start[:2], query.goal[:2], query.planner, query.parameters, query.robot_radius,
            query.tolerance, query.kinematic,
        )  # fmt: skip
        answer = await self._request(lambda number: msgspec.structs.replace(asked, request=number))
        return answer.plans if isinstance(answer, machine_link.PlansFound) else []

    async def history(self) -> machine_link.PlanningHistory:
        """Return the history of planning on the container's map.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time.
        """
        answer = await self._request(machine_link.AskHistory, HISTORY_TIMEOUT)
        if not isinstance(answer, machine_link.PlanningHistory):
            raise Unavailable(f"the machine answered the request for planning history with {type(answer).__name__}")
        return answer

    def note_history(
        self, rows: list[PlannerHistory], link: LinkHistory | None, counts: dict[str, int] | None = None
    ) -> None:
        """Add to the history of planning and to the counts; there is no answer, and the note may be lost."""
        self._stream.write(machine_link.NoteHistory(rows, link, counts or {}))

    async def prepare_index(self, planner: str) -> None:
        """Make the machine prepare a planner's index of the map, beside its layers; wait until it is done.

        Raises
        ------
        InvalidPlanner
            The planner cannot prepare this map.
        Unavailable
            The machine does not answer in time, or has no space.
        """
        await self._request(lambda number: machine_link.PrepareIndex(number, planner), INDEX_TIMEOUT)

    def map_in_use(self, version: MapVersion, error: PPaaSError | None = None) -> None:
        """Answer that the clone uses a version of its map from now on, or why it does not."""
        self._stream.write(machine_link.MapInUse(version, None if error is None else refusal_of(error)))

    def share(self, topic: str, payload: bytes, addressee: str = "") -> None:
        """Publish a message for the robots on the same map, or for one of them; it may be lost."""
        self._stream.write(machine_link.FabricPublish(topic, payload, addressee))

    def record(self, batch: bytes) -> None:
        """Write a batch to the recordings of the robot; it may be lost."""
        self._stream.write(machine_link.RecordBatch(batch))

    def spans_ended(self, spans: list[SpanRecord], dropped: int) -> None:
        """Hand over spans that have ended, and the number of further ones that were dropped; they may be lost."""
        self._stream.write(machine_link.SpansEnded(spans, dropped))

    @property
    def waiting(self) -> int:
        """Number of written bytes that are still queued for the machine."""
        return self._stream.waiting

    async def close(self) -> None:
        """Close the connection."""
        await self._stream.close()


def _last(entries: Sequence[tuple[int, bytes]]) -> int:
    """Return the number of the last entry; -1 if there is none."""
    return entries[-1][0] if entries else -1
