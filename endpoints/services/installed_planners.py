"""Catalogue of the installed and permitted planners.

A separate process lists them, so that the web process need not load their kernels. The result is cached on the disk.
"""

import asyncio
import logging
import sys

import msgspec

from endpoints.services import list_planners, planner_cache
from endpoints.services.planner_cache import PlannerCatalogue
from ppaas.decoding import from_json
from ppaas.errors import Unavailable
from ppaas.plugins import permitted

logger = logging.getLogger(__name__)

PROGRAM = ("-m", list_planners.__name__)
"""Arguments of Python that run the program; the permitted plug-ins follow as JSON."""


class InstalledPlanners:
    """Catalogue of the installed planners, which does not change while the cloud runs."""

    def __init__(self) -> None:
        self._known: PlannerCatalogue | None = None
        self._lock = asyncio.Lock()

    async def all(self) -> PlannerCatalogue:
        """Return all planners, ordered by name.

        Raises
        ------
        Unavailable
            A planner of this project cannot be loaded; the reason is logged. One of another distribution is left out.
        """
        async with self._lock:
            if self._known is None:
                self._known = await _load_or_list()
            return self._known


async def _load_or_list() -> PlannerCatalogue:
    arguments = (*PROGRAM, msgspec.json.encode(permitted()).decode())
    file = await asyncio.to_thread(planner_cache.cache_file, " ".join(arguments))
    known = planner_cache.load(file)
    if known is None:
        known, complete = await _list(arguments)
        if complete:
            planner_cache.save(file, known)
    return known


async def _list(arguments: tuple[str, ...]) -> tuple[PlannerCatalogue, bool]:
    """Return the installed planners, and whether these are all."""
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(sys.executable, *arguments, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    text = err.decode(errors="replace")
    if process.returncode not in (0, list_planners.INCOMPLETE):
        logger.error("cannot list the planners: %s", text)
        raise Unavailable("an installed planner cannot be loaded: see the log of the cloud")
    if process.returncode:
        logger.warning("planners are left out: %s", text)
    return from_json(out, PlannerCatalogue), not process.returncode
