"""Services of a client: those that it calls, and those that it advertises.

Each call of an advertised service runs in its own task, so a slow handler does not block the socket.
"""

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
from ppaas.wire.rosbridge_client import RosbridgeClientSession, ServiceResult, failure_of
from robots.client.send_queue import SUBSCRIPTION, SendQueue


class ServiceCalls:
    """Calls that wait for a response.

    Parameters
    ----------
    session : RosbridgeClientSession
        Builds the frames.
    queue : SendQueue
        Queue of frames to the cloud.
    """

    def __init__(self, session: RosbridgeClientSession, queue: SendQueue) -> None:
        self._session = session
        self._queue = queue
        self._waiting: dict[str, asyncio.Future[ServiceResult]] = {}

    async def call(self, service: str, kind: ServiceType, request: Message, timeout: float) -> Message:
        """Call a service and return its response.

        Raises
        ------
        Unavailable
            There was no response within ``timeout`` seconds, or the session was lost.
        PPaaSError
            The error that the service returned.
        """
        call_id, frame = self._session.call(service, request)
        self._waiting[call_id] = asyncio.get_running_loop().create_future()
        try:
            async with asyncio.timeout(timeout):
                await self._queue.put(frame, call_id)
                response = await self._waiting[call_id]
        except TimeoutError as error:
            raise Unavailable(f"service {service!r} did not answer within {timeout:g} s") from error
        finally:
            del self._waiting[call_id]
            self._session.give_up(call_id)
            self._queue.discard(call_id)
        failure = failure_of(response)
        if failure is not None:
            raise failure
        return decode(kind.response, response.values)

    def handle_response(self, response: ServiceResult) -> None:
        """Complete the call that a response belongs to."""
        future = self._waiting.get(response.id or "")
        if future is not None and not future.done():
            future.set_result(response)

    def session_lost(self) -> None:
        """Fail the calls of the lost session; calls that were not sent yet stay queued."""
        for call_id, error in self._session.disconnected(self._queue.waiting()).items():
            self._fail(call_id, error)

    def fail(self, error: PPaaSError) -> None:
        """Fail all calls with an error."""
        for call_id in self._waiting:
            self._fail(call_id, error)

    def _fail(self, call_id: str, error: PPaaSError) -> None:
        future = self._waiting.get(call_id)
        if future is not None and not future.done():
            future.set_exception(error)


logger = logging.getLogger(__name__)

# -- services that a client advertises ---------------------------------------------------------------------------------

Handler = Callable[[Any], Message | Awaitable[Message]]
"""Takes a request and returns the response or an awaitable of it; may raise a ``PPaaSError``."""

ANSWER = "answer"
"""Key of queued responses: call numbers are valid in one session only, so they are discarded with it."""

MAX_CALLS = 100
"""Maximum number of calls in progress; further calls are refused."""


@dataclass(frozen=True, slots=True)
class _AdvertisedService:
    kind: ServiceType
    handler: Handler


class AdvertisedServices:
    """Registry of the services of one client.

    Parameters
    ----------
    session : RosbridgeClientSession
        Builds the frames; advertises the services again when a new session begins.
    queue : SendQueue
        Queue of frames to the cloud.
    """

    def __init__(self, session: RosbridgeClientSession, queue: SendQueue) -> None:
        self._session = session
        self._queue = queue
        self._services: dict[str, _AdvertisedService] = {}
        self._in_progress: set[asyncio.Task[None]] = set()

    async def advertise(self, service: str, kind: ServiceType, handler: Handler) -> None:
        """Advertise a service.

        Raises
        ------
        Conflict
            This client already advertises the service.
        PPaaSError
            The name is not a valid ROS graph name, or the queue is closed.
        """
        name = normalise(service)
        if name in self._services:
            raise Conflict(f"this client already advertises service {name!r}; unadvertise it first")
        frame = self._session.advertise_service(service, kind)
        self._services[name] = _AdvertisedService(kind, handler)
        await self._queue.put(frame, SUBSCRIPTION)

    async def unadvertise(self, service: str) -> None:
        """Withdraw a service; calls in progress are still answered.

        Raises
        ------
        NotFound
            This client does not advertise the service.
        PPaaSError
            The queue is closed.
        """
        name = normalise(service)
        if self._services.pop(name, None) is None:
            raise NotFound("advertised service", name, list(self._services))
        await self._queue.put(self._session.unadvertise_service(service), SUBSCRIPTION)

    def handle_call(self, call: CallService) -> None:
        """Start a task that runs the handler and sends a response in every case."""
        task = asyncio.create_task(self._serve(call, full=len(self._in_progress) >= MAX_CALLS))
        self._in_progress.add(task)
        task.add_done_callback(self._in_progress.discard)

    def session_lost(self) -> None:
        """Cancel all calls: the cloud has already failed them towards their callers."""
        self.end()
        self._queue.discard(ANSWER)

    def end(self) -> None:
        """Cancel all calls in progress."""
        for task in self._in_progress:
            task.cancel()

    async def _serve(self, call: CallService, *, full: bool) -> None:
        try:
            if full:
                raise QuotaExceeded(f"this client already handles {MAX_CALLS} calls; call {call.service!r} again later")
            frame = self._session.respond(call, await self._response(call))
        except PPaaSError as error:
            frame = self._session.refuse(call, error)
        except Exception as error:
            logger.exception("the handler of service %r failed", call.service)
            failure = PPaaSError(f"the handler of service {call.service!r} failed: {type(error).__name__}")
            frame = self._session.refuse(call, failure)
        await self._queue.put(frame, ANSWER)

    async def _response(self, call: CallService) -> Message:
        advertised = self._services.get(normalise(call.service))
        if advertised is None:
            raise Unavailable(f"service {call.service!r} is no longer advertised here; call it again")
        answer = advertised.handler(decode(advertised.kind.request, call.args))
        response = await answer if inspect.isawaitable(answer) else answer
        if not isinstance(response, advertised.kind.response):
            wanted, got = advertised.kind.response.__name__, type(response).__name__
            raise PPaaSError(f"the handler of service {call.service!r} must return {wanted}, not {got}")
        return response
