"""Files of recordings for callers: as they are, or put together in a separate process."""

import json
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

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


@asynccontextmanager
async def assembled(
    services: Services, caller: str, robot: ReachedRobot, sources: list[Path]
) -> AsyncIterator[BinaryIO]:
    """Put files together, with the topics that the caller may subscribe to.

    A caller has a few of these copies at once, because each may have a gigabyte.

    Yields
    ------
    BinaryIO
        A temporary file without a name: no copy is left, whatever becomes of this process.

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
    async with services.copies.turn_of_user(caller):
        with disk_errors(Path(tempfile.gettempdir())):
            whole = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
        with whole:
            async with services.heavy_work.turn(caller):
                await run_in_threadpool(_put_together, sources, readable, whole.fileno())
            yield whole


def _put_together(sources: list[Path], readable: list[list[str]], target: int) -> None:
    arguments = {"sources": [str(source) for source in sources], "target": target, "readable": readable}
    failure = "the recording could not be put together"
    run_program(_ASSEMBLY, [json.dumps(arguments)], failure, SECONDS, inherited=(target,))
