"""Endpoints of a joined machine: its agent keeps their processes running, and they outlive a killed agent."""

import contextlib
import sys
from pathlib import Path
from typing import Any

from engine.local.process_keeper import ProcessKeeper, left_processes
from engine.processes.run_dir import add_owner, make_run_dir, remove_unless_owned
from engine.protocols.endpoint_sockets import endpoint_socket
from engine.remote.endpoint_processes import EndpointProcesses
from engine.remote.membership import Membership
from ppaas.decoding import from_json

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
