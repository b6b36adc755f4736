"""Disk cache of the planner catalogue.

Listing the planners takes 1.5 s, because it loads them. The catalogue is valid as long as the same planners are
installed and no file of their packages has changed.
"""

import logging
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import msgspec

from engine.processes.disk_notes import note_file, source_of, write_note
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)

PlannerCatalogue = list[dict[str, Any]]
"""Name, aliases, purpose, parameters and traits of each planner (``ppaas.planners.catalogue``)."""

GROUP = "ppaas.planners"


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


def load(file: Path) -> PlannerCatalogue | None:
    """Return the catalogue in a file; None if it is missing or unreadable."""
    try:
        return from_json(file.read_bytes(), PlannerCatalogue)
    except (OSError, msgspec.DecodeError):
        return None


def save(file: Path, catalogue: PlannerCatalogue) -> None:
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
