"""Keeper of the endpoint processes of a host: a cloud's own, which must serve before it does, or those that join."""

import asyncio
import logging
import sys
from collections.abc import Sequence
from pathlib import Path

import msgspec

from endpoints.cloud_processes import serving
from endpoints.cloud_processes.config import EndpointConfig, FrontConfig, JoinedEndpointConfig
from engine.control.master_calls.server import EndpointServer
from engine.local.kept_process import SpareProcesses
from engine.local.process_keeper import ProcessKeeper
from engine.remote.endpoint_processes import EndpointProcesses
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-m", serving.__name__)
"""Command that runs an endpoint; with docstrings, since the routes' docstrings document REST."""

START_TIMEOUT, LOOK = 600.0, 0.02
"""Time limit until all endpoints serve, as long as the local machine's limit, and the period of checks [s]. They start
while the fork server compiles kernels, if it is the first start on a computer."""

HOPELESS = 3
"""Number of exits in a row after which the start fails."""


class EndpointKeeper:
    """Keeps the endpoint processes of this host running.

    Parameters
    ----------
    configs : sequence of EndpointConfig
        Settings of each.
    server : EndpointServer
        Knows which of them have registered.
    run_dir : Path
        Folder of the sockets of the cloud.
    file : Path
        File that records them for the next cloud process.
    spares : SpareProcesses
        Endpoint processes that wait for their settings; those that are not needed are ended.
    """

    def __init__(
        self,
        configs: Sequence[EndpointConfig],
        server: EndpointServer,
        run_dir: Path,
        file: Path,
        spares: SpareProcesses,
    ) -> None:
        self._server = server
        self._spares = spares
        self._keeper = ProcessKeeper(COMMAND, {config.name: config for config in configs}, run_dir, file, spares)

    async def start(self) -> None:
        """Start or adopt all endpoints, and wait until they serve.

        Raises
        ------
        Unavailable
            They do not serve in time.
        """
        await self._keeper.start()
        until = asyncio.get_running_loop().time() + START_TIMEOUT
        while asyncio.get_running_loop().time() < until:
            if self._registered() >= self._keeper.names:
                await self._spares.close()
                return
            if self._keeper.deaths >= HOPELESS:
                break
            await asyncio.sleep(LOOK)
        raise Unavailable("an endpoint process does not serve; see its messages above")

    def _registered(self) -> set[str]:
        return {one.registration.endpoint for one in self._server.endpoints if one.registration is not None}

    def change(self, configs: Sequence[EndpointConfig]) -> None:
        """Start the next processes with settings that the running ones follow."""
        self._keeper.change({config.name: config for config in configs})

    async def stop(self) -> None:
        """Stop all endpoints."""
        await self._keeper.stop()


def joined_processes(count: int, front: FrontConfig, listen: str = "") -> EndpointProcesses:
    """Return the endpoint processes of a joined machine.

    Parameters
    ----------
    count : int
        Number of processes.
    front : FrontConfig
        Settings with which they serve clients.
    listen : str
        Host or address at which containers of other hosts reach them.

    Raises
    ------
    InvalidInput
        They would not have one port.
    """
    if front.port == 0:
        raise InvalidInput("endpoints of other hosts need a --port other than 0: all of a host listen there")
    config = JoinedEndpointConfig(name="", run_dir="", folder="", listen=listen, front=front)
    return EndpointProcesses(serving.__name__, count, msgspec.to_builtins(config))
