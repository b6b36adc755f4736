"""Maps: published, looked at, changed, rolled back and removed."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Request
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Paged, Provided, may_read, readable_head, robots_in
from endpoints.rest.maps.content_check import check_contents, grid_of
from endpoints.rest.maps.schemas import MapAnswer, MapChange, MapSummary, RollBack
from endpoints.rest.maps.upload_form import OPENAPI, MapForm, received
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.services.services import Services
from ppaas.clock import epoch
from ppaas.errors import Conflict, NotFound, NotPermitted
from storage.opened_maps import OpenMap
from storage.ports import Store
from storage.records import MapRecord, Publication, User
from storage.staged_uploads import StagedUpload

router = APIRouter(prefix="/maps", tags=["maps"], route_class=StrictRoute)

IfMatch = Annotated[
    str | None,
    Header(
        description="The version that must be the present one, or nothing is done (409)",
        examples=['"' + 64 * "0" + '"'],
    ),
]


@router.post(
    "", status_code=201, response_model=MapAnswer, responses=KNOWN | BODY | problems(409, 429), openapi_extra=OPENAPI
)
async def publish_map(request: Request, services: Provided, user: Caller, if_match: IfMatch = None) -> MapAnswer:
    """Publish a map, or its new version: the two files of map_server, an octree of OctoMap, or all three."""
    services.cloud.quotas.learn(user)
    async with received(request, services.map_store) as (form, draft):
        with _changed(services, form.id):
            return await run_in_threadpool(_publish, services, user, form, draft, if_match)


@router.get("", response_model=Page[MapSummary], responses=KNOWN)
async def list_maps(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the maps that the caller may see, by id."""
    visible_to = None if user.role == "admin" else user.id
    after = paging.key(str, "")
    found = await run_in_threadpool(services.map_store.maps, visible_to, after=after, limit=paging.most)
    return paging.page([MapSummary.of(head) for head in found], lambda head: head.id)


@router.get("/{map_id}", response_model=MapAnswer, responses=KNOWN | problems(404))
async def show_map(map_id: MapId, services: Provided, user: Caller) -> MapAnswer:
    """Show a map in its present version."""
    return await run_in_threadpool(shown_map, services, user, map_id)


@router.patch("/{map_id}", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404))
async def change_map(
    map_id: MapId, change: Annotated[MapChange, Body(media_type=MERGE_PATCH)], services: Provided, user: Caller
) -> MapSummary:
    """Change who may see a map, or its description, by a JSON merge patch (RFC 7396); its files stay."""
    await _owned_head(services, user, map_id)
    said: dict[str, Any] = change.model_dump(exclude_unset=True)
    if "readers" in said:
        said["readers"] = tuple(dict.fromkeys(said["readers"] or ()))
    if "description" in said:
        said["description"] = said["description"] or ""
    with _changed(services, map_id):
        return MapSummary.of(await run_in_threadpool(services.map_store.change_map, map_id, **said))


@router.post("/{map_id}/roll_back", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404, 409))
async def roll_back_map(
    map_id: MapId, wanted: RollBack, services: Provided, user: Caller, if_match: IfMatch = None
) -> MapSummary:
    """Make a version that a map had the present one again. Its versions tell of it."""
    head = await _owned_head(services, user, map_id)
    said = Publication(map_id, user.id, epoch(), wanted.message, head.owner, if_match=_version(if_match))
    with _changed(services, map_id):
        return MapSummary.of(await run_in_threadpool(services.map_store.roll_back, wanted.version, said))


@router.delete("/{map_id}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def remove_map(map_id: MapId, services: Provided, user: Caller) -> None:
    """Remove a map with all its versions and what was planned on it; one that robots go by is kept."""
    await _owned_head(services, user, map_id)
    if robots_in(services, map_id=map_id):
        raise Conflict(f"robots go by map {map_id!r}: let them disconnect first")
    await services.plan_writer.settled()
    with _changed(services, map_id):
        await run_in_threadpool(_remove, services, map_id)


def _remove(services: Services, map_id: str) -> None:
    """Remove a map behind its paths, so that whoever is cut off can go on; and those paths that came meanwhile."""
    _forget_planning(services.store, map_id)
    services.map_store.remove_map(map_id)
    _forget_planning(services.store, map_id)


def _forget_planning(store: Store, map_id: str) -> None:
    store.remove_plans(map_id)
    store.remove_history(map_id)


@contextmanager
def _changed(services: Services, map_id: str) -> Iterator[None]:
    """Have a map looked up anew after the block, whatever came of it."""
    try:
        yield
    finally:
        services.map_cache.forget(map_id)


async def _owned_head(services: Services, user: User, map_id: str) -> MapRecord:
    head = await readable_head(services, user, map_id)
    if user.role != "admin" and user.id != head.owner:
        raise NotPermitted(f"only the owner of map {map_id!r} may do this")
    return head


def _publish(services: Services, user: User, form: MapForm, draft: StagedUpload, if_match: str | None) -> MapAnswer:
    info = check_contents(draft)
    said = Publication(
        form.id,
        user.id,
        epoch(),
        form.message,
        _owner(services, user, form.id),
        form.readers,
        form.description,
        _version(if_match),
    )
    with services.usage.new_map(services.map_store, services.cloud.quotas, user.id, form.id):
        return MapAnswer.of(services.map_store.publish(draft, said), **info)


def _owner(services: Services, user: User, map_id: str) -> str:
    """Return whose a map is to be: an administrator mends another's, and it stays the other's."""
    if user.role == "admin":
        try:
            return services.map_store.map_head(map_id).owner
        except NotFound:
            pass
    return user.id


def _version(if_match: str | None) -> str | None:
    """Return the version of an If-Match header (RFC 9110), which has it in quotes."""
    return None if if_match is None else if_match.strip().strip('"')


@contextmanager
def opened_map(
    services: Services, user: User, map_id: str, version: str | None = None, **only: Any
) -> Iterator[OpenMap]:
    """Open a map; ``NotFound`` also where it may not be seen, so that ids are not given away."""
    if not may_read(user, services.map_store.map_head(map_id)):
        raise NotFound("map", map_id)
    with services.map_store.open_map(map_id, version, **only) as opened:
        yield opened


def shown_map(services: Services, user: User, map_id: str, version: str | None = None) -> MapAnswer:
    """Return what there is to say of a map."""
    with opened_map(services, user, map_id, version) as opened:
        return MapAnswer.of(opened.record, **grid_of(opened.buffers))
