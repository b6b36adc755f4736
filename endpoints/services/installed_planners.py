"""Catalogue of the installed and permitted planners.

A separate process lists them, so that the web process need not load their kernels. The result is cached on the disk.
"""

import asyncio
import logging
import sys
from typing import TYPE_CHECKING

import msgspec

from endpoints.services import planner_cache
from endpoints.services.planner_cache import PlannerCatalogue
from ppaas.decoding import from_json
from ppaas.errors import Unavailable
from ppaas.plugins import permitted

if TYPE_CHECKING:
    from endpoints.services import list_planners  # noqa: F401 - the program named below

logger = logging.getLogger(__name__)

PROGRAM = ("-m", "endpoints.services.list_planners")
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
            A planner cannot be loaded; the reason is logged.
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
        known = await _list(arguments)
        planner_cache.save(file, known)
    return known


async def _list(arguments: tuple[str, ...]) -> PlannerCatalogue:
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(sys.executable, *arguments, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    if process.returncode != 0:
        logger.error("cannot list the planners: %s", err.decode(errors="replace"))
        raise Unavailable("an installed planner cannot be loaded: see the log of the cloud")
    return from_json(out, PlannerCatalogue)
