"""Keeper of the endpoint processes of a host: starts them, restarts those that exit, and adopts earlier ones."""

import asyncio
import logging
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import msgspec

from endpoints.processes import serving
from endpoints.processes.config import EndpointConfig
from endpoints.processes.records import EndpointRecord, left_endpoints
from engine.local.kept_process import KeptProcess
from engine.processes.background import Background
from engine.processes.ending import end_process
from engine.processes.instances import name_of, pid_of
from engine.processes.private_files import write_private
from engine.service.endpoints.server import EndpointServer
from engine.service.liveness import watch
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-m", serving.__name__)
"""Command that runs an endpoint; with docstrings, since those of routes are the documentation of REST."""

START_TIMEOUT, LOOK = 600.0, 0.02
"""Time limit until all endpoints serve, as long as that of the local machine, and the period of checks [s]. They start
while the fork server compiles kernels, if it is the first start on a computer."""

ADOPT_PATIENCE = 5.0
"""Time within which an adopted endpoint must register; after that it counts as frozen, and is replaced [s]."""

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
    file : Path
        File that records them for the next cloud process.
    """

    def __init__(self, configs: Sequence[EndpointConfig], server: EndpointServer, file: Path) -> None:
        self._configs = {config.name: config for config in configs}
        self._server = server
        self._file = file
        self._pids: dict[str, int] = {}
        self._watching = Background()
        self._kept = {
            config.name: KeptProcess(config.name, config, COMMAND, started=partial(self._record, config.name))
            for config in configs
        }

    async def start(self) -> None:
        """Start or adopt all endpoints, and wait until they serve.

        Raises
        ------
        Unavailable
            They do not serve in time.
        """
        adopted = await self._adopt()
        for kept in self._kept.values():
            await kept.start()
        impatient = asyncio.get_running_loop().call_later(ADOPT_PATIENCE, self._kill_silent, adopted)
        try:
            await self._until_registered()
        finally:
            impatient.cancel()
        self._watching.run(watch((self._server.endpoints.beats, self._kill_frozen)))

    async def _adopt(self) -> list[str]:
        """Adopt the endpoints of a killed cloud process, and end those with other settings; return the adopted ones."""
        adopted = []
        for left in left_endpoints(self._file):
            if self._configs.get(left.config.name) == left.config:
                self._kept[left.config.name].adopt(pid_of(left.process))
                self._record(left.config.name, pid_of(left.process))
                adopted.append(left.config.name)
            else:
                await _end(left)
        return adopted

    def _kill_silent(self, adopted: list[str]) -> None:
        for name in set(adopted) - self._registered():
            self._kill_frozen(name)

    def _registered(self) -> set[str]:
        return {one.registration.endpoint for one in self._server.endpoints if one.registration is not None}

    async def _until_registered(self) -> None:
        until = asyncio.get_running_loop().time() + START_TIMEOUT
        while asyncio.get_running_loop().time() < until:
            if self._registered() >= self._kept.keys():
                return
            if any(kept.deaths >= HOPELESS for kept in self._kept.values()):
                break
            await asyncio.sleep(LOOK)
        raise Unavailable("an endpoint process does not serve; see its messages above")

    def _kill_frozen(self, name: str) -> None:
        kept = self._kept.get(name)
        if kept is not None:
            logger.error("endpoint %s does not report any more: it is frozen, and replaced", name)
            kept.kill()

    def _record(self, name: str, pid: int) -> None:
        self._pids[name] = pid
        records = [
            EndpointRecord(process, self._configs[name])
            for name, pid in self._pids.items()
            if (process := name_of(pid)) is not None
        ]
        try:
            write_private(self._file, msgspec.json.encode(records))
        except OSError as error:
            logger.warning("the endpoints cannot be recorded, so a restarted cloud cannot adopt them: %s", error)

    async def stop(self) -> None:
        """Stop all endpoints."""
        await self._watching.cancel()
        await asyncio.gather(*(kept.stop() for kept in self._kept.values()))
        self._file.unlink(missing_ok=True)


async def _end(left: EndpointRecord) -> None:
    logger.warning("endpoint %s of an earlier cloud process is stopped: the settings have changed", left.config.name)
    await end_process(left.process)
