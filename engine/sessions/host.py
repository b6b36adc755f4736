"""Sessions of the clients of a place, retained beyond their sockets, and the sockets at endpoints that carry them.

A named session outlives its sockets. Its subscriptions, waiting frames and pending requests are retained for some time
after the socket closed or its endpoint was lost, and passed to the next socket that names the session, at whatever
endpoint. A socket that names an attached session takes it over: the client knows best whether its old socket is dead.
"""

import asyncio
import logging
from collections.abc import Iterator

import msgspec

from engine.links.shared_place import Listener
from engine.protocols.refusals import error_of, refusal_of
from engine.protocols.session_frames import (
    AccessChanged,
    Attach,
    Attached,
    ClientFrame,
    ClientOffers,
    CountPlan,
    Detach,
    Inform,
    NumberedFrame,
    PlanCounted,
    RoundTrip,
    SessionClient,
    SessionOptions,
    SessionOver,
    SessionToContainer,
    Settled,
    SocketReady,
)
from engine.rights.access import Access
from engine.sessions.namespaces import scope_of
from engine.sessions.outbox import EndpointEnd, SocketSink
from engine.sessions.place.clone import Clone
from engine.sessions.place.place import Place
from engine.sessions.session import ClientSession, PlanPermits
from engine.sessions.unsettled import Replay, UnsettledFrames
from ppaas.errors import Conflict, PPaaSError
from ppaas.listener_faults import ListenerFaults
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Bool
from ppaas.wire.binary.packing import Packer
from ppaas.wire.own_topics import OWN_TOPICS, PRESENCE
from ppaas.wire.ros.serialization import serialize
from ppaas.wire.rosbridge import RosbridgeSession

logger = logging.getLogger(__name__)

MAX_AWAY = 64
"""Largest number of detached sessions of one user; the oldest detached session is evicted first."""

ATTEND_PERIOD = 0.1
"""Interval at which endpoints are told what clients offer, if that has changed, and at which outboxes are flushed whose
link to an endpoint was slow [s]."""

RETURN = 10.0
"""Time for which a session without a name is known after its container was replaced [s]: its endpoint attaches it."""

ITSELF = 0
"""Number of the session host among the clients of its place, which count from 1."""

Socket = tuple[EndpointEnd, int]
"""Socket of a client: the link to its endpoint, and its number there."""


REPORT_PERIOD = 0.1
"""Longest time until a settled frame is reported to the endpoint that keeps it [s]."""


class SessionRecord(msgspec.Struct, frozen=True):
    """Session in a checkpoint: the frames that set it up, or that are not answered.

    ``taken`` is the number of the last frame of the client that was executed before the checkpoint, ``sent`` the number
    of frames that the client was sent.
    """

    id: str
    client: SessionClient
    options: SessionOptions
    access: Access
    taken: int
    frames: list[NumberedFrame]
    sent: int = 0


_decoder = msgspec.json.Decoder(list[SessionRecord])


class RetainedSession:
    """Session that outlives its sockets.

    Parameters
    ----------
    place : Place
        Place of the robot.
    attach : Attach
        First request for it.

    Attributes
    ----------
    taken : int
        Number of the last frame of the client that was taken.
    sent_before : int
        Number of frames that the client was sent by earlier containers; those are not kept.
    sink : SocketSink, optional
        The current socket.
    """

    def __init__(self, place: Place, attach: Attach) -> None:
        self.id, self.client, self.options = attach.id, attach.client, attach.options
        self.taken = 0
        self.sent_before = attach.sent
        self.ended = False
        self.sink: SocketSink | None = None
        self.expiry: asyncio.TimerHandle | None = None
        self._permits = PlanPermits()
        self._reporting: asyncio.TimerHandle | None = None
        self.unsettled = UnsettledFrames(self._report_later)
        options = attach.options
        packer = Packer(compact=options.compact, png=options.png, serialize=serialize)
        wire = RosbridgeSession(options.level, scope_of(attach.client.robot, options.namespace), packer)
        self.session = ClientSession(
            place, attach.client.role, wire, attach.client.title, self._permits.take,
            access=attach.access, user=attach.client.user, identity=f"goal-{self.id}", unsettled=self.unsettled,
            ask=self.ask_permit,
        )  # fmt: skip
        self.session.outbox.repeats = options.counts
        self.session.over.add_done_callback(lambda over: self._tell_over(over.result()))

    def record(self) -> SessionRecord:
        """Return the session as a checkpoint has it."""
        waiting = self.session.waiting()
        executed = waiting[0].number - 1 if waiting else self.taken
        frames = {frame.number: frame for frame in (*self.unsettled.frames(), *waiting)}
        return SessionRecord(
            self.id, self.client, self.options, self.session.access, executed,
            [frames[number] for number in sorted(frames)], self.session.outbox.count,
        )  # fmt: skip

    # -- frames of the client ------------------------------------------------------------------------------------------

    def take(self, frame: NumberedFrame) -> None:
        """Execute a frame, unless it was taken before."""
        if frame.number > self.taken:
            self.taken = frame.number
            self.session.serve(frame)

    def replay(self, frame: NumberedFrame, replay: Replay) -> None:
        """Execute a frame that an earlier container got."""
        self.taken = max(self.taken, frame.number)
        self.session.serve(frame, replay)

    def continue_with(self, attach: Attach) -> list[int]:
        """Go on after the link to the endpoint was lost; return the frames that it keeps and that are settled."""
        self.session.outbox.resume(attach.sent)
        pending = {frame.number for frame in self.record().frames}
        taken = [frame.number for frame in attach.kept if frame.number <= self.taken]
        for frame in attach.kept:
            self.take(frame)
        return [number for number in taken if number not in pending]

    # -- permits -------------------------------------------------------------------------------------------------------

    def ask_permit(self) -> None:
        """Ask the endpoint whether the path that is requested is within the quota; a later one if there is none now."""
        if self.sink is not None:
            self.sink.link.write(CountPlan(self.sink.socket))

    def permit(self, refusal: PPaaSError | None) -> None:
        """Take the answer."""
        self._permits.answer(refusal)
        self.session.resume()

    # -- the socket ----------------------------------------------------------------------------------------------------

    def connect(self, sink: SocketSink | None) -> None:
        """Send through a socket from now on; with None, let all frames wait."""
        self.sink = sink
        self.session.outbox.connect(sink)
        if sink is not None and self.session.awaits_permit:
            self.ask_permit()

    def _report_later(self) -> None:
        if self._reporting is None:
            self._reporting = asyncio.get_running_loop().call_later(REPORT_PERIOD, self._report)

    def _report(self) -> None:
        self._reporting = None
        settled = self.unsettled.take_settled()
        if settled and self.sink is not None:
            self.sink.link.write(Settled(self.sink.socket, settled))

    def _tell_over(self, reason: PPaaSError) -> None:
        if self.sink is not None:
            self.sink.link.write(SessionOver(self.sink.socket, refusal_of(reason)))

    def end(self) -> None:
        """End the session."""
        self.ended = True
        for timer in (self.expiry, self._reporting):
            if timer is not None:
                timer.cancel()
        self.connect(None)
        self.session.end()


class SessionHost:
    """Sessions of the clients of a place.

    Parameters
    ----------
    place : Place
        The place.
    """

    def __init__(self, place: Place) -> None:
        self._place = place
        self._named: dict[SessionClient, RetainedSession] = {}
        self._sockets: dict[Socket, RetainedSession] = {}
        self._nameless: dict[str, RetainedSession] = {}
        self._records: dict[str, SessionRecord] = {}
        self._links: dict[EndpointEnd, ClientOffers | None] = {}
        self._faults = ListenerFaults(logger)
        self._presence: bool | None = None
        place.client_topics.advertise(PRESENCE, OWN_TOPICS[PRESENCE], (ITSELF, None), latch=True)
        self._tell_presence()
        self.taken = 0
        """Number of frames of clients that were taken."""

    @property
    def away(self) -> int:
        """Number of detached sessions."""
        return sum(retained.sink is None for retained in self._named.values())

    @property
    def sockets(self) -> int:
        """Number of sockets at all endpoints."""
        return len(self._sockets)

    @property
    def robot_is_here(self) -> bool:
        """Whether a socket of the robot itself is attached, at any endpoint."""
        return any(retained.client.role == "robot" for retained in self._sockets.values())

    @property
    def software(self) -> str:
        """Software of the robot's client, as it names it; empty if it does not, or is not attached."""
        robots = (retained for retained in self._sockets.values() if retained.client.role == "robot")
        return next((retained.options.software for retained in robots), "")

    def hear(self, topic: str, listener: Listener) -> None:
        """Notify a listener in this process of the messages of a topic, of the clone or of a client."""
        self._place.subscribe(topic, self._place.join(listener))

    @property
    def round_trip(self) -> float | None:
        """Round trip to the robot [s]; None before an endpoint has measured it."""
        return self._place.round_trip

    def link_facts(self) -> bytes:
        """Return the facts of the robot's connection as JSON, for its diagnosis."""
        return msgspec.json.encode(self._place.link_facts())

    # -- links ---------------------------------------------------------------------------------------------------------

    def begin(self, clone: Clone, endpoint: EndpointEnd) -> None:
        """Use a clone from now on, and serve the sockets of its first endpoint."""
        self._place.begin(clone)
        self.link_up(endpoint)
        self.forget_restored()

    def link_up(self, link: EndpointEnd) -> None:
        """Begin to serve the sockets of an endpoint."""
        self._links[link] = None

    def link_lost(self, link: EndpointEnd) -> None:
        """Detach all sockets of an endpoint that was lost."""
        self._links.pop(link, None)
        for socket in [socket for socket in self._sockets if socket[0] is link]:
            retained = self._sockets[socket]
            self._keep_nameless(retained)
            retained.session.guard(self._detach, socket, for_good=False)

    def _keep_nameless(self, retained: RetainedSession) -> None:
        """Keep a session without a name for a moment, since its endpoint may have lost the link alone."""
        if retained.client.name is None and not retained.session.over.done():
            self._nameless[retained.id] = retained
            retained.expiry = asyncio.get_running_loop().call_later(RETURN, self._end, retained)

    async def attend(self) -> None:
        """Tell endpoints what clients offer, and send what waited for a slow link, until cancelled."""
        while True:
            await asyncio.sleep(ATTEND_PERIOD)
            for retained in tuple(self._sockets.values()):
                if len(retained.session.outbox):
                    retained.session.guard(retained.session.outbox.flush)
            self._tell_presence()
            if self._sockets:
                self._tell_offers()

    def _tell_presence(self) -> None:
        if self.robot_is_here != self._presence:
            self._presence = self.robot_is_here
            self._place.publish(PRESENCE, encode(Bool(self._presence)), ITSELF, must_arrive=False)

    def _tell_offers(self) -> None:
        place = self._place
        offers = ClientOffers(
            place.client_topics.types(),
            place.client_services.types(),
            place.client_actions.types(),
            sorted(place.heard()),
        )
        for link, told in self._links.items():
            if told != offers:  # a link that came back knows nothing of it
                self._links[link] = offers
                link.write(offers)

    def take(self, link: EndpointEnd, frame: SessionToContainer) -> None:
        """Handle a frame of an endpoint."""
        if isinstance(frame, Attach):
            self._attach_or_refuse(link, frame)
        elif isinstance(frame, RoundTrip):
            self._place.round_trip = frame.seconds
        else:
            retained = self._sockets.get((link, frame.socket))
            if retained is not None:  # else the session has ended, and its endpoint was told
                retained.session.guard(self._handle, (link, frame.socket), retained, frame)

    def _handle(self, socket: Socket, retained: RetainedSession, frame: SessionToContainer) -> None:
        match frame:
            case ClientFrame():
                self.taken += 1
                retained.take(frame.frame)
            case SocketReady():
                self._let_read(retained, reads=frame.ready)
            case PlanCounted():
                refused = frame.refusal
                retained.permit(None if refused is None else error_of(refused))
            case AccessChanged():
                retained.session.access = frame.access
            case Inform():
                retained.session.inform(frame.slug, frame.text)
            case Detach():
                self._detach(socket, for_good=frame.for_good)

    @staticmethod
    def _let_read(retained: RetainedSession, *, reads: bool) -> None:
        if retained.sink is not None:
            retained.sink.reads = reads
            retained.session.outbox.flush()

    # -- attaching -----------------------------------------------------------------------------------------------------

    def _attach_or_refuse(self, link: EndpointEnd, attach: Attach) -> None:
        fault = self._faults.call(f"the session of {attach.client.title}", self._attach, link, attach)
        if fault is not None:
            link.write(SessionOver(attach.socket, refusal_of(fault)))

    def _attach(self, link: EndpointEnd, attach: Attach) -> None:
        nameless = attach.client.name is None
        retained = self._nameless.pop(attach.id, None) if nameless else self._named.get(attach.client)
        if attach.carried and retained is not None:
            self._carry_on(link, attach, retained)
            return
        if retained is not None:
            self._displace(retained)
        # A client that lacks frames which are not kept, or rights that its session has used, begins anew.
        if retained is not None and not self._may_resume(retained, attach):
            self._end(retained)
            retained = None
        resumed = retained is not None
        if retained is None:
            retained, resumed = self._begin(attach)
        if attach.resume is not None and resumed:
            retained.session.outbox.resume(attach.resume.received)
        self._connect(link, attach, retained, resumed=resumed)

    def _carry_on(self, link: EndpointEnd, attach: Attach, retained: RetainedSession) -> None:
        """Attach the socket of a session that an endpoint carries, and whose link was lost."""
        if retained.sink is not None or retained.id != attach.id:
            self._refuse(link, attach.socket)
            return
        settled = retained.continue_with(attach)
        self._connect(link, attach, retained, resumed=True)
        if settled:
            link.write(Settled(attach.socket, settled))

    @staticmethod
    def _may_resume(retained: RetainedSession, attach: Attach) -> bool:
        if retained.session.over.done():
            return False
        return _is_resumed(retained.id, retained.session.access, retained.sent_before, attach)

    @staticmethod
    def _refuse(link: EndpointEnd, socket: int) -> None:
        """Refuse a session that an endpoint carried, since its client came back at another."""
        reason = refusal_of(Conflict("another connection of the same session took over"))
        link.write(SessionOver(socket, reason, taken_over=True))

    def _connect(self, link: EndpointEnd, attach: Attach, retained: RetainedSession, *, resumed: bool) -> None:
        if retained.expiry is not None:
            retained.expiry.cancel()
        retained.session.access, retained.options = attach.access, attach.options
        self._sockets[link, attach.socket] = retained
        link.write(Attached(attach.socket, retained.id, resumed, retained.taken))
        retained.connect(SocketSink(link, attach.socket, retained.unsettled.take_settled))
        if retained.session.over.done():
            link.write(SessionOver(attach.socket, refusal_of(retained.session.over.result())))

    def _displace(self, retained: RetainedSession) -> None:
        if retained.sink is not None:
            link, socket = retained.sink.link, retained.sink.socket
            self._sockets.pop((link, socket), None)
            retained.session.release()
            retained.connect(None)
            self._refuse(link, socket)

    def _begin(self, attach: Attach) -> tuple[RetainedSession, bool]:
        """Begin a session: a new one, or one of an earlier container; return it, and whether it is resumed."""
        record = self._take_record(attach)
        if record is not None:
            attach = msgspec.structs.replace(attach, id=record.id)
        retained = RetainedSession(self._place, attach)
        if attach.client.name is not None:
            self._named[attach.client] = retained
        retained.session.over.add_done_callback(lambda _: self._end(retained) if retained.sink is None else None)
        retained.session.outbox.count = attach.sent
        self._repeat(retained, attach, record)
        return retained, record is not None

    def _take_record(self, attach: Attach) -> SessionRecord | None:
        """Return the session in the checkpoint that a socket continues; another one of the same name is over."""
        found = [
            record
            for record in self._records.values()
            if (record.id == attach.id if attach.carried else record.client == attach.client and record.client.name)
        ]
        for record in found:
            del self._records[record.id]
        return next((record for record in found if _is_resumed(record.id, record.access, record.sent, attach)), None)

    @staticmethod
    def _repeat(retained: RetainedSession, attach: Attach, record: SessionRecord | None) -> None:
        """Execute the frames of a session that an earlier container had, and those that no container got.

        The endpoint does not keep the frames of endpoints that the client was at before; these are in the checkpoint.
        """
        done = 0 if record is None else record.taken
        since, settled = (attach.since, set(attach.settled)) if attach.carried else (done, set[int]())
        before = () if record is None else record.frames
        frames = [frame for frame in before if frame.number <= since and frame.number not in settled]
        for frame in (*frames, *attach.kept):
            if frame.number <= done:
                retained.replay(frame, "applied")
            elif frame.number <= attach.taken:
                retained.replay(frame, "sent")
            else:
                retained.take(frame)
        retained.taken = max(retained.taken, done, attach.taken)

    # -- detaching -----------------------------------------------------------------------------------------------------

    def _detach(self, socket: Socket, *, for_good: bool) -> None:
        """Detach a socket; a named session is retained for a while, unless its client left for good."""
        retained = self._sockets.pop(socket)
        retained.session.release()
        retained.connect(None)
        client = retained.client
        if not for_good and retained.id in self._nameless:
            return
        if client.name is None or for_good or retained.session.over.done():
            self._end(retained)
            return
        self._named[client] = self._named.pop(client)  # moves to the end: the order is that of detaching
        retained.expiry = asyncio.get_running_loop().call_later(retained.options.linger, self._end, retained)
        # Bounded, since a client may name a new session each time.
        away = [other for other in self._of_user(client.user) if other.sink is None]
        for other in away[:-MAX_AWAY]:
            self._end(other)

    def _of_user(self, user: str) -> Iterator[RetainedSession]:
        return (retained for client, retained in self._named.items() if client.user == user)

    def _end(self, retained: RetainedSession) -> None:
        if retained.ended:
            return
        if self._named.get(retained.client) is retained:
            del self._named[retained.client]
        self._nameless.pop(retained.id, None)
        self._faults.call(f"the session of {retained.client.title}", retained.end)

    def close(self) -> None:
        """End all sessions."""
        for retained in {*self._named.values(), *self._nameless.values(), *self._sockets.values()}:
            self._end(retained)
        self._sockets.clear()

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the sessions as JSON, for the container that replaces this one."""
        known = (*self._named.values(), *self._nameless.values(), *self._sockets.values())
        now = {retained.id: retained for retained in known}
        return msgspec.json.encode([*self._records.values(), *(retained.record() for retained in now.values())])

    def restore(self, state: bytes) -> None:
        """Know the sessions of an earlier container, until their clients' sockets are attached."""
        try:
            self._records = {record.id: record for record in _decoder.decode(state)}
        except msgspec.DecodeError as error:
            logger.warning("the sessions of an earlier container cannot be read, and begin anew: %s", error)

    def forget_restored(self) -> None:
        """Let restored sessions whose clients do not return within their linger end."""
        loop = asyncio.get_running_loop()
        for record in self._records.values():
            loop.call_later(max(record.options.linger, RETURN), self._records.pop, record.id, None)


def _is_resumed(session: str, access: Access, sent: int, attach: Attach) -> bool:
    """Return whether a client resumes a session.

    Parameters
    ----------
    session : str
        Id of the session.
    access : Access
        Rights with which it was used: it may hold what the client has no right to any more.
    sent : int
        Number of frames that were sent in it and are not kept.
    attach : Attach
        Request of the client's endpoint.
    """
    if not attach.access.includes(access):
        return False
    if attach.carried or not attach.options.counts:
        return True
    point = attach.resume
    return point is not None and point.id == session and point.received >= sent
