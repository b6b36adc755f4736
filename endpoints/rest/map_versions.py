"""Versions of maps, and the files of each as they were published."""

from typing import Any

from fastapi import APIRouter
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Paged, Provided, readable_head
from endpoints.rest.maps import described, readable_map
from endpoints.rest.names import MapId, VersionId
from endpoints.rest.openapi import KNOWN, Responses, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import MapAnswer, MapVersionAnswer
from endpoints.services import Services
from ppaas.maps.image import media_type
from storage.records import MapVersionRecord, User

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"])


def _files(content: dict[str, Any]) -> Responses:
    return {200: {"description": "The file, byte for byte", "content": content}} | KNOWN | problems(404)


YAML = "application/yaml"
_BYTES = {"schema": {"type": "string", "format": "binary"}}
_YAML_FILE = _files({YAML: {}})
_IMAGE_FILE = _files({"image/x-portable-graymap": _BYTES, "image/png": _BYTES})


@router.get("/versions", response_model=Page[MapVersionAnswer], responses=KNOWN | problems(404))
async def list_versions(map_id: MapId, services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the versions that a map ever had, newest first."""
    head = await readable_head(services, user, map_id)
    before = paging.key(MapVersionRecord, None)
    found = await run_in_threadpool(services.map_store.versions, map_id, before=before, limit=paging.most)
    answers = [
        MapVersionAnswer(version=one.version, created=one.created, present=one.version == head.version) for one in found
    ]
    return paging.page(answers, lambda one: MapVersionRecord(one.created, one.version))


@router.get("/versions/{version}", response_model=MapAnswer, responses=KNOWN | problems(404))
async def show_version(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> MapAnswer:
    """Show a map as it was in one of its versions."""
    return await run_in_threadpool(lambda: described(readable_map(services, user, map_id, version)))


@router.get("/yaml", response_class=Response, responses=_YAML_FILE)
async def fetch_yaml(map_id: MapId, services: Provided, user: Caller) -> Response:
    """Return the YAML file of the present version."""
    return await run_in_threadpool(_yaml, services, user, map_id)


@router.get("/image", response_class=Response, responses=_IMAGE_FILE)
async def fetch_image(map_id: MapId, services: Provided, user: Caller) -> Response:
    """Return the image of the present version."""
    return await run_in_threadpool(_image, services, user, map_id)


@router.get("/versions/{version}/yaml", response_class=Response, responses=_YAML_FILE)
async def fetch_version_yaml(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the YAML file of a version."""
    return await run_in_threadpool(_yaml, services, user, map_id, version)


@router.get("/versions/{version}/image", response_class=Response, responses=_IMAGE_FILE)
async def fetch_version_image(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the image of a version."""
    return await run_in_threadpool(_image, services, user, map_id, version)


def _yaml(services: Services, user: User, map_id: str, version: str | None = None) -> Response:
    return _file(readable_map(services, user, map_id, version).yaml, YAML)


def _image(services: Services, user: User, map_id: str, version: str | None = None) -> Response:
    image = readable_map(services, user, map_id, version).image
    return _file(image, media_type(image))


def _file(content: bytes, kind: str) -> Response:
    return Response(content, media_type=kind, headers={"X-Content-Type-Options": "nosniff"})
