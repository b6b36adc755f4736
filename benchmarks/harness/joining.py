"""Machines that join a cloud on this host by ``ppaas machine join``, as machines of other hosts do."""

import asyncio
import os
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from pathlib import Path

from ppaas.errors import Unavailable
from robots import cli

MACHINE = (sys.executable, "-m", cli.__name__, "machine")


async def ticket_of(data: Path) -> str:
    """Return a ticket to the cloud with this data folder.

    Raises
    ------
    Unavailable
        The cloud issues no ticket.
    """
    process = await asyncio.create_subprocess_exec(*MACHINE, "ticket", "--data", str(data), stdout=PIPE)
    told, _ = await process.communicate()
    if process.returncode:
        raise Unavailable(f"'ppaas machine ticket' failed with status {process.returncode}")
    return told.decode().strip()


async def join(name: str, folder: Path, ticket: str | None = None) -> Process:
    """Start the process of a machine, which becomes its agent.

    Parameters
    ----------
    name : str
        Name of the machine.
    folder : Path
        For its log, its key and its temporary files: a short path, since it contains sockets.
    ticket : str, optional
        Ticket for the first join; a machine that has joined before uses its key.
    """
    (folder / "t").mkdir(parents=True, exist_ok=True)
    shown = () if ticket is None else (ticket,)
    with (folder / "log").open("ab") as log:
        return await asyncio.create_subprocess_exec(
            *MACHINE, "join", *shown, "--name", name, "--data", str(folder / "data"),
            stdin=DEVNULL, stdout=log, stderr=log, env=os.environ | {"TMPDIR": str(folder / "t")},
            start_new_session=True,
        )  # fmt: skip
