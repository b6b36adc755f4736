"""Routes of the zones of a map, which are a file of each of its versions."""

from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, HTTPException, Query, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.audit.requests import note_details
from endpoints.resources.services import Services
from endpoints.resources.version_removal import follow_publication
from endpoints.rest.dependencies import AnyCaller, Caller, Provided, owned_head
from endpoints.rest.maps.maps import IfMatch, invalidated, matched_version, opened_map
from endpoints.rest.maps.schemas import CheckedZonesAnswer, PublishedZones
from endpoints.rest.names import MapId, VersionId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.schemas import Description
from endpoints.rest.strict_json import is_format, media_type_of
from ppaas.clock import epoch
from ppaas.errors import NotFound
from ppaas.maps.formats.map_files import read_info
from ppaas.zones.gate import CheckedZones, checked_zones
from ppaas.zones.reading import geojson_of, with_time_zones
from ppaas.zones.zone import NO_ZONES, ZoneSet
from storage.records import MapRecord, Publication, User
from storage.versions import ALL_BUT_ZONES, IMAGE, YAML, ZONES

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"])

GEOJSON = "application/geo+json"
_CONTENT: dict[str, Any] = {
    GEOJSON: {"schema": {"type": "object", "description": "Feature collection of GeoJSON, in metres on the map"}}
}
_FILE: Responses = {200: {"description": "Feature collection of GeoJSON; `ETag`: the version", "content": _CONTENT}}
_FILE |= KNOWN | problems(404)
_BODY = {"requestBody": {"required": True, "content": _CONTENT}}

Reason = Annotated[Description, Query(description="Reason of the change, shown in the list of versions")]


@router.get("/zones", response_class=Response, responses=_FILE)
async def fetch_zones(map_id: MapId, services: Provided, user: AnyCaller) -> Response:
    """Return the zones of the current version as GeoJSON, and in `in_force` the names of those in force now."""
    record, zones = await run_in_threadpool(_zones, services, user, map_id)
    answer: dict[str, Any] = msgspec.to_builtins(with_time_zones(zones))
    answer["in_force"] = [zone.name for zone in zones.in_force(epoch())]
    return _answer(record, msgspec.json.encode(answer))


@router.get("/versions/{version}/zones", response_class=Response, responses=_FILE)
async def fetch_version_zones(map_id: MapId, version: VersionId, services: Provided, user: Caller) -> Response:
    """Return the zones of a version as GeoJSON."""
    record, zones = await run_in_threadpool(_zones, services, user, map_id, version)
    return _answer(record, geojson_of(with_time_zones(zones)))


@router.put(
    "/zones",
    response_model=PublishedZones,
    responses=KNOWN | BODY | problems(403, 404, 409, 429),
    openapi_extra=_BODY,
)
async def put_zones(
    map_id: MapId, request: Request, *, services: Provided, user: Caller, if_match: IfMatch = None, message: Reason = ""
) -> PublishedZones:
    """Set or replace the zones of a map: this publishes a version that has its other files and these zones.

    Zones that are equal to the current version's zones add no version. What was mended is in `warnings`; if a zone is
    not valid, none is published, and the problem has `faults` with the places.
    """
    head = await owned_head(services, user, map_id)
    checked = await _checked(request, services, user, map_id)
    publication = Publication(map_id, user.id, epoch(), message, head.owner, if_match=matched_version(if_match))
    record = await _change(request, services, publication, checked.zones)
    return PublishedZones.of(record, warnings=checked.warnings)


@router.post(
    "/zones/check", response_model=CheckedZonesAnswer, responses=KNOWN | BODY | problems(404), openapi_extra=_BODY
)
async def check_zones(map_id: MapId, request: Request, *, services: Provided, user: Caller) -> CheckedZonesAnswer:
    """Check zones for a map as if they were published; nothing is changed."""
    checked = await _checked(request, services, user, map_id)
    return CheckedZonesAnswer(zones=len(checked.zones.zones), warnings=checked.warnings)


@router.delete("/zones", status_code=204, responses=KNOWN | problems(400, 403, 404, 409, 429))
async def remove_zones(
    map_id: MapId, request: Request, *, services: Provided, user: Caller, if_match: IfMatch = None, message: Reason = ""
) -> None:
    """Remove the zones of a map: this publishes a version that has its other files only."""
    head = await owned_head(services, user, map_id)
    if ZONES not in head.present.files:
        raise NotFound(f"file of map {map_id!r}:", ZONES, list(head.present.files))
    publication = Publication(map_id, user.id, epoch(), message, head.owner, if_match=matched_version(if_match))
    await _change(request, services, publication, NO_ZONES)


async def _checked(request: Request, services: Services, user: User, map_id: str) -> CheckedZones:
    if not is_format(media_type_of(request), "json"):
        raise HTTPException(415, f"send GeoJSON with the header 'Content-Type: {GEOJSON}' or 'application/json'")
    return await run_in_threadpool(_check, services, user, map_id, await request.body())


def _check(services: Services, user: User, map_id: str, body: bytes) -> CheckedZones:
    with opened_map(services, user, map_id, only=(YAML, IMAGE, ZONES)) as opened:
        info = read_info(*opened.grid())
        return checked_zones(body, info, opened.zones())


async def _change(request: Request, services: Services, publication: Publication, zones: ZoneSet) -> MapRecord:
    owner = publication.owner or publication.author
    with invalidated(services, publication.map):
        record = await services.usage.in_turn(owner, _publish, services, owner, publication, zones)
    await follow_publication(services, record)
    note_details(request.scope, version=record.version, zones=len(zones.zones))
    return record


def _publish(services: Services, owner: str, publication: Publication, zones: ZoneSet) -> MapRecord:
    map_store = services.map_store
    with map_store.stage() as upload:
        upload.keeps = ALL_BUT_ZONES
        if zones != NO_ZONES:
            upload.add(ZONES, [geojson_of(zones)])
        with services.usage.new_map(services, owner, publication.map, upload):
            return map_store.publish(upload, publication)


def _zones(services: Services, user: User, map_id: str, version: str | None = None) -> tuple[MapRecord, ZoneSet]:
    with opened_map(services, user, map_id, version, only=(ZONES,)) as opened:
        return opened.record, opened.zones()


def _answer(record: MapRecord, content: bytes) -> Response:
    headers = {"X-Content-Type-Options": "nosniff", "ETag": f'"{record.version}"'}
    return Response(content, media_type=GEOJSON, headers=headers)
