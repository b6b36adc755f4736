"""Masters of a machine's cloud: finds the one that leads."""

import asyncio
from collections.abc import Iterable

from engine.protocols.address import TlsAddress
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.known_masters import KnownMasters
from engine.remote.membership import Membership
from ppaas.errors import Unavailable

ROUND = 1.0
"""Time after which all masters are asked again [s]: one that is stopped accepts connections and says nothing, and one
that refused them may lead now."""


class Masters:
    """The masters of a machine's cloud, as this machine knows them; a ``MasterDirectory``.

    Parameters
    ----------
    membership : Membership
        Address at which this machine has joined, and its folder, which holds the addresses of the others.

    Attributes
    ----------
    epoch : int
        Latest epoch of a master that led.
    """

    def __init__(self, membership: Membership) -> None:
        self._membership = membership
        self._known = KnownMasters(membership.folder)
        self._address = membership.cloud
        self._router_ports: dict[TlsAddress, int] = {}
        self.epoch = 0

    @property
    def current(self) -> str:
        """Address of the master that led when it was last asked for."""
        return str(self._address)

    def note(self, masters: tuple[str, ...]) -> tuple[str, ...]:
        """Take the addresses of all masters; return the Zenoh endpoints of their routers."""
        self._known.note(masters)
        return self.routers()

    def read_again(self) -> None:
        """Read the addresses again, which another process of this machine may have noted."""
        self._known.read()

    def routers(self) -> tuple[str, ...]:
        """Return the Zenoh endpoints of the routers of all masters: by default at the port after that for machines."""
        ports = self._router_ports
        routers = (address._replace(port=ports.get(address, address.port + 1)) for address in self._addresses())
        return tuple(f"tls/{router.authority}" for router in routers)

    async def settings(self) -> ClusterSettings:
        """Request the settings of the cluster from the master that leads, and remember where that is.

        Raises
        ------
        Unavailable
            No master that leads was reached.
        """
        addresses = self._addresses()
        return await self._settings_of(addresses, ROUND if len(addresses) > 1 else None)

    async def _settings_of(self, addresses: list[TlsAddress], limit: float | None) -> ClusterSettings:
        asked = [asyncio.create_task(self._ask(address)) for address in addresses]
        try:
            async with asyncio.timeout(limit):
                settings, self._address = await self._first(asked)
        except TimeoutError as error:
            raise Unavailable(f"no master leads at {', '.join(map(str, addresses))}") from error
        finally:
            for task in asked:
                task.cancel()
            await asyncio.gather(*asked, return_exceptions=True)
        self.epoch = settings.epoch
        self._router_ports[self._address] = settings.fabric_port
        self._known.note(settings.masters)
        return settings

    async def another_leads(self) -> bool:
        """Return whether a master at another address leads; that is then the current one."""
        others = [address for address in self._addresses() if address != self._address]
        if not others:
            return False
        try:
            await self._settings_of(others, ROUND)
        except Unavailable:
            return False
        return True

    def _addresses(self) -> list[TlsAddress]:
        return list(dict.fromkeys((self._address, self._membership.cloud, *self._known.addresses)))

    async def _ask(self, address: TlsAddress) -> tuple[ClusterSettings, TlsAddress]:
        settings = await self._membership.settings(address)
        if settings.epoch < self.epoch:
            raise Unavailable(
                f"the master at {address} is of epoch {settings.epoch}, and another one has led since, in epoch "
                f"{self.epoch}; if the store of the cloud was restored from a backup, start this machine again"
            )
        return settings, address

    @staticmethod
    async def _first(
        asked: Iterable[asyncio.Task[tuple[ClusterSettings, TlsAddress]]],
    ) -> tuple[ClusterSettings, TlsAddress]:
        errors = []
        for answer in asyncio.as_completed(asked):
            try:
                return await answer
            except Unavailable as error:
                errors.append(error)
        raise errors[0] if len(errors) == 1 else Unavailable("; ".join(map(str, errors)))
