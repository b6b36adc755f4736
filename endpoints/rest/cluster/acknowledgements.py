"""Routes of acknowledged alerts: all operators whom an alert concerns see who has seen to it."""

from collections.abc import Iterator
from typing import Annotated

from fastapi import APIRouter, Request
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_object, plain
from endpoints.rest.dependencies import Caller, Paged, Provided
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.shared_robots import reach, robots_shared_with
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter, NotPermitted
from storage.alerts.acknowledgements import CLOUD, Acknowledgement, acknowledge, acknowledgements
from storage.ports import Store
from storage.records import User

router = APIRouter(prefix="/acknowledgements", tags=["alerts"], route_class=StrictRoute)

_ROBOTS = "robots/"


class AcknowledgeRequest(RequestBody):
    """Alert to acknowledge."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"object": "robots/tb1", "alert": "lost"}]})

    object: Annotated[str, Field(min_length=1, max_length=256)] = Field(
        description="What it is about: `robots/ID`, `maps/ID/tasks/ID`, `buildings/ID`; for administrators `cloud` or "
        "`endpoints/ID`"
    )
    alert: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        description="Which alert of it, as `lost`, `failed`, `silent`, `store` or `goal ID`"
    )


class AcknowledgementAnswer(ResponseBody):
    """Acknowledged alert."""

    object: str = Field(description="What it is about; robots of others have their address", examples=["robots/tb1"])
    alert: str = Field(examples=["lost"])
    by: str = Field(description="User who acknowledged it")
    time: float = Field(description="What began before this time is acknowledged [s since the epoch]")

    @classmethod
    def of(cls, one: Acknowledgement, name: str) -> "AcknowledgementAnswer":
        """Return an acknowledgement of an object, which the caller knows by this name, as JSON."""
        return cls(object=name, alert=one.alert, by=one.by, time=one.time)


@router.post("", status_code=201, response_model=AcknowledgementAnswer, responses=KNOWN | BODY | problems(403, 404))
async def acknowledge_alert(
    wanted: AcknowledgeRequest, request: Request, services: Provided, user: Caller
) -> AcknowledgementAnswer:
    """Acknowledge an alert: pages show it no longer as open until it happens again. It is kept for 30 days.

    Who may drive a robot acknowledges its alerts, the owner of a task or a building those of it, and administrators
    those of the cloud.
    """
    note_object(request.scope, plain(wanted.object))
    owner, name = await run_in_threadpool(_resolve, services.store, user, wanted.object)
    new = Acknowledgement(object=name, alert=wanted.alert, by=user.id, time=epoch())
    await run_in_threadpool(acknowledge, services.store, owner, new)
    return AcknowledgementAnswer.of(new, wanted.object)


@router.get("", response_model=Page[AcknowledgementAnswer], responses=KNOWN)
async def list_acknowledgements(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the acknowledged alerts of the cloud, of the caller's tasks and buildings, and of robots in reach."""
    after = paging.key(tuple[str, str], ("", ""))
    found = await run_in_threadpool(lambda: sorted(_visible(services.store, user), key=_key))
    return paging.page([one for one in found if _key(one) > after], _key)


def _key(one: AcknowledgementAnswer) -> tuple[str, str]:
    return one.object, one.alert


def _resolve(store: Store, user: User, name: str) -> tuple[str, str]:
    """Return whom an object concerns, and its name there; raises unless the caller may acknowledge its alerts."""
    match name.split("/"):
        case ["cloud"] | ["endpoints", _]:
            if user.role != "admin":
                raise NotPermitted("only an administrator may acknowledge alerts of the cloud")
            return CLOUD, name
        case ["robots", address]:
            robot = reach(store, user, address)
            robot.access.check_role("drive")
            return robot.user, f"{_ROBOTS}{robot.id}"
        case ["maps", map_id, "tasks", task_id]:
            return store.task(user.id, map_id, task_id).user, name
        case ["buildings", building_id]:
            return store.building(user.id, building_id).user, name
        case _:
            known = "'cloud', 'endpoints/ID', 'robots/ID', 'buildings/ID' and 'maps/ID/tasks/ID'"
            raise InvalidParameter(f"there are no alerts of {name[:64]!a}: an object is one of {known}")


def _visible(store: Store, user: User) -> Iterator[AcknowledgementAnswer]:
    for owner in (user.id, CLOUD):
        yield from (AcknowledgementAnswer.of(one, one.object) for one in acknowledgements(store, owner))
    reached = {(robot.user, robot.id) for robot in robots_shared_with(store, user)}
    for owner in {owner for owner, _ in reached}:
        for one in acknowledgements(store, owner):
            robot = one.object.removeprefix(_ROBOTS)
            if one.object != robot and (owner, robot) in reached:
                yield AcknowledgementAnswer.of(one, f"{_ROBOTS}{owner}:{robot}")
