"""What is told of the planners that are installed, kept on the disk from one run of the cloud to the next.

To find it out anew takes a second and a half, for planners must be loaded to be asked. It stays true as long as the
same planners are installed and none of the files of their packages has changed.
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

logger = logging.getLogger(__name__)

PlannerCatalogue = list[dict[str, Any]]

GROUP = "ppaas.planners"


def cache_file(asked: str) -> Path:
    """Return where the answer to a question is kept, for the planners that are installed now.

    Parameters
    ----------
    asked : str
        The question, so that the answer to another one is not taken for it.
    """
    entries = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    files = sorted({file for entry in entries for file in _sources(entry)})
    made_from = [
        sys.version, asked, *(f"{entry.name} {entry.value}" for entry in entries),
        *map(source_of, files),
    ]  # fmt: skip
    return note_file("planners", made_from)


def kept(file: Path) -> PlannerCatalogue | None:
    """Return what is kept in a file; none where nothing is that can be read."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=PlannerCatalogue)
    except (OSError, msgspec.DecodeError):
        return None


def keep(file: Path, told: PlannerCatalogue) -> None:
    """Keep what is told, whole or not at all."""
    try:
        write_note(file, told)
    except OSError as error:
        logger.warning("what is told of the planners is not kept, so they are asked again at the next start: %s", error)


def _sources(entry: EntryPoint) -> Iterator[Path]:
    """Return the files of the package that a planner is part of, which is not imported."""
    found = find_spec(entry.module.partition(".")[0])
    if found is None:
        return
    for folder in found.submodule_search_locations or ():
        yield from Path(folder).rglob("*.py")
    if found.has_location and found.origin is not None:
        yield Path(found.origin)
