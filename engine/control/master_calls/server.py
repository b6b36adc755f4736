"""Server of the endpoints: each connects, registers and calls the master.

Those of this host dial a Unix socket; those of other hosts come by the port for machines (`engine.remote.machines`).
"""

import asyncio
import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple, get_type_hints

from engine.calls.caller import Caller, Frame
from engine.control.master_calls.cloud import Cloud
from engine.control.master_calls.control_plane import MasterParts
from engine.control.master_calls.interface import MasterCalls
from engine.control.master_calls.served_endpoint import ServedEndpoint
from engine.control.robot_sessions import RobotSessions
from engine.processes.background import Background
from engine.processes.heartbeats import watch
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import UnprovenPeers
from engine.protocols.sockets import listen
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

SOCKET = "endpoints.sock"
"""Name of the socket in the folder of the cloud."""

REGISTER_TIMEOUT = 5.0
"""Time within which a connected endpoint must register [s]."""


class Extra(NamedTuple):
    """Further methods that an endpoint may call.

    Parameters
    ----------
    interface : type
        Interface with the methods.
    served : object
        Object that has them.
    close : callable
        Called when the endpoint is lost.
    """

    interface: type
    served: object
    close: Callable[[], object] = lambda: None


class EndpointServer:
    """Listens for endpoints.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only this user may connect to it.
    secret : str
        Secret of the cloud's own processes.
    cloud : Cloud
    sessions : RobotSessions

    Attributes
    ----------
    endpoints : Neighbours
        The registered endpoints.
    """

    def __init__(self, path: Path, secret: str, cloud: Cloud, sessions: RobotSessions) -> None:
        self.path = path
        self.endpoints = cloud.neighbours
        self._secret = secret
        self._cloud = cloud
        self._parts = {interface: getattr(cloud, name) for name, interface in get_type_hints(MasterParts).items()}
        self._sessions = sessions
        self._extras: list[Callable[[], Extra]] = []
        self._server: asyncio.Server | None = None
        self._links: dict[ServedEndpoint, FrameStream[Frame]] = {}
        self._background = Background()
        self._unproven = UnprovenPeers("master, links of endpoints")

    def serve_also(self, make: Callable[[], Extra]) -> None:
        """Let endpoints call other methods, too; ``make`` is called for each endpoint that connects from now on."""
        self._extras.append(make)

    async def start(self) -> None:
        """Start to listen on the socket, and to watch the endpoints."""
        self._server = await listen(UnixAddress(self.path), self.connected)
        self._background.run(watch((self.endpoints.beats, self._hang_up), meanwhile=self._leave_removed))

    def _hang_up(self, name: str) -> None:
        """Close the link of an endpoint that does not respond; its clients return at others, or it registers again."""
        logger.error("endpoint %s does not report any more: its link is closed", name)
        self.endpoints.hang_up(name)

    def _leave_removed(self) -> None:
        for endpoint in self._links:
            if endpoint.machine is not None and self._cloud.driver.administration.is_removed(endpoint.machine):
                endpoint.hang_up()

    async def connected(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str | None = None
    ) -> None:
        """Serve a connection; ``machine`` is the name in its certificate, None on the local socket."""
        stream: FrameStream[Frame] = FrameStream(reader, writer, Frame)
        endpoint = ServedEndpoint(self._cloud, self._sessions, self._secret, machine)
        extras = [make() for make in self._extras]
        served = {extra.interface: extra.served for extra in extras}
        endpoint.caller = Caller(stream, {MasterCalls: endpoint, **self._parts, **served})
        endpoint.caller.admits = endpoint.may_call
        self._links[endpoint] = stream
        self._unproven.came(stream)
        endpoint.registered = partial(self._unproven.proved, stream)
        late = asyncio.get_running_loop().call_later(REGISTER_TIMEOUT, self._check_registered, endpoint, stream)
        try:
            await endpoint.caller.serve()
        except PPaaSError as error:
            logger.warning("closed the link of endpoint %s: %s", endpoint.name or "without a name", error)
        finally:
            late.cancel()
            self._unproven.proved(stream)
            endpoint.gone()
            for extra in extras:
                extra.close()
            del self._links[endpoint]
            await stream.close()

    @staticmethod
    def _check_registered(endpoint: ServedEndpoint, stream: FrameStream[Frame]) -> None:
        if endpoint.registration is None:
            logger.warning("closed the link of an endpoint that did not register in time")
            stream.abort()

    async def close(self) -> None:
        """Stop listening, and close all links."""
        await self._background.cancel()
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(stream.close() for stream in self._links.values()))
        self.path.unlink(missing_ok=True)
