"""Routes of the recordings of a robot, and of the ring of its last minutes."""

import asyncio
import json
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, BinaryIO

from fastapi import APIRouter, Path, Query
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool
from starlette.responses import FileResponse

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Administered, AnyCaller, Driven, Looked, Paged, Provided
from endpoints.rest.maps.map_programs import run_program
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.recordings.file_response import OpenFileResponse
from endpoints.rest.schemas import RequestBody, ResponseBody, TopicGlobs
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.shared_robots import ReachedRobot
from ppaas.errors import NotFound, Unavailable
from ppaas.messages.base.message import Empty
from ppaas.messages.health.watching import RecorderState, StartRecordingRequest
from ppaas.nodes.recorder.node import MOST_SECONDS
from ppaas.recording.parameters import MOST_MINUTES
from storage.recordings import RecordingsFolder, Segment, StoredRecording
from storage.store_errors import disk_errors

if TYPE_CHECKING:
    from endpoints.rest.recordings import assembly_program  # noqa: F401 - the program named below


# Files of recordings for callers: as they are, or put together in a separate process.

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


def last_segments(segments: Sequence[Segment], minutes: float | None) -> list[FilePath]:
    """Return the files of a ring that have the last minutes before its end; all of them for None."""
    if minutes is None or not segments:
        return [segment.path for segment in segments]
    since = segments[-1].path.stat().st_mtime - 60.0 * minutes
    ends = [segment.begin / 1e9 for segment in segments[1:]] + [float("inf")]
    return [segment.path for segment, end in zip(segments, ends, strict=True) if end > since]


@asynccontextmanager
async def assembled(
    services: Services, caller: str, robot: ReachedRobot, sources: list[FilePath]
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
        with disk_errors(FilePath(tempfile.gettempdir())):
            whole = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
        with whole:
            async with services.heavy_work.turn(caller):
                await run_in_threadpool(_put_together, sources, readable, whole.fileno())
            yield whole


def _put_together(sources: list[FilePath], readable: list[list[str]], target: int) -> None:
    arguments = {"sources": [str(source) for source in sources], "target": target, "readable": readable}
    failure = "the recording could not be put together"
    # A separate process has a limit of memory, and what was cut off is put together there (ADR 0049).
    run_program(_ASSEMBLY, [json.dumps(arguments)], failure, SECONDS, inherited=(target,))


router = APIRouter(prefix="/robots/{robot_id}", tags=["robots"], route_class=StrictRoute)

DEFAULT_SECONDS = 600.0
"""Time after which a recording ends by itself [s]."""

PATIENCE, LOOK = 20.0, 0.05
"""Time within which the recorder of a machine begins and ends a file, and the period of looking for it [s]. Its process
is started for the first file, which takes a second, or longer on a machine without a free core."""

MEDIA_TYPE = "application/octet-stream"

RecordingId = Annotated[
    Name, Path(description="Id of a recording; `ring` is the ring of the last minutes", examples=["20261126T224142Z"])
]
Minutes = Annotated[
    float | None,
    Query(gt=0.0, le=MOST_MINUTES, allow_inf_nan=False, description="Of the ring: only the last minutes (all)"),
]


class RecordingRequest(RequestBody):
    """Recording to start."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"seconds": 60.0, "topics": ["*"]}]})

    seconds: float = Field(
        default=DEFAULT_SECONDS, gt=0.0, le=MOST_SECONDS, description="Time after which it ends by itself [s]"
    )
    topics: TopicGlobs | None = Field(
        default=None, description="Globs of the topics to record; by default the robot file's"
    )


class RecorderAnswer(ResponseBody):
    """State of the recorder of a robot."""

    recording: str = Field(description="Id of the recording in progress; empty if there is none")
    left: float = Field(description="Time until it ends by itself [s]")
    ring_minutes: float = Field(description="Length of the ring [min]; 0 if the robot has none")
    messages: int = Field(description="Messages since the container of the clone started")
    lost: int = Field(description="Messages that were dropped because the machine was too slow")
    problem: str = Field(description="Why nothing is recorded, or the last recording ended early; empty if all is well")


class RecordingAnswer(ResponseBody):
    """Recording of a robot."""

    id: str
    size: int = Field(description="Size of what is written so far [bytes]")
    changed: float = Field(description="Time of the last write [s since the epoch]")
    finished: bool = Field(
        description="Whether it is complete. One that is not is in progress, or was cut off; its file has what is there"
    )


@router.get("/recorder", response_model=RecorderAnswer, responses=KNOWN | problems(403, 404, 503))
async def show_recorder(robot: Looked, services: Provided) -> RecorderState:
    """Show what the recorder of a connected robot does."""
    return await services.cloud.nodes.recorder(robot.user, robot.id, "state", Empty())


@router.get("/recordings", response_model=Page[RecordingAnswer], responses=KNOWN | problems(403, 404))
async def list_recordings(robot: Looked, services: Provided, paging: Paged) -> dict[str, Any]:
    """List the recordings of a robot, newest first."""
    before = paging.key(str, "")
    found = await run_in_threadpool(folder_of(services).recordings, robot.user, robot.id)
    later = [one for one in found if not before or one.id < before]
    return paging.page(later[: paging.fetch_limit], lambda one: one.id)


@router.post(
    "/recordings",
    status_code=201,
    response_model=RecordingAnswer,
    responses=KNOWN | BODY | problems(403, 404, 409, 429, 503),
)
async def start_recording(wanted: RecordingRequest, robot: Driven, services: Provided) -> StoredRecording:
    """Start to record a connected robot; one recording at a time."""
    folder = folder_of(services)
    request = StartRecordingRequest(wanted.seconds, list(wanted.topics or ()))
    state = await services.cloud.nodes.recorder(robot.user, robot.id, "start", request)
    return await _begun(services, folder, robot, state.recording)


@router.get("/recordings/{recording_id}", response_model=RecordingAnswer, responses=KNOWN | problems(403, 404))
async def show_recording(recording_id: RecordingId, robot: Looked, services: Provided) -> StoredRecording:
    """Show a recording, or the ring."""
    return await run_in_threadpool(_stored, folder_of(services), robot, recording_id)


@router.post(
    "/recordings/{recording_id}/stop", response_model=RecordingAnswer, responses=KNOWN | problems(403, 404, 503)
)
async def stop_recording(recording_id: RecordingId, robot: Driven, services: Provided) -> StoredRecording:
    """Stop a recording; nothing happens to one that has ended."""
    folder = folder_of(services)
    await run_in_threadpool(folder.recording, robot.user, robot.id, recording_id)
    state = await services.cloud.nodes.recorder(robot.user, robot.id, "state", Empty())
    if state.recording == recording_id:
        await services.cloud.nodes.recorder(robot.user, robot.id, "stop", Empty())
    return await _ended(folder, robot, recording_id)


@router.delete("/recordings/{recording_id}", status_code=204, responses=KNOWN | problems(403, 404, 503))
async def delete_recording(recording_id: RecordingId, robot: Administered, services: Provided) -> None:
    """Delete a recording, or what the ring has so far."""
    folder = folder_of(services)
    if recording_id == RING:
        await run_in_threadpool(folder.remove_ring, robot.user, robot.id)
    else:
        await run_in_threadpool(folder.remove_recording, robot.user, robot.id, recording_id)


@router.get(
    "/recordings/{recording_id}/file",
    response_class=FileResponse,  # describes it: FastAPI looks for its argument status_code
    responses=KNOWN | problems(403, 404, 416, 503) | {200: {"content": {MEDIA_TYPE: {}}}},
)
async def fetch_recording(
    recording_id: RecordingId, robot: Looked, services: Provided, user: AnyCaller, minutes: Minutes = None
) -> OpenFileResponse:
    """Return a recording, or the last minutes of the ring, as a file of MCAP.

    A caller who may subscribe to some topics only gets these. What is in progress or was cut off is put together as far
    as it is written; it may be up to three seconds behind.
    """
    folder = folder_of(services)
    if recording_id == RING:
        segments = await run_in_threadpool(folder.segments, robot.user, robot.id)
        sources, finished = await run_in_threadpool(last_segments, segments, minutes), False
    else:
        stored = await run_in_threadpool(folder.recording, robot.user, robot.id, recording_id)
        sources, finished = [stored.path], stored.finished
    name = f"{robot.id}-{recording_id}.mcap"
    if finished and robot.access.is_full:
        return await run_in_threadpool(_opened, sources[0], name, recording_id)
    async with AsyncExitStack() as stack:
        whole = await stack.enter_async_context(assembled(services, user.id, robot, sources))
        return OpenFileResponse(whole, name, MEDIA_TYPE, stack.pop_all().aclose)


def _opened(path: FilePath, name: str, recording_id: str) -> OpenFileResponse:
    with disk_errors(path, but=FileNotFoundError):
        try:
            return OpenFileResponse(path.open("rb"), name, MEDIA_TYPE)
        except FileNotFoundError as error:  # removed a moment ago
            raise NotFound("recording", recording_id) from error


def _stored(folder: RecordingsFolder, robot: ReachedRobot, recording_id: str) -> StoredRecording:
    if recording_id != RING:
        return folder.recording(robot.user, robot.id, recording_id)
    segments = folder.segments(robot.user, robot.id)
    if not segments:
        raise NotFound("recording", RING)
    last = segments[-1].path
    size = sum(segment.size for segment in segments)
    return StoredRecording(RING, last, size, last.stat().st_mtime, finished=False)


async def _begun(services: Services, folder: RecordingsFolder, robot: ReachedRobot, recording: str) -> StoredRecording:
    """Return a new recording once its file exists.

    Raises
    ------
    Unavailable
        The machine does not record: why.
    """
    try:
        async with asyncio.timeout(PATIENCE):
            while True:
                try:
                    return await run_in_threadpool(folder.recording, robot.user, robot.id, recording)
                except NotFound:
                    await asyncio.sleep(LOOK)
                    await _raise_problem(services, robot)
    except TimeoutError as error:
        await services.cloud.nodes.recorder(robot.user, robot.id, "stop", Empty())
        raise Unavailable(f"the recorder of the robot's machine did not begin within {PATIENCE:g} s") from error


async def _raise_problem(services: Services, robot: ReachedRobot) -> None:
    state = await services.cloud.nodes.recorder(robot.user, robot.id, "state", Empty())
    if state.problem:
        raise Unavailable(state.problem, public=state.problem)


async def _ended(folder: RecordingsFolder, robot: ReachedRobot, recording: str) -> StoredRecording:
    """Return a recording that was stopped, once it is complete; as it is, if that takes too long."""
    until = asyncio.get_running_loop().time() + PATIENCE
    while True:
        stored = await run_in_threadpool(folder.recording, robot.user, robot.id, recording)
        if stored.finished or asyncio.get_running_loop().time() > until:
            return stored
        await asyncio.sleep(LOOK)
