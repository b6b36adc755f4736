"""Maps: published, looked at, fetched and removed."""

from fastapi import APIRouter
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, may_read, readable_head, robots_in
from endpoints.rest.map_form import OPENAPI, MapForm, PublishedMap
from endpoints.rest.schemas import MapAnswer, MapSummary
from endpoints.services import Services
from ppaas.clock import epoch
from ppaas.errors import Conflict, NotFound, NotPermitted
from ppaas.maps.files import load_map
from storage.records import MapRecord, User
from storage.versions import new_map

router = APIRouter(prefix="/maps", tags=["maps"])

_BYTES = {"X-Content-Type-Options": "nosniff"}


@router.post("", status_code=201, response_model=MapAnswer, openapi_extra=OPENAPI)
async def publish_map(form: PublishedMap, services: Provided, user: Caller) -> MapAnswer:
    """Publish a map, or its new version, from the two files of map_server."""
    return await run_in_threadpool(_publish, services, user, form)


@router.get("", response_model=list[MapSummary])
async def list_maps(services: Provided, user: Caller) -> list[MapRecord]:
    """List the maps that the caller may see, by id."""
    heads = await run_in_threadpool(services.map_store.maps)
    return [head for head in heads if may_read(user, head)]


@router.get("/{map_id}", response_model=MapAnswer)
async def show_map(map_id: str, services: Provided, user: Caller) -> MapAnswer:
    """Describe a map."""
    return await run_in_threadpool(lambda: _describe(_readable(services, user, map_id)))


@router.get("/{map_id}/yaml", response_class=Response, responses={200: {"content": {"application/yaml": {}}}})
async def fetch_yaml(map_id: str, services: Provided, user: Caller) -> Response:
    """Return the YAML file as it was published."""
    record = await run_in_threadpool(_readable, services, user, map_id)
    return Response(record.yaml, media_type="application/yaml", headers=_BYTES)


@router.get("/{map_id}/image", response_class=Response, responses={200: {"content": {"image/x-portable-graymap": {}}}})
async def fetch_image(map_id: str, services: Provided, user: Caller) -> Response:
    """Return the image file as it was published."""
    record = await run_in_threadpool(_readable, services, user, map_id)
    return Response(record.image, media_type="image/x-portable-graymap", headers=_BYTES)


@router.delete("/{map_id}", status_code=204)
async def remove_map(map_id: str, services: Provided, user: Caller) -> None:
    """Remove a map with all its versions; one that a robot stands in is kept."""
    head = await readable_head(services, user, map_id)
    if user.role != "admin" and user.id != head.owner:
        raise NotPermitted(f"only the owner of map {map_id!r} may remove it")
    if robots_in(services, map_id=map_id):
        raise Conflict(f"robots stand in map {map_id!r}: let them disconnect first")
    await run_in_threadpool(services.map_store.remove_map, map_id)


def _publish(services: Services, user: User, form: MapForm) -> MapAnswer:
    owner, readers = user.id, form.readers
    try:
        head = services.map_store.map_head(form.id)
    except NotFound:
        readers = readers or ()
    else:
        # An administrator mends another's map, and it stays the other's; anyone else is refused by the store.
        owner = head.owner if user.role == "admin" else owner
        readers = head.readers if readers is None else readers
    record = new_map(form.id, owner, form.yaml, form.image, readers=readers, created=epoch())
    described = _describe(record)
    services.map_store.put_map(record)
    return described


def _readable(services: Services, user: User, map_id: str) -> MapRecord:
    record = services.map_store.map(map_id)
    if not may_read(user, record):
        raise NotFound("map", map_id)
    return record


def _describe(record: MapRecord) -> MapAnswer:
    """Read the files, which is also what proves that they are a map."""
    info = load_map(record.yaml, record.image).info
    return MapAnswer(
        id=record.id,
        owner=record.owner,
        version=record.version,
        readers=list(record.readers),
        created=record.created,
        resolution=info.resolution,
        width=info.width,
        height=info.height,
        origin=list(info.origin),
    )
