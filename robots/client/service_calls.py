"""Service calls of a client: matches each response to its call."""

import asyncio

from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import Message, ServiceType, decode
from ppaas.wire.rosbridge_client import RosbridgeClientSession, ServiceResult, failure_of
from robots.client.send_queue import SendQueue


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
