"""Client of a master of ROS 1, in the name of one node."""

import asyncio
from typing import Any

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.ros1_master import MasterState, read_state, read_types
from robots.bridges.ros1.http import call

MAX_CALLS = 4
"""Largest number of calls at once: rosmaster lets five connections wait."""


class Master:
    """Methods of a master.

    Parameters
    ----------
    uri, node, own : str
        URI of the master, and name and URI of the node.
    """

    def __init__(self, uri: str, node: str, own: str) -> None:
        self._uri, self._node, self._own = uri, node, own
        self._turn = asyncio.Semaphore(MAX_CALLS)

    async def state(self) -> MasterState:
        """Return the nodes that publish, subscribe and serve; all methods raise as `call`."""
        return read_state(await self._call("getSystemState"))

    async def types(self) -> dict[str, str]:
        """Return the types of all topics, spelled as in ROS 2."""
        return read_types(await self._call("getTopicTypes"))

    async def publish(self, topic: str, type_name: str) -> None:
        """Register a publisher."""
        await self._call("registerPublisher", topic, type_name, self._own)

    async def subscribe(self, topic: str, type_name: str) -> list[str]:
        """Register a subscriber; return the URIs of the nodes that publish the topic."""
        return read_uris(await self._call("registerSubscriber", topic, type_name, self._own))

    async def serve(self, service: str, data: str) -> None:
        """Register a service, served at the TCPROS URI ``data``."""
        await self._call("registerService", service, data, self._own)

    async def stop_publishing(self, topic: str) -> None:
        """Unregister a publisher."""
        await self._call("unregisterPublisher", topic, self._own)

    async def stop_subscribing(self, topic: str) -> None:
        """Unregister a subscriber."""
        await self._call("unregisterSubscriber", topic, self._own)

    async def stop_serving(self, service: str, data: str) -> None:
        """Unregister a service."""
        await self._call("unregisterService", service, data)

    async def _call(self, method: str, *arguments: str) -> Any:
        async with self._turn:
            return await call(self._uri, method, self._node, *arguments)


def read_uris(value: Any) -> list[str]:
    """Return a list of URIs.

    Raises
    ------
    MalformedMessage
        The value is not a list of URIs.
    """
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise MalformedMessage("no list of URIs")
    return value
