"""The calls of services that a client makes: each gets its own answer, or why there is none."""

import asyncio

from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import Message, ServiceType, decode
from ppaas.wire.rosbridge_client import RosbridgeClientSession, ServiceResult, failure_of
from robots.client.send_queue import Outbox


class Calls:
    """Calls that wait for their answers.

    Parameters
    ----------
    session : RosbridgeClientSession
        Makes the frames.
    outbox : Outbox
        Where they go.
    """

    def __init__(self, session: RosbridgeClientSession, outbox: Outbox) -> None:
        self._session = session
        self._outbox = outbox
        self._waiting: dict[str, asyncio.Future[ServiceResult]] = {}

    async def call(self, service: str, kind: ServiceType, request: Message, timeout: float) -> Message:
        """Call a service, and return its response.

        Raises
        ------
        Unavailable
            No answer in ``timeout`` seconds, or the connection was lost meanwhile.
        PPaaSError
            What the service says it failed with.
        """
        call_id, frame = self._session.call(service, request)
        self._waiting[call_id] = asyncio.get_running_loop().create_future()
        try:
            async with asyncio.timeout(timeout):
                await self._outbox.put(frame, call_id)
                response = await self._waiting[call_id]
        except TimeoutError as error:
            raise Unavailable(f"{service!r} did not answer in {timeout:g} s") from error
        finally:
            del self._waiting[call_id]
            self._session.give_up(call_id)
            self._outbox.discard(call_id)
        failure = failure_of(response)
        if failure is not None:
            raise failure
        return decode(kind.response, response.values)

    def answered(self, response: ServiceResult) -> None:
        """Take an answer."""
        future = self._waiting.get(response.id or "")
        if future is not None and not future.done():
            future.set_result(response)

    def lost(self) -> None:
        """End the calls that the cloud knows nothing of any more; those that were not sent yet are still to be made."""
        for call_id, error in self._session.disconnected(self._outbox.waiting()).items():
            self._fail(call_id, error)

    def fail(self, error: PPaaSError) -> None:
        """End all calls with an error."""
        for call_id in self._waiting:
            self._fail(call_id, error)

    def _fail(self, call_id: str, error: PPaaSError) -> None:
        future = self._waiting.get(call_id)
        if future is not None and not future.done():
            future.set_exception(error)
