"""Agent of another host: ``python -m engine.remote.agent FOLDER``, with ``MachineOptions`` as JSON on standard input.

It requests the settings of the cluster from its cloud and runs the machine's agent until the cloud closes the
connection. It repeats this until SIGTERM or Ctrl-C, so the machine rejoins a cloud that was restarted or unreachable.
"""

import asyncio
import contextlib
import logging
import os
import signal
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import uvloop

from engine.agent.agent import run, until_terminated
from engine.agent.components import dial_master
from engine.agent.config import AgentConfig
from engine.agent.master_session import Master
from engine.local.process_keeper import ProcessKeeper, left_processes
from engine.processes.exclusive_owner import LOCK, sole_owner
from engine.processes.instances import folder_of, instance_name, sweep_stale
from engine.processes.private_files import keep_new_files_private
from engine.processes.run_dir import (
    add_owner,
    keep_temporary_files_in,
    make_run_dir,
    remove_folder,
    remove_unless_owned,
)
from engine.protocols.address import endpoint_socket
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.endpoint_processes import EndpointProcesses
from engine.remote.masters import Masters
from engine.remote.membership import Membership, membership_in
from engine.remote.settings_check import check_settings
from engine.runtimes.compilation.cache_folder import ensure_cache
from engine.tracing.recording import MACHINE, begin_traces, end_traces
from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.log_lines import log_lines

logger = logging.getLogger(__name__)


# -- endpoints of the machine ------------------------------------------------------------------------------------------

FILE = "endpoints-here.json"
"""File in the folder of the membership that records the processes."""


class MachineEndpoints:
    """Keeps the endpoint processes of a joined machine running.

    Parameters
    ----------
    membership : Membership
        The machine and its cloud.
    wanted : EndpointProcesses

    Attributes
    ----------
    run_dir : Path
        Folder of their sockets.

    Raises
    ------
    InvalidInput
        The path of the folder for temporary files is too long for sockets.
    """

    def __init__(self, membership: Membership, wanted: EndpointProcesses) -> None:
        file = membership.folder / FILE
        names = [f"{membership.machine}-{number}" for number in range(1, wanted.count + 1)]
        longest = max(len(endpoint_socket(Path(), name).name) for name in names)
        self.run_dir = _left_folder(file) or make_run_dir(longest)
        here = {"folder": str(membership.folder), "run_dir": str(self.run_dir)}
        settings = {name: {**wanted.settings, **here, "name": name} for name in names}
        self._keeper = ProcessKeeper((sys.executable, "-m", wanted.module), settings, self.run_dir, file)

    async def start(self) -> None:
        """Start or adopt the processes, and restart each whenever it exits or freezes."""
        await self._keeper.start()

    async def stop(self) -> None:
        """Stop all of them."""
        await self._keeper.stop()
        remove_unless_owned(self.run_dir)


def _left_folder(file: Path) -> Path | None:
    """Return the folder of processes of a killed agent that still run; this process owns it, too, from now on."""
    for left in left_processes(file):
        settings = from_json(left.settings, dict[str, Any])
        with contextlib.suppress(OSError, KeyError):  # it has just exited
            folder = Path(settings["run_dir"])
            add_owner(folder)
            return folder
    return None


# -- agent -------------------------------------------------------------------------------------------------------------

RETRIES = (0.25, 0.5, 1.0, 2.0, 5.0)
"""Delays before the first, second … attempt in a row to reach the cloud [s]; after ``STEADY`` [s] the row restarts."""

STEADY = 30.0


class MachineOptions(msgspec.Struct, frozen=True):
    """Options of the machine.

    Parameters
    ----------
    cores : int, optional
        CPUs to offer. Default: all.
    labels : dict of str to str
        Labels of the machine.
    patience : float
        Time for which the cloud may be unreachable [s].
    endpoints : EndpointProcesses, optional
        None for no endpoints.
    """

    cores: int | None = None
    labels: dict[str, str] = {}
    patience: float = sys.float_info.max
    endpoints: EndpointProcesses | None = None


class SocketFolders(NamedTuple):
    """Folders of the sockets of the machine: of its agent, and of its endpoints if it has any."""

    run_dir: Path
    endpoints: Path | None


async def stay(membership: Membership, options: MachineOptions) -> None:
    """Run a machine of the cloud until SIGTERM.

    Raises
    ------
    Conflict
        This machine speaks no protocol of the cloud. Its release may be installed before this process starts again.
    InvalidInput, NotFound
        The stores of the cloud cannot be reached from this machine.
    Unavailable
        The cloud was unreachable for longer than the options allow.
    """
    base = Path(tempfile.gettempdir())
    sweep_stale(base)  # folders of killed processes
    folder = folder_of(instance_name(), base)
    folder.mkdir(mode=0o700)
    async with contextlib.AsyncExitStack() as stack:
        stack.callback(remove_folder, folder)
        sockets = await _start_endpoints(membership, options, stack)
        keep_temporary_files_in(folder)  # until this process exits: the fork server listens there
        await _stay(membership, options, SocketFolders(folder / "run", sockets))


async def _start_endpoints(
    membership: Membership, options: MachineOptions, stack: contextlib.AsyncExitStack
) -> Path | None:
    """Start the endpoints of the machine, or adopt the endpoints of a killed agent; return the folder of their sockets.

    They find the cloud themselves, and serve on while the agent is restarted.
    """
    if options.endpoints is None:
        return None
    endpoints = MachineEndpoints(membership, options.endpoints)
    stack.push_async_callback(endpoints.stop)
    await endpoints.start()
    return endpoints.run_dir


async def _stay(membership: Membership, options: MachineOptions, places: SocketFolders) -> None:
    terminated, tries, last_contact, masters = asyncio.Event(), 0, monotonic(), Masters(membership)
    while True:
        began = monotonic()
        if await _run_once(membership, masters, options, places, terminated):
            last_contact = monotonic()
        if terminated.is_set():
            return
        if monotonic() - last_contact > options.patience:
            raise Unavailable(f"the cloud of machine {membership.machine} was unreachable for {options.patience:g} s")
        tries = 0 if monotonic() - began > STEADY else tries + 1
        with until_terminated(terminated):
            await asyncio.sleep(RETRIES[min(tries, len(RETRIES)) - 1])
        if terminated.is_set():
            return


async def _run_once(
    membership: Membership, masters: Masters, options: MachineOptions, places: SocketFolders, terminated: asyncio.Event
) -> bool:
    config: AgentConfig | None = None
    try:
        with until_terminated(terminated):
            config = config_of(membership, options, await masters.settings(), places, masters)
        dial = partial(dial_again, membership, masters, options, config)
        return config is not None and await run(config, terminated, dial, masters)
    except Unavailable as error:
        logger.warning("machine %s is not connected to its cloud: %s", membership.machine, error)
        return False


def config_of(
    membership: Membership, options: MachineOptions, settings: ClusterSettings, places: SocketFolders, masters: Masters
) -> AgentConfig:
    """Return the configuration of the agent.

    Raises
    ------
    Conflict, InvalidInput, NotFound
        As of ``check_settings``.
    """
    check_settings(settings)
    places.run_dir.mkdir(mode=0o700, exist_ok=True)
    return AgentConfig(
        machine=membership.machine,
        control=masters.current,
        secret="",  # the certificate identifies the machine
        run_dir=str(places.run_dir),
        cloud=settings.cloud,
        store=settings.store,
        map_store=settings.map_store,
        outbox=str(membership.outbox),
        cores=options.cores,
        labels=options.labels,
        peering=membership.peering(settings, masters.routers()),
        endpoints=None if places.endpoints is None else str(places.endpoints),
        identity=str(membership.folder),
        runtime=settings.runs.runtime,
        image=settings.runs.image,
        allowed=settings.runs.allowed,
        adopt_within=settings.runs.adopt_within,
    )


async def dial_again(membership: Membership, masters: Masters, options: MachineOptions, config: AgentConfig) -> Master:
    """Connect to the cloud again, with the configuration that the machine already runs.

    Raises
    ------
    Conflict
        The cloud was started with other settings, or speaks no protocol of this machine.
    Unavailable
        The cloud is unreachable.
    """
    places = SocketFolders(Path(config.run_dir), None if config.endpoints is None else Path(config.endpoints))
    now = config_of(membership, options, await masters.settings(), places, masters)
    if _without_addresses(now) != _without_addresses(config):
        raise Conflict("the cloud was restarted with other settings; the machine joins it again")
    return await dial_master(config, masters)


def _without_addresses(config: AgentConfig) -> AgentConfig:
    # These differ between the masters of a cloud.
    peering = None if config.peering is None else msgspec.structs.replace(config.peering, connect=())
    return msgspec.structs.replace(config, cloud="", control="", peering=peering)


def main() -> None:
    """Run until SIGTERM or Ctrl-C."""
    keep_new_files_private()
    log_lines("%(levelname)s agent %(name)s: %(message)s", process="agent", level=logging.INFO)
    signal.signal(signal.SIGINT, lambda *_: os.kill(os.getpid(), signal.SIGTERM))
    ensure_cache()
    options = from_json(sys.stdin.buffer.read(), MachineOptions)
    folder = Path(sys.argv[1])
    try:
        membership = membership_in(folder)
        with sole_owner(folder / LOCK, f"the folder {folder} of this machine", "join from another folder with --data"):
            begin_traces(MACHINE, membership.machine)
            uvloop.run(stay(membership, options))
    except PPaaSError as error:
        logger.error("the machine cannot run: %s", error)
        sys.exit(1)
    finally:
        end_traces()


if __name__ == "__main__":
    main()
