"""The port of a cloud at which machines of other hosts arrive: each connection is handed on by what it is for."""

import asyncio
import logging
import ssl
from collections.abc import Awaitable, Callable

from engine.protocols.address import TlsAddress
from engine.protocols.sockets import ConnectionHandler, listen
from engine.remote.authority import Authority
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

FromMachine = Callable[[asyncio.StreamReader, asyncio.StreamWriter, str], Awaitable[None]]
"""Serves a connection of a machine, by its name."""


class TlsListener:
    """Takes connections over mutual TLS.

    Parameters
    ----------
    address : TlsAddress
        Where to listen.
    authority : Authority
        Knows the machines.
    control, robot, terms : callable
        Serve the control links, the robot links, and machines that ask what they must know first.
    join : callable
        Serves who has no certificate yet.
    """

    def __init__(
        self,
        address: TlsAddress,
        authority: Authority,
        *,
        control: FromMachine,
        robot: FromMachine,
        terms: FromMachine,
        join: ConnectionHandler,
    ) -> None:
        self.address = address
        self._authority = authority
        self._serve: dict[str | None, FromMachine] = {"control": control, "robot": robot, "terms": terms}
        self._join = join
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.StreamWriter] = set()

    async def start(self) -> None:
        """Listen; from now on ``address`` has the port, also where any was to be taken.

        Raises
        ------
        Unavailable
            The address is not ours, or taken.
        """
        context = self._authority.identity.server_context()
        self._server = await listen(self.address, self._connected, context)
        self.address = self.address._replace(port=self._server.sockets[0].getsockname()[1])

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open.add(writer)
        try:
            await self._hand_on(reader, writer, writer.get_extra_info("ssl_object"))
        except PPaaSError as error:
            logger.warning("somebody at %s was turned away: %s", self.address, error)
        finally:
            self._open.discard(writer)
            writer.close()

    async def _hand_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, tls: ssl.SSLObject) -> None:
        purpose, shown = tls.selected_alpn_protocol(), tls.getpeercert(binary_form=True)
        if purpose == "join":
            await self._join(reader, writer)
            return
        if shown is None or purpose not in self._serve:
            raise NotPermitted("it shows no certificate, or does not say what it comes for")
        await self._serve[purpose](reader, writer, self._authority.machine_of(shown))

    async def close(self) -> None:
        """Hang up on all, and listen no more."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
