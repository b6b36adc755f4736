"""Endpoints of a joined machine: its agent keeps their processes running, and they outlive a killed agent."""

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from engine.local.process_keeper import ProcessKeeper, left_processes
from engine.processes.run_dir import add_owner, make_run_dir, remove_unless_owned
from engine.protocols.endpoint_sockets import endpoint_socket
from engine.remote.membership import Membership

FILE = "endpoints-here.json"
"""File in the folder of the membership that records the processes."""


class MachineEndpoints:
    """Keeps the endpoint processes of a joined machine running.

    Parameters
    ----------
    membership : Membership
        The machine and its cloud.
    command : sequence of str
        Command that runs an endpoint.
    settings : sequence of dict
        Settings of each, without ``name``, ``folder`` and ``run_dir``.

    Attributes
    ----------
    run_dir : Path
        Folder of their sockets.

    Raises
    ------
    InvalidInput
        The path of the folder for temporary files is too long for sockets.
    """

    def __init__(self, membership: Membership, command: Sequence[str], settings: Sequence[Mapping[str, Any]]) -> None:
        file = membership.folder / FILE
        named = {f"{membership.machine}-{number}": one for number, one in enumerate(settings, 1)}
        longest = max(len(endpoint_socket(Path(), name).name) for name in named)
        self.run_dir = _left_folder(file) or make_run_dir(longest)
        here = {"folder": str(membership.folder), "run_dir": str(self.run_dir)}
        complete = {name: {**one, **here, "name": name} for name, one in named.items()}
        self._keeper = ProcessKeeper(command, complete, self.run_dir, file)

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
        settings = msgspec.json.decode(left.settings, type=dict[str, Any])
        with contextlib.suppress(OSError, KeyError):  # it has just exited
            folder = Path(settings["run_dir"])
            add_owner(folder)
            return folder
    return None
