"""Route of merges of maps: two maps of one place, made without a common start, become one."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_details, note_object
from endpoints.resources.heavy_work import callable_in_thread
from endpoints.resources.services import Services
from endpoints.resources.version_removal import follow_publication
from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.maps.map_programs import MAKE_SECONDS, run_program
from endpoints.rest.maps.maps import IfMatch, check_may_publish, invalidated, opened_map, publish_upload
from endpoints.rest.maps.schemas import MapAnswer
from endpoints.rest.maps.upload_form import MapForm
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.strict_json import StrictRoute
from ppaas.errors import Conflict
from ppaas.maps.formats.map_files import read_info
from storage.map_port import OpenMap
from storage.records import MapRecord, User
from storage.staged_uploads import StagedUpload, blocks, mapped
from storage.temporary import temporary_folder
from storage.versions import IMAGE, POSEGRAPH, YAML

if TYPE_CHECKING:
    from endpoints.rest.maps import merge_program  # noqa: F401 - the program named below
from pydantic import Field

from endpoints.rest.names import Name
from endpoints.rest.schemas import Description, RequestBody, Triple

_PROGRAM = "endpoints.rest.maps.merge_program"

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"], route_class=StrictRoute)


class MapMerge(RequestBody):
    """Map to merge with, and the map that becomes the result."""

    with_: Name = Field(alias="with", description="Map that is moved into the frame of this one")
    into: Name = Field(description="Map that is published; may be one of the two")
    message: Description = Field("", description="Reason, stored with the version; by default, the names of both maps")


class MergedMapAnswer(MapAnswer):
    """Published map, and how the maps fit."""

    motion: Triple = Field(description="Frame of the other map in that of this one: x [m], y [m], yaw [rad]")
    places: int = Field(description="Number of places that both maps have and that agree")
    support: float = Field(description="Share of the scans of the other map near those of this one that fit, 0 to 1")
    confirmed: float = Field(description="Share of the points seen by both that agree, 0 to 1")


@router.post(
    "/merge",
    status_code=201,
    response_model=MergedMapAnswer,
    responses=KNOWN | BODY | problems(403, 404, 409, 429),
)
async def merge_map(
    map_id: MapId,
    wanted: MapMerge,
    *,
    request: Request,
    services: Provided,
    user: Caller,
    if_match: IfMatch = None,
) -> MergedMapAnswer:
    """Merge the pose graphs of two maps and publish the result, in the frame of this map.

    The grid is redrawn from the scans of both; an octree is not part of the result. Maps that do not overlap
    enough, contradict each other, or fit in several ways are not merged (409).
    """
    note_object(request.scope, f"maps/{wanted.into}")
    with invalidated(services, wanted.into):
        async with services.heavy_work.turn(user.id):
            publish = callable_in_thread(partial(publish_upload, services, user, if_match=if_match))
            await run_in_threadpool(check_may_publish, services, user, wanted.into, if_match)
            merged, record = await run_in_threadpool(_merge, services, user, map_id, wanted, publish)
    await follow_publication(services, record)
    note_details(request.scope, version=merged.version, merged=[map_id, wanted.with_])
    return merged


def _merge(
    services: Services,
    user: User,
    map_id: str,
    wanted: MapMerge,
    publish: Callable[[MapForm, StagedUpload], tuple[MapAnswer, MapRecord]],
) -> tuple[MergedMapAnswer, MapRecord]:
    with temporary_folder() as folder, services.map_store.stage() as upload:
        kept, moved = folder / "first", folder / "second"
        with opened_map(services, user, map_id) as first:
            _copy_graph(first, kept)
            resolution = read_info(bytes(first.buffer(YAML)), first.buffer(IMAGE)).resolution
        with opened_map(services, user, wanted.with_) as second:
            _copy_graph(second, moved)
        found = merge_in_process(kept, moved, resolution, folder)
        for part in (YAML, IMAGE, POSEGRAPH):
            upload.add(part, blocks(mapped(folder / part)))
        message = wanted.message or f"merge of {map_id} and {wanted.with_}"
        form = MapForm(wanted.into, None, None, message)
        published, record = publish(form, upload)
        answer: dict[str, Any] = published.model_dump() | found
        return MergedMapAnswer(**answer), record


def _copy_graph(opened: OpenMap, to: Path) -> None:
    if POSEGRAPH not in opened.record.present.files:
        raise Conflict(
            f"map {opened.record.id!r} has no pose graph, and cannot be merged: publish one that a robot or "
            "'ppaas slam' made, with its .posegraph"
        )
    with to.open("wb") as file:
        file.writelines(blocks(opened.buffer(POSEGRAPH)))


def merge_in_process(first: Path, second: Path, resolution: float, folder: Path) -> dict[str, Any]:
    """Merge two pose graphs in a separate process; blocks.

    Parameters
    ----------
    first, second : Path
        Pose graphs.
    resolution : float
        Edge of a cell of the grid [m].
    folder : Path
        Folder in which the files ``yaml``, ``image`` and ``posegraph`` are written.

    Returns
    -------
    dict
        ``motion``, ``places``, ``support``, ``confirmed``.

    Raises
    ------
    PPaaSError
        The error of the merge; ``QuotaExceeded`` if it ran out of memory, ``Unavailable`` if out of time.
    """
    arguments = [str(first), str(second), repr(resolution), str(folder)]
    found: dict[str, Any] = run_program(_PROGRAM, arguments, "the maps could not be merged", MAKE_SECONDS)
    return found
