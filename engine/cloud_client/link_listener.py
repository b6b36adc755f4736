"""Listener of an endpoint for containers: each names its place, and knows the secret of it."""

import asyncio
import logging
import secrets
import ssl
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from engine.links.place_link import PlaceLink
from engine.processes.private_files import write_private
from engine.protocols import robot_link
from engine.protocols.address import EndpointAddress, TlsAddress, UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import UnprovenPeers, is_same, place_secret
from engine.protocols.sockets import fingerprint, listen
from engine.protocols.tls_identity import TlsIdentity
from engine.protocols.versions import agree
from ppaas.errors import Conflict, NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0
"""Time within which a connected container must send its first frame [s]."""


class MachineAccess(NamedTuple):
    """Access for containers of other hosts.

    Parameters
    ----------
    host : str
        Host or address to listen at; the port is any free one.
    authority : Path
        Certificate of the cloud's authority, which signs the machines' certificates.
    """

    host: str
    authority: Path


class LinkListener:
    """Passes the link of each container to its place.

    Parameters
    ----------
    machine : str
        Name of this machine.
    path : Path
        Path of the Unix socket; only this user may connect to it.
    machines : MachineAccess, optional
        Access for containers of other hosts; None for none.
    place : callable
        Returns the link of a place by name.

    Attributes
    ----------
    secret : str
        Secret from which the places' secrets are derived.
    address : EndpointAddress
        Addresses that containers dial.
    """

    def __init__(
        self, machine: str, path: Path, place: Callable[[str], PlaceLink], machines: MachineAccess | None = None
    ) -> None:
        self.path = path
        self.address = EndpointAddress(machine, str(UnixAddress(path)))
        self.secret = secrets.token_urlsafe(24)
        self._place = place
        self._machines = machines
        self._servers: list[asyncio.Server] = []
        self._streams: set[FrameStream[robot_link.FromContainer]] = set()
        self._unproven = UnprovenPeers("endpoint, links of containers")

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._servers.append(await listen(UnixAddress(self.path), self._connected))
        if self._machines is not None:
            await self._start_for_others(self._machines)

    async def _start_for_others(self, access: MachineAccess) -> None:
        from engine.remote.authority import key_pem, new_key, self_signed  # noqa: PLC0415 - imports cryptography

        identity = TlsIdentity(self.path.with_suffix(".key"), self.path.with_suffix(".pem"), access.authority)
        key = new_key()
        # Containers learn its fingerprint from the master, so nobody need sign it.
        certificate_pem = self_signed("endpoint.ppaas", key)
        write_private(identity.key, key_pem(key))
        write_private(identity.certificate, certificate_pem)
        server = await listen(TlsAddress(access.host, 0), self._connected_from_afar, identity.server_context())
        self._servers.append(server)
        far = TlsAddress(access.host, server.sockets[0].getsockname()[1])
        shown = fingerprint(ssl.PEM_cert_to_DER_cert(certificate_pem.decode()))
        self.address = EndpointAddress(self.address.machine, self.address.near, str(far), shown)

    async def _serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Serve a container, unless the place has a later one: a machine that was cut off may still run the former."""
        place = self._place(hello.place)
        if hello.generation < place.generation:
            logger.info("container %s was replaced, and is not served any more", hello.container)
            stream.write(robot_link.Shutdown())
            return
        place.generation = hello.generation
        await place.serve(hello, stream)

    def _is_of_place(self, hello: robot_link.Hello) -> bool:
        return is_same(place_secret(self.secret, hello.place, hello.generation), hello.secret)

    async def _connected_from_afar(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a container of another host, whose machine has a certificate of this cloud."""
        if writer.get_extra_info("ssl_object").getpeercert(binary_form=True) is None:
            logger.warning("closed a link of a container whose machine has no certificate")
            writer.close()
            return
        await self._connected(reader, writer)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.add(stream)
        self._unproven.came(stream)
        try:
            async with asyncio.timeout(HELLO_TIMEOUT):
                hello = await stream.receive()
            if not isinstance(hello, robot_link.Hello) or not self._is_of_place(hello):
                raise NotPermitted("a container without the secret of its place dialled this endpoint")
            self._unproven.proved(stream)
            agree(f"container {hello.container[:64]!r}", "", hello.protocols)
            await self._serve(hello, stream)
        except Conflict as error:
            logger.error("%s", error)
            stream.write(robot_link.Shutdown())  # else it would dial again and again
        except (PPaaSError, TimeoutError) as error:
            logger.warning("closed a link of a container: %s", str(error) or "it sent no first frame in time")
        finally:
            self._unproven.proved(stream)
            self._streams.discard(stream)
            await stream.close()

    async def close(self) -> None:
        """Stop listening, and close all links."""
        for server in self._servers:
            server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        for path in (self.path, self.path.with_suffix(".key"), self.path.with_suffix(".pem")):
            path.unlink(missing_ok=True)
