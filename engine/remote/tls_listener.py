"""TLS listener of a cloud for machines of other hosts: dispatches each connection by its purpose."""

import asyncio
import logging
import ssl
from collections.abc import Awaitable, Callable

from engine.protocols.address import TlsAddress
from engine.protocols.sockets import ConnectionHandler, listen
from engine.remote.authority import STANDBY, Authority
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

MAX_JOINING = 64
"""Largest number of clients without a certificate at once; each has a few seconds to show its ticket."""

FromMachine = Callable[[asyncio.StreamReader, asyncio.StreamWriter, str], Awaitable[None]]
"""Serves a connection of a machine; the last argument is the machine's name."""


class TlsListener:
    """Accepts connections over mutual TLS.

    Parameters
    ----------
    address : TlsAddress
        Address to listen at.
    authority : Authority
        Certificate authority, which identifies machines.
    control, robot, settings : callable
        Serve control links, robot links, and requests for the settings of the cluster.
    standby : callable
        Serves standbys of the cloud.
    endpoint : callable
        Serves endpoints of machines.
    join : callable
        Serves machines without a certificate, which request to join.
    """

    def __init__(
        self,
        address: TlsAddress,
        authority: Authority,
        *,
        control: FromMachine,
        robot: FromMachine,
        settings: FromMachine,
        standby: FromMachine,
        endpoint: FromMachine,
        join: ConnectionHandler,
    ) -> None:
        self.address = address
        self._authority = authority
        self._serve: dict[str | None, FromMachine] = {
            "control": control,
            "robot": robot,
            "terms": settings,
            "standby": standby,
            "endpoint": endpoint,
        }
        self._join = join
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.StreamWriter] = set()
        self._joining = 0

    async def start(self) -> None:
        """Listen. Afterwards ``address`` has the actual port, even if it was 0.

        Raises
        ------
        Unavailable
            The address is in use, or does not belong to this host.
        """
        context = self._authority.identity.server_context()
        self._server = await listen(self.address, self._connected, context)
        self.address = self.address._replace(port=self._server.sockets[0].getsockname()[1])

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open.add(writer)
        try:
            await self._dispatch(reader, writer, writer.get_extra_info("ssl_object"))
        except PPaaSError as error:
            logger.warning("a connection at %s was refused: %s", self.address, error)
        finally:
            self._open.discard(writer)
            writer.close()

    async def _dispatch(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, tls: ssl.SSLObject) -> None:
        purpose, certificate = tls.selected_alpn_protocol(), tls.getpeercert(binary_form=True)
        if purpose == "join":
            await self._let_join(reader, writer)
            return
        if certificate is None or purpose not in self._serve:
            raise NotPermitted("the client has no certificate or no known purpose")
        machine = self._authority.machine_of(certificate)
        if machine.endswith(STANDBY) != (purpose == "standby"):
            raise NotPermitted(f"the certificate of {machine!r} is not for this purpose: {purpose}")
        await self._serve[purpose](reader, writer, machine)

    async def _let_join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._joining >= MAX_JOINING:
            raise NotPermitted(f"{MAX_JOINING} clients are joining already")
        self._joining += 1
        try:
            await self._join(reader, writer)
        finally:
            self._joining -= 1

    async def close(self) -> None:
        """Close all connections and stop listening."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
