"""Robot link relay: forwards the robot links of a machine's containers to the master on another host.

A container dials a Unix socket, as with a master on its own machine, and the agent forwards the bytes over TLS. So a
container neither holds the key of its machine, with which it could impersonate the machine, nor needs a network.
"""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.agent.relays.relay import Relay
from engine.protocols.sockets import Streams


class RobotLinkRelay(Relay):
    """Forwards the robot links of containers.

    Parameters
    ----------
    path : Path
        Path of the Unix socket that containers dial.
    dial : callable
        Connects to an address; raises ``Unavailable`` if nobody answers.
    where : callable
        Returns the current address of the master.
    """

    def __init__(self, path: Path, dial: Callable[[str], Awaitable[Streams]], where: Callable[[], str]) -> None:
        super().__init__(path)
        self._dial_master = dial
        self._where = where

    async def _dial(self, _reader: asyncio.StreamReader) -> tuple[str, Streams]:
        address = self._where()
        return address, await self._dial_master(address)

    def leave_others(self) -> None:
        """Abort the connections to other addresses than the current one: a stopped master never closes them."""
        for writer, address in tuple(self._open.items()):
            if address and address != self._where():  # without one, it is being dialled
                writer.transport.abort()
