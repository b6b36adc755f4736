"""Connection to an MQTT broker that is made again whenever it is lost, and the messages that wait for it."""

import asyncio
import logging
import ssl
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from aiomqtt import Client, MqttError, Will
from aiomqtt.exceptions import MqttConnectError
from paho.mqtt.reasoncodes import ReasonCode

from ppaas.clock import monotonic
from ppaas.errors import NotAuthenticated, Unavailable
from ppaas.wire.refusals import untrusted
from robots.bridges.vda5050.broker import Broker
from robots.client.connection import backoff


@dataclass(frozen=True, slots=True)
class Outgoing:
    """Message for the broker: topic, payload, quality of service, and whether the broker retains it."""

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False


class Outbox:
    """Queue of messages.

    Parameters
    ----------
    capacity : int
        Largest number of messages that wait.
    """

    def __init__(self, capacity: int = 1000) -> None:
        self._capacity = capacity
        self._waiting: OrderedDict[str, Outgoing] = OrderedDict()
        self._number = 0
        self._filled = asyncio.Event()
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Outgoing) -> None:
        """Queue a message that must not be lost.

        Raises
        ------
        Unavailable
            The queue is full: the broker has been away for long.
        """
        if len(self._waiting) >= self._capacity:
            raise Unavailable(f"{len(self._waiting)} messages wait for the MQTT broker: check that it can be reached")
        self._number += 1
        self._add(f"#{self._number}", message)  # no topic begins with '#'

    def put_newest(self, message: Outgoing) -> None:
        """Queue a message in place of a waiting one of its topic; drop it if the queue is full of others."""
        if self._waiting.pop(message.topic, None) is not None or len(self._waiting) >= self._capacity:
            self.dropped += 1
        if len(self._waiting) < self._capacity:
            self._add(message.topic, message)

    def put_back(self, message: Outgoing) -> None:
        """Queue a message that was taken out and not sent before all others; a newer one of its topic replaces it."""
        if message.topic not in self._waiting and len(self._waiting) < self._capacity:
            self._number += 1
            self._add(f"#{self._number}", message)
            self._waiting.move_to_end(f"#{self._number}", last=False)

    def _add(self, key: str, message: Outgoing) -> None:
        self._waiting[key] = message
        self._filled.set()

    async def next(self) -> Outgoing:
        """Wait for the next message, and take it out of the queue."""
        while not self._waiting:
            self._filled.clear()
            await self._filled.wait()
        return self._waiting.popitem(last=False)[1]


logger = logging.getLogger(__name__)

KEEP_ALIVE = 15
"""Time without messages after which the client pings [s]; the broker publishes the last will after 1.5 times that."""

CONNECT_TIMEOUT = 10.0
"""Time limit of a connection, a subscription or a message that the broker confirms [s]."""

FAREWELL_TIMEOUT = 2.0
"""Time limit of the last message [s]."""

MAX_INCOMING = 2000
"""Largest number of received messages that wait; further ones are dropped."""

STABLE_AFTER = 5.0
"""Age at which a connection counts as stable [s]; delays then start from the shortest again."""

REFUSED = (4, 5, 134, 135)
"""Codes of CONNACK: wrong name or password, and not authorised, as MQTT 3 and 5 number them."""

Received = Callable[[str, bytes, bool], None]
"""Called with the topic and the payload of a message, and whether the broker had retained it."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """Use of a connection.

    Attributes
    ----------
    topics : sequence of str
        Filters of the topics to subscribe to.
    received : Received
        Called with each message; it does not raise.
    connected : callable
        Called after each connection and subscription.
    lost : callable
        Called when a connection is lost.
    will : callable
        Returns the message that the broker publishes when the connection breaks; None for none.
    farewell : callable
        Returns the last message of a link that ends; None for none.
    """

    topics: Sequence[str]
    received: Received
    connected: Callable[[], None] = lambda: None
    lost: Callable[[], None] = lambda: None
    will: Callable[[], Outgoing | None] = lambda: None
    farewell: Callable[[], Outgoing | None] = lambda: None


class MqttLink:
    """Client of a broker.

    Parameters
    ----------
    broker : Broker
    identifier : str
        Identifier of the client, unique at the broker.
    exchange : Exchange

    Attributes
    ----------
    outbox : Outbox
        Messages to send.
    connections : int
        Number of connections so far.
    """

    def __init__(self, broker: Broker, identifier: str, exchange: Exchange) -> None:
        self._broker, self._identifier, self._exchange = broker, identifier, exchange
        self.outbox = Outbox()
        self.connections = 0

    async def run(self) -> None:
        """Exchange messages until cancelled; connect again after each loss.

        Raises
        ------
        NotAuthenticated
            The broker refuses the login of the first connection.
        """
        delays = backoff()
        while True:
            _check_cancelled()
            since = monotonic()
            before = self.connections
            try:
                await self._connect()
            except MqttError as error:
                _check_cancelled()
                if _is_refusal(error) and not self.connections:
                    raise NotAuthenticated(f"the broker {self._name} refuses user or password: {error}") from error
                lost = "lost the connection to" if self.connections > before else "cannot connect to"
                logger.warning("%s the broker %s: %s", lost, self._name, _words_of(error))
            if self.connections > before:
                self._exchange.lost()
                if monotonic() - since > STABLE_AFTER:
                    delays = backoff()
            await asyncio.sleep(next(delays))

    @property
    def _name(self) -> str:
        return f"{self._broker.host}:{self._broker.port}"

    def _client(self) -> Client:
        will = self._exchange.will()
        return Client(
            self._broker.host,
            self._broker.port,
            username=self._broker.user,
            password=self._broker.password,
            identifier=self._identifier,
            will=None if will is None else Will(will.topic, will.payload, will.qos, will.retain),
            clean_session=True,
            timeout=CONNECT_TIMEOUT,
            keepalive=KEEP_ALIVE,
            max_queued_incoming_messages=MAX_INCOMING,
            tls_context=self._broker.tls,
        )

    async def _connect(self) -> None:
        """Exchange messages over one connection until it is lost."""
        async with self._client() as client:
            for topic in self._exchange.topics:
                await client.subscribe(topic, qos=1)
            _check_cancelled()
            self.connections += 1
            logger.info("connected to the broker %s", self._name)
            self._exchange.connected()
            tasks = [asyncio.create_task(self._send(client)), asyncio.create_task(self._receive(client))]
            try:
                await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            except asyncio.CancelledError:
                await self._say_farewell(client, tasks)
                raise
            finally:
                for task in tasks:
                    task.cancel()
                await asyncio.gather(*tasks, return_exceptions=True)
            for task in tasks:
                if not task.cancelled():
                    task.result()

    async def _send(self, client: Client) -> None:
        while True:
            message = await self.outbox.next()
            try:
                await client.publish(message.topic, message.payload, message.qos, message.retain)
            except MqttError:
                self.outbox.put_back(message)
                raise
            _check_cancelled()

    async def _receive(self, client: Client) -> None:
        async for message in client.messages:
            payload = message.payload
            if isinstance(payload, bytes | bytearray):
                self._exchange.received(message.topic.value, bytes(payload), message.retain)

    async def _say_farewell(self, client: Client, tasks: Sequence[asyncio.Task[None]]) -> None:
        for task in tasks:
            task.cancel()
        farewell = self._exchange.farewell()
        if farewell is None:
            return
        try:
            async with asyncio.timeout(FAREWELL_TIMEOUT):
                await client.publish(farewell.topic, farewell.payload, farewell.qos, farewell.retain)
        except (MqttError, TimeoutError) as error:
            logger.warning("the broker %s did not take the last message: %s", self._name, error)


def _check_cancelled() -> None:
    """Raise if the task was cancelled.

    Closing a connection may fail then, and its error hides the cancellation; and `asyncio.wait_for` of Python 3.11,
    which aiomqtt calls, loses a cancellation if what it waits for ends at the same moment.
    """
    task = asyncio.current_task()
    if task is not None and task.cancelling():
        raise asyncio.CancelledError


def _words_of(error: MqttError) -> str:
    cause = error.__context__  # aiomqtt raises it from None
    if isinstance(cause, ssl.SSLCertVerificationError):
        return untrusted(cause.verify_message, "--broker-ca-file")
    return str(error)


def _is_refusal(error: MqttError) -> bool:
    if not isinstance(error, MqttConnectError):
        return False
    return (error.rc.value if isinstance(error.rc, ReasonCode) else error.rc) in REFUSED
