"""Topics and services of ROS 2 on Zenoh as ``zenoh-bridge-ros2dds`` has them: bare names as keys, bare CDR as payload.

rmw_zenoh has domain and type in its keys, and attachments; a key here is the name alone, as ``tb1/tf``.
"""

import asyncio
from typing import Any

from ppaas.errors import PPaaSError
from ppaas.wire.ros.graph import Qos
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Answer, Closable, Publisher, Received
from robots.bridges.zenoh.node import ZenohOptions, ZenohTransport


class _Declared:
    """Declaration in Zenoh, which ends when it is closed."""

    def __init__(self, declared: Any) -> None:
        self._declared = declared

    def publish(self, data: bytes) -> None:
        self._declared.put(data)

    def close(self) -> None:
        self._declared.undeclare()


class PlainZenohTransport(ZenohTransport):
    """Transport whose peers need not be nodes of ROS.

    Parameters
    ----------
    options : ZenohOptions
        Options of the session.
    """

    def __init__(self, options: ZenohOptions) -> None:
        super().__init__(options)
        self._refusals = Notices()
        self._replying: set[asyncio.Task[None]] = set()

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher."""
        return _Declared(self.session.declare_publisher(topic.lstrip("/")))

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic."""
        handler = self.in_loop(lambda sample: received(sample.payload.to_bytes()))
        return _Declared(self.session.declare_subscriber(topic.lstrip("/"), handler))

    def serve(self, service: str, type_name: str, answer: Answer) -> Closable:
        """Serve a service; each request is answered in a separate task."""
        key = service.lstrip("/")

        def received(query: Any) -> None:
            task = asyncio.get_running_loop().create_task(self._answered(query, key, answer))
            self._replying.add(task)
            task.add_done_callback(self._replying.discard)

        return _Declared(self.session.declare_queryable(key, self.in_loop(received), complete=True))

    async def _answered(self, query: Any, key: str, answer: Answer) -> None:
        try:
            query.reply(key, await answer(query.payload.to_bytes() if query.payload else b""))
        except PPaaSError as error:
            self._refusals.warn(f"a request to {key} was not answered: {error}")
        finally:
            query.drop()

    async def close(self) -> None:
        """Close the session."""
        for task in self._replying:
            task.cancel()
        await asyncio.gather(*self._replying, return_exceptions=True)
        await super().close()
