"""Machines that join a cloud on this host by ``ppaas machine join``, as machines of other hosts do."""

import asyncio
import contextlib
import os
import signal
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from robots import cli
from robots.client.rest import RestClient

MACHINE = ("-m", cli.__name__, "machine")

JOIN_TIMEOUT = 60.0
"""Time within which a machine must have joined [s]."""

END_TIMEOUT = 20.0
"""Time within which a machine must exit after SIGTERM [s]."""

RESTART = 0.5
"""Delay before a machine that exited is restarted [s]."""

BLINK = 0.05
"""Period at which the list of machines is requested [s]."""


async def ticket_of(data: Path, *arguments: str) -> str:
    """Return a ticket to the cloud with this data folder; ``arguments`` are further ones of the command.

    Raises
    ------
    Unavailable
        The cloud issues no ticket.
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable, *MACHINE, "ticket", "--data", str(data), *arguments, stdout=PIPE
    )
    told, _ = await process.communicate()
    if process.returncode:
        raise Unavailable(f"'ppaas machine ticket' failed with status {process.returncode}")
    return told.decode().strip()


async def joined_machines(rest: RestClient) -> list[str]:
    """Return the names of the machines of a cloud that have joined, without those that still start."""
    return [view["id"] for view in await rest.items("/v1/machines") if view["state"] != "starting"]


INSTALLED = {"PYTHONSAFEPATH": "1"}
"""Environment in which a process imports the packages of its interpreter rather than modules of the current folder."""


class JoinedMachine:
    """The process of a machine, which becomes its agent.

    Parameters
    ----------
    name : str
        Name of the machine.
    folder : Path
        For its log, its key and its temporary files: a short path, since it contains sockets.
    process : Process
        The process.
    restarts : bool
        Whether the process is restarted whenever it exits, as by a process supervisor.
    options : sequence of str
        Further arguments of ``ppaas machine join``.

    Attributes
    ----------
    python : str
        Interpreter that runs it, from the next start on.
    """

    def __init__(
        self, name: str, folder: Path, process: Process, *, restarts: bool, options: Sequence[str] = ()
    ) -> None:
        self.name = name
        self.python = sys.executable
        self._folder = folder
        self._process = process
        self._options = options
        self._keeper = asyncio.create_task(self._keep()) if restarts else None

    @classmethod
    async def start(
        cls,
        name: str,
        folder: Path,
        ticket: str,
        *,
        restarts: bool = False,
        options: Sequence[str] = (),
        python: str = sys.executable,
    ) -> Self:
        """Start a machine that joins the cloud by a ticket."""
        process = await _join(name, folder, options, python, ticket)
        machine = cls(name, folder, process, restarts=restarts, options=options)
        machine.python = python
        return machine

    async def _keep(self) -> None:
        while True:
            await self._process.wait()
            await asyncio.sleep(RESTART)
            self._process = await _join(self.name, self._folder, self._options, self.python)

    async def is_in(self, rest: RestClient) -> None:
        """Wait until the machine has joined the cloud.

        Raises
        ------
        Unavailable
            The process exited, or the machine did not join within `JOIN_TIMEOUT`.
        """
        deadline = monotonic() + JOIN_TIMEOUT
        while self.name not in await joined_machines(rest):
            if self._process.returncode is not None or monotonic() > deadline:
                raise Unavailable(f"machine {self.name!r} did not join: status {self._process.returncode}")
            await asyncio.sleep(BLINK)

    def terminate(self) -> None:
        """Send SIGTERM to the agent; it is started again if the machine restarts."""
        self._process.terminate()

    def kill(self) -> None:
        """Kill the agent; its containers and its router exit with it."""
        self._process.kill()

    def freeze(self) -> None:
        """Stop the agent by SIGSTOP."""
        self._process.send_signal(signal.SIGSTOP)

    async def end(self) -> None:
        """End the restarts, then the agent by SIGTERM.

        Raises
        ------
        Unavailable
            The agent did not exit within `END_TIMEOUT`, and was killed.
        """
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)
        with contextlib.suppress(ProcessLookupError):  # it has exited
            self._process.terminate()
            self._process.send_signal(signal.SIGCONT)
        try:
            await asyncio.wait_for(self._process.wait(), END_TIMEOUT)
        except TimeoutError as error:
            self._process.kill()
            await self._process.wait()
            raise Unavailable(f"machine {self.name} did not exit within {END_TIMEOUT:g} s after SIGTERM") from error


async def _join(name: str, folder: Path, options: Sequence[str], python: str, ticket: str | None = None) -> Process:
    """Start the process of a machine; one that has joined before needs no ticket, but uses its key."""
    (folder / "t").mkdir(parents=True, exist_ok=True)
    shown = () if ticket is None else (ticket,)
    with (folder / "log").open("ab") as log:
        return await asyncio.create_subprocess_exec(
            python, *MACHINE, "join", *shown, "--name", name, "--data", str(folder / "data"), *options,
            stdin=DEVNULL, stdout=log, stderr=log,
            env=os.environ | INSTALLED | {"TMPDIR": str(folder / "t")},
            start_new_session=True,
        )  # fmt: skip
