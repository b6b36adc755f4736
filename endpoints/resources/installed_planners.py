"""Catalogue of the installed and permitted planners.

A separate process lists them, so that the web process need not load their kernels. That takes 1.5 s, so the result
is cached on the disk.
"""

import asyncio
import logging
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import msgspec

from endpoints.resources import list_planners
from engine.processes.disk_notes import note_file, source_of, write_note
from ppaas.decoding import from_json
from ppaas.errors import Unavailable
from ppaas.plugins import permitted

logger = logging.getLogger(__name__)

PlannerCatalogue = list[dict[str, Any]]
"""Name, aliases, purpose, parameters and traits of each planner (``ppaas.planners.catalogue``)."""

GROUP = "ppaas.planners"

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
    file = await asyncio.to_thread(cache_file, " ".join(arguments))
    known = _load(file)
    if known is None:
        known, complete = await _list(arguments)
        if complete:
            _save(file, known)
    return known


async def _list(arguments: tuple[str, ...]) -> tuple[PlannerCatalogue, bool]:
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


# -- cache on the disk: valid while the same planners are installed and no file of their packages changed --------------


def cache_file(arguments: str) -> Path:
    """Return the cache file for the planners that are installed now.

    Parameters
    ----------
    arguments : str
        Arguments of the listing program, which are part of the key.
    """
    entries = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    files = sorted({file for entry in entries for file in _sources(entry)})
    key_parts = [
        sys.version, arguments, *(f"{entry.name} {entry.value}" for entry in entries),
        *map(source_of, files),
    ]  # fmt: skip
    return note_file("planners", key_parts)


def _load(file: Path) -> PlannerCatalogue | None:
    """Return the catalogue in a file; None if it is missing or unreadable."""
    try:
        return from_json(file.read_bytes(), PlannerCatalogue)
    except (OSError, msgspec.DecodeError):
        return None


def _save(file: Path, catalogue: PlannerCatalogue) -> None:
    """Write a catalogue to a file atomically; failures are only logged."""
    try:
        write_note(file, catalogue)
    except OSError as error:
        logger.warning("the planner catalogue cannot be cached and is listed again at the next start: %s", error)


def _sources(entry: EntryPoint) -> Iterator[Path]:
    """Return the source files of a planner's package without importing it."""
    found = find_spec(entry.module.partition(".")[0])
    if found is None:
        return
    for folder in found.submodule_search_locations or ():
        yield from Path(folder).rglob("*.py")
    if found.has_location and found.origin is not None:
        yield Path(found.origin)
