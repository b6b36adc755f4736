"""Routes of the people whom the caller's robots see on a map: state, settings, and whom to follow."""

from typing import Annotated

import msgspec
from fastapi import APIRouter, Body
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.people.settings import change_settings, follow
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.people.schemas import (
    FollowRequest,
    PeopleAnswer,
    PeopleSettingsAnswer,
    PeopleSettingsChange,
    PeopleSettingsFile,
)
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute, merge
from engine.control.views import PeopleGroupView
from ppaas.errors import InvalidParameter, NotFound, Unavailable
from ppaas.people.settings import PeopleSettings

router = APIRouter(prefix="/maps/{map_id}/people", tags=["people"], route_class=StrictRoute)


@router.get("", response_model=PeopleAnswer, responses=KNOWN | problems(404))
async def show_people(map_id: MapId, services: Provided, user: Caller) -> PeopleAnswer:
    """Show the people whom the caller's robots see on a map, and which robot follows whom and why."""
    await readable_head(services, user, map_id)
    group = await _group(services, user.id, map_id)
    reason = ""
    if group is not None and group.state == "ready":
        try:
            return PeopleAnswer.of(map_id, group, await services.cloud.people.people(user.id, map_id))
        except Unavailable as error:
            reason = str(error)
    return PeopleAnswer.without(map_id, group, (await _settings(services, user.id, map_id)).rule, reason)


@router.get("/settings", response_model=PeopleSettingsAnswer, responses=KNOWN | problems(404))
async def show_people_settings(map_id: MapId, services: Provided, user: Caller) -> PeopleSettings:
    """Show the settings of the caller's robots on a map: the rule of following, targets, names, zones and counting."""
    await readable_head(services, user, map_id)
    return await _settings(services, user.id, map_id)


@router.put("/settings", response_model=PeopleSettingsAnswer, responses=KNOWN | BODY | problems(404, 409))
async def put_people_settings(
    map_id: MapId, file: PeopleSettingsFile, services: Provided, user: Caller
) -> PeopleSettings:
    """Replace the settings of the caller's robots on a map; robots go on with them at once."""
    await readable_head(services, user, map_id)
    settings = file.settings()
    return await change_settings(services, user.id, map_id, lambda _: settings)


@router.patch("/settings", response_model=PeopleSettingsAnswer, responses=KNOWN | BODY | problems(404, 409))
async def change_people_settings(
    map_id: MapId,
    change: Annotated[PeopleSettingsChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: Caller,
) -> PeopleSettings:
    """Change settings by a JSON merge patch (RFC 7396); the type `application/json` is accepted too."""
    await readable_head(services, user, map_id)
    patch = change.model_dump(exclude_unset=True)
    return await change_settings(services, user.id, map_id, lambda settings: _merged(settings, patch))


@router.post("/follow", response_model=PeopleSettingsAnswer, responses=KNOWN | BODY | problems(404, 409))
async def follow_people(map_id: MapId, request: FollowRequest, services: Provided, user: Caller) -> PeopleSettings:
    """Let robots follow these people and nobody else (rule `named`); `PATCH` the rule to undo it."""
    await readable_head(services, user, map_id)
    settings = await _settings(services, user.id, map_id)
    people = list(dict.fromkeys(_person(one, settings.names) for one in request.people))
    if people:
        known = [person.id for person in (await services.cloud.people.people(user.id, map_id)).people]
        for person in people:
            if person not in known:
                raise NotFound("person", str(person), list(map(str, known)))
    return await change_settings(services, user.id, map_id, follow(people))


async def _group(services: Services, user: str, map_id: str) -> PeopleGroupView | None:
    groups = await services.cloud.people.views()
    return next((group for group in groups if (group.user, group.map) == (user, map_id)), None)


async def _settings(services: Services, user: str, map_id: str) -> PeopleSettings:
    return (await run_in_threadpool(services.store.map_people, user, map_id)).settings


def _merged(settings: PeopleSettings, patch: dict[str, object]) -> PeopleSettings:
    try:
        return PeopleSettingsFile.model_validate(merge(msgspec.to_builtins(settings), patch)).settings()
    except ValidationError as error:
        raise RequestValidationError([{**fault, "loc": ("body", *fault["loc"])} for fault in error.errors()]) from error


def _person(given: int | str, names: dict[str, str]) -> int:
    """Return the id of a person, given by id or name."""
    if isinstance(given, int):
        return given
    found = [int(person) for person, name in names.items() if name == given]
    if not found:
        raise NotFound("person", given, sorted(set(names.values())))
    if len(found) > 1:
        raise InvalidParameter(f"people: {len(found)} people are named {given!r}; give an id: {sorted(found)}")
    return found[0]
