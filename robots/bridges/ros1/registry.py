"""Registrations of a node at a master, which forgets them when it is restarted."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping

from ppaas.wire.names import ros1_type
from ppaas.wire.ros.graph import Kind
from ppaas.wire.ros.ros1_master import MasterState, Nodes
from robots.bridges.core.notices import Notices
from robots.bridges.ros1.master import Master
from robots.bridges.ros1.publication import Publication
from robots.bridges.ros1.service import Service
from robots.bridges.ros1.subscription import Subscription

Key = tuple[Kind, str]
Named = Publication | Subscription | Service


class Registry:
    """Registrations of one node.

    Parameters
    ----------
    master : Master
        The master.
    node : str
        Name of the node.
    data : str
        TCPROS URI of the node's services.
    publishers : callable
        Called with each topic to which a subscriber was registered, and the URIs of its publishers.
    notices : Notices
        Log.
    """

    def __init__(
        self, master: Master, node: str, data: str, publishers: Callable[[str, list[str]], None], notices: Notices
    ) -> None:
        self.master, self._publishers = master, publishers
        self._node, self._data, self._notices = node, data, notices
        self._registered: dict[Key, Named] = {}

    async def reconcile(self, state: MasterState, wanted: Mapping[Key, Named]) -> None:
        """Register what is wanted and not registered, and withdraw the rest.

        All is tried before an error is raised as by `Master`; what has failed is missing the next time.

        Parameters
        ----------
        state : MasterState
            State of the master.
        wanted : mapping
            Publications, subscriptions and services by kind and name.
        """
        await self._each(self._withdraw, self._registered.keys() - wanted.keys())
        missing = [key for key, one in wanted.items() if self._is_missing(key, one, state)]
        await self._each(lambda key: self._register(key, wanted[key]), missing)

    def forget(self, key: Key) -> None:
        """Register a publication, a subscription or a service once more at the next turn."""
        self._registered.pop(key, None)

    async def withdraw(self) -> None:
        """Unregister all; raises as `Master`."""
        await self._each(self._withdraw, list(self._registered))

    def _is_missing(self, key: Key, one: Named, state: MasterState) -> bool:
        kind, name = key
        nodes: Nodes = {
            Kind.PUBLISHER: state.publishers, Kind.SUBSCRIBER: state.subscribers, Kind.SERVER: state.services
        }[kind]  # fmt: skip
        registered = nodes.get(name, frozenset())
        others = registered - {self._node}
        if kind is Kind.SERVER and others:
            self._notices.warn(f"{name} is served by {', '.join(sorted(others))}, and so not by the cloud")
            return False
        return self._registered.get(key) is not one or self._node not in registered

    async def _register(self, key: Key, one: Named) -> None:
        kind, name = key
        if kind is Kind.SUBSCRIBER:
            uris = await self.master.subscribe(name, ros1_type(one.type))
            self._publishers(name, uris)
        elif kind is Kind.PUBLISHER:
            await self.master.publish(name, ros1_type(one.type))
        else:
            await self.master.serve(name, self._data)
        self._registered[key] = one

    async def _withdraw(self, key: Key) -> None:
        kind, name = key
        if kind is Kind.SUBSCRIBER:
            await self.master.stop_subscribing(name)
        elif kind is Kind.PUBLISHER:
            await self.master.stop_publishing(name)
        else:
            await self.master.stop_serving(name, self._data)
        del self._registered[key]

    @staticmethod
    async def _each(work: Callable[[Key], Awaitable[None]], keys: "set[Key] | list[Key]") -> None:
        for result in await asyncio.gather(*map(work, keys), return_exceptions=True):
            if isinstance(result, BaseException):
                raise result
