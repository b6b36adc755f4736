"""Routes of map versions: their list, their differences, and their files as published."""

from contextlib import ExitStack
from typing import Annotated, Any

from fastapi import APIRouter, Query
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response, StreamingResponse

from endpoints.resources.services import Services
from endpoints.resources.version_removal import remove_version
from endpoints.rest.dependencies import AnyCaller, Caller, Paged, Provided, owned_head, readable_head
from endpoints.rest.maps.maps import opened_map, shown_map
from endpoints.rest.maps.schemas import CellRectangle, MapAnswer, MapDifference, MapVersionAnswer, PartFate
from endpoints.rest.names import MapId, Version, VersionId
from endpoints.rest.openapi import KNOWN, Responses, problems
from endpoints.rest.paging import Page
from ppaas.maps.formats.difference import difference
from ppaas.maps.formats.image import FORMATS, media_type
from ppaas.maps.formats.map_files import open_grid
from storage.map_port import OpenMap
from storage.records import MapVersionRecord, User
from storage.staged_uploads import blocks
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML, ZONES

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"])


def _files(content: dict[str, Any]) -> Responses:
    return {200: {"description": "The file, byte for byte", "content": content}} | KNOWN | problems(404)


_BLOCK = 1 << 20
"""Bytes read per call of a thread; a call costs as much as sending about 10 kB."""

YAML_TYPE = "application/yaml"
BINARY_TYPE = "application/octet-stream"
_BYTES = {"schema": {"type": "string", "format": "binary"}}
_YAML_FILE = _files({YAML_TYPE: {}})
_IMAGE_FILE = _files({one.media_type: _BYTES for one in FORMATS})
_BINARY_FILE = _files({BINARY_TYPE: _BYTES})


@router.get("/versions", response_model=Page[MapVersionAnswer], responses=KNOWN | problems(404))
async def list_versions(map_id: MapId, services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the versions of a map, newest first, with author, time and message."""
    head = await readable_head(services, user, map_id)
    before = paging.key(int, None)
    found = await run_in_threadpool(services.map_store.versions, map_id, before=before, limit=paging.fetch_limit)
    return paging.page([_version(one, head.present) for one in found], lambda one: one.number)


@router.get("/versions/{version}", response_model=MapAnswer, responses=KNOWN | problems(404))
async def show_version(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> MapAnswer:
    """Show one version of a map."""
    return await run_in_threadpool(shown_map, services, user, map_id, version)


@router.delete("/versions/{version}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def delete_version(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> None:
    """Remove a version of a map and its files; refused (409) if it is the current one, or while robots use it.

    Paths that are stored for this version stay.
    """
    head = await owned_head(services, user, map_id)
    await remove_version(services, head.owner, map_id, version)


@router.get("/difference", response_model=MapDifference, responses=KNOWN | problems(404))
async def compare_versions(
    map_id: MapId,
    services: Provided,
    user: Caller,
    old: Annotated[Version, Query(description="SHA-256 of the files of a version")],
    new: Annotated[
        Version | None, Query(description="SHA-256 of the files of another version; default: the current version")
    ] = None,
) -> MapDifference:
    """Return the differences between two versions of a map."""
    async with services.heavy_work.turn(user.id):
        return await run_in_threadpool(_difference, services, user, map_id, old, new)


@router.get("/yaml", response_class=Response, responses=_YAML_FILE)
async def fetch_yaml(map_id: MapId, services: Provided, user: AnyCaller) -> Response:
    """Return the YAML file of the current version."""
    return await run_in_threadpool(_file, services, user, map_id, YAML)


@router.get("/image", response_class=Response, responses=_IMAGE_FILE)
async def fetch_image(map_id: MapId, services: Provided, user: AnyCaller) -> Response:
    """Return the image of the current version."""
    return await run_in_threadpool(_file, services, user, map_id, IMAGE)


@router.get("/octomap", response_class=Response, responses=_BINARY_FILE)
async def fetch_octomap(map_id: MapId, services: Provided, user: Caller) -> Response:
    """Return the octree of the current version."""
    return await run_in_threadpool(_file, services, user, map_id, OCTOMAP)


@router.get("/posegraph", response_class=Response, responses=_BINARY_FILE)
async def fetch_posegraph(map_id: MapId, services: Provided, user: Caller) -> Response:
    """Return the pose graph of the current version: the key frames that its grid was made of."""
    return await run_in_threadpool(_file, services, user, map_id, POSEGRAPH)


@router.get("/versions/{version}/yaml", response_class=Response, responses=_YAML_FILE)
async def fetch_version_yaml(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the YAML file of a version."""
    return await run_in_threadpool(_file, services, user, map_id, YAML, version)


@router.get("/versions/{version}/image", response_class=Response, responses=_IMAGE_FILE)
async def fetch_version_image(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the image of a version."""
    return await run_in_threadpool(_file, services, user, map_id, IMAGE, version)


@router.get("/versions/{version}/octomap", response_class=Response, responses=_BINARY_FILE)
async def fetch_version_octomap(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the octree of a version."""
    return await run_in_threadpool(_file, services, user, map_id, OCTOMAP, version)


@router.get("/versions/{version}/posegraph", response_class=Response, responses=_BINARY_FILE)
async def fetch_version_posegraph(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the pose graph of a version."""
    return await run_in_threadpool(_file, services, user, map_id, POSEGRAPH, version)


def _version(one: MapVersionRecord, present: MapVersionRecord) -> MapVersionAnswer:
    return MapVersionAnswer(
        number=one.number,
        version=one.version,
        created=one.created,
        author=one.author,
        message=one.message,
        restored=one.restored,
        parts=sorted(one.files),
        present=one.number == present.number,
    )


def _file(services: Services, user: User, map_id: str, part: str, version: str | None = None) -> Response:
    """Return a file as a stream; its memory mapping stays open until the stream ends."""
    with opened_map(services, user, map_id, version, only=(part,)) as opened:
        data = opened.buffer(part)
    kinds = {YAML: YAML_TYPE, OCTOMAP: BINARY_TYPE, POSEGRAPH: BINARY_TYPE}
    kind = kinds[part] if part in kinds else media_type(data)
    headers = {"X-Content-Type-Options": "nosniff", "Content-Length": str(len(data))}
    return StreamingResponse(blocks(data, _BLOCK), media_type=kind, headers=headers)


def _difference(services: Services, user: User, map_id: str, old: str, new: str | None) -> MapDifference:
    with ExitStack() as stack:
        before, after = (stack.enter_context(opened_map(services, user, map_id, one)) for one in (old, new))
        grids = [open_grid(*one.grid()) for one in (before, after)]
        found = difference(*grids)
        rectangle = None if found.rectangle is None else CellRectangle(**found.rectangle._asdict())
        return MapDifference(
            old=before.record.version,
            new=after.record.version,
            changed=found.changed,
            rectangle=rectangle,
            corners=None if found.corners is None else found.corners.tolist(),
            aligned=found.aligned,
            octomap=_fate(OCTOMAP, before, after),
            zones=_fate(ZONES, before, after),
        )


def _fate(part: str, before: OpenMap, after: OpenMap) -> PartFate:
    old, new = before.record.present.files.get(part), after.record.present.files.get(part)
    if old == new:
        return "none" if old is None else "same"
    return "added" if old is None else "removed" if new is None else "changed"
