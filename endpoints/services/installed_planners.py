"""Which planners the cloud has, and lets run: asked of a process that loads their kernels, so that this one need not.

It is asked once, and the answer kept for the next runs.
"""

import asyncio
import logging
import sys

import msgspec

from endpoints.services import planner_cache
from endpoints.services.planner_cache import Told
from ppaas.errors import Unavailable
from ppaas.plugins import permitted

logger = logging.getLogger(__name__)

SCRIPT = """
import sys, msgspec
from ppaas.plugins import permit_only
allowed = ALLOWED
if allowed is not None:
    permit_only(allowed)
from ppaas.planners.catalogue import catalogue
sys.stdout.buffer.write(msgspec.json.encode(catalogue()))
"""


class InstalledPlanners:
    """What is told of the planners that are installed; they stay the same as long as the cloud runs."""

    def __init__(self) -> None:
        self._known: Told | None = None
        self._asking = asyncio.Lock()

    async def all(self) -> Told:
        """Return all, by name.

        Raises
        ------
        Unavailable
            One of them cannot be loaded; the log says why.
        """
        async with self._asking:
            if self._known is None:
                self._known = await _find_out()
            return self._known


async def _find_out() -> Told:
    script = SCRIPT.replace("ALLOWED", repr(permitted()))
    file = await asyncio.to_thread(planner_cache.cache_file, script)
    known = planner_cache.kept(file)
    if known is None:
        known = await _ask(script)
        planner_cache.keep(file, known)
    return known


async def _ask(script: str) -> Told:
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", script, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    if process.returncode != 0:
        logger.error("cannot list the planners: %s", err.decode(errors="replace"))
        raise Unavailable("one of the planners installed cannot be loaded; the log of the cloud says why")
    return msgspec.json.decode(out, type=Told)
