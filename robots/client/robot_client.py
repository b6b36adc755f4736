"""A robot's, or an operator's, connection to the cloud.

::

    async with RobotClient("http://cloud:8500", robot="tb1", token=token) as client:
        await client.subscribe("cmd_vel", Twist, base.command)
        await client.publish("odom", odometry)

The connection is kept: when it is lost, the client connects again and finds its session as it left it, or begins a new
one and renews its subscriptions and what it offers. It gives up only where the cloud says no, and then every method
raises why.
"""

import asyncio
import logging
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Protocol, Self, TypeVar, cast
from uuid import uuid4

import msgspec

from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import Message, ServiceType
from ppaas.wire.names import normalise
from ppaas.wire.operations import CallService
from ppaas.wire.rosbridge_client import ReceivedMessage, RosbridgeClientSession, ServiceResult, StatusReport
from robots.client.advertised_services import Handler, Offers
from robots.client.connection import Address, Link, Role, backoff
from robots.client.connection_keeper import ConnectionKeeper
from robots.client.send_queue import SUBSCRIPTION, Outbox
from robots.client.service_calls import Calls
from robots.client.subscription import Subscription

logger = logging.getLogger(__name__)

M = TypeVar("M", bound=Message)


class Nearby(Protocol):
    """Nodes of the robot that run beside the client."""

    def published(self, topic: str, message: Message) -> bool:
        """Take what the client publishes; tell whether the cloud has to hear it as well."""
        ...

    def owns(self, topic: str) -> bool:
        """Tell whether these nodes alone say things on a topic, so that the cloud's word on it is not heard."""
        ...


def _log_status(error: PPaaSError) -> None:
    logger.warning("the cloud says: %s", error)


class RobotClient:
    """Publishes, subscribes, calls services and offers them for one robot.

    Parameters
    ----------
    url : str
        Of the cloud: ``http://host:port`` (or https, ws, wss).
    robot, token, role : str
        Whose topics these are, who asks, and whether as the robot itself or as its operator.
    session : str, optional
        Name under which the cloud keeps what belongs to this client while it is away: one of its own, if none is given.
    hold : bool
        Open a place for the robot if it has none, and hold it; an operator that only looks on need not.
    link : Link, optional
        Time-outs and sizes of the connection.
    connect_timeout : float
        Seconds in which the first connection must stand, all attempts together.
    capacity : int
        Frames that may wait to be sent; ``publish`` waits when there are more.
    reconnect_delays : callable
        Makes the seconds to wait before each attempt to connect again.
    on_status : callable
        Told of each error that the cloud reports; logged by default.
    """

    def __init__(
        self,
        url: str,
        *,
        robot: str,
        token: str,
        role: Role = "robot",
        session: str = "",
        hold: bool = True,
        link: Link | None = None,
        connect_timeout: float = 30.0,
        capacity: int = 256,
        reconnect_delays: Callable[[], Iterator[float]] = backoff,
        on_status: Callable[[PPaaSError], None] = _log_status,
    ) -> None:
        self._connect_timeout = connect_timeout
        self._on_status = on_status
        self._session = RosbridgeClientSession()
        self._outbox = Outbox(capacity)
        self._keeper = ConnectionKeeper(
            Address(url, robot=robot, token=token, role=role, session=session or uuid4().hex, hold=hold),
            link or Link(),
            self._outbox,
            reconnect_delays,
            greeting=self._session.reconnected,
            received=self._take,
            lost=self._session_lost,
        )
        self._subscriptions: dict[str, list[Subscription[Message]]] = {}
        self._calls = Calls(self._session, self._outbox)
        self._offers = Offers(self._session, self._outbox)
        self._nearby: Nearby | None = None
        self._failure: PPaaSError | None = None
        self._runner: asyncio.Task[None] | None = None

    # -- life ------------------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Connect.

        Raises
        ------
        PPaaSError
            The cloud's refusal, or ``Unavailable`` when it was not reached in ``connect_timeout``.
        """
        self._runner = asyncio.create_task(self._run())
        waiting = asyncio.create_task(self._keeper.connected.wait())
        try:
            await asyncio.wait(
                {self._runner, waiting}, timeout=self._connect_timeout, return_when=asyncio.FIRST_COMPLETED
            )
            self._check()
            if not self._keeper.connected.is_set():
                raise Unavailable(f"the cloud was not reached in {self._connect_timeout:g} s; is it up?")
        except BaseException:
            await self._stop()
            raise
        finally:
            waiting.cancel()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None and self._failure is None and self._keeper.connected.is_set():
            await self._flush()
        await self._stop()

    async def _flush(self, patience: float = 2.0) -> None:
        try:
            await asyncio.wait_for(self._outbox.drained(), patience)
        except (TimeoutError, PPaaSError):
            logger.warning("%d frames were not sent before the client closed", len(self._outbox))

    async def _stop(self) -> None:
        if self._runner is not None:
            self._runner.cancel()
            await asyncio.gather(self._runner, return_exceptions=True)
        self._end(Unavailable("the client is closed"), None)

    @property
    def connected(self) -> bool:
        """Tell whether the connection stands now."""
        return self._keeper.connected.is_set()

    @property
    def connections(self) -> int:
        """Count the connections that there have been."""
        return self._keeper.connections

    @property
    def resumptions(self) -> int:
        """Count the connections that found the session of the one before."""
        return self._keeper.resumptions

    @property
    def dropped(self) -> int:
        """Count the newest-only messages that gave way to newer ones before they were sent."""
        return self._outbox.dropped

    async def closed(self) -> None:
        """Wait until the client gives up, and raise why."""
        if self._runner is not None:
            await asyncio.wait({self._runner})
        self._check()

    def _check(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _end(self, for_senders: PPaaSError, for_readers: PPaaSError | None) -> None:
        self._failure = self._failure or for_senders
        self._outbox.close(self._failure)
        self._calls.fail(self._failure)
        self._offers.end()
        for subscriptions in self._subscriptions.values():
            for subscription in subscriptions:
                subscription.close(for_readers)
        self._subscriptions.clear()

    # -- what the user asks ----------------------------------------------------------------------------------------

    async def publish(self, topic: str, message: Message, *, newest_only: bool = False) -> None:
        """Publish a message.

        Parameters
        ----------
        topic : str
            Of this robot.
        message : Message
            What to say.
        newest_only : bool
            On a slow link drop what waits of this topic in favour of this message, and do not wait. Without it nothing
            is dropped: the call waits while too much is to be sent.

        Raises
        ------
        PPaaSError
            The client has given up, or is closed.
        """
        self._check()
        if self._nearby is not None and not self._nearby.published(normalise(topic), message):
            return
        frame = self._session.publish(topic, message)
        if newest_only:
            self._outbox.put_newest(normalise(topic), frame)
        else:
            await self._outbox.put(frame)

    async def subscribe(
        self,
        topic: str,
        kind: type[M],
        callback: Callable[[M], None] | None = None,
        *,
        queue_size: int = 100,
        throttle: float = 0.0,
    ) -> Subscription[M]:
        """Hear a topic: by the callback, or by iterating over what is returned.

        Parameters
        ----------
        topic : str
            Of this robot.
        kind : type of Message
            What it carries.
        callback : callable, optional
            Called with each message on the event loop.
        queue_size : int
            Messages kept for a slow reader, here and in the cloud; 1 keeps only the newest.
        throttle : float
            Hear it at most once in this many seconds.

        Raises
        ------
        PPaaSError
            The client has given up, or is closed.
        """
        self._check()
        subscription = Subscription(topic, kind, callback, queue_size)
        frame = self._session.subscribe(topic, kind, throttle, queue_size)
        self._subscriptions.setdefault(normalise(topic), []).append(cast(Subscription[Message], subscription))
        await self._tell(frame)
        return subscription

    async def unsubscribe(self, subscription: Subscription[M]) -> None:
        """Hear it no more."""
        name = normalise(subscription.topic)
        left = [other for other in self._subscriptions.get(name, []) if other is not subscription]
        subscription.close()
        if left:
            self._subscriptions[name] = left
            return
        if self._subscriptions.pop(name, None) is not None:
            await self._tell(self._session.unsubscribe(name))

    async def _tell(self, frame: str) -> None:
        """Send what changes a subscription; should the session begin anew meanwhile, its greeting tells it."""
        await self._outbox.put(frame, SUBSCRIPTION)

    async def call(self, service: str, kind: ServiceType, request: Message, timeout: float = 10.0) -> Message:
        """Call a service of this robot's clone, or of a client, and return its response, a ``kind.response``.

        Raises
        ------
        Unavailable
            No answer in ``timeout`` seconds, or the connection was lost meanwhile.
        PPaaSError
            What the service says it failed with.
        """
        self._check()
        return await self._calls.call(service, kind, request, timeout)

    async def advertise_service(self, service: str, kind: ServiceType, handler: Handler) -> None:
        """Offer a service to all who may speak to this robot, or for it.

        What the cloud refuses, such as a name of the clone's own, it tells of as a status.

        Parameters
        ----------
        service : str
            Of this robot.
        kind : ServiceType
            What it takes and gives.
        handler : callable
            Called on the event loop with each request, a ``kind.request``; returns the response, a ``kind.response``,
            or is a coroutine function that does. Several calls may be under way at once. A ``PPaaSError`` that it
            raises is what the caller is told. It is cancelled when the session is lost: nobody waits for it any more.

        Raises
        ------
        Conflict
            This client offers the service already.
        PPaaSError
            Not a ROS graph name; the client has given up, or is closed.
        """
        self._check()
        await self._offers.advertise(service, kind, handler)

    async def unadvertise_service(self, service: str) -> None:
        """Offer a service no more; calls under way are still answered.

        Raises
        ------
        NotFound
            This client does not offer it.
        PPaaSError
            The client has given up, or is closed.
        """
        self._check()
        await self._offers.unadvertise(service)

    # -- nodes beside it -------------------------------------------------------------------------------------------

    def attach(self, nearby: Nearby | None) -> None:
        """Let nodes beside the client hear what it publishes, and speak for the cloud; None ends it."""
        self._nearby = nearby

    def hear(self, topic: str, payload: msgspec.Raw) -> None:
        """Take a message of a node beside the client, for those who subscribed here.

        Raises
        ------
        MalformedMessage
            It is not of the topic's type.
        """
        for subscription in tuple(self._subscriptions.get(normalise(topic), ())):
            subscription.deliver(payload)

    # -- what the connection tells -----------------------------------------------------------------------------------

    async def _run(self) -> None:
        try:
            await self._keeper.run()
        except PPaaSError as error:
            self._end(error, error)
        except Exception as error:
            logger.exception("a callback failed; the client ends")
            failure = PPaaSError(f"a callback of the client failed: {error!r}")
            self._end(failure, failure)

    def _session_lost(self) -> None:
        self._calls.lost()
        self._offers.lost()

    def _take(self, frame: str | bytes) -> None:
        try:
            operation = self._session.receive(frame)
            if isinstance(operation, ReceivedMessage):
                if self._nearby is None or not self._nearby.owns(normalise(operation.topic)):
                    self.hear(operation.topic, operation.msg)
            elif isinstance(operation, ServiceResult):
                self._calls.answered(operation)
            elif isinstance(operation, CallService):
                self._offers.called(operation)
            elif isinstance(operation, StatusReport):
                self._on_status(operation.error())
        except PPaaSError as error:
            logger.warning("a frame of the cloud was refused: %s", error)
