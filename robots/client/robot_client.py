"""Client of the cloud's WebSocket for a robot or its operator.

::

    async with RobotClient("http://cloud:8500", robot="tb1", token=token) as client:
        await client.subscribe("cmd_vel", Twist, base.command)
        await client.publish("odom", odometry)

A lost connection is reestablished: the client resumes its session, or begins a new one and renews its subscriptions and
advertised services. The client fails for good only if the cloud refuses it; every method then raises the reason.
"""

import asyncio
import logging
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Protocol, Self, TypeVar
from uuid import uuid4

import msgspec

from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import Message, ServiceType
from ppaas.wire.names import normalise
from ppaas.wire.operations import CallService
from ppaas.wire.rosbridge_client import ReceivedMessage, RosbridgeClientSession, ServiceResult, StatusReport
from robots.client.connection import Address, ConnectionOptions, Role, backoff
from robots.client.connection_keeper import ConnectionKeeper
from robots.client.send_queue import SUBSCRIPTION, SendQueue
from robots.client.services import AdvertisedServices, Handler, ServiceCalls
from robots.client.subscription import SubscriptionRegistry, TopicSubscription


class NearbyNodes(Protocol):
    """Local nodes that exchange messages with a client directly, without the cloud."""

    def published(self, topic: str, message: Message) -> bool:
        """Process a message that the client publishes; return whether it must go to the cloud as well."""
        ...

    def owns(self, topic: str) -> bool:
        """Return whether these nodes are the only publishers of a topic; the client then ignores the cloud's copies."""
        ...


logger = logging.getLogger(__name__)

M = TypeVar("M", bound=Message)


def _log_status(error: PPaaSError) -> None:
    logger.warning("the cloud reported an error: %s", error)


class RobotClient:
    """Publishes, subscribes, calls services and advertises services for one robot.

    Parameters
    ----------
    url : str
        URL of the cloud: ``http://host:port`` (or https, ws, wss).
    robot, token, role : str
        Id of the robot, token of the user, and role of this client: ``robot`` or ``operator``.
    session : str, optional
        Name under which the cloud keeps this client's session while it is disconnected; a random one by default.
    hold : bool
        Whether this client opens a place for the robot and keeps it open; False for an operator that only watches.
    link : ConnectionOptions, optional
        Time-outs and sizes of the connection.
    connect_timeout : float
        Time limit for the first connection, over all attempts [s]. It begins again each time that the cloud says that
        it is starting, as on the first start on a computer, which compiles kernels.
    capacity : int
        Maximum number of queued frames; ``publish`` waits while the queue is full.
    reconnect_delays : callable
        Returns an iterator of the delays between attempts to connect [s].
    on_status : callable
        Called with each error that the cloud reports; logs it by default.
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
        link: ConnectionOptions | None = None,
        connect_timeout: float = 30.0,
        capacity: int = 256,
        reconnect_delays: Callable[[], Iterator[float]] = backoff,
        on_status: Callable[[PPaaSError], None] = _log_status,
    ) -> None:
        self._connect_timeout = connect_timeout
        self._on_status = on_status
        self._session = RosbridgeClientSession()
        self._queue = SendQueue(capacity)
        self._keeper = ConnectionKeeper(
            Address(url, robot=robot, token=token, role=role, session=session or uuid4().hex, hold=hold),
            link or ConnectionOptions(),
            self._queue,
            reconnect_delays,
            greeting=self._session.reconnected,
            received=self._handle_frame,
            lost=self._session_lost,
        )
        self._subscriptions = SubscriptionRegistry()
        self._calls = ServiceCalls(self._session, self._queue)
        self._services = AdvertisedServices(self._session, self._queue)
        self._nearby: NearbyNodes | None = None
        self._failure: PPaaSError | None = None
        self._runner: asyncio.Task[None] | None = None

    # -- connection ----------------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Connect.

        Raises
        ------
        PPaaSError
            The reason of the cloud's refusal, or ``Unavailable`` if it was not reached within ``connect_timeout``.
        """
        self._runner = asyncio.create_task(self._run())
        try:
            await self._keeper.wait_connected(self._runner, self._connect_timeout, self._check)
        except BaseException:
            await self._stop()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None and self._failure is None and self._keeper.connected.is_set():
            await self._flush()
        await self._stop()

    async def _flush(self, timeout: float = 2.0) -> None:
        try:
            await asyncio.wait_for(self._queue.drained(), timeout)
        except (TimeoutError, PPaaSError):
            logger.warning("%d frames were not sent before the client closed", len(self._queue))

    async def _stop(self) -> None:
        if self._runner is not None:
            self._runner.cancel()
            await asyncio.gather(self._runner, return_exceptions=True)
        self._end(Unavailable("the client is closed"), None)

    @property
    def connected(self) -> bool:
        """Whether the client is connected now."""
        return self._keeper.connected.is_set()

    @property
    def connections(self) -> int:
        """Number of connections so far."""
        return self._keeper.connections

    @property
    def resumptions(self) -> int:
        """Number of connections that resumed the previous session."""
        return self._keeper.resumptions

    @property
    def dropped(self) -> int:
        """Number of newest-only messages that were replaced or dropped before they were sent."""
        return self._queue.dropped

    async def closed(self) -> None:
        """Wait until the client has failed for good, and raise the reason."""
        if self._runner is not None:
            await asyncio.wait({self._runner})
        self._check()

    def _check(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _end(self, for_senders: PPaaSError, for_readers: PPaaSError | None) -> None:
        self._failure = self._failure or for_senders
        self._queue.close(self._failure)
        self._calls.fail(self._failure)
        self._services.end()
        self._subscriptions.close(for_readers)

    # -- topics and services -------------------------------------------------------------------------------------------

    async def publish(self, topic: str, message: Message, *, newest_only: bool = False) -> None:
        """Publish a message.

        Parameters
        ----------
        topic : str
            Topic of this robot.
        message : Message
            Message to publish.
        newest_only : bool
            Replace a queued message of this topic, and never wait: for streams on a slow link. Otherwise no message is
            dropped, and the call waits while the queue is full.

        Raises
        ------
        PPaaSError
            The client has failed or is closed.
        """
        self._check()
        if self._nearby is not None and not self._nearby.published(normalise(topic), message):
            return
        frame = self._session.publish(topic, message)
        if newest_only:
            self._queue.put_newest(normalise(topic), frame)
        else:
            await self._queue.put(frame)

    async def subscribe(
        self,
        topic: str,
        kind: type[M],
        callback: Callable[[M], None] | None = None,
        *,
        queue_size: int = 100,
        throttle: float = 0.0,
    ) -> TopicSubscription[M]:
        """Subscribe to a topic; messages go to the callback, or to an iteration over the returned subscription.

        Parameters
        ----------
        topic : str
            Topic of this robot.
        kind : type of Message
            Message type of the topic.
        callback : callable, optional
            Called with each message on the event loop.
        queue_size : int
            Messages kept for a slow reader, here and in the cloud; 1 keeps only the newest.
        throttle : float
            Least time between two messages [s].

        Raises
        ------
        PPaaSError
            The client has failed or is closed.
        """
        self._check()
        subscription = TopicSubscription(topic, kind, callback, queue_size)
        frame = self._session.subscribe(topic, kind, throttle, queue_size)
        self._subscriptions.add(subscription)
        await self._queue.put(frame, SUBSCRIPTION)
        return subscription

    async def unsubscribe(self, subscription: TopicSubscription[M]) -> None:
        """End a subscription."""
        if self._subscriptions.remove(subscription):
            frame = self._session.unsubscribe(normalise(subscription.topic))
            await self._queue.put(frame, SUBSCRIPTION)

    async def call(self, service: str, kind: ServiceType, request: Message, timeout: float = 10.0) -> Message:
        """Call a service of the robot's clone or of another client; return the response, a ``kind.response``.

        Raises
        ------
        Unavailable
            There was no response within ``timeout`` seconds, or the session was lost.
        PPaaSError
            The error that the service returned.
        """
        self._check()
        return await self._calls.call(service, kind, request, timeout)

    async def advertise_service(self, service: str, kind: ServiceType, handler: Handler) -> None:
        """Advertise a service to the robot's clone and to all its clients.

        The cloud reports a refusal, such as for the name of a service of the clone, through ``on_status``.

        Parameters
        ----------
        service : str
            Name of the service.
        kind : ServiceType
            Its request and response types.
        handler : callable
            Called on the event loop with each request, a ``kind.request``; returns the response, a ``kind.response``,
            or an awaitable of it. Several calls may be in progress at once. The caller gets a ``PPaaSError`` that it
            raises. A coroutine is cancelled if the session is lost, since the caller no longer waits.

        Raises
        ------
        Conflict
            This client already advertises the service.
        PPaaSError
            The name is not a valid ROS graph name, or the client has failed or is closed.
        """
        self._check()
        await self._services.advertise(service, kind, handler)

    async def unadvertise_service(self, service: str) -> None:
        """Withdraw a service; calls in progress are still answered.

        Raises
        ------
        NotFound
            This client does not advertise the service.
        PPaaSError
            The client has failed or is closed.
        """
        self._check()
        await self._services.unadvertise(service)

    # -- local nodes ---------------------------------------------------------------------------------------------------

    def attach(self, nearby: NearbyNodes | None) -> None:
        """Attach local nodes, which get this client's messages and publish to its subscriptions; None detaches."""
        self._nearby = nearby

    def deliver(self, topic: str, payload: msgspec.Raw) -> None:
        """Deliver a message of a local node or of the cloud to the subscriptions of its topic.

        Raises
        ------
        MalformedMessage
            The message is not of the topic's type.
        """
        self._subscriptions.deliver(topic, payload)

    # -- incoming frames -----------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        try:
            await self._keeper.run()
        except PPaaSError as error:
            self._end(error, error)
        except Exception as error:
            logger.exception("a callback failed; the client stops")
            failure = PPaaSError(f"a callback of the client failed: {error!r}")
            self._end(failure, failure)

    def _session_lost(self) -> None:
        self._calls.session_lost()
        self._services.session_lost()

    def _handle_frame(self, frame: str | bytes) -> None:
        try:
            operation = self._session.receive(frame)
            if isinstance(operation, ReceivedMessage):
                if self._nearby is None or not self._nearby.owns(normalise(operation.topic)):
                    self._subscriptions.deliver(operation.topic, operation.msg)
            elif isinstance(operation, ServiceResult):
                self._calls.handle_response(operation)
            elif isinstance(operation, CallService):
                self._services.handle_call(operation)
            elif isinstance(operation, StatusReport):
                self._on_status(operation.error())
        except PPaaSError as error:
            logger.warning("ignored an invalid frame of the cloud: %s", error)
