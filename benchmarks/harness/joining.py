"""Machines that join a cloud on this host, over the links of machines of other hosts."""

import asyncio
import os
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from pathlib import Path

from ppaas.errors import Unavailable
from robots import cli

MACHINE = (sys.executable, "-m", cli.__name__, "machine")


async def ticket_of(data: Path) -> str:
    """Return a ticket of the cloud with this data folder.

    Raises
    ------
    Unavailable
        It gives none.
    """
    process = await asyncio.create_subprocess_exec(*MACHINE, "ticket", "--data", str(data), stdout=PIPE)
    told, _ = await process.communicate()
    if process.returncode:
        raise Unavailable(f"no ticket for another machine was given: status {process.returncode}")
    return told.decode().strip()


async def join(name: str, folder: Path, ticket: str | None = None) -> Process:
    """Start the process of a machine, which becomes its agent.

    Parameters
    ----------
    name : str
        Of the machine.
    folder : Path
        For its log, its key and its temporary files: a short path, as there are sockets among them.
    ticket : str, optional
        With which it joins; one that was in already has its key.
    """
    (folder / "t").mkdir(parents=True, exist_ok=True)
    shown = () if ticket is None else (ticket,)
    with (folder / "log").open("ab") as log:
        return await asyncio.create_subprocess_exec(
            *MACHINE, "join", *shown, "--name", name, "--data", str(folder / "data"),
            stdin=DEVNULL, stdout=log, stderr=log, env=os.environ | {"TMPDIR": str(folder / "t")},
            start_new_session=True,
        )  # fmt: skip
