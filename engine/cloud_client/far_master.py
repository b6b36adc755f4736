"""Access of an endpoint on a joined machine to the master that leads its cloud."""

import asyncio

from engine.cloud_client.master_link import SilenceCause
from engine.protocols.address import parse_address
from engine.protocols.sockets import Streams, dial
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.masters import Masters
from engine.remote.membership import Membership
from engine.remote.settings_check import check_protocols
from ppaas.errors import Conflict


class FarMaster:
    """Access to the master that leads the cloud of a joined machine.

    Parameters
    ----------
    membership : Membership
        The machine, and the cloud that it has joined.
    masters : Masters
        Masters of that cloud, as this process has asked them.
    settings : ClusterSettings
        Settings of the cloud with which this endpoint started.
    """

    secret = ""
    is_far = True

    def __init__(self, membership: Membership, masters: Masters, settings: ClusterSettings) -> None:
        self._membership = membership
        self._settings = _lasting(settings)
        self._masters = masters

    async def dial(self) -> Streams:
        """Find the master that leads, and connect to it."""
        self._masters.read_again()
        settings = await self._masters.settings()
        check_protocols(settings)
        if _lasting(settings) != self._settings:
            raise Conflict("the cloud was started with other settings; this endpoint starts again with them")
        address = parse_address(self._masters.current)
        context = await asyncio.to_thread(self._membership.identity.client_context, "endpoint")
        return await dial(address, context)

    async def silence(self) -> SilenceCause:
        """Return whether a master at another address leads."""
        self._masters.read_again()
        return SilenceCause.MOVED if await self._masters.another_leads() else SilenceCause.UNKNOWN


def _lasting(settings: ClusterSettings) -> tuple[object, ...]:
    """Return the settings that an endpoint uses, which may not change while it runs."""
    return settings.store, settings.map_store, settings.runs.allowed, settings.serves
