"""Session of a robot's client, independent of the socket that carries it.

Each frame of the client is executed at the robot's place. Errors are reported to that client only, and only if it
requested ``status`` (by ``set_level`` or ``&status=1``).
"""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Any, Final, ParamSpec

from engine.links.shared_place import check_type
from engine.protocols.session_frames import NumberedFrame
from engine.rights.access import Access
from engine.rights.roles import Role, check_may_publish, signed
from engine.sessions.calls import ClientCalls
from engine.sessions.goals import ClientGoals
from engine.sessions.namespaces import namespace_hint, with_hint
from engine.sessions.offered_actions import OfferedActions
from engine.sessions.outbox import FrameOutbox, Sent
from engine.sessions.place.place import Place
from engine.sessions.unsettled import Posting, Replay, UnsettledFrames
from ppaas.clock import epoch, monotonic
from ppaas.errors import InvalidInput, NotFound, PPaaSError, rebuild
from ppaas.listener_faults import internal_error
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Twist
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.nodes.nav2_actions import PATH_GOALS
from ppaas.nodes.topics import policy_of
from ppaas.tracing.spans import within
from ppaas.wire import operations
from ppaas.wire.goals import refusal
from ppaas.wire.names import ros1_type, ros2_spelling
from ppaas.wire.own_topics import HEARTBEAT, OWN_TOPICS, check_not_own
from ppaas.wire.ros.serialization import are_types_read, read_types
from ppaas.wire.rosbridge import Respell, RosbridgeSession
from ppaas.wire.stamped_twists import TWIST_STAMPED, stamping

logger = logging.getLogger(__name__)

P = ParamSpec("P")

HEARTBEAT_PERIOD = 1.0
"""Interval of the messages on ``HEARTBEAT`` [s]."""

MAX_LOGGED = 64
"""Largest number of different errors of one client that are logged as warnings."""

PATH_SERVICES = frozenset({"move_base/compute_path", "move_base/make_plan"})
"""Services of the clone that plan a path and count as path requests of the user."""

RAW: Final = b"cbor-raw"
"""Compression whose name in a frame makes it wait."""

MAX_SEARCHED: Final = 4096
"""Largest frame that is searched for the name [bytes]; a subscription is far smaller."""

MAX_HELD: Final = 1 << 20
"""Largest size of all frames that wait for types of ROS [bytes]; beyond it, none waits any longer."""

Execute = Callable[[operations.ClientOperation | operations.RefusedOperation], None]
"""Executes an operation; raises ``PermitAwaited`` if it must wait for a permit."""


class PermitAwaited(Exception):
    """An operation requests a path, and whether it may is being asked."""


class PlanPermits:
    """Answers whether the paths that a client requests are within the quota of its user, each for one operation.

    The quota is counted outside of the container, so an operation that requests a path waits for the answer.
    """

    def __init__(self) -> None:
        self._answers: list[PPaaSError | None] = []

    def answer(self, refusal: PPaaSError | None) -> None:
        """Take an answer: None if the path may be requested."""
        self._answers.append(refusal)

    def take(self) -> None:
        """Use an answer.

        Raises
        ------
        PermitAwaited
            There is none yet.
        PPaaSError
            The path may not be requested.
        """
        if not self._answers:
            raise PermitAwaited
        refusal = self._answers.pop(0)
        if refusal is not None:
            raise refusal


# -- frames of the client ----------------------------------------------------------------------------------------------


class FrameTaker:
    """Decodes the frames of a client, and executes their operations in order, each once.

    Two kinds of frames let the later ones wait. An operation that requests a path waits for a permit. A subscription in
    bytes of ROS (``compression: cbor-raw``) waits for the types of ROS: reading them takes most of a second of CPU,
    once in a process. So they are read in a thread; the frames of other clients are handled meanwhile.

    Parameters
    ----------
    wire : RosbridgeSession
        State of the rosbridge protocol.
    execute : callable
        Executes an operation.
    unsettled : UnsettledFrames
        Frames of the client.
    ask : callable
        Called when an operation waits for a permit; `resume` must follow.
    release : callable
        Called once the types of ROS are read; `release` must follow.
    """

    def __init__(
        self,
        wire: RosbridgeSession,
        execute: Execute,
        unsettled: UnsettledFrames,
        ask: Callable[[], None],
        release: Callable[[], None],
    ) -> None:
        self._wire = wire
        self._execute_one = execute
        self._unsettled = unsettled
        self._ask = ask
        self._release = release
        self._suspended: Iterator[operations.ClientOperation | operations.RefusedOperation] | None = None
        self._current = NumberedFrame(0, b"")
        self._waiting: deque[NumberedFrame] = deque()
        self._reading = False
        self._held = 0

    def waiting(self) -> list[NumberedFrame]:
        """Return the frames that are not executed yet, in order; the first may have an operation that waits."""
        return [self._current, *self._waiting] if self.awaits_permit else [*self._waiting]

    @property
    def awaits_permit(self) -> bool:
        """Whether an operation waits for a permit."""
        return self._suspended is not None

    def take(self, frame: NumberedFrame) -> None:
        """Execute a frame, after those that wait."""
        self._waiting.append(frame)
        if not self._reading:
            self._go_on()
            return
        self._held += len(frame.content)
        if self._held > MAX_HELD:
            self.release()

    def replay(self, frame: NumberedFrame) -> None:
        """Execute a frame that an earlier container got, before all others; it waits for no types."""
        self._run(frame)

    def resume(self) -> None:
        """Execute the operation that waits for a permit, and the frames after it."""
        suspended, self._suspended = self._suspended, None  # it may be suspended again, for the next permit
        if suspended is not None:
            self._execute(suspended)
        self._go_on()

    def release(self) -> None:
        """Execute the frames that wait for types of ROS."""
        if self._reading:
            self._reading = False
            self._go_on(read=False)

    def _go_on(self, *, read: bool = True) -> None:
        while self._waiting and not (self.awaits_permit or self._reading):
            if read and _asks_for_raw(self._waiting[0]) and not are_types_read():
                self._reading, self._held = True, sum(len(frame.content) for frame in self._waiting)
                reading = asyncio.get_running_loop().run_in_executor(None, read_types)
                reading.add_done_callback(lambda _: self._release())
            else:
                self._run(self._waiting.popleft())

    def _run(self, frame: NumberedFrame) -> None:
        self._current = frame
        self._unsettled.begin(frame)
        receive = self._wire.receive_binary if frame.binary else self._wire.receive
        operation = receive(frame.content)
        self._unsettled.gather(self._wire.incomplete)
        if isinstance(operation, operations.Fragment):
            self._unsettled.wait_for_rest(operation.id)
        elif isinstance(operation, operations.RefusedOperation) and operation.parts:
            self._execute(map(self._wire.receive, operation.parts))
        else:
            self._execute(iter((operation,)))

    def _execute(self, waiting: Iterable[operations.ClientOperation | operations.RefusedOperation]) -> None:
        rest = iter(waiting)
        for operation in rest:
            try:
                self._execute_one(operation)
            except PermitAwaited:
                self._suspended = chain((operation,), rest)
                self._ask()
                return
        self._unsettled.end()


def _asks_for_raw(frame: NumberedFrame) -> bool:
    return len(frame.content) <= MAX_SEARCHED and RAW in frame.content


# -- topics that a session sends by itself, and messages that it delays ------------------------------------------------


class ClientHeartbeat:
    """Sends a client that subscribes to ``HEARTBEAT`` a message at once and then once a second.

    By it a client knows that its connection is alive, whatever others publish. Pages in browsers do not see the pings
    of a WebSocket, and a topic on which nothing is published looks like a connection that is lost.

    Parameters
    ----------
    publish : callable
        Called with the topic and a message as JSON.
    """

    def __init__(self, publish: Callable[[str, bytes], None]) -> None:
        self._publish = publish
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Send messages from now on."""
        if self._timer is None:
            self._beat()

    def stop(self) -> None:
        """Send no further messages."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _beat(self) -> None:
        self._timer = asyncio.get_running_loop().call_later(HEARTBEAT_PERIOD, self._beat)
        self._publish(HEARTBEAT, encode(Header(stamp=Time.of(epoch()))))


class DelayedMessages:
    """Sends the messages that a client's subscriptions delay by ``throttle_rate``.

    Parameters
    ----------
    wire : RosbridgeSession
        Has the messages.
    put : callable
        Called with the topic and the frame of each message that is due.
    guard : callable
        Calls a function, and ends the session if it fails.
    """

    def __init__(
        self,
        wire: RosbridgeSession,
        put: Callable[[str, bytes], None],
        guard: Callable[[Callable[[], None]], None],
    ) -> None:
        self._wire = wire
        self._put = put
        self._guard = guard
        # A loop returns a handle without a time for a timer that is due within half a millisecond (uvloop).
        self._at = float("inf")
        self._timer: asyncio.Handle | None = None

    def schedule(self) -> None:
        """Set the timer for the next message, if one waits."""
        due = self._wire.next_due()
        if due is None:
            return
        loop = asyncio.get_running_loop()
        at = loop.time() + max(due - monotonic(), 0.0)
        if at < self._at:
            self.stop()
            self._at, self._timer = at, loop.call_at(at, self._guard, self._send)

    def stop(self) -> None:
        """Stop the timer."""
        if self._timer is not None:
            self._timer.cancel()
        self._at, self._timer = float("inf"), None

    def _send(self) -> None:
        self.stop()
        for topic, frame in self._wire.due(monotonic()):
            self._put(topic, frame)
        self.schedule()


def spelling_at(place: Place) -> Callable[[str, str | None], Respell | None]:
    """Return the function that returns, for a topic of a place and a type, what spells its messages for a client.

    Velocities of the clone get a header for a client that names them ``geometry_msgs/TwistStamped``.
    """

    def spelling_of(topic: str, kind: str | None) -> Respell | None:
        respell = ros2_spelling(kind)
        if policy_of(topic).type is not Twist or (kind or "").replace("/msg/", "/", 1) != TWIST_STAMPED:
            return respell
        stamp = stamping(place.base_frame, epoch)
        return stamp if respell is None else lambda twist: respell(stamp(twist))

    return spelling_of


class ClientSession:
    """Session of one client of a place.

    Parameters
    ----------
    place : Place
        Place of the robot.
    role : {"robot", "operator"}
        Role of the client, which limits the topics it may publish.
    wire : RosbridgeSession
        State of the rosbridge protocol.
    name : str
        Name in the log.
    count_plan : callable
        Called for each path request of the client; raises if the rate is exceeded, and ``PermitAwaited`` if that is not
        known yet.
    access : Access
        Rights of the client.
    user : str
        User of the client.
    identity : str
        Name of the session among all sessions of the robot, by which its goals are known; by default made up.
    unsettled : UnsettledFrames, optional
        Frames that a next container needs.
    ask : callable
        Called when an operation waits for a permit; `resume` must follow.

    Attributes
    ----------
    access : Access
        Rights of the client, which may be replaced.
    outbox : FrameOutbox
        Frames for the client.
    over : Future
        Done once the session must end; its result is the reason.
    """

    def __init__(
        self,
        place: Place,
        role: Role,
        wire: RosbridgeSession,
        name: str,
        count_plan: Callable[[], None] = lambda: None,
        *,
        access: Access,
        user: str = "",
        identity: str = "",
        unsettled: UnsettledFrames | None = None,
        ask: Callable[[], None] = lambda: None,
    ) -> None:
        self.access = access
        self._place, self._role, self._user = place, role, user
        self._wire = wire
        wire.spelling_of, wire.packer.type_of = spelling_at(place), place.topic_type
        self.name = name
        self.outbox = FrameOutbox()
        self.over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._logged: set[tuple[str, str]] = set()
        self._delayed = DelayedMessages(wire, self._put, self.guard)
        self._heartbeat = ClientHeartbeat(self.published)
        self._client = place.join(self)
        place.health.joined(self._client, role, self.outbox)
        self.unsettled = unsettled or UnsettledFrames()
        self._posting = Posting(place, self._client, self.unsettled, count_plan)
        self._taker = FrameTaker(wire, self._execute, self.unsettled, ask, self.release)
        identity = identity or f"goal-{self._client}"
        self._goals = ClientGoals(
            place, self._client, wire, self.outbox, self._answer, posting=self._posting, identity=identity
        )
        self._actions = OfferedActions(place, self._client, wire, self.outbox.put_answer)
        self._calls = ClientCalls(place, self._client, wire, self._answer, self._answer_here, posting=self._posting)
        self._handlers = self._handlers_by_operation()

    def _handlers_by_operation(self) -> dict[type, Callable[[Any], None]]:
        return {
            operations.Publish: self._publish,
            operations.Advertise: self._advertise,
            operations.Unadvertise: self._unadvertise,
            operations.Subscribe: self._subscribe,
            operations.Unsubscribe: self._unsubscribe,
            operations.CallService: self._calls.start,
            operations.AdvertiseService: self._advertise_service,
            operations.UnadvertiseService: self._unadvertise_service,
            operations.ServiceResponse: self._calls.respond,
            operations.SendActionGoal: self._send_goal,
            operations.CancelActionGoal: self._goals.cancel,
            operations.AdvertiseAction: self._advertise_action,
            operations.UnadvertiseAction: self._unadvertise_action,
            operations.ActionFeedback: self._actions.feedback,
            operations.ActionResult: self._actions.result,
            operations.SetLevel: lambda _: self.unsettled.until_withdrawn(("level",)),  # handled by the wire
            operations.RefusedOperation: self._refuse,
        }

    def end(self) -> None:
        """Leave the place and cancel pending calls."""
        self._heartbeat.stop()
        self._calls.end()
        self._place.leave(self._client)
        self._delayed.stop()

    # -- from the client -----------------------------------------------------------------------------------------------

    def take(self, frame: NumberedFrame, replay: Replay = "") -> None:
        """Execute a frame of the client; report its errors to the client, unless an earlier container got the frame."""
        self._posting.replay = replay
        try:
            with self.outbox.corked():  # answers go out together with what they settle
                (self._taker.replay if replay else self._taker.take)(frame)
        finally:
            self._posting.replay = ""

    def serve(self, frame: NumberedFrame, replay: Replay = "") -> None:
        """Execute a frame like ``take``; an internal error ends the session."""
        self.guard(self.take, frame, replay)

    def guard(self, work: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Do work of this session; an internal error is logged once, and ends this session alone."""
        try:
            work(*args, **kwargs)
        except Exception as error:
            level = logging.DEBUG if self.over.done() else logging.ERROR
            logger.log(level, "%s: serving failed", self.name, exc_info=True)
            self.closed(internal_error(error))

    def waiting(self) -> list[NumberedFrame]:
        """Return the frames that are not executed yet, in order."""
        return self._taker.waiting()

    @property
    def awaits_permit(self) -> bool:
        """Whether an operation waits for a permit."""
        return self._taker.awaits_permit

    def resume(self) -> None:
        """Execute the operation that waits for a permit, and the frames after it."""
        with self.outbox.corked():
            self.guard(self._taker.resume)

    def release(self) -> None:
        """Execute the frames that wait for types of ROS."""
        with self.outbox.corked():
            self.guard(self._taker.release)

    def acknowledged(self, sequence: int) -> None:
        """Handle that all messages up to a sequence number are in a checkpoint."""
        self.guard(self.unsettled.acknowledged, sequence)

    def _execute(self, operation: operations.ClientOperation | operations.RefusedOperation) -> None:
        try:
            with within(getattr(operation, "traceparent", None) or ""):
                self._handlers[type(operation)](operation)
        except PPaaSError as error:
            self._place.health.refused(self._client, self._topic_of(operation), error)
            self._report_error(error, operation_id=getattr(operation, "id", None))

    def _topic_of(self, operation: object) -> str:
        """Return the topic of an operation, as the clone names it; empty if it has none."""
        topic = getattr(operation, "topic", None)
        return self._wire.names.without_namespace(topic).strip("/") if isinstance(topic, str) else ""

    def _refuse(self, refused: operations.RefusedOperation) -> None:
        """Answer a call or a goal whose frame could not be read; report the error of any other frame.

        A client that tries to log in is told how, whatever its status level: rosbridge would end the connection.
        """
        self._place.health.refused(self._client, "", refused.error)
        if refused.op == "call_service":
            self._calls.refuse(refused)
        elif refused.op == "send_action_goal":
            self._goals.refuse(refused)
        else:
            self._report_error(refused.error, operation_id=refused.id, always=refused.op == "auth")

    def _advertise_service(self, operation: operations.AdvertiseService) -> None:
        service = self._wire.names.resolve(operation.service)
        self.access.check_publish(service)
        self._calls.advertise(operation, self)
        self.unsettled.until_withdrawn(("service", service))

    def _unadvertise_service(self, operation: operations.UnadvertiseService) -> None:
        self._calls.unadvertise(operation)
        self.unsettled.withdrawn("service", self._wire.names.resolve(operation.service))

    def _advertise_action(self, operation: operations.AdvertiseAction) -> None:
        action = self._wire.names.resolve(operation.action)
        self.access.check_goal(action)
        self._actions.advertise(operation)
        self.unsettled.until_withdrawn(("action", action))

    def _unadvertise_action(self, operation: operations.UnadvertiseAction) -> None:
        self._actions.unadvertise(operation)
        self.unsettled.withdrawn("action", self._wire.names.resolve(operation.action))

    def _send_goal(self, operation: operations.SendActionGoal) -> None:
        try:
            self.access.check_goal(self._wire.names.callee(operation.action))
        except PPaaSError as error:
            self._answer(refusal(operation, error))
        else:
            self._goals.start(operation)

    def _answer_here(self, service: str, arguments: bytes) -> bytes | None:
        self.access.check_call(service)
        if service in PATH_SERVICES:
            self._posting.count_plan()
        return self._goals.cancel_all(service, arguments)

    def _publish(self, operation: operations.Publish) -> None:
        topic = self._wire.names.resolve(operation.topic)
        check_may_publish(self._role, topic)
        self.access.check_publish(topic)
        check_not_own(topic)
        if topic in PATH_GOALS:
            self._posting.count_plan()
        must_arrive, latch = not policy_of(topic).stream, operation.latch is True
        try:
            message = signed(topic, bytes(operation.msg), self._user)
            self._posting.post(topic, message, must_arrive=must_arrive, latch=latch)
        except NotFound as error:
            raise with_hint(error, topic, self._place.topics) from error

    def _advertise(self, operation: operations.Advertise) -> None:
        topic = self._wire.names.resolve(operation.topic)
        check_may_publish(self._role, topic)
        self.access.check_publish(topic)
        check_not_own(topic)
        self._place.advertise(
            topic, ros1_type(operation.type), self._client, operation.id, latch=operation.latch is True
        )
        self.unsettled.until_withdrawn(("topic", topic, operation.id))

    def _unadvertise(self, operation: operations.Unadvertise) -> None:
        topic = self._wire.names.resolve(operation.topic)
        self._place.unadvertise(topic, self._client, operation.id)
        self.unsettled.withdrawn("topic", topic, *(() if operation.id is None else (operation.id,)))

    def _subscribe(self, operation: operations.Subscribe) -> None:
        topic = self._wire.names.resolve(operation.topic)
        try:
            if topic != HEARTBEAT:
                self.access.check_subscribe(topic)
            kind = ros1_type(operation.type) if operation.type else None
            self._hear(topic, kind)
            self.unsettled.until_withdrawn(("subscription", topic, operation.id))
        except PPaaSError:
            self._wire.forget(operation)
            self.unsettled.withdrawn("subscription", topic, operation.id)
            self._unsubscribe_if_unused(topic)
            raise
        if (operation.throttle_rate or 0) < 0 or (operation.queue_length or 0) < 0:
            text = "throttle_rate and queue_length are not negative: 0 is used instead"
            self._report(rebuild(InvalidInput.slug, text), "warning", operation.id)
        objection = self._wire.objection(operation)
        if objection is not None:
            self._report(objection, "warning", operation.id)
        if topic != HEARTBEAT and self._place.topic_type(topic) is None:
            hint = namespace_hint(topic, self._place.topics)
            text = f"topic {topic!r} does not exist yet; its messages arrive as soon as a client advertises it{hint}"
            self._report(rebuild(NotFound.slug, text), "warning", operation.id)

    def _hear(self, topic: str, kind: str | None) -> None:
        if topic != HEARTBEAT:
            self._place.hear(topic, self._client, kind)
            return
        check_type(topic, OWN_TOPICS[HEARTBEAT], kind or OWN_TOPICS[HEARTBEAT])
        self._heartbeat.start()

    def _unsubscribe(self, operation: operations.Unsubscribe) -> None:
        topic = self._wire.names.resolve(operation.topic)
        self.unsettled.withdrawn("subscription", topic, *(() if operation.id is None else (operation.id,)))
        self._unsubscribe_if_unused(topic)

    def _unsubscribe_if_unused(self, topic: str) -> None:
        if self._wire.hears(topic) or self._goals.hears(topic):
            return
        if topic == HEARTBEAT:
            self._heartbeat.stop()
        self._place.unsubscribe(topic, self._client)

    # -- to the client -------------------------------------------------------------------------------------------------

    def _answer(self, frame: bytes, fragment_size: int = 0, sent: Sent | None = None) -> None:
        if sent is None:  # an answer to the frame that is executed now
            return self.unsettled.answer(lambda settle: self._answer(frame, fragment_size, settle))
        try:
            self.outbox.put_answer(frame, fragment_size, sent)
        except PPaaSError as error:  # a response must not be dropped: the client is disconnected instead
            self.closed(error)

    def _report_error(
        self, error: PPaaSError, about: str = "", operation_id: operations.Id = None, *, always: bool = False
    ) -> None:
        first = (error.slug, about) not in self._logged and len(self._logged) < MAX_LOGGED
        if first:
            self._logged.add((error.slug, about))
        logger.log(logging.WARNING if first else logging.DEBUG, "%s: %s: %s", self.name, error.slug, error)
        self._report(error, "error", operation_id, always=always)

    def _report(
        self, error: PPaaSError, level: operations.Level, operation_id: operations.Id, *, always: bool = False
    ) -> None:
        status = None if self._posting.replay else self._wire.status(error, operation_id, level, always=always)
        if status is not None:
            self.outbox.put("", status, DEFAULT_DEPTH)

    def inform(self, slug: str, text: str) -> None:
        """Send the client a status of level info, if it requested this level."""
        self._report(rebuild(slug, text), "info", None)

    def _put(self, topic: str, frame: bytes) -> None:
        keep = self._wire.queue_length(topic, policy_of(topic).depth)
        self.outbox.put(topic, frame, keep, self._wire.fragment_size(topic))

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Handle a message of a topic that the client subscribed to; an internal error ends this session alone."""
        self.guard(self._take_message, topic, payload)

    def _take_message(self, topic: str, payload: bytes) -> None:
        for frame in self._wire.publish(topic, payload, monotonic()):
            self._put(topic, frame)
        self._delayed.schedule()
        if self._goals.hears(topic):
            try:
                self._goals.published(topic, payload)
            except PPaaSError as error:
                self._report_error(error, topic)

    def requested(self, call: int, service: str, payload: bytes) -> None:
        """Handle a call of a service that the client offers.

        Raises
        ------
        Unavailable
            The client reads too slowly.
        """
        self.outbox.put_answer(self._calls.request(call, service, payload))

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Handle the refusal of a message of this client by the clone."""
        self.guard(self._take_refusal, topic, error, sequence)

    def _take_refusal(self, topic: str, error: PPaaSError, sequence: int) -> None:
        self._goals.refused(sequence, error)
        self._report_error(error, topic)

    def closed(self, reason: PPaaSError) -> None:
        """End the session: the place closed, or closed for this client."""
        if not self.over.done():
            self.over.set_result(reason)
