"""Maps: published, looked at, changed and removed."""

from typing import Annotated, Any

from fastapi import APIRouter, Body
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Paged, Provided, may_read, readable_head, robots_in
from endpoints.rest.map_form import OPENAPI, MapForm, PublishedMap
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import MapAnswer, MapChange, MapSummary
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.services import Services
from ppaas.clock import epoch
from ppaas.errors import Conflict, NotFound, NotPermitted
from ppaas.maps.files import load_map
from ppaas.maps.record import with_rules
from storage.records import MapRecord, User
from storage.versions import new_map

router = APIRouter(prefix="/maps", tags=["maps"], route_class=StrictRoute)


@router.post(
    "", status_code=201, response_model=MapAnswer, responses=KNOWN | BODY | problems(409), openapi_extra=OPENAPI
)
async def publish_map(form: PublishedMap, services: Provided, user: Caller) -> MapAnswer:
    """Publish a map, or its new version, from the two files of map_server."""
    try:
        return await run_in_threadpool(_publish, services, user, form)
    finally:
        services.map_heads.forget(form.id)


@router.get("", response_model=Page[MapSummary], responses=KNOWN)
async def list_maps(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the maps that the caller may see, by id."""
    visible_to = None if user.role == "admin" else user.id
    after = paging.key(str, "")
    found = await run_in_threadpool(services.map_store.maps, visible_to, after=after, limit=paging.most)
    return paging.page(found, lambda head: head.id)


@router.get("/{map_id}", response_model=MapAnswer, responses=KNOWN | problems(404))
async def show_map(map_id: MapId, services: Provided, user: Caller) -> MapAnswer:
    """Show a map in its present version."""
    return await run_in_threadpool(lambda: described(readable_map(services, user, map_id)))


@router.patch("/{map_id}", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404))
async def change_map(
    map_id: MapId, change: Annotated[MapChange, Body(media_type=MERGE_PATCH)], services: Provided, user: Caller
) -> MapRecord:
    """Change who may see a map, or its description, by a JSON merge patch (RFC 7396); its files stay."""
    await _owned_head(services, user, map_id)
    said: dict[str, Any] = change.model_dump(exclude_unset=True)
    if "readers" in said:
        said["readers"] = tuple(dict.fromkeys(said["readers"] or ()))
    if "description" in said:
        said["description"] = said["description"] or ""
    try:
        return await run_in_threadpool(services.map_store.change_map, map_id, **said)
    finally:
        services.map_heads.forget(map_id)


@router.delete("/{map_id}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def remove_map(map_id: MapId, services: Provided, user: Caller) -> None:
    """Remove a map with all its versions; one that a robot stands in is kept."""
    await _owned_head(services, user, map_id)
    if robots_in(services, map_id=map_id):
        raise Conflict(f"robots stand in map {map_id!r}: let them disconnect first")
    try:
        await run_in_threadpool(services.map_store.remove_map, map_id)
    finally:
        services.map_heads.forget(map_id)


async def _owned_head(services: Services, user: User, map_id: str) -> MapRecord:
    head = await readable_head(services, user, map_id)
    if user.role != "admin" and user.id != head.owner:
        raise NotPermitted(f"only the owner of map {map_id!r} may do this")
    return head


def _publish(services: Services, user: User, form: MapForm) -> MapAnswer:
    owner, readers, description = user.id, form.readers, form.description
    try:
        head = services.map_store.map_head(form.id)
    except NotFound:
        readers, description = readers or (), description or ""
    else:
        # An administrator mends another's map, and it stays the other's; anyone else is refused by the store.
        owner = head.owner if user.role == "admin" else owner
        readers = head.readers if readers is None else readers
        description = head.description if description is None else description
    yaml = form.yaml if form.rules is None else with_rules(form.yaml, form.rules)
    record = new_map(form.id, owner, yaml, form.image, readers=readers, created=epoch(), description=description)
    answer = described(record)
    services.map_store.put_map(record)
    return answer


def readable_map(services: Services, user: User, map_id: str, version: str | None = None) -> MapRecord:
    """Return a map with its files; ``NotFound`` also where it may not be seen, so that ids are not given away."""
    if not may_read(user, services.map_store.map_head(map_id)):
        raise NotFound("map", map_id)
    return services.map_store.map(map_id, version)


def described(record: MapRecord) -> MapAnswer:
    """Read the files, which is also what proves that they are a map."""
    info = load_map(record.yaml, record.image).info
    return MapAnswer(
        id=record.id,
        owner=record.owner,
        version=record.version,
        readers=list(record.readers),
        created=record.created,
        description=record.description,
        resolution=info.resolution,
        width=info.width,
        height=info.height,
        origin=list(info.origin),
    )
