"""The services that a client offers: each call is answered in a task of its own, so that none holds up the socket."""

import asyncio
import inspect
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from ppaas.errors import Conflict, NotFound, PPaaSError, QuotaExceeded, Unavailable
from ppaas.messages import Message, ServiceType, decode
from ppaas.wire.names import normalise
from ppaas.wire.operations import CallService
from ppaas.wire.rosbridge_client import RosbridgeClientSession
from robots.client.send_queue import SUBSCRIPTION, Outbox

logger = logging.getLogger(__name__)

Handler = Callable[[Any], Message | Awaitable[Message]]
"""Takes a request; returns the response, now or as a coroutine, or raises a ``PPaaSError``."""

ANSWER = "answer"
"""What answers are bound to: in another session their numbers are those of other calls."""

MAX_CALLS = 100
"""Calls that may be worked on at a time; more are refused."""


@dataclass(frozen=True, slots=True)
class _Offer:
    kind: ServiceType
    handler: Handler


class Offers:
    """What one client offers.

    Parameters
    ----------
    session : RosbridgeClientSession
        Makes the frames, and says again what is offered where a session begins anew.
    outbox : Outbox
        Where they go.
    """

    def __init__(self, session: RosbridgeClientSession, outbox: Outbox) -> None:
        self._session = session
        self._outbox = outbox
        self._offers: dict[str, _Offer] = {}
        self._working: set[asyncio.Task[None]] = set()

    async def advertise(self, service: str, kind: ServiceType, handler: Handler) -> None:
        """Offer a service.

        Raises
        ------
        Conflict
            It is offered already.
        PPaaSError
            Not a ROS graph name, or nothing is sent any more.
        """
        name = normalise(service)
        if name in self._offers:
            raise Conflict(f"this client offers service {name!r} already: unadvertise it first")
        frame = self._session.advertise_service(service, kind)
        self._offers[name] = _Offer(kind, handler)
        await self._outbox.put(frame, SUBSCRIPTION)

    async def unadvertise(self, service: str) -> None:
        """Offer a service no more; what is under way is still answered.

        Raises
        ------
        NotFound
            It is not offered.
        PPaaSError
            Nothing is sent any more.
        """
        name = normalise(service)
        if self._offers.pop(name, None) is None:
            raise NotFound("offered service", name, list(self._offers))
        await self._outbox.put(self._session.unadvertise_service(service), SUBSCRIPTION)

    def called(self, call: CallService) -> None:
        """Take a call, which is answered whatever becomes of it."""
        task = asyncio.create_task(self._serve(call, full=len(self._working) >= MAX_CALLS))
        self._working.add(task)
        task.add_done_callback(self._working.discard)

    def lost(self) -> None:
        """Work no more on what the cloud has told its callers is lost."""
        self.end()
        self._outbox.discard(ANSWER)

    def end(self) -> None:
        """Give up all that is under way."""
        for task in self._working:
            task.cancel()

    async def _serve(self, call: CallService, *, full: bool) -> None:
        try:
            if full:
                raise QuotaExceeded(f"a client works on {MAX_CALLS} calls at a time: call {call.service!r} again later")
            frame = self._session.respond(call, await self._response(call))
        except PPaaSError as error:
            frame = self._session.refuse(call, error)
        except Exception as error:
            logger.exception("the handler of %r failed", call.service)
            failure = PPaaSError(f"the handler of {call.service!r} failed: {type(error).__name__}")
            frame = self._session.refuse(call, failure)
        await self._outbox.put(frame, ANSWER)

    async def _response(self, call: CallService) -> Message:
        offer = self._offers.get(normalise(call.service))
        if offer is None:
            raise Unavailable(f"{call.service!r} is offered here no more; call again, to find who offers it now")
        answer = offer.handler(decode(offer.kind.request, call.args))
        response = await answer if inspect.isawaitable(answer) else answer
        if not isinstance(response, offer.kind.response):
            wanted, got = offer.kind.response.__name__, type(response).__name__
            raise PPaaSError(f"the handler of {call.service!r} returned {got}, not {wanted}")
        return response
