"""Session on the fabric: publications and requests over Zenoh, through the router of the machine.

Publications may be lost, when the router is unreachable or a reader is slow. A *request* is reliable: it has an id, is
repeated until it is answered or times out, and is executed once however often it arrives. After the router died, the
session reconnects by itself with all its declarations.
"""

import asyncio
import logging
import uuid
from collections.abc import Awaitable, Callable
from typing import Any, Protocol, cast

import msgspec
import zenoh

from engine.fabric.inbox import Inbox, RequestCache
from engine.fabric.zenoh_config import RouterCredentials, client_config
from engine.protocols.refusals import Refusal, error_of, refusal_of
from ppaas.clock import monotonic
from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidParameter, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

MAX_PATIENCE = 60.0
"""Longest timeout of a request [s]."""

FIRST_ATTEMPT, LAST_ATTEMPT = 0.25, 1.0
"""Time before an unanswered request is repeated [s]; doubled each time, up to the last."""

FIRST_PAUSE, LAST_PAUSE = 0.02, 0.25
"""Pause between repetitions while no server is reachable [s]; doubled each time, up to the last."""

_REFUSAL = zenoh.Encoding("application/x-ppaas-refusal")
"""Encoding of our own errors, which distinguishes them from Zenoh's."""

Handler = Callable[[str, bytes], Awaitable[bytes]]
"""Takes key and payload of a request; returns the answer, or raises a PPaaSError, which is sent to the client."""


class _Envelope(msgspec.Struct, frozen=True):
    id: str
    patience: float


class _Entity(Protocol):
    def undeclare(self) -> None: ...


class Declaration:
    """A declaration on the fabric: a subscription, a service, a watch or a liveliness token.

    Parameters
    ----------
    loop : AbstractEventLoop
        Event loop of the fabric.
    entity : object
        The declared object of Zenoh.
    inbox : Inbox, optional
        Queue that it fills.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, entity: _Entity, inbox: Inbox[Any] | None = None) -> None:
        self._loop = loop
        self._entity = entity
        self._inbox = inbox

    def close(self) -> None:
        """Undeclare it. Its callback is not called again. Zenoh is called in a thread, since that may block."""
        if self._inbox is not None:
            self._inbox.close()
        self._loop.run_in_executor(None, self._entity.undeclare)


class Fabric:
    """A session on the fabric; use ``Fabric.open``.

    Parameters
    ----------
    session : zenoh.Session
        Open session, owned by this object from now on.
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
            Credentials that the router accepts.
        timeout : float
            Time limit for connecting [s].

        Raises
        ------
        Unavailable
            No router answers there, or it refuses the credentials.
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
        """Close the session, then cancel all requests that are being answered. Closing twice is allowed."""
        # In the other order, Zenoh's threads would call into a closed loop and wait for ever.
        await asyncio.to_thread(self._session.close)
        self._answers.cancel()
        for task in self._replying:
            task.cancel()

    def _declare(self, entity: object, inbox: Inbox[Any] | None = None) -> Declaration:
        return Declaration(self._loop, cast(_Entity, entity), inbox)

    # -- publications, which may be lost -------------------------------------------------------------------------------

    def publish(self, key: str, payload: bytes) -> None:
        """Publish without waiting. The message is lost while there is no router or the queue is full."""
        # Not "express", which sends each message in its own batch: a burst to a healthy reader would overrun the queue.
        self._session.put(key, payload, congestion_control=zenoh.CongestionControl.DROP)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, limit: int = 64) -> Declaration:
        """Subscribe to a key expression; the callback gets key and payload of each publication, on the loop.

        When the callback is slower than the publishers, the newest ``limit`` publications are queued and older ones
        are lost.
        """

        def take(sample: zenoh.Sample) -> None:
            callback(str(sample.key_expr), bytes(sample.payload))

        inbox = Inbox(self._loop, take, limit)
        return self._declare(self._session.declare_subscriber(key, inbox.put), inbox)

    # -- requests, which are repeated until answered -------------------------------------------------------------------

    async def request(
        self,
        key: str,
        payload: bytes,
        *,
        id: str | None = None,  # noqa: A002  # the usual word
        timeout: float = 5.0,
    ) -> bytes:
        """Send a request to the server of a key, repeatedly until it is answered.

        Parameters
        ----------
        key : str
            Key, without wildcards.
        payload : bytes
            The request.
        id : str, optional
            Id of the request. The id of an earlier request returns its answer again, within its timeout. Default: a new
            id.
        timeout : float
            Time limit [s], at most 60.

        Raises
        ------
        Unavailable
            No answer arrived in time; the request may have been executed.
        PPaaSError
            The error that the server answered with.
        """
        if not 0.0 < timeout <= MAX_PATIENCE:
            raise InvalidParameter(
                f"the timeout of a request must be greater than 0 and at most {MAX_PATIENCE:g} s, not {timeout}"
            )
        envelope = msgspec.msgpack.encode(_Envelope(id or uuid.uuid4().hex, timeout))
        deadline = monotonic() + timeout
        pause, attempt = FIRST_PAUSE, FIRST_ATTEMPT
        while (left := deadline - monotonic()) > 0.0:
            reply = await self._attempt(key, payload, envelope, min(left, attempt))
            if reply is not None and (answer := _unpack(reply)) is not None:
                return answer
            await asyncio.sleep(min(pause, max(0.0, deadline - monotonic())))
            pause, attempt = min(2 * pause, LAST_PAUSE), min(2 * attempt, LAST_ATTEMPT)
        raise Unavailable(f"no answer from {key!r} within {timeout:g} s")

    async def _attempt(self, key: str, payload: bytes, envelope: bytes, timeout: float) -> zenoh.Reply | None:
        first: asyncio.Future[zenoh.Reply | None] = self._loop.create_future()

        def settle(reply: zenoh.Reply | None) -> None:
            if not first.done():
                first.set_result(reply)

        def resolve(reply: zenoh.Reply | None = None) -> None:
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(settle, reply)

        self._session.get(
            key,
            zenoh.handlers.Callback(resolve, resolve),
            payload=payload,
            attachment=envelope,
            timeout=timeout,
            # A lost request is repeated; blocking here would stall the event loop.
            congestion_control=zenoh.CongestionControl.DROP,
        )
        return await first

    def serve(self, key: str, handler: Handler, *, limit: int = 1024) -> Declaration:
        """Answer the requests under a key expression; each is executed once, however often it arrives.

        The ids of executed requests are lost when this process restarts. A handler must therefore be idempotent, or
        store the results under its own ids.
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
                answer = await asyncio.shield(self._execute(query, handler))
                query.reply(query.key_expr, answer)
            except PPaaSError as error:
                _refuse(query, error)
            except zenoh.ZError as error:
                logger.warning("the answer to a request on %s could not be sent: %s", query.key_expr, error)
            except Exception as error:
                logger.exception("a request on %s failed", query.key_expr)
                _refuse(query, PPaaSError(f"internal error: {type(error).__name__}"))

    def _execute(self, query: zenoh.Query, handler: Handler) -> Awaitable[bytes]:
        if query.attachment is None:
            raise InvalidParameter("the request has no id attached")
        try:
            envelope = from_msgpack(bytes(query.attachment), _Envelope)
        except msgspec.DecodeError as error:
            raise InvalidParameter(f"the attachment of the request is invalid: {error}") from error
        key, payload = str(query.key_expr), bytes(query.payload or b"")

        async def begin() -> bytes:
            return await handler(key, payload)

        return self._answers.answer(f"{key} {envelope.id}", min(envelope.patience, MAX_PATIENCE), begin)

    # -- liveliness ----------------------------------------------------------------------------------------------------

    def announce(self, key: str) -> Declaration:
        """Declare a liveliness token under a key, which others can watch."""
        return self._declare(self._session.liveliness().declare_token(key))

    def watch(self, key: str, callback: Callable[[str, bool], None], *, limit: int = 1024) -> Declaration:
        """Watch liveliness tokens; the callback gets the key and true when one appears, false when it disappears.

        It is called on the loop, first for all existing tokens. When the router dies all tokens disappear; they appear
        again when it is back.
        """

        def take(sample: zenoh.Sample) -> None:
            callback(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        inbox = Inbox(self._loop, take, limit)
        return self._declare(self._session.liveliness().declare_subscriber(key, inbox.put, history=True), inbox)


def _refuse(query: zenoh.Query, error: PPaaSError) -> None:
    query.reply_err(msgspec.msgpack.encode(refusal_of(error)), encoding=_REFUSAL)


def _unpack(reply: zenoh.Reply) -> bytes | None:
    """Return the answer, or None if Zenoh itself reports an error, such as a timeout; raise the server's error."""
    if reply.ok is not None:
        return bytes(reply.ok.payload)
    if reply.err is None or reply.err.encoding != _REFUSAL:
        return None
    refusal = from_msgpack(bytes(reply.err.payload), Refusal)
    raise error_of(refusal)
