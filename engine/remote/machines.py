"""The cloud's side of remote machines: its certificate authority, its tickets, and the port that they connect to."""

import asyncio
import logging
import secrets
import socket
import ssl
from collections.abc import Awaitable, Callable
from pathlib import Path

import msgspec

from engine.fabric.zenoh_config import Peering, RouterCredentials
from engine.links.control_server import ControlServer
from engine.links.robot_link_server import LinkServer
from engine.processes.private_files import write_private
from engine.protocols.address import EVERYWHERE, TlsAddress, parse_address
from engine.protocols.control_link import MastersChanged
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import ConnectionHandler, listen
from engine.protocols.versions import OWN
from engine.remote.authority import STANDBY, Authority
from engine.remote.cluster_settings import ClusterSettings, ContainerSettings, EndpointSettings
from engine.remote.join_secrets import JoinSecrets
from engine.remote.joining import JoinServer, Ticket, Tickets
from engine.remote.masters import KnownMasters
from engine.remote.secret_joining import SecretJoins
from engine.remote.standbys import Standbys
from ppaas import __version__
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)


# -- incoming connections ----------------------------------------------------------------------------------------------

MAX_JOINING = 64
"""Largest number of clients without a certificate at once; each has a few seconds to show its ticket."""

FromMachine = Callable[[asyncio.StreamReader, asyncio.StreamWriter, str], Awaitable[None]]
"""Serves a connection of a machine; the last argument is the machine's name."""


class MutualTlsListener:
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
        # Only the last certificate of each name is valid, so there is no list of revoked ones.
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


# -- machines ----------------------------------------------------------------------------------------------------------

ADDRESS = "address"
"""File with the address for machines; it exists while the cloud listens there."""

FABRIC = "fabric.json"
"""File with the credentials of the cloud's routers, so that routers of machines reconnect to a restarted cloud."""


class RemoteMachines:
    """Accepts machines of other hosts.

    Parameters
    ----------
    folder : Path
        Folder of certificates and tickets, in the data folder of the cloud.
    address : TlsAddress
        Address to listen at. The router listens at the next port, or at any free one if the port is 0.
    cloud : str
        Instance name of the cloud process.
    store, map_store : str
        URLs of the stores.
    own : str
        Name of the local machine.
    runs : ContainerSettings
        Settings of containers.
    serves : EndpointSettings
        Settings of endpoints.
    join_secrets : JoinSecrets, optional
        Secrets with which machines and standbys may join without a ticket.
    masters : tuple of str
        Addresses at which a master of this cloud may listen for machines.

    Raises
    ------
    InvalidInput
        The folder or the secrets cannot be used, or other hosts cannot reach the stores.
    Unavailable
        The address does not belong to this host.
    """

    def __init__(
        self,
        folder: Path,
        address: TlsAddress,
        *,
        cloud: str,
        store: str,
        map_store: str,
        own: str,
        runs: ContainerSettings = ContainerSettings(),  # noqa: B008 - it is frozen
        serves: EndpointSettings = EndpointSettings(),  # noqa: B008 - it is frozen
        join_secrets: JoinSecrets | None = None,
        masters: tuple[str, ...] = (),
    ) -> None:
        for url in (store, map_store):
            check_reachable(url)
        self._folder = folder
        self._authority = Authority(folder)
        self._address = address
        self._masters = KnownMasters(folder)
        self._masters.note(masters)
        self._standbys = Standbys(folder.parent, self._masters, self._announce)
        taken = frozenset((own,))
        by_secret = SecretJoins(self._authority, join_secrets or JoinSecrets(), taken, self._is_connected)
        self._join_server = JoinServer(self._authority, Tickets(folder / "tickets"), taken, by_secret.serve)
        router = address._replace(port=address.port + 1 if address.port else _free_port(address.host))
        credentials = _credentials(folder / FABRIC)
        self._settings = ClusterSettings(
            cloud, store, map_store, router.port, credentials, runs, __version__, serves=serves, protocols=OWN
        )
        identity = self._authority.identity
        self.peering = Peering(
            str(identity.key), str(identity.certificate), str(identity.authority), credentials,
            listen=(f"tls/{router.authority}",),
        )  # fmt: skip
        self._listener: MutualTlsListener | None = None
        self._control: ControlServer | None = None

    @property
    def host(self) -> str | None:
        """Host name or address of the cloud for machines, or None if it listens at all addresses."""
        return None if self._address.host in EVERYWHERE else self._address.host

    async def start(self, control: ControlServer, robots: LinkServer, endpoints: FromMachine) -> None:
        """Listen, and write the address to a file, for tickets.

        Raises
        ------
        Unavailable
            The address is in use, or does not belong to this host.
        """
        self._control, self._standbys.mandate = control, control.mandate
        self._listener = MutualTlsListener(
            self._address,
            self._authority,
            control=control.connected,
            robot=robots.connected,
            settings=self._send_settings,
            standby=self._standbys.connected,
            endpoint=endpoints,
            join=self._join_server.connected,
        )
        await self._listener.start()
        write_private(self._folder / ADDRESS, str(self._listener.address).encode())

    async def _send_settings(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str) -> None:
        """Send the settings of the cluster; without a mandate, close the connection: another master may lead."""
        stream: FrameStream[ClusterSettings] = FrameStream(reader, writer, ClusterSettings)
        mandate = self._standbys.mandate
        if mandate.leads():
            settings = msgspec.structs.replace(self._settings, epoch=mandate.epoch, masters=self._masters.texts())
            await stream.send(settings)
        await stream.close()

    def _is_connected(self, machine: str) -> bool:
        return self._control is not None and self._control.is_connected(machine)

    def _announce(self) -> None:
        if self._control is not None:
            self._control.tell_all(MastersChanged(self._masters.texts()))

    async def close(self) -> None:
        """Close all connections and stop listening."""
        if self._listener is not None:
            (self._folder / ADDRESS).unlink(missing_ok=True)
            await self._listener.close()


def _credentials(file: Path) -> RouterCredentials:
    try:
        if not file.exists():
            write_private(file, msgspec.json.encode(RouterCredentials("agent", secrets.token_urlsafe(32))))
        return from_json(file.read_bytes(), RouterCredentials)
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(
            f"the credentials of routers in {file} cannot be read; repair or remove the file: {error}"
        ) from error


def check_reachable(url: str) -> None:
    """Check that machines of other hosts can reach a store.

    Raises
    ------
    InvalidInput
        The store is in the memory of one process.
    """
    if url.startswith("memory:"):
        raise InvalidInput(
            "machines of other hosts cannot reach a store in memory: set --store and --map-store to shared ones, "
            "such as cassandra: and hdfs:, or to a folder that all hosts share"
        )


def make_ticket(folder: Path, *, valid: float, machine: str | None = None, host: str | None = None) -> Ticket:
    """Make a ticket for a running cloud.

    Parameters
    ----------
    folder : Path
        Folder of the cloud's certificates and tickets.
    valid : float
        Time for which the ticket is valid [s].
    machine : str, optional
        Name of the machine that may use it. Default: any new machine.
    host : str, optional
        Host name or address by which the machine reaches this host. Default: the address that the cloud listens at, or
        the name of this host.

    Raises
    ------
    Unavailable
        No cloud that accepts machines runs with this folder.
    InvalidInput
        The name of the machine is invalid.
    """
    try:
        address = parse_address((folder / ADDRESS).read_text())
    except OSError as error:
        raise Unavailable(
            f"no cloud that accepts machines of other hosts runs with the folder {folder}: start it with "
            "'ppaas up --listen-machines HOST:PORT', or name its data folder by --data"
        ) from error
    if not isinstance(address, TlsAddress):
        raise Unavailable(f"{folder / ADDRESS} has no address for machines; restart the cloud")
    reached = host or (socket.gethostname() if address.host in EVERYWHERE else address.host)
    cloud = Authority(folder).fingerprint
    return Tickets(folder / "tickets").make(address._replace(host=reached), cloud, valid=valid, machine=machine)


def _free_port(host: str) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.create_server((host, 0), family=family) as listener:
            return int(listener.getsockname()[1])
    except OSError as error:
        raise Unavailable(
            f"cannot listen at {host} for machines: {error.strerror}; use an address of this host"
        ) from error
