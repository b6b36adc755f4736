"""Routes of maps: publish, list, show, change, roll back and remove."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.audit.requests import note_details, note_object
from endpoints.resources.services import Services
from endpoints.resources.version_removal import follow_publication
from endpoints.rest.dependencies import AnyCaller, Caller, Paged, Provided, is_in_use, owned_head
from endpoints.rest.maps.content_check import check_contents, grid_of
from endpoints.rest.maps.schemas import MapAnswer, MapChange, MapReviewAnswer, MapSummary, PublishedMap, RollBack
from endpoints.rest.maps.upload_form import OPENAPI, MapForm, read_form
from endpoints.rest.maps.version_proposals import propose
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.sharing.named_users import check_readers
from endpoints.sharing.shared_robots import may_read
from ppaas.clock import epoch
from ppaas.errors import Conflict, NotFound
from ppaas.people.names import coordinator_checkpoint
from ppaas.traffic.taking_part import traffic_checkpoint
from storage.map_port import OpenMap
from storage.ports import Store
from storage.records import MapRecord, Publication, User
from storage.staged_uploads import StagedUpload
from storage.versions import ONLY_ZONES, check_may_follow

router = APIRouter(prefix="/maps", tags=["maps"], route_class=StrictRoute)

IfMatch = Annotated[
    str | None,
    Header(
        description="Version that must be the current one; otherwise nothing is changed (409)",
        examples=['"' + 64 * "0" + '"'],
    ),
]


WAITS: Responses = {202: {"model": MapReviewAnswer, "description": "With `review`: the version waits"}}


@router.post(
    "",
    status_code=201,
    response_model=PublishedMap,
    responses=KNOWN | BODY | problems(403, 404, 409, 429) | WAITS,
    openapi_extra=OPENAPI,
)
async def publish_map(request: Request, services: Provided, user: Caller, if_match: IfMatch = None) -> Any:
    """Publish a map or a new version of it: the two files of map_server, perhaps with a pose graph; an octree; or all.

    A version without zones has the zones of the one before.
    With `review`, the new version waits until the owner of the map approves or refuses it (202).
    """
    async with read_form(request, services.map_store) as (form, upload):
        note_object(request.scope, f"maps/{form.id}")
        if form.review:
            publication = Publication(form.id, user.id, epoch(), form.message, if_match=matched_version(if_match))
            upload.keeps = ONLY_ZONES if form.keeps_zones else frozenset()
            return await _propose(request, services, user, upload, publication)
        with invalidated(services, form.id):
            async with services.heavy_work.turn(user.id):
                published, record = await publish_upload(services, user, form, upload, if_match)
    await follow_publication(services, record)
    note_details(request.scope, version=published.version, readers=published.readers)
    return published


async def _propose(
    request: Request, services: Services, user: User, upload: StagedUpload, publication: Publication
) -> Response:
    async with services.heavy_work.turn(user.id):
        await run_in_threadpool(check_contents, upload)
        review = await propose(services, user, upload, publication)
    note_details(request.scope, review=review.number, version=review.version, base=review.base)
    answer = MapReviewAnswer.of(review, review.base)
    return Response(answer.model_dump_json(), 202, media_type="application/json")


@router.get("", response_model=Page[MapSummary], responses=KNOWN)
async def list_maps(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the maps that the caller may read, by id."""
    visible_to = None if user.role == "admin" else user.id
    after = paging.key(str, "")
    found = await run_in_threadpool(services.map_store.maps, visible_to, after=after, limit=paging.fetch_limit)
    return paging.page([MapSummary.of(head) for head in found], lambda head: head.id)


@router.get("/{map_id}", response_model=MapAnswer, responses=KNOWN | problems(404))
async def show_map(map_id: MapId, services: Provided, user: AnyCaller) -> MapAnswer:
    """Show the current version of a map."""
    return await run_in_threadpool(shown_map, services, user, map_id)


@router.patch("/{map_id}", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404))
async def change_map(
    map_id: MapId, change: Annotated[MapChange, Body(media_type=MERGE_PATCH)], services: Provided, user: Caller
) -> MapSummary:
    """Change readers, description or traffic of a map by a JSON merge patch (RFC 7396); its files stay unchanged.

    Robots that are connected begin or end to take part in the traffic when they reconnect.
    """
    await owned_head(services, user, map_id)
    fields: dict[str, Any] = change.model_dump(exclude_unset=True)
    if "readers" in fields:
        readers = fields["readers"] = tuple(dict.fromkeys(fields["readers"] or ()))
        await run_in_threadpool(check_readers, services.store, services.map_store, map_id, readers)
    if "description" in fields:
        fields["description"] = fields["description"] or ""
    if "traffic" in fields:
        fields["traffic"] = bool(fields["traffic"])
    with invalidated(services, map_id):
        return MapSummary.of(await run_in_threadpool(services.map_store.change_map, map_id, **fields))


@router.post("/{map_id}/roll_back", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404, 409))
async def roll_back_map(
    map_id: MapId, wanted: RollBack, services: Provided, user: Caller, if_match: IfMatch = None
) -> MapSummary:
    """Make an earlier version of a map the current one again; this adds an entry to its versions."""
    head = await owned_head(services, user, map_id)
    publication = Publication(map_id, user.id, epoch(), wanted.message, head.owner, if_match=matched_version(if_match))
    with invalidated(services, map_id):
        record = await run_in_threadpool(services.map_store.roll_back, wanted.version, publication)
    await services.cloud.maps.changed(record)
    return MapSummary.of(record)


@router.delete("/{map_id}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def remove_map(map_id: MapId, services: Provided, user: Caller) -> None:
    """Remove a map with its versions, stored paths, tasks and counts of people; refused (409) while robots use it."""
    head = await owned_head(services, user, map_id)
    if await is_in_use(services, map_id):
        raise Conflict(
            f"map {map_id!r} is in use by robots: disconnect them first; the container of one that left uses it until "
            "it ends"
        )
    await services.plan_writer.settled()
    await services.plan_writer.forget(lambda record: record.map == map_id)
    await services.cloud.maps.end_groups(map_id)
    with invalidated(services, map_id):
        # What belongs to the map, the map, then what was added meanwhile: it can be repeated if it is interrupted.
        await run_in_threadpool(_forget_map, services.store, map_id)
        await services.usage.in_turn(head.owner, _remove, services, head.owner, map_id)
        await run_in_threadpool(_forget_map, services.store, map_id)


def _remove(services: Services, owner: str, map_id: str) -> None:
    try:
        services.map_store.remove_map(map_id)
    finally:
        services.usage.stored.forget_map(owner, map_id)


def _forget_map(store: Store, map_id: str) -> None:
    store.remove_plans(map_id)
    store.remove_history(map_id)
    store.remove_people(map_id)
    store.remove_tasks(map_id)
    for user in store.users():  # any of them may have had robots on it
        for checkpoint in (coordinator_checkpoint(map_id), traffic_checkpoint(map_id)):
            store.remove_clone(user.id, checkpoint)


@contextmanager
def invalidated(services: Services, map_id: str) -> Iterator[None]:
    """Drop a map from the cache after the block, also if the block raises."""
    try:
        yield
    finally:
        services.map_cache.forget(map_id)


async def publish_upload(
    services: Services, user: User, form: MapForm, upload: StagedUpload, if_match: str | None
) -> tuple[PublishedMap, MapRecord]:
    """Check an upload and make it the current version of a map. Raises as `MapStore.publish` does.

    The version has the zones of the one before, unless the form says otherwise.
    """
    upload.keeps = ONLY_ZONES if form.keeps_zones else frozenset()
    await run_in_threadpool(check_readers, services.store, services.map_store, form.id, form.readers or ())
    info = await run_in_threadpool(check_contents, upload)
    owner = await run_in_threadpool(_owner, services, user, form.id)
    publication = Publication(
        form.id,
        user.id,
        epoch(),
        form.message,
        owner,
        form.readers,
        form.description,
        matched_version(if_match),
    )
    record = await services.usage.in_turn(owner, _publish, services, upload, owner, publication)
    warnings = [*form.warnings, *info.pop("warnings", ())]
    return PublishedMap.of(record, warnings=warnings, **info), record


def _publish(services: Services, upload: StagedUpload, owner: str, publication: Publication) -> MapRecord:
    with services.usage.new_map(services, owner, publication.map, upload):
        return services.map_store.publish(upload, publication)


def _owner(services: Services, user: User, map_id: str) -> str:
    """Return the owner of a map to publish; if an administrator publishes a user's map, the user stays its owner."""
    if user.role == "admin":
        try:
            return services.map_store.map_head(map_id).owner
        except NotFound:
            pass
    return user.id


def check_may_publish(services: Services, user: User, map_id: str, if_match: str | None = None) -> None:
    """Raise ``Conflict``, before work whose result is published, if `publish_upload` would; blocks."""
    try:
        head = services.map_store.map_head(map_id)
    except NotFound:
        head = None
    owner = head.owner if head is not None and user.role == "admin" else user.id
    check_may_follow(head, Publication(map_id, user.id, epoch(), "", owner, if_match=matched_version(if_match)))


def matched_version(if_match: str | None) -> str | None:
    """Return the version of an If-Match header (RFC 9110), which has it in quotes."""
    return None if if_match is None else if_match.strip().strip('"')


@contextmanager
def opened_map(
    services: Services, user: User, map_id: str, version: str | None = None, **only: Any
) -> Iterator[OpenMap]:
    """Open a map; ``NotFound`` also if the user may not read it, so that ids are not revealed."""
    if not may_read(services.store, user, services.map_store.map_head(map_id)):
        raise NotFound("map", map_id)
    with services.map_store.open_map(map_id, version, **only) as opened:
        yield opened


def shown_map(services: Services, user: User, map_id: str, version: str | None = None) -> MapAnswer:
    """Return the description of one version of a map, by default the current one."""
    with opened_map(services, user, map_id, version) as opened:
        return MapAnswer.of(opened.record, **grid_of(opened.buffers))
