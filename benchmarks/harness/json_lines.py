"""Lines of JSON on standard input and output, by which a bench speaks with a process that it measures."""

import asyncio
import sys
from collections.abc import AsyncIterator
from typing import Any

import msgspec

MOST = 1 << 16


async def lines() -> AsyncIterator[Any]:
    """Yield what comes, line by line, until whoever started this process hangs up."""
    reader = asyncio.StreamReader(MOST)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async for line in reader:
        yield msgspec.json.decode(line)


def tell(value: object) -> None:
    """Print a line."""
    sys.stdout.write(f"{msgspec.json.encode(value).decode()}\n")
    sys.stdout.flush()
