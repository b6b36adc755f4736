"""End of a child process that runs until its input ends."""

import asyncio
import contextlib
from asyncio.subprocess import Process


async def end(process: Process, grace: float) -> None:
    """Close the standard input of a process, and wait for its exit; kill it after a time [s]."""
    if process.stdin is not None:
        process.stdin.close()
    try:
        async with asyncio.timeout(grace):
            await process.wait()
    except TimeoutError:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()
