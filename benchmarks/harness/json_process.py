"""Processes that talk with a bench in lines of JSON: the side of the bench, and the side of the process."""

import asyncio
import contextlib
import sys
from collections.abc import AsyncIterator
from types import ModuleType
from typing import Any

import msgspec

from ppaas.errors import Unavailable

MOST = 1 << 28
"""Longest line [bytes]."""


class JsonProcess:
    """A process that reads requests and writes answers.

    Parameters
    ----------
    process : Process
        The process, with pipes for standard input and output.
    """

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    async def say(self, value: object) -> None:
        """Send a line without waiting for an answer."""
        if self._process.stdin is None:
            raise Unavailable("the process of the bench has no pipe for standard input")
        self._process.stdin.write(msgspec.json.encode(value) + b"\n")
        await self._process.stdin.drain()

    async def hear(self) -> Any:
        """Return the next line of the process.

        Raises
        ------
        Unavailable
            The process has exited.
        """
        line = await self._process.stdout.readline() if self._process.stdout is not None else b""
        if not line:
            raise Unavailable(f"a process of the bench exited with status {await self._process.wait()}")
        return msgspec.json.decode(line)

    async def ask(self, value: object) -> Any:
        """Send a line and return the answer; raises as ``hear``."""
        await self.say(value)
        return await self.hear()

    async def kill(self) -> None:
        """Kill the process and wait until it has exited."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()


@contextlib.asynccontextmanager
async def json_process(module: ModuleType, *arguments: str) -> AsyncIterator[JsonProcess]:
    """Run a module as a process, and kill it afterwards."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", module.__name__, *arguments,
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=MOST,
    )  # fmt: skip
    talk = JsonProcess(process)
    try:
        yield talk
    finally:
        await talk.kill()


MOST_REQUEST = 1 << 16
"""Longest line [bytes]."""


async def lines() -> AsyncIterator[Any]:
    """Yield the decoded lines of standard input until it is closed."""
    reader = asyncio.StreamReader(MOST_REQUEST)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async for line in reader:
        yield msgspec.json.decode(line)


def tell(value: object) -> None:
    """Print a line."""
    sys.stdout.write(f"{msgspec.json.encode(value).decode()}\n")
    sys.stdout.flush()
