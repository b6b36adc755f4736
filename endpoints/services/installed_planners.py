"""Planners that are installed and allowed to run, as listed by a process of its own: only that one loads their kernels.

It is asked once, and the answer is kept for the next runs.
"""

import asyncio
import logging
import sys
from typing import TYPE_CHECKING

import msgspec

from endpoints.services import planner_cache
from endpoints.services.planner_cache import PlannerCatalogue
from ppaas.errors import Unavailable
from ppaas.plugins import permitted

if TYPE_CHECKING:
    from endpoints.services import list_planners  # noqa: F401 - the program that is named below

logger = logging.getLogger(__name__)

PROGRAM = ("-m", "endpoints.services.list_planners")
"""Arguments of Python that list the planners; the plug-ins that are allowed follow."""


class InstalledPlanners:
    """What is told of the planners that are installed; they stay the same as long as the cloud runs."""

    def __init__(self) -> None:
        self._known: PlannerCatalogue | None = None
        self._asking = asyncio.Lock()

    async def all(self) -> PlannerCatalogue:
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


async def _find_out() -> PlannerCatalogue:
    question = (*PROGRAM, msgspec.json.encode(permitted()).decode())
    file = await asyncio.to_thread(planner_cache.cache_file, " ".join(question))
    known = planner_cache.kept(file)
    if known is None:
        known = await _ask(question)
        planner_cache.keep(file, known)
    return known


async def _ask(question: tuple[str, ...]) -> PlannerCatalogue:
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(sys.executable, *question, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    if process.returncode != 0:
        logger.error("cannot list the planners: %s", err.decode(errors="replace"))
        raise Unavailable("one of the planners installed cannot be loaded; the log of the cloud says why")
    return msgspec.json.decode(out, type=PlannerCatalogue)
