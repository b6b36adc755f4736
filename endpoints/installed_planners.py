"""Which planners the cloud has: asked once, of a process that loads their kernels, so that this one need not."""

import asyncio
import logging
import sys
from typing import Any

import msgspec

from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

SCRIPT = """
import sys, msgspec
from ppaas.planners.catalogue import catalogue
sys.stdout.buffer.write(msgspec.json.encode(catalogue()))
"""


class InstalledPlanners:
    """What is told of the planners that are installed; they stay the same as long as the cloud runs."""

    def __init__(self) -> None:
        self._known: list[dict[str, Any]] | None = None
        self._asking = asyncio.Lock()

    async def all(self) -> list[dict[str, Any]]:
        """Return all, by name.

        Raises
        ------
        Unavailable
            One of them cannot be loaded; the log says why.
        """
        async with self._asking:
            if self._known is None:
                self._known = await _ask()
            return self._known


async def _ask() -> list[dict[str, Any]]:
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", SCRIPT, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    if process.returncode != 0:
        logger.error("cannot list the planners: %s", err.decode(errors="replace"))
        raise Unavailable("one of the planners installed cannot be loaded; the log of the cloud says why")
    found: list[dict[str, Any]] = msgspec.json.decode(out)
    return found
