"""Routes of the map that a robot makes: its size, its pose graph, and its publication."""

import asyncio
import contextlib
import json
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fastapi import APIRouter, Request, Response
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_details
from endpoints.resources.heavy_work import callable_in_thread
from endpoints.resources.news import RobotFacts
from endpoints.resources.publications import ProgressFile, RunningPublication, Stage
from endpoints.resources.robot_files import whole_file
from endpoints.resources.services import Services
from endpoints.resources.version_removal import follow_publication
from endpoints.rest.dependencies import Administered, Caller, Looked, Provided
from endpoints.rest.maps.map_programs import MAKE_SECONDS, run_program
from endpoints.rest.maps.maps import check_may_publish, invalidated, publish_upload
from endpoints.rest.maps.schemas import MapAnswer
from endpoints.rest.maps.upload_form import MapForm
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.schemas import MAX_DESCRIPTION, RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.shared_robots import ReachedRobot
from ppaas.errors import Conflict, Unavailable
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.slam_toolbox import GetPoseGraphResponse
from storage.records import MapRecord, User
from storage.staged_uploads import StagedUpload, blocks, mapped
from storage.store_errors import disk_errors
from storage.temporary import temporary_folder
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML

if TYPE_CHECKING:
    from endpoints.rest.maps import draw_posegraph  # noqa: F401 - the program named below

Motion = dict[str, list[float]]
"""Motion of key frames: ``before`` and ``after``, see `draw_posegraph.draw`."""

OCTOMAP_TIMEOUT = 60.0
"""Time within which a robot has to send its octomap again, moved with the key frames [s]."""

_DRAWING = "endpoints.rest.maps.draw_posegraph"

router = APIRouter(prefix="/robots/{robot_id}/map", tags=["robots"], route_class=StrictRoute)


class PublishingAnswer(ResponseBody):
    """Progress of the publication of a map."""

    stage: Stage = Field(description="What is done now, in the order of this list")
    part: float = Field(description="Part of the stage that is done, from 0 to 1; 0 where it is not known")


class RobotMapAnswer(ResponseBody):
    """Size of the map that a robot makes."""

    key_frames: int = Field(description="Number of scans that the map consists of")
    edges: int = Field(description="Number of measured relative poses between them")
    closures: int = Field(description="Number of those that close loops")
    joined_with: list[str] = Field(description="Robots whose maps are one with this one; `USER/ROBOT` of other users")
    refused: str | None = Field(
        description="Why the map could not be joined with other robots' maps at the last attempt; null if it could"
    )
    tried: float | None = Field(description="Time of that attempt [s since the epoch]; null if there was none")
    publishing: PublishingAnswer | None = Field(description="Publication in progress; null if there is none")


class PublishRequest(RequestBody):
    """Map to publish."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"publish": "office-2"}]})

    publish: Name = Field(description="Id of the map; a new version of it if it exists")
    refine: bool = Field(
        default=True, description="Whether missing loops are closed and all scans aligned with each other first"
    )
    message: str = Field(default="", max_length=MAX_DESCRIPTION, description="Shown in the list of versions")


@router.get("", response_model=RobotMapAnswer, responses=KNOWN | problems(403, 404, 503))
async def show_robot_map(robot: Looked, services: Provided) -> RobotMapAnswer:
    """Show the size of the map that a connected robot makes, and the robots with which it makes it."""
    numbers = await services.cloud.nodes.map(robot.user, robot.id, -1)
    facts = RobotFacts(services)
    sharing = await facts.sharing(robot.user, robot.id)
    progress = await facts.progress(robot.user, robot.id)
    return RobotMapAnswer(
        key_frames=numbers.key_frames,
        edges=numbers.edges,
        closures=numbers.closures,
        joined_with=list(sharing.joined_with),
        refused=sharing.refused or None,
        tried=sharing.tried,
        publishing=None if progress is None else PublishingAnswer(stage=progress.stage, part=progress.part),
    )


@router.get(
    "/posegraph",
    response_class=Response,
    responses=KNOWN | problems(403, 404, 503) | {200: {"content": {"application/octet-stream": {}}}},
)
async def fetch_robot_posegraph(robot: Looked, services: Provided) -> Response:
    """Return the pose graph of the map that a connected robot makes."""
    file, _ = await services.posegraphs.fetch(services.cloud.nodes, robot.user, robot.id)
    return Response(file, media_type="application/octet-stream", headers={"X-Content-Type-Options": "nosniff"})


@router.post("", status_code=201, response_model=MapAnswer, responses=KNOWN | BODY | problems(403, 404, 409, 429, 503))
async def publish_robot_map(
    robot: Administered, wanted: PublishRequest, request: Request, services: Provided, user: Caller
) -> MapAnswer:
    """Publish the map that a connected robot makes, with its pose graph, as a version; the robot may go on mapping.

    If the robot makes a 3D map too, the version has it as its octomap. Meanwhile `GET` shows how far it is.
    """
    await run_in_threadpool(check_may_publish, services, user, wanted.publish)
    with services.publications.begin(robot.user, robot.id) as publication:
        published, record = await _publish(services, user, robot, wanted, publication)
    await follow_publication(services, record)
    note_details(request.scope, map=wanted.publish, version=published.version)
    return published


async def _publish(
    services: Services, user: User, robot: ReachedRobot, wanted: PublishRequest, publication: RunningPublication
) -> tuple[MapAnswer, MapRecord]:
    file, numbers = await services.posegraphs.fetch(services.cloud.nodes, robot.user, robot.id)
    if not file:
        raise Conflict(f"robot {robot.id!r} has mapped nothing yet: publish its map once it sent scans and odometry")
    octomap = await _octomap(services, robot)
    publication.stage = Stage.WAITING
    with invalidated(services, wanted.publish):
        async with services.heavy_work.turn(user.id):
            loop = asyncio.get_running_loop()

            def moved(motion: Motion) -> bytes:
                fetched = _moved_octomap(services, robot, octomap, motion)
                return asyncio.run_coroutine_threadsafe(fetched, loop).result(2.0 * OCTOMAP_TIMEOUT)

            store = callable_in_thread(partial(publish_upload, services, user, if_match=None))
            work = _Drawing(services, wanted, numbers, publication, moved, store)
            return await run_in_threadpool(work.publish, file)


async def _octomap(services: Services, robot: ReachedRobot, motion: Motion | None = None) -> bytes:
    """Return the octomap of a robot, moved with its key frames; empty if it makes none."""

    def page(offset: int) -> Awaitable[GetOctomapFileResponse]:
        request = GetOctomapFileRequest(offset, **(motion or {})) if offset == 0 else GetOctomapFileRequest(offset)
        return services.cloud.nodes.octomap(robot.user, robot.id, request)

    return await whole_file(await page(0), page, robot.id)


async def _moved_octomap(services: Services, robot: ReachedRobot, octomap: bytes, motion: Motion) -> bytes:
    """Return the octomap of a robot, moved with its key frames; the one of before if the robot does not send it."""
    if not (octomap and motion["before"]):
        return octomap
    with contextlib.suppress(Unavailable, TimeoutError):
        async with asyncio.timeout(OCTOMAP_TIMEOUT):
            return await _octomap(services, robot, motion) or octomap
    return octomap


class _Drawing(NamedTuple):
    """Work that draws a map and publishes it; blocks."""

    services: Services
    wanted: PublishRequest
    numbers: GetPoseGraphResponse
    publication: RunningPublication
    octomap: Callable[[Motion], bytes]
    store: Callable[[MapForm, StagedUpload], tuple[MapAnswer, MapRecord]]

    def publish(self, posegraph: bytes) -> tuple[MapAnswer, MapRecord]:
        """Draw the grid of a pose graph in a separate process, and publish both, with the octomap if there is one."""
        services, wanted = self.services, self.wanted
        with temporary_folder() as folder, services.map_store.stage() as upload:
            with disk_errors(folder):
                (folder / POSEGRAPH).write_bytes(posegraph)
            motion = self._draw(folder)
            octomap = self.octomap(motion)
            with disk_errors(folder):
                (folder / OCTOMAP).write_bytes(octomap)
            for part in (YAML, IMAGE, POSEGRAPH, *([OCTOMAP] if octomap else [])):
                upload.add(part, blocks(mapped(folder / part)))
            form = MapForm(wanted.publish, None, None, wanted.message)
            return self.store(form, upload)

    def _draw(self, folder: Path) -> Motion:
        numbers, publication = self.numbers, self.publication
        settings = {
            "refine": self.wanted.refine, "do_loop_closing": numbers.do_loop_closing, "resolution": numbers.resolution,
            "min_pass_through": numbers.min_pass_through, "occupancy_threshold": numbers.occupancy_threshold,
        }  # fmt: skip
        publication.file = ProgressFile(folder)
        try:
            arguments = [str(folder), json.dumps(settings)]
            motion: Motion = run_program(_DRAWING, arguments, "the map of the robot could not be drawn", MAKE_SECONDS)
            return motion
        finally:
            publication.stage, publication.file = Stage.STORING, None
