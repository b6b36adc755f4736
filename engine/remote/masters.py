"""Masters of a machine's cloud: their addresses on disk, and the search for the one that leads."""

import asyncio
import logging
from collections.abc import Iterable
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress, parse_address
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.membership import Membership
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)


# -- addresses on disk -------------------------------------------------------------------------------------------------

FILE = "masters.json"
"""Name of the file in a folder of certificates."""

MOST = 8
"""Largest number of addresses; those that were noted first are forgotten."""


class KnownMasters:
    """Addresses at which a master of a cloud may listen for machines, the latest ones first.

    Parameters
    ----------
    folder : Path
        Folder of the file. A file that cannot be read counts as empty.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / FILE
        self.addresses: tuple[TlsAddress, ...] = ()
        self.read()

    def read(self) -> None:
        """Read the file again, which another process may have replaced."""
        try:
            self.addresses = _parsed(from_json(self._file.read_bytes(), list[str]))
        except FileNotFoundError:
            self.addresses = ()
        except (OSError, msgspec.DecodeError) as error:
            logger.warning("the addresses of masters in %s cannot be read: %s", self._file, error)

    def note(self, addresses: Iterable[str]) -> bool:
        """Add addresses, and store them; return whether there was a new one. Invalid ones are left out."""
        noted = dict.fromkeys((*_parsed(addresses), *self.addresses))
        kept = tuple(noted)[:MOST]
        if set(kept) <= set(self.addresses):
            return False
        self.addresses = kept
        try:
            write_private(self._file, msgspec.json.encode(self.texts()))
        except OSError as error:
            logger.warning("the addresses of masters cannot be stored in %s: %s", self._file, error)
        return True

    def texts(self) -> tuple[str, ...]:
        """Return the addresses as text."""
        return tuple(map(str, self.addresses))


def _parsed(addresses: Iterable[str]) -> tuple[TlsAddress, ...]:
    found = []
    for text in addresses:
        try:
            address = parse_address(text)
        except InvalidInput as error:
            logger.warning("an address of a master is left out: %s", error)
            continue
        if isinstance(address, TlsAddress):
            found.append(address)
    return tuple(found)


# -- the one that leads ------------------------------------------------------------------------------------------------

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
