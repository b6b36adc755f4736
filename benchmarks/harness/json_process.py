"""A process of the bench that answers lines of JSON."""

import asyncio
import contextlib
import sys
from collections.abc import AsyncIterator
from types import ModuleType
from typing import Any

import msgspec

from ppaas.errors import Unavailable

MOST = 1 << 28
"""Bytes of a line."""


class JsonProcess:
    """A process that is asked.

    Parameters
    ----------
    process : Process
        With pipes to it.
    """

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    async def say(self, value: object) -> None:
        """Say something that is not waited for."""
        if self._process.stdin is None:
            raise Unavailable("there is no way to the process")
        self._process.stdin.write(msgspec.json.encode(value) + b"\n")
        await self._process.stdin.drain()

    async def hear(self) -> Any:
        """Return what it says next.

        Raises
        ------
        Unavailable
            It ended.
        """
        line = await self._process.stdout.readline() if self._process.stdout is not None else b""
        if not line:
            raise Unavailable(f"a process of the bench ended: status {await self._process.wait()}")
        return msgspec.json.decode(line)

    async def ask(self, value: object) -> Any:
        """Say something, and return the answer; raises as ``hear``."""
        await self.say(value)
        return await self.hear()

    async def kill(self) -> None:
        """End it by force."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()


@contextlib.asynccontextmanager
async def json_process(module: ModuleType, *arguments: str) -> AsyncIterator[JsonProcess]:
    """Run a module as a process, and end it afterwards."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", module.__name__, *arguments,
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=MOST,
    )  # fmt: skip
    talk = JsonProcess(process)
    try:
        yield talk
    finally:
        await talk.kill()
