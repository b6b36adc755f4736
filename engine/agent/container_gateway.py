"""The gate of a machine: through it, and only through it, its containers reach the stores and the fabric.

A container says who it is once, with the secret it was launched with. From then on what it asks for is done in the
name of its user and robot: it cannot name another.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

import msgspec

from engine.agent.fleet_topics import Fabric, FleetTopics, scope_of
from engine.agent.plan_service import PlanDesk
from engine.processes.background import Background
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.pending_handshakes import PendingHandshakes
from engine.protocols.robot_link import Refusal
from engine.specs.checkpoints import marks
from engine.specs.containers import ContainerSpec
from ppaas.clock import epoch
from ppaas.errors import NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from storage.ports import Store
from storage.records import CloneCheckpoint

logger = logging.getLogger(__name__)

ATTACH_TIMEOUT = 5.0
MAX_REQUESTS = 16
"""Requests of one container to the stores that may be under way."""

Stream = FrameStream[machine_link.FromContainer]


Prepare = Callable[[str], Awaitable[None]]
"""Puts what a planner, by its name, prepares of a map beside the layers of that map."""


class _Expected(NamedTuple):
    spec: ContainerSpec
    prepare: Prepare


async def _nothing_to_prepare(planner: str) -> None:
    raise Unavailable(f"the machine prepares nothing for {planner!r}")


class _Guest:
    """A container that was let in."""

    def __init__(self, expected: _Expected, stream: Stream) -> None:
        self.spec = spec = expected.spec
        self.prepare = expected.prepare
        self.stream = stream
        self.scope = scope_of(spec)
        self.turn = asyncio.Lock()
        self.requests = 0
        self.was_refused = False
        self.is_shut = False


class Gate:
    """Serves the machine links of this machine's containers.

    Parameters
    ----------
    path : Path
        Of the socket; only this user may connect to it.
    store : Store
        Where checkpoints and plans are kept.
    fabric : Fabric
        Where positions are shared.
    cloud : str
        Name of the cloud process whose machine this is.
    link : str
        What the way from this machine to the store is called in the history.
    acts : callable
        Tells whether this machine acts for its cloud now: else it keeps no checkpoint, for another may have made later
        ones, and robots of others hear nothing of its own.
    attach_timeout : float
        Seconds that whoever dials has to say who it is.
    """

    def __init__(
        self,
        path: Path,
        store: Store,
        fabric: Fabric,
        cloud: str = "",
        *,
        link: str = "machine",
        acts: Callable[[], bool] = lambda: True,
        attach_timeout: float = ATTACH_TIMEOUT,
    ) -> None:
        self.path = path
        self._store = store
        self._plans = PlanDesk(store, link)
        self._topics = FleetTopics(fabric)
        self.cloud = cloud
        self._acts = acts
        self._attach_timeout = attach_timeout
        self._awaited: PendingHandshakes[_Expected] = PendingHandshakes()
        self._streams: set[Stream] = set()
        self._guests: dict[str, _Guest] = {}
        self._background = Background()
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Listen."""
        self._server = await asyncio.start_unix_server(self._connected, self.path)
        self.path.chmod(0o600)

    def expect(self, spec: ContainerSpec, secret: str, prepare: Prepare = _nothing_to_prepare) -> None:
        """Await a container, once; ``prepare`` is for the map that it stands in."""
        self._awaited.expect(spec.id, secret, _Expected(spec, prepare))

    def forget(self, container: str) -> None:
        """Await it no more."""
        self._awaited.forget(container)

    def shut_out(self, container: str) -> None:
        """Do nothing more for a container, which is to end."""
        self.forget(container)
        guest = self._guests.get(container)
        if guest is not None:
            guest.is_shut = True

    def resized(self, container: str, threads: int) -> None:
        """Tell a container how many threads its kernels may use from now on; nothing happens where it is gone."""
        guest = self._guests.get(container)
        if guest is not None:
            guest.stream.write(machine_link.Resized(threads))

    def endpoint_came(self) -> None:
        """Tell all containers but those that are to end that an endpoint awaits them."""
        for guest in self._guests.values():
            if not guest.is_shut:
                guest.stream.write(machine_link.EndpointCame())

    @property
    def awaited(self) -> int:
        """How many containers have not dialled yet."""
        return len(self._awaited)

    async def close(self) -> None:
        """Hang up on all containers and listen no more."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        await self._background.join()
        self.path.unlink(missing_ok=True)

    # -- one container -------------------------------------------------------------------------------------------------

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: Stream = FrameStream(reader, writer, machine_link.FromContainer)
        self._streams.add(stream)
        try:
            await self._serve(await self._admitted(stream))
        except (PPaaSError, TimeoutError) as error:
            logger.warning("a container was cut off at the gate: %s", error or "it said nothing")
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def _admitted(self, stream: Stream) -> _Guest:
        async with asyncio.timeout(self._attach_timeout):
            attach = await stream.receive()
        if not isinstance(attach, machine_link.Attach):
            raise NotPermitted("it did not say who it is")
        return _Guest(self._awaited.admit(attach.container, attach.secret), stream)

    async def _serve(self, guest: _Guest) -> None:
        subscriptions = self._topics.hear_others(guest.scope, guest.stream)
        self._guests[guest.spec.id] = guest
        try:
            while (frame := await guest.stream.receive()) is not None:
                self._take(frame, guest)
        finally:
            del self._guests[guest.spec.id]
            for subscription in subscriptions:
                subscription.close()

    def _take(self, frame: machine_link.FromContainer, guest: _Guest) -> None:
        match frame:
            case machine_link.SaveClone():
                self._ask(frame.request, guest, _in_turn(guest, lambda: self._save_clone(guest, frame.nodes)))
            case machine_link.KeepPlan():
                self._ask(frame.request, guest, _in_turn(guest, lambda: self._plans.keep(guest.spec, frame.plan)))
            case machine_link.FindPlans():
                self._ask(frame.request, guest, lambda: asyncio.to_thread(self._find_plans, guest.spec, frame))
            case machine_link.AskHistory():
                self._ask(frame.request, guest, lambda: asyncio.to_thread(self._plans.history, guest.spec))
            case machine_link.NoteHistory():
                self._note_history(frame, guest)
            case machine_link.PrepareIndex():
                self._ask(frame.request, guest, lambda: guest.prepare(frame.planner))
            case machine_link.Share():
                self._share(frame, guest)
            case machine_link.Attach():
                raise NotPermitted(f"container {guest.spec.id} wants to be another")

    # -- the stores ----------------------------------------------------------------------------------------------------

    def _ask(self, request: int, guest: _Guest, work: Callable[[], Awaitable[machine_link.Answer | None]]) -> None:
        if guest.requests >= MAX_REQUESTS:
            error = QuotaExceeded(f"{MAX_REQUESTS} requests of this container are under way: wait for their answers")
            guest.stream.write(machine_link.Done(request, Refusal(error.slug, str(error))))
            return
        guest.requests += 1
        self._background.run(self._answer(request, guest, work))

    async def _answer(
        self, request: int, guest: _Guest, work: Callable[[], Awaitable[machine_link.Answer | None]]
    ) -> None:
        refusal = answer = None
        try:
            answer = await work()
        except PPaaSError as error:
            refusal = Refusal(error.slug, str(error))
        except Exception as error:
            logger.exception("a request of container %s failed", guest.spec.id)
            refusal = Refusal(PPaaSError.slug, f"internal error: {type(error).__name__}")
        finally:
            guest.requests -= 1
        guest.stream.write(
            machine_link.Done(request, refusal) if answer is None else msgspec.structs.replace(answer, request=request)
        )

    def _save_clone(self, guest: _Guest, nodes: dict[str, bytes]) -> None:
        spec = guest.spec
        if spec.robot is None:
            raise NotPermitted("a container that only plans has no clone")
        if guest.is_shut or not self._acts():
            raise Unavailable("this machine has not heard from its cloud: the robot may be served by another by now")
        marked = nodes | marks(spec, self.cloud)
        self._store.save_clone(CloneCheckpoint(spec.user, spec.robot.id, marked, epoch()))

    def _find_plans(self, spec: ContainerSpec, asked: machine_link.FindPlans) -> machine_link.PlansFound:
        return machine_link.PlansFound(asked.request, self._plans.find(spec, asked))

    def _note_history(self, frame: machine_link.NoteHistory, guest: _Guest) -> None:
        self._background.run(self._noted(frame, guest))

    async def _noted(self, frame: machine_link.NoteHistory, guest: _Guest) -> None:
        """Nobody waits for an answer to a note: one that is lost is told in the log."""
        try:
            async with guest.turn:
                await asyncio.to_thread(self._plans.note, guest.spec, frame.rows, frame.link)
        except PPaaSError as error:
            logger.warning("container %s: what it planned is not in the history: %s", guest.spec.id, error)

    # -- the fabric ----------------------------------------------------------------------------------------------------

    def _share(self, frame: machine_link.Share, guest: _Guest) -> None:
        if guest.is_shut or not self._acts():
            return
        try:
            self._topics.share(guest.scope, frame)
        except PPaaSError as error:
            # Nobody waits for an answer to a share, and the container has more to do: it is served on.
            level = logging.DEBUG if guest.was_refused else logging.WARNING
            logger.log(level, "container %s may not share this: %s", guest.spec.id, error)
            guest.was_refused = True


def _in_turn(guest: _Guest, work: Callable[[], None]) -> Callable[[], Awaitable[None]]:
    """Let work wait for what its container asked for before: else an older checkpoint might be kept over a newer."""

    async def run() -> None:
        async with guest.turn:
            await asyncio.to_thread(work)

    return run
