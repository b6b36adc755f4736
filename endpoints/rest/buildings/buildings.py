"""Routes of buildings: put, list, show, check and remove them, name their readers, and show their layouts."""

from itertools import islice
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, HTTPException, Query, Request, Response
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_details
from endpoints.resources.services import Services
from endpoints.rest.buildings.access import layout_for, owned_building, readable_building, readable_buildings
from endpoints.rest.buildings.schemas import (
    BuildingAnswer,
    BuildingChange,
    BuildingSummary,
    BuildingVersionAnswer,
    CheckedBuilding,
    LayoutAnswer,
    PutBuildingAnswer,
)
from endpoints.rest.dependencies import Caller, Paged, Provided
from endpoints.rest.maps.maps import matched_version
from endpoints.rest.names import BuildingAddress
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import Description
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute, is_format, media_type_of
from endpoints.sharing.named_users import EVERYBODY, check_users
from endpoints.sharing.shared_robots import reads_itself
from engine.rights.globs import split_address
from ppaas.buildings.building import Building, building_of
from ppaas.clock import epoch
from ppaas.errors import Conflict, InvalidBuilding, NotFound, QuotaExceeded
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.records import User

router = APIRouter(prefix="/buildings", tags=["buildings"], route_class=StrictRoute)

MOST_BUILDINGS = 100
"""Limit of the buildings of a user."""

IfMatch = Annotated[
    str | None,
    Header(description="Version that must be the current one; otherwise nothing is changed (409)", examples=['"3"']),
]
Reason = Annotated[Description, Query(description="Reason of the change, shown in the list of versions")]

_SCHEMA = {
    "type": "object",
    "description": "Building: its `floors`, and settings of `lifts`, `doors` and `ways`",
    "required": ["floors"],
    "properties": {name: {"type": "array"} for name in ("floors", "lifts", "doors", "ways")},
    "example": {
        "floors": [{"name": "L1", "map": "hotel-1"}, {"name": "L2", "map": "hotel-2", "elevation": 4.0}],
        "lifts": [{"lift": "north", "wait": 30.0}],
    },
}
_BODY = {"requestBody": {"required": True, "content": {"application/json": {"schema": _SCHEMA}}}}
_NEW: Responses = {201: {"model": PutBuildingAnswer, "description": "The building is new"}}


@router.get("", response_model=Page[BuildingSummary], responses=KNOWN)
async def list_buildings(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the buildings that the caller may read, by owner and id."""
    last = paging.key(tuple[str, str], ("", ""))

    def found() -> list[BuildingRecord]:
        return list(islice(readable_buildings(services.store, user, last), paging.fetch_limit))

    shown = [BuildingSummary.summary(record) for record in await run_in_threadpool(found)]
    return paging.page(shown, lambda one: (one.owner, one.id))


@router.get("/{building_id}", response_model=BuildingAnswer, responses=KNOWN | problems(404))
async def show_building(
    building_id: BuildingAddress,
    response: Response,
    services: Provided,
    user: Caller,
    version: Annotated[int | None, Query(ge=1, le=2**53, description="Version; the current one by default")] = None,
) -> BuildingAnswer:
    """Show a building. The header `ETag` is its version."""
    record = await run_in_threadpool(readable_building, services.store, user, building_id)
    shown = record.present if version is None else record.version(version)
    response.headers["ETag"] = f'"{shown.number}"'
    return BuildingAnswer.whole(record, shown)


@router.get("/{building_id}/versions", response_model=list[BuildingVersionAnswer], responses=KNOWN | problems(404))
async def list_building_versions(
    building_id: BuildingAddress, services: Provided, user: Caller
) -> list[BuildingVersionAnswer]:
    """List the versions of a building that are kept, newest first."""
    record = await run_in_threadpool(readable_building, services.store, user, building_id)
    return [BuildingVersionAnswer.of(record, version) for version in (record.present, *record.former)]


@router.put(
    "/{building_id}",
    response_model=PutBuildingAnswer,
    responses={**_NEW, **KNOWN, **BODY, **problems(403, 404, 409, 429)},
    openapi_extra=_BODY,
)
async def put_building(
    building_id: BuildingAddress,
    request: Request,
    response: Response,
    *,
    services: Provided,
    user: Caller,
    if_match: IfMatch = None,
    message: Reason = "",
) -> PutBuildingAnswer:
    """Put a building, or a new version of it; a building that is equal to the current version adds none.

    All its maps must exist, and be readable by its owner and by the caller. What may be wrong is in `warnings`.
    """
    building = await _read(request)
    owner, name = split_address(building_id, user.id)
    before = await run_in_threadpool(_replaced, services, user, building_id, matched_version(if_match))
    await run_in_threadpool(_check_maps, services, user, owner, building, before)
    made = BuildingVersion(number=1, building=building, author=user.id, created=epoch(), message=message)
    if before is None:
        record = BuildingRecord(user=owner, id=name, present=made)
    else:
        record = before if before.building == building else before.followed_by(made)
    if record is not before:
        await services.usage.in_turn(owner, _put, services, record, before)
    response.status_code = 201 if before is None else 200
    response.headers["ETag"] = f'"{record.present.number}"'
    note_details(request.scope, version=record.present.number, floors=len(building.floors))
    layout = await run_in_threadpool(layout_for, services, user, building)
    return PutBuildingAnswer.whole(record, warnings=list(layout.warnings))


@router.post(
    "/{building_id}/check",
    response_model=CheckedBuilding,
    responses=KNOWN | BODY | problems(403, 404),
    openapi_extra=_BODY,
)
async def check_building(
    building_id: BuildingAddress, request: Request, services: Provided, user: Caller
) -> CheckedBuilding:
    """Check a building as if it were put, by the zones that its maps have now; nothing is changed."""
    building = await _read(request)
    owner, _ = split_address(building_id, user.id)
    before = await run_in_threadpool(_replaced, services, user, building_id, None)
    await run_in_threadpool(_check_maps, services, user, owner, building, before)
    return CheckedBuilding.of(await run_in_threadpool(layout_for, services, user, building))


@router.get("/{building_id}/layout", response_model=LayoutAnswer, responses=KNOWN | problems(404))
async def show_building_layout(building_id: BuildingAddress, services: Provided, user: Caller) -> LayoutAnswer:
    """Show where lifts, doors, ways and docks are on the floors, by the current zones of the maps.

    Floors whose map the caller may not read are without places, and in `warnings`.
    """
    record = await run_in_threadpool(readable_building, services.store, user, building_id)
    layout = await run_in_threadpool(layout_for, services, user, record.building)
    return LayoutAnswer.of(record.present.number, layout)


@router.patch("/{building_id}", response_model=BuildingSummary, responses=KNOWN | BODY | problems(403, 404, 409))
async def change_building(
    building_id: BuildingAddress,
    change: Annotated[BuildingChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: Caller,
) -> BuildingSummary:
    """Change who may read a building, by a JSON merge patch (RFC 7396). This adds no version."""
    return BuildingSummary.summary(await run_in_threadpool(_share, services, user, building_id, change.readers))


@router.delete("/{building_id}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def remove_building(
    building_id: BuildingAddress, services: Provided, user: Caller, if_match: IfMatch = None
) -> None:
    """Remove a building with all its versions; its maps stay."""

    def remove() -> None:
        record = owned_building(services.store, user, building_id)
        _check_match(building_id, record, matched_version(if_match))
        services.store.remove_building(*record.key, instead_of=record)

    await run_in_threadpool(remove)


async def _read(request: Request) -> Building:
    if not is_format(media_type_of(request), "json"):
        raise HTTPException(415, "send JSON with the header 'Content-Type: application/json'")
    return building_of(await request.body())


def _replaced(services: Services, user: User, address: str, match: str | None) -> BuildingRecord | None:
    """Return the building that another replaces, None for a new one; raise unless the caller may put it."""
    record = None
    try:
        record = owned_building(services.store, user, address)
    except NotFound:
        if split_address(address, user.id)[0] != user.id:
            raise
    _check_match(address, record, match)
    return record


def _check_match(address: str, record: BuildingRecord | None, match: str | None) -> None:
    if match is not None and (record is None or match != str(record.present.number)):
        current = "does not exist" if record is None else f"is at version {record.present.number}"
        raise Conflict(f"building {address!r} {current}, not at version {match[:20]}: read it again and retry")


def _check_maps(services: Services, user: User, owner: str, building: Building, before: BuildingRecord | None) -> None:
    """Raise ``InvalidBuilding`` if owner or caller may not read a map that the building has not had before."""
    known = set() if before is None else {floor.map for floor in before.building.floors}
    for floor in building.floors:
        if floor.map in known:
            continue
        try:
            head = services.map_store.map_head(floor.map)
        except NotFound:
            head = None
        if head is None or not reads_itself(user, head):
            raise InvalidBuilding(f"floor {floor.name!r}: there is no map {floor.map!r} that you may read")
        if not head.readable_by(owner):
            raise InvalidBuilding(f"floor {floor.name!r}: map {floor.map!r} is not shared with {owner!r}, its owner")


def _put(services: Services, record: BuildingRecord, before: BuildingRecord | None) -> None:
    if before is None and len(services.store.buildings(record.user)) >= MOST_BUILDINGS:
        raise QuotaExceeded(f"a user may have {MOST_BUILDINGS} buildings: remove one")
    services.store.put_building(record, instead_of=before)


def _share(services: Services, user: User, address: str, readers: list[Any]) -> BuildingRecord:
    record = owned_building(services.store, user, address)
    named = tuple(dict.fromkeys(readers))
    check_users(services.store, (name for name in named if name != EVERYBODY and name not in record.readers))
    changed = replace(record, readers=named)
    services.store.put_building(changed, instead_of=record)
    return changed
