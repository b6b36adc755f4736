"""Container gateway: the only connection of a machine's containers to the stores and the fabric.

A container identifies itself once, with the secret that it was launched with. All its later requests act for the user
and robot of that container; a request cannot name others.
"""

import asyncio
import logging
from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec

from engine.agent.fleet_topics import FleetTopics, TopicFabric, heard_by, scope_of
from engine.agent.kernel_service import KernelService, nothing_to_compile
from engine.agent.store_requests import CloneService, PlanService
from engine.processes.background import Background
from engine.processes.occasional_log import OccasionalLog
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import PendingHandshakes, is_same
from engine.protocols.refusals import Refusal, error_of, refusal_of
from engine.protocols.versions import agree
from engine.recorder.recorder_process import NO_RECORDER, Recordings
from engine.specs.containers import ContainerSpec
from engine.specs.work_counts import add_counts
from engine.tracing.recording import pass_on
from ppaas.errors import Conflict, NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from ppaas.tracing.spans import within
from storage.ports import Store

logger = logging.getLogger(__name__)

ATTACH_TIMEOUT = 5.0
"""Time within which a container must identify itself [s]."""

FOLLOW_TIMEOUT = 10.0
"""Time limit for a container to go on with other layers [s]; a frozen one is replaced before."""

MAX_REQUESTS = 16
"""Largest number of store requests of one container in progress at once."""

Stream = FrameStream[machine_link.FromContainer]

Prepare = Callable[[str], Awaitable[None]]
"""Makes the index of the planner with the given name, in the folder with the layers of the container's map."""


class _Expected(NamedTuple):
    spec: ContainerSpec
    secret: str
    prepare: Prepare


async def _nothing_to_prepare(planner: str) -> None:
    raise Unavailable(f"this machine makes no index for planner {planner!r}")


class _AttachedContainer:
    def __init__(self, expected: _Expected, stream: Stream) -> None:
        self.spec = spec = expected.spec
        self.secret = expected.secret
        self.prepare = expected.prepare
        self.stream = stream
        self.scope = scope_of(spec)
        self.heard = heard_by(spec)
        self.turn = asyncio.Lock()
        self.requests = 0
        self.following: asyncio.Future[None] | None = None
        self.following_spec = self.spec
        self.was_refused = False
        self.is_shut = False


class ContainerGateway:
    """Server of the machine links of this machine's containers; ``work`` is what all of them have done so far.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only the user of this process may connect to it.
    store : Store
        Store of checkpoints and plans.
    fabric : TopicFabric
        Session on the fabric, over which robots share positions.
    cloud : str
        Name of the cloud process that this machine belongs to.
    link : str
        Name of the network link from this machine to the store, in the history of planning.
    acts : callable
        Returns whether this machine acts for its cloud now. While it does not, the gateway stores no checkpoint, since
        another machine may have stored later ones, and publishes nothing on the fabric.
    may_be_replaced : callable
        Returns whether another machine may run the robots' next containers, when this one does not act.
    recordings : Recordings
        Recorder of the machine.
    kernels : KernelService, optional
        Kernels of the machine; all are compiled by default.
    attach_timeout : float
        Time within which a connecting container must identify itself [s].
    """

    def __init__(
        self,
        path: Path,
        store: Store,
        fabric: TopicFabric,
        cloud: str = "",
        *,
        link: str = "machine",
        acts: Callable[[], bool] = lambda: True,
        may_be_replaced: Callable[[], bool] = lambda: True,
        recordings: Recordings = NO_RECORDER,
        kernels: KernelService | None = None,
        attach_timeout: float = ATTACH_TIMEOUT,
    ) -> None:
        self.path = path
        self._clones = CloneService(store)
        self._plans = PlanService(store, link)
        self._topics = FleetTopics(fabric)
        self._recordings, self.kernels = recordings, kernels or nothing_to_compile()
        self.cloud = cloud
        self._acts = acts
        self._may_be_replaced = may_be_replaced
        self._attach_timeout = attach_timeout
        self._awaited: PendingHandshakes[_Expected] = PendingHandshakes()
        self._streams: set[Stream] = set()
        self._attached: dict[str, _AttachedContainer] = {}
        self._arrived = asyncio.Event()
        self._background = Background()
        self._unnoted = OccasionalLog(logger)
        self.work: Counter[str] = Counter()
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await asyncio.start_unix_server(self._connected, self.path)
        self.path.chmod(0o600)

    def expect(self, spec: ContainerSpec, secret: str, prepare: Prepare = _nothing_to_prepare) -> None:
        """Accept one connection of a container, by its secret; ``prepare`` makes the indexes of its map."""
        self._awaited.expect(spec.id, secret, _Expected(spec, secret, prepare))

    def forget(self, container: str) -> None:
        """Stop expecting a container that has not connected yet."""
        self._awaited.forget(container)

    def shut_out(self, container: str) -> None:
        """Execute no more checkpoints and publications of a container that is being stopped."""
        self.forget(container)
        attached = self._attached.get(container)
        if attached is not None:
            attached.is_shut = True

    def resized(self, container: str, threads: int) -> None:
        """Send a container the new number of threads of its kernels; do nothing if it has disconnected."""
        attached = self._attached.get(container)
        if attached is not None:
            attached.stream.write(machine_link.Resized(threads))

    async def until_attached(self, container: str) -> None:
        """Wait until a container has identified itself; cancel it if the container has exited."""
        while container not in self._attached:
            await self._arrived.wait()

    async def use_layers(
        self, spec: ContainerSpec, layers: Path, changes: Sequence[tuple[int, int, int, int]] | None
    ) -> None:
        """Move an attached container to the map versions of a spec; wait until it uses them.

        Its requests act for these versions from its answer on.

        Parameters
        ----------
        spec : ContainerSpec
            Its spec with other versions of map and masks.
        layers : Path
            Folder with their layers.
        changes : sequence of tuple of int, optional
            Rectangles that cover the cells that differ; None if size or origin differ.

        Raises
        ------
        Unavailable
            The container is not attached, or disconnects before its answer.
        PPaaSError
            The container refuses the layers; the reason.
        """
        attached = self._attached.get(spec.id)
        if attached is None:
            raise Unavailable(f"container {spec.id} is not attached")
        masks, in_space = ({}, False) if spec.robot is None else (spec.robot.masks, spec.robot.in_space)
        attached.following_spec = attached.spec.on_maps(spec.map, masks, in_space=in_space)
        attached.following = asyncio.get_running_loop().create_future()
        boxes = None if changes is None else [(one[0], one[1], one[2], one[3]) for one in changes]
        attached.stream.write(machine_link.UseLayers(spec.map, masks, in_space, str(layers), boxes))
        try:
            async with asyncio.timeout(FOLLOW_TIMEOUT):
                await attached.following
        except TimeoutError as error:
            raise Unavailable(f"container {spec.id} did not answer within {FOLLOW_TIMEOUT:g} s") from error
        finally:
            attached.following = None

    @staticmethod
    def _followed(frame: machine_link.MapInUse, attached: _AttachedContainer) -> None:
        waiting = attached.following
        if waiting is None or waiting.done() or frame.map != attached.following_spec.map:
            return
        if frame.refusal is not None:
            waiting.set_exception(error_of(frame.refusal))
            return
        attached.spec = attached.following_spec
        waiting.set_result(None)

    def endpoint_came(self) -> None:
        """Notify all containers, except those being stopped, that an endpoint accepts connections again."""
        for attached in self._attached.values():
            if not attached.is_shut:
                attached.stream.write(machine_link.EndpointCame())

    @property
    def awaited(self) -> int:
        """Number of expected containers that have not connected yet."""
        return len(self._awaited)

    async def close(self) -> None:
        """Stop listening, and close the connections of all containers."""
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
            async with asyncio.timeout(self._attach_timeout):
                first = await stream.receive()
            if isinstance(first, machine_link.Compiling | machine_link.AwaitKernels):
                await self._serve_kernels(first, stream)
            else:
                await self._serve(self._admitted(first, stream))
        except (PPaaSError, TimeoutError) as error:
            logger.warning(
                "the container gateway closed the connection of a container: %s",
                str(error) or "it sent nothing in time",
            )
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def _serve_kernels(self, first: machine_link.Compiling | machine_link.AwaitKernels, stream: Stream) -> None:
        """Serve a connection about kernels; the container need not be attached yet."""
        attached = self._attached.get(first.container)
        if attached is None:
            self._awaited.check(first.container, first.secret)
        elif not is_same(attached.secret, first.secret):
            raise NotPermitted(f"container {first.container} has another secret")
        if isinstance(first, machine_link.Compiling):
            with self.kernels.compiles(first.container):
                await stream.receive()
        else:
            await self.kernels.serve(first, stream)

    def _admitted(self, attach: machine_link.FromContainer | None, stream: Stream) -> _AttachedContainer:
        if not isinstance(attach, machine_link.AttachContainer):
            raise NotPermitted("the first message of a container must be its attach request")
        agree(f"container {attach.container[:64]!r}", "", attach.protocols)
        return _AttachedContainer(self._awaited.admit(attach.container, attach.secret), stream)

    async def _serve(self, attached: _AttachedContainer) -> None:
        subscriptions = self._topics.hear_others(attached.scope, attached.heard, attached.stream)
        self._attached[attached.spec.id] = attached
        self._arrived.set()
        # One event for each arrival: all that wait for a container look again.
        self._arrived = asyncio.Event()
        try:
            while (frame := await attached.stream.receive()) is not None:
                with within(getattr(frame, "trace", "")):
                    self._take(frame, attached)
        finally:
            del self._attached[attached.spec.id]
            self._recordings.left(attached.spec)
            if attached.following is not None and not attached.following.done():
                attached.following.set_exception(Unavailable(f"container {attached.spec.id} has disconnected"))
            for subscription in subscriptions:
                subscription.close()

    def _take(self, frame: machine_link.FromContainer, attached: _AttachedContainer) -> None:
        spec = attached.spec  # as of the frame: the map may be replaced before the request is executed
        match frame:
            case machine_link.SaveClone():
                self._ask(frame.request, attached, _in_turn(attached, lambda: self._save_clone(attached, spec, frame)))
            # Reads need not wait for their turn: only what is stored has an order.
            case machine_link.ReadLog():
                self._ask(frame.request, attached, lambda: asyncio.to_thread(self._clones.log, spec, frame))
            case machine_link.KeepPlan():
                self._ask(frame.request, attached, _in_turn(attached, lambda: self._plans.keep(spec, frame.plan)))
            case machine_link.FindPlans():
                self._ask(frame.request, attached, lambda: asyncio.to_thread(self._find_plans, spec, frame))
            case machine_link.AskHistory():
                self._ask(frame.request, attached, lambda: asyncio.to_thread(self._plans.history, spec))
            case machine_link.PrepareIndex():
                self._ask(frame.request, attached, lambda: attached.prepare(frame.planner))
            case machine_link.AttachContainer() | machine_link.Compiling() | machine_link.AwaitKernels():
                raise NotPermitted(f"container {attached.spec.id} is attached already, and sent another attach request")
            case _:
                self._take_unanswered(frame, attached)

    def _take_unanswered(self, frame: machine_link.Unanswered, attached: _AttachedContainer) -> None:
        match frame:
            case machine_link.NoteHistory():
                self._background.run(self._noted(frame, attached, attached.spec))
            case machine_link.FabricPublish():
                self._share(frame, attached)
            case machine_link.MapInUse():
                self._followed(frame, attached)
            case machine_link.RecordBatch():
                self._recordings.take(attached.spec, frame.batch, attached.stream.write)
            case machine_link.SpansEnded():
                pass_on(attached.spec.id, frame.spans, frame.dropped)

    # -- the stores ----------------------------------------------------------------------------------------------------

    def _ask(
        self, request: int, attached: _AttachedContainer, work: Callable[[], Awaitable[machine_link.Answer | None]]
    ) -> None:
        if attached.requests >= MAX_REQUESTS:
            error = QuotaExceeded(f"{MAX_REQUESTS} requests of this container are in progress: wait for their answers")
            attached.stream.write(machine_link.Done(request, refusal_of(error)))
            return
        attached.requests += 1
        self._background.run(self._answer(request, attached, work))

    async def _answer(
        self, request: int, attached: _AttachedContainer, work: Callable[[], Awaitable[machine_link.Answer | None]]
    ) -> None:
        refusal = answer = None
        try:
            answer = await work()
        except PPaaSError as error:
            refusal = refusal_of(error)
        except Exception as error:
            logger.exception("a request of container %s failed", attached.spec.id)
            refusal = Refusal(PPaaSError.slug, f"internal error: {type(error).__name__}")
        finally:
            attached.requests -= 1
        attached.stream.write(
            machine_link.Done(request, refusal) if answer is None else msgspec.structs.replace(answer, request=request)
        )

    def _save_clone(self, attached: _AttachedContainer, spec: ContainerSpec, frame: machine_link.SaveClone) -> None:
        acts = self._acts()
        if attached.is_shut or (not acts and self._may_be_replaced()):
            raise Conflict("this machine has lost contact with its cloud: another machine may serve the robot now")
        if not acts:
            raise Unavailable("no master leads, since none can use the store: start the store")
        self._clones.save(spec, frame, self.cloud)

    def _find_plans(self, spec: ContainerSpec, asked: machine_link.FindPlans) -> machine_link.PlansFound:
        return machine_link.PlansFound(asked.request, self._plans.find(spec, asked))

    async def _noted(self, frame: machine_link.NoteHistory, attached: _AttachedContainer, spec: ContainerSpec) -> None:
        """Store a note; no client waits for an answer, so a failure is only logged."""
        try:
            add_counts(self.work, frame.counts)
            async with attached.turn:
                await asyncio.to_thread(self._plans.note, spec, frame.rows, frame.link)
        except PPaaSError as error:
            self._unnoted.warning("container %s: its planning times are lost: %s", attached.spec.id, error)

    # -- the fabric ----------------------------------------------------------------------------------------------------

    def _share(self, frame: machine_link.FabricPublish, attached: _AttachedContainer) -> None:
        if attached.is_shut or not self._acts():
            return
        try:
            self._topics.share(attached.scope, frame)
        except PPaaSError as error:
            # A share has no answer, and the container has other work: keep the connection.
            level = logging.DEBUG if attached.was_refused else logging.WARNING
            logger.log(level, "container %s cannot share a message: %s", attached.spec.id, error)
            attached.was_refused = True


def _in_turn(attached: _AttachedContainer, work: Callable[[], None]) -> Callable[[], Awaitable[None]]:
    """Run the work after earlier work of its container, so that an older checkpoint cannot replace a newer one."""

    async def run() -> None:
        async with attached.turn:
            await asyncio.to_thread(work)

    return run
