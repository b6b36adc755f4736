"""Files of recordings for callers: as they are, or put together in a process of its own."""

import json
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.concurrency import run_in_threadpool

from endpoints.rest.maps.map_programs import run_program
from endpoints.services.services import Services
from endpoints.sharing.shared_robots import ReachedRobot
from ppaas.errors import NotFound, Unavailable
from storage.disk_errors import disk_errors
from storage.recordings.folder import RecordingsFolder, Segment

if TYPE_CHECKING:
    from endpoints.rest.recordings import assembly_program  # noqa: F401 - the program named below

RING = "ring"
"""Name of the ring in place of the id of a recording."""

SECONDS = 120.0
"""Time limit of putting a file together [s]."""

_ASSEMBLY = "endpoints.rest.recordings.assembly_program"


def folder_of(services: Services) -> RecordingsFolder:
    """Return the folder of recordings.

    Raises
    ------
    Unavailable
        This cloud keeps none, or this endpoint does not reach them.
    """
    if services.far_folder is not None:
        raise Unavailable("recordings are on the host of the cloud: send this request to an endpoint there")
    if services.recordings is None:
        raise Unavailable("this cloud keeps no recordings: it has no data folder")
    return services.recordings


def last_segments(segments: Sequence[Segment], minutes: float | None) -> list[Path]:
    """Return the files of a ring that have the last minutes before its end; all of them for None."""
    if minutes is None or not segments:
        return [segment.path for segment in segments]
    since = segments[-1].path.stat().st_mtime - 60.0 * minutes
    ends = [segment.begin / 1e9 for segment in segments[1:]] + [float("inf")]
    return [segment.path for segment, end in zip(segments, ends, strict=True) if end > since]


async def assembled(services: Services, caller: str, robot: ReachedRobot, sources: list[Path]) -> Path:
    """Put files together, with the topics that the caller may subscribe to.

    Returns
    -------
    Path
        A temporary file, which the caller of this function removes.

    Raises
    ------
    NotFound
        There are no files.
    Unavailable
        They are too large, or the disk is full.
    """
    if not sources:
        raise NotFound("recording", RING)
    readable = [list(globs) for globs in robot.access.readable]
    async with services.heavy_work.turn(caller):
        return await run_in_threadpool(_put_together, sources, readable)


def _put_together(sources: list[Path], readable: list[list[str]]) -> Path:
    with disk_errors(Path(tempfile.gettempdir())):
        descriptor, name = tempfile.mkstemp(prefix="ppaas-recording-", suffix=".mcap")
        os.close(descriptor)
    arguments = {"sources": [str(source) for source in sources], "target": name, "readable": readable}
    try:
        run_program(_ASSEMBLY, [json.dumps(arguments)], "the recording could not be put together", SECONDS)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return Path(name)
