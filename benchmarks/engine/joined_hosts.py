"""Machines that join a cloud on this host by ``ppaas machine join``, with the link of remote machines."""

import contextlib
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.joining import JoinedMachine, ticket_of
from ppaas.errors import Unavailable


class LocalHosts:
    """Provides additional machines on this host.

    Parameters
    ----------
    arguments : tuple of str
        Arguments of the cloud; those that allow machines to join are added.
    """

    def __init__(self, arguments: tuple[str, ...]) -> None:
        self.arguments = (*arguments, "--listen-machines", "127.0.0.1:0")
        self.environment: dict[str, str] = {}
        self._count = 0

    @contextlib.asynccontextmanager
    async def joined(self, target: Target, folder: Path) -> AsyncIterator[JoinedMachine]:
        """Start a machine that joins the cloud with this folder by a ticket, and end it afterwards."""
        self._count += 1
        name = f"bench-{self._count}"
        with tempfile.TemporaryDirectory(prefix="m-", ignore_cleanup_errors=True) as own:  # sockets need a short path
            machine = await JoinedMachine.start(name, Path(own), await ticket_of(folder / "data"))
            try:
                await machine.is_in(target.rest)
                yield machine
            finally:
                with contextlib.suppress(Unavailable):  # it did not exit by itself, and was killed
                    await machine.end()
