"""The fabric: what containers, machines and stores share, over a Zenoh session to the router of the machine.

Publications may be lost: when the router is away, when a reader is slow. What must arrive is a *request*: it has an
id, is repeated until it is answered or its time is up, and is carried out once however often it arrives. The session
comes back by itself after the router died, and all that was declared with it.
"""

import asyncio
import logging
import uuid
from collections.abc import Awaitable, Callable
from typing import Any, Protocol, cast

import msgspec
import zenoh

from engine.fabric.inbox import Inbox
from engine.fabric.request_cache import RequestCache
from engine.fabric.zenoh_config import RouterCredentials, client_config
from engine.protocols.robot_link import Refusal
from ppaas.clock import monotonic
from ppaas.errors import InvalidParameter, PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

MAX_PATIENCE = 60.0
FIRST_ATTEMPT, LAST_ATTEMPT = 0.25, 1.0
"""Seconds after which a request is repeated that nobody has answered yet; doubled each time up to the last."""

FIRST_PAUSE, LAST_PAUSE = 0.02, 0.25
"""Seconds between repetitions while nobody is there to answer; doubled each time up to the last."""

_REFUSAL = zenoh.Encoding("application/x-ppaas-refusal")
"""Marks our own errors among those that Zenoh makes itself."""

Handler = Callable[[str, bytes], Awaitable[bytes]]
"""Takes key and payload of a request, returns the answer, or raises a PPaaSError that is told to whoever asked."""


class _Envelope(msgspec.Struct, frozen=True):
    """What travels beside the payload of a request."""

    id: str
    patience: float


class _Entity(Protocol):
    def undeclare(self) -> None: ...


class Declaration:
    """Something declared on the fabric: a subscription, a service, a watch or a token of life.

    Parameters
    ----------
    loop : AbstractEventLoop
        Of the fabric.
    entity : object
        Zenoh's own.
    inbox : Inbox, optional
        That it fills.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, entity: _Entity, inbox: Inbox[Any] | None = None) -> None:
        self._loop = loop
        self._entity = entity
        self._inbox = inbox

    def close(self) -> None:
        """Take it back. Its callback is called no more; the router is told in a thread, since that may block."""
        if self._inbox is not None:
            self._inbox.close()
        self._loop.run_in_executor(None, self._entity.undeclare)


class Fabric:
    """A session on the fabric; use ``Fabric.open``.

    Parameters
    ----------
    session : zenoh.Session
        Open, and from now on ours.
    """

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._loop = asyncio.get_running_loop()
        self._answers = RequestCache()
        self._replying: set[asyncio.Task[None]] = set()

    @classmethod
    async def open(cls, endpoint: str, credentials: RouterCredentials, *, timeout: float = 5.0) -> "Fabric":
        """Open a session.

        Parameters
        ----------
        endpoint : str
            Zenoh endpoint of the router.
        credentials : RouterCredentials
            That the router knows.
        timeout : float
            Seconds to go on trying.

        Raises
        ------
        Unavailable
            No router answers there, or it does not let us in.
        """
        config = client_config(endpoint, credentials)
        deadline = monotonic() + timeout
        while True:
            try:
                return cls(await asyncio.to_thread(zenoh.open, config))
            except zenoh.ZError as error:
                if monotonic() > deadline:
                    raise Unavailable(f"no session with the router at {endpoint}: {error}") from error
            await asyncio.sleep(FIRST_PAUSE)

    async def close(self) -> None:
        """Close the session, then stop answering. Closing twice is allowed."""
        # The other way round, Zenoh's threads would call into a loop that has ended, and wait for it for ever.
        await asyncio.to_thread(self._session.close)
        self._answers.cancel()
        for task in self._replying:
            task.cancel()

    def _declare(self, entity: object, inbox: Inbox[Any] | None = None) -> Declaration:
        return Declaration(self._loop, cast(_Entity, entity), inbox)

    # -- publications, which may be lost -------------------------------------------------------------------------------

    def publish(self, key: str, payload: bytes) -> None:
        """Publish; it does not wait, and is lost while there is no router or no room."""
        # Not "express": that sends each message by itself, and a burst to a healthy reader overruns the queue.
        self._session.put(key, payload, congestion_control=zenoh.CongestionControl.DROP)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, limit: int = 64) -> Declaration:
        """Call back on the loop with key and payload of what is published under a key expression.

        Where the callback is slower than the publishers, the newest ``limit`` publications wait and older ones are
        lost.
        """

        def take(sample: zenoh.Sample) -> None:
            callback(str(sample.key_expr), bytes(sample.payload))

        inbox = Inbox(self._loop, take, limit)
        return self._declare(self._session.declare_subscriber(key, inbox.put), inbox)

    # -- requests, which are not ---------------------------------------------------------------------------------------

    async def request(
        self,
        key: str,
        payload: bytes,
        *,
        id: str | None = None,  # noqa: A002  # the word for it
        timeout: float = 5.0,
    ) -> bytes:
        """Ask whoever serves a key, again and again until there is an answer.

        Parameters
        ----------
        key : str
            Without wildcards.
        payload : bytes
            The request.
        id : str, optional
            Of the request; give that of an earlier one to ask for its answer again, if it was not longer ago than its
            timeout. Without it, a new one.
        timeout : float
            Seconds, at most 60.

        Raises
        ------
        Unavailable
            No answer came in time; whether the request was carried out is not known.
        PPaaSError
            What the server answered instead.
        """
        if not 0.0 < timeout <= MAX_PATIENCE:
            raise InvalidParameter(f"a request waits for up to {MAX_PATIENCE:g} s, not {timeout}")
        envelope = msgspec.msgpack.encode(_Envelope(id or uuid.uuid4().hex, timeout))
        deadline = monotonic() + timeout
        pause, attempt = FIRST_PAUSE, FIRST_ATTEMPT
        while (left := deadline - monotonic()) > 0.0:
            reply = await self._ask(key, payload, envelope, min(left, attempt))
            if reply is not None and (answer := _unpack(reply)) is not None:
                return answer
            await asyncio.sleep(min(pause, max(0.0, deadline - monotonic())))
            pause, attempt = min(2 * pause, LAST_PAUSE), min(2 * attempt, LAST_ATTEMPT)
        raise Unavailable(f"no answer from {key!r} within {timeout:g} s")

    async def _ask(self, key: str, payload: bytes, envelope: bytes, timeout: float) -> zenoh.Reply | None:
        first: asyncio.Future[zenoh.Reply | None] = self._loop.create_future()

        def settle(reply: zenoh.Reply | None) -> None:
            if not first.done():
                first.set_result(reply)

        def tell(reply: zenoh.Reply | None = None) -> None:
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(settle, reply)

        self._session.get(
            key,
            zenoh.handlers.Callback(tell, tell),
            payload=payload,
            attachment=envelope,
            timeout=timeout,
            congestion_control=zenoh.CongestionControl.DROP,  # a lost one is repeated; a blocked loop stalls all
        )
        return await first

    def serve(self, key: str, handler: Handler, *, limit: int = 1024) -> Declaration:
        """Answer the requests under a key expression; each is carried out once, however often it arrives.

        What this process carried out it no longer knows after it was started again: a handler keeps what it did
        under ids of its own, or can be repeated.
        """

        def take(query: zenoh.Query) -> None:
            task = asyncio.ensure_future(self._reply(query, handler))
            self._replying.add(task)
            task.add_done_callback(self._replying.discard)

        inbox = Inbox(self._loop, take, limit)
        return self._declare(self._session.declare_queryable(key, inbox.put), inbox)

    async def _reply(self, query: zenoh.Query, handler: Handler) -> None:
        with query:
            try:
                answer = await asyncio.shield(self._carry_out(query, handler))
                query.reply(query.key_expr, answer)
            except PPaaSError as error:
                _refuse(query, error)
            except zenoh.ZError as error:
                logger.warning("an answer on %s could not be sent: %s", query.key_expr, error)
            except Exception as error:
                logger.exception("a request on %s failed", query.key_expr)
                _refuse(query, PPaaSError(f"internal error: {type(error).__name__}"))

    def _carry_out(self, query: zenoh.Query, handler: Handler) -> Awaitable[bytes]:
        if query.attachment is None:
            raise InvalidParameter("a request carries an id beside its payload")
        try:
            envelope = msgspec.msgpack.decode(bytes(query.attachment), type=_Envelope)
        except msgspec.DecodeError as error:
            raise InvalidParameter(f"not the envelope of a request: {error}") from error
        key, payload = str(query.key_expr), bytes(query.payload or b"")

        async def begin() -> bytes:
            return await handler(key, payload)

        return self._answers.answer(f"{key} {envelope.id}", min(envelope.patience, MAX_PATIENCE), begin)

    # -- who is there --------------------------------------------------------------------------------------------------

    def announce(self, key: str) -> Declaration:
        """Let others see that we live, under a key."""
        return self._declare(self._session.liveliness().declare_token(key))

    def watch(self, key: str, callback: Callable[[str, bool], None], *, limit: int = 1024) -> Declaration:
        """Call back on the loop with the key of each who comes (true) or goes (false), first those who are there.

        When the router dies, all go, and come again with it.
        """

        def take(sample: zenoh.Sample) -> None:
            callback(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        inbox = Inbox(self._loop, take, limit)
        return self._declare(self._session.liveliness().declare_subscriber(key, inbox.put, history=True), inbox)


def _refuse(query: zenoh.Query, error: PPaaSError) -> None:
    query.reply_err(msgspec.msgpack.encode(Refusal(error.slug, str(error))), encoding=_REFUSAL)


def _unpack(reply: zenoh.Reply) -> bytes | None:
    """Return the answer; None where Zenoh says by itself that there is none, as when it waited in vain."""
    if reply.ok is not None:
        return bytes(reply.ok.payload)
    if reply.err is None or reply.err.encoding != _REFUSAL:
        return None
    refusal = msgspec.msgpack.decode(bytes(reply.err.payload), type=Refusal)
    raise rebuild(refusal.slug, refusal.text)
