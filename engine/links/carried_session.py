"""Carried session: a client's session, as the endpoint of its socket sees it.

The session itself is in the container. The endpoint passes its frames on, and keeps those that the container has not
settled. When the container is lost, the next one gets these, and the client notices only a pause.
"""

import asyncio
import secrets
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Protocol

import msgspec

from engine.links.frame_writer import FrameSink
from engine.processes.background import Background
from engine.protocols.refusals import error_of, refusal_of
from engine.protocols.session_frames import (
    AccessChanged,
    Attach,
    Attached,
    ClientFrame,
    CountPlan,
    Detach,
    Inform,
    NumberedFrame,
    PlanCounted,
    SessionClient,
    SessionOptions,
    SessionOver,
    SessionToContainer,
    Settled,
    SocketFrame,
    SocketReady,
)
from engine.rights.access import Access
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable, rebuild
from ppaas.nodes.topics import policy_of
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.binary.packing import operation_of
from ppaas.wire.resumption import ResumptionPoint
from ppaas.wire.rosbridge import RosbridgeSession


class _Publish(msgspec.Struct):
    op: str = ""
    topic: str = ""


_decoder = msgspec.json.Decoder(_Publish)


def is_stream(frame: NumberedFrame) -> bool:
    """Return whether a frame of a client publishes a message that may be lost.

    The topic may be below a namespace of the robot.
    """
    try:
        read = _decoder.decode(operation_of(frame.content) if frame.binary else frame.content)
    except (PPaaSError, msgspec.DecodeError, UnicodeError):
        return False
    name = read.topic.strip("/")
    return read.op == "publish" and any(policy_of(topic).stream for topic in (name, name.rpartition("/")[2]))


MAX_KEPT = 4000
MAX_KEPT_BYTES = 64 << 20
"""Largest number and total size [bytes] of the frames of a client that are not settled, beside those of streams."""

MAX_UNSENT = 64 << 10
MAX_WAITING = 1 << 20
"""Bytes that wait for a container that is lost, and for one that is slow, above which messages that may be lost are
dropped."""


async def unlimited() -> None:
    """Count no path."""


class Carrier(Protocol):
    """Link to the container of a place."""

    @property
    def waiting(self) -> int:
        """Number of bytes that wait for a slow container."""
        ...

    def carry(self, session: "CarriedSession") -> int:
        """Begin to carry the frames of a session; return the number of its socket."""
        ...

    def drop(self, socket: int) -> None:
        """Carry the frames of a session no longer."""
        ...

    def send(self, frame: SessionToContainer) -> bool:
        """Send a frame to the container; return whether there is one."""
        ...


class CarriedSession:
    """Session of a client, carried by the endpoint of its socket.

    Parameters
    ----------
    place : Carrier
        Link to the container of the place.
    client : SessionClient
        The client.
    options : SessionOptions
        Options of the session.
    access : Access
        Rights of the client.
    resume : ResumptionPoint, optional
        Point at which the client resumes its session.
    count_plan : callable
        Awaited for each path that the client requests; raises if that exceeds the quota.

    Attributes
    ----------
    id : str
        Id of the session.
    resumed : bool
        Whether it was retained from an earlier socket.
    taken : int
        Number of frames of the client that were taken.
    over : Future
        Done once the session has ended; its result is the reason.
    displaced : Future
        Done once another socket took over the session; its result is the reason.
    """

    def __init__(
        self,
        place: Carrier,
        client: SessionClient,
        options: SessionOptions,
        access: Access,
        resume: ResumptionPoint | None = None,
        *,
        count_plan: Callable[[], Awaitable[object]] = unlimited,
    ) -> None:
        self.id = secrets.token_hex(8)
        self.resumed = False
        self.taken = 0
        loop = asyncio.get_running_loop()
        self.over: asyncio.Future[PPaaSError] = loop.create_future()
        self.displaced: asyncio.Future[PPaaSError] = loop.create_future()
        self._place = place
        self._client, self._options, self._access, self._resume = client, options, access, resume
        self._count_plan = count_plan
        self._background = Background()
        self._attached: asyncio.Future[None] = loop.create_future()
        self._carried = False
        self._kept: dict[int, NumberedFrame] = {}
        self._kept_bytes = 0
        self._since = 0
        self._settled_before: set[int] = set()
        self._drop_above = MAX_UNSENT
        self._sent_to_container = 0
        self._sent = 0
        self._sink: FrameSink | None = None
        self._held: deque[bytes] = deque()
        self._told_ready = True
        self._socket = place.carry(self)

    # -- the container -------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        """Attach the socket to the session in the container; called again for each container that replaces another."""
        sent = self._place.send(
            Attach(
                self._socket, self._client, self._options, self._access, self.id,
                None if self._carried else self._resume, self._carried,
                list(self._kept.values()), self._sent_to_container, self._sent + len(self._held),
                self._since, sorted(self._settled_before),
            )
        )  # fmt: skip
        if sent:
            self._sent_to_container = max(self._sent_to_container, self.taken)
            self._told_ready = True

    def begin_without_container(self) -> None:
        """Begin a new session now; the first container of the place gets its frames."""
        self._carried = True

    async def attached(self, timeout: float, why: Callable[[], PPaaSError | None] = lambda: None) -> None:
        """Wait until a container has attached the socket.

        Parameters
        ----------
        timeout : float
            Time limit [s].
        why : callable
            Returns the reason why none has done so in time, if it is known.

        Raises
        ------
        Unavailable
            None has done so in time.
        PPaaSError
            The session has ended; the reason.
        """
        either: set[asyncio.Future[Any]] = {self._attached, self.over}
        await asyncio.wait(either, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
        if self.over.done():
            raise self.over.result()
        if not self._attached.done():
            raise why() or Unavailable(f"no container was ready within {timeout:g} s; try again")

    def note(self, frame: Attached | Settled | SessionOver | CountPlan) -> None:
        """Handle a frame of the container about this session."""
        match frame:
            case Attached():
                self._note_attached(frame)
            case Settled():
                self._settle(frame.numbers)
            case SessionOver():
                reason = error_of(frame.reason)
                if frame.taken_over:
                    self.displace(reason)
                else:
                    self.closed(reason)
            case CountPlan():
                self._background.run(self._answer_count())

    def _note_attached(self, attached: Attached) -> None:
        if not self._carried:
            self.id, self.resumed, self.taken = attached.id, attached.resumed, attached.taken
            self._sent_to_container = self._since = attached.taken
            self._sent = self._resume.received if self._resume is not None and attached.resumed else 0
        self._carried = True
        if not self._attached.done():
            self._attached.set_result(None)

    async def _answer_count(self) -> None:
        refusal = None
        try:
            await self._count_plan()
        except PPaaSError as error:
            refusal = refusal_of(error)
        self._place.send(PlanCounted(self._socket, refusal))

    # -- frames of the client ------------------------------------------------------------------------------------------

    def take(self, content: bytes, *, binary: bool = False) -> None:
        """Pass a frame of the client on, text in UTF-8 or binary."""
        self.taken += 1
        frame = NumberedFrame(self.taken, content, binary)
        if self._place.waiting > MAX_WAITING and is_stream(frame):
            return
        self._kept[frame.number] = frame
        self._kept_bytes += len(content)
        if self._carried and self._place.send(ClientFrame(self._socket, frame)):
            self._sent_to_container = frame.number
        elif self._kept_bytes > self._drop_above:
            self._drop_streams()
        if len(self._kept) > MAX_KEPT or self._kept_bytes > MAX_KEPT_BYTES:
            self._check_kept()

    def _drop_streams(self) -> None:
        for number, frame in tuple(self._kept.items()):
            if is_stream(frame):
                self._settle([number])
        self._drop_above = self._kept_bytes + MAX_UNSENT

    def _check_kept(self) -> None:
        self._drop_streams()
        if len(self._kept) > MAX_KEPT or self._kept_bytes > MAX_KEPT_BYTES:
            self.closed(QuotaExceeded(f"{len(self._kept)} messages are not acknowledged yet; wait before sending more"))

    def _settle(self, numbers: list[int] | tuple[int, ...]) -> None:
        for number in numbers:
            frame = self._kept.pop(number, None)
            if frame is not None:
                self._kept_bytes -= len(frame.content)
            elif number <= self._since:
                self._settled_before.add(number)

    @property
    def access(self) -> Access:
        """Rights of the client."""
        return self._access

    @access.setter
    def access(self, access: Access) -> None:
        if access != self._access:
            self._access = access
            self._place.send(AccessChanged(self._socket, access))

    def inform(self, slug: str, text: str) -> None:
        """Send the client a status of level info, if it requested this level; also while there is no container."""
        if self._place.send(Inform(self._socket, slug, text)):
            return
        status = RosbridgeSession(self._options.level).status(rebuild(slug, text), None, "info")
        if status is not None:
            self._held.append(status)
            self.flush()

    # -- frames for the client -----------------------------------------------------------------------------------------

    def connect(self, sink: FrameSink | None) -> None:
        """Send through a connection from now on."""
        self._sink = sink
        self.flush()

    def deliver(self, frame: SocketFrame) -> None:
        """Pass a frame of the container on to the client."""
        if frame.settled:
            self._settle(frame.settled)
        self._held.append(BinaryFrame(frame.content) if frame.binary else frame.content)
        self.flush()

    def flush(self) -> None:
        """Send what waits, and tell the container whether the client reads fast enough."""
        sink = self._sink
        while sink is not None and self._held and sink.ready:
            self._sent += 1
            sink.send_frame(self._held.popleft())
        ready = not self._held
        if ready != self._told_ready:
            self._told_ready = ready
            self._place.send(SocketReady(self._socket, ready))

    # -- the end -------------------------------------------------------------------------------------------------------

    def closed(self, reason: PPaaSError) -> None:
        """End the session for this client."""
        if not self.over.done():
            self.over.set_result(reason)

    def displace(self, reason: PPaaSError) -> None:
        """Note that another socket took over the session."""
        if not self.displaced.done():
            self.displaced.set_result(reason)

    def detach(self, *, for_good: bool) -> None:
        """Detach the socket; the container retains the session for a while, unless the client left for good."""
        self._place.send(Detach(self._socket, for_good))
        self._place.drop(self._socket)
