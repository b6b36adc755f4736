"""Lines of JSON on standard input and output, by which a measured process talks with the bench."""

import asyncio
import sys
from collections.abc import AsyncIterator
from typing import Any

import msgspec

MOST = 1 << 16
"""Longest line [bytes]."""


async def lines() -> AsyncIterator[Any]:
    """Yield the decoded lines of standard input until it is closed."""
    reader = asyncio.StreamReader(MOST)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async for line in reader:
        yield msgspec.json.decode(line)


def tell(value: object) -> None:
    """Print a line."""
    sys.stdout.write(f"{msgspec.json.encode(value).decode()}\n")
    sys.stdout.flush()
