"""Tasks: what any capable robot of the caller on a map is to do. Their JSON schemas and routes."""

import secrets
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page, StatePaging
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.task_estimates import estimate
from endpoints.rest.task_schemas import TaskAnswer, TaskFile, TaskFilter
from engine.control.tasks.areas import area_in
from engine.specs.containers import MapVersion
from ppaas.buildings.building import Building
from ppaas.clock import epoch
from ppaas.errors import Conflict, QuotaExceeded, Unavailable
from ppaas.tasks.records import Task
from storage.buildings.records import all_buildings, building_with_map, no_building_of
from storage.ports import Store, TaskStore
from storage.records import MapTask

router = APIRouter(prefix="/maps/{map_id}/tasks", tags=["tasks"], route_class=StrictRoute)

MOST_OPEN = 1000
"""Limit of the tasks of a user on a map that have not ended."""

READ_AT_ONCE = 128
"""Tasks that are read from the store at once."""

ATTEMPTS = 8
"""Number of attempts to cancel or confirm a task that changes at the same time."""

TaskId = Annotated[Name, Path(examples=["018f3c2ab4d0-5e1c9a02"])]


@router.post("", status_code=201, response_model=TaskAnswer, responses=KNOWN | BODY | problems(404, 429))
async def add_task(map_id: MapId, file: TaskFile, services: Provided, user: Caller) -> TaskAnswer:
    """Add a task: one of the caller's robots on the map does it, the best one that has its labels.

    A task with floors is done by any of the caller's robots in the building, by lifts, ways and doors. It is kept if no
    robot is connected, and for 7 days after its end.
    """
    head = await readable_head(services, user, map_id)
    now = epoch()
    record = MapTask(user.id, map_id, file.task(f"{int(now * 1000.0):012x}-{secrets.token_hex(4)}", now))
    building = await run_in_threadpool(_building_of, services.store, record)
    record = await run_in_threadpool(_add, services.store, building, record)
    await _tell(services, record)
    area = area_in(building, (user.id, map_id))
    return TaskAnswer.of(record, await estimate(services, MapVersion(head.id, head.version), area, record, now))


@router.get("", response_model=Page[TaskAnswer], responses=KNOWN | problems(404))
async def list_tasks(
    map_id: MapId,
    services: Provided,
    user: Caller,
    paging: Annotated[StatePaging, Depends()],
    state: Annotated[
        TaskFilter | None, Query(description="Only tasks in this state; `open`: all that have not ended")
    ] = None,
) -> dict[str, Any]:
    """List the caller's tasks on a map, oldest first."""
    await readable_head(services, user, map_id)
    read = partial(_read, services.store, (user.id, map_id))
    records = await run_in_threadpool(paging.sought, read, partial(_is_sought, state), lambda record: record.task.id)
    return paging.page([TaskAnswer.of(record) for record in records], lambda answer: answer.id)


@router.get("/{task_id}", response_model=TaskAnswer, responses=KNOWN | problems(404))
async def show_task(map_id: MapId, task_id: TaskId, services: Provided, user: Caller) -> TaskAnswer:
    """Show a task: who does it, and what became of it."""
    await readable_head(services, user, map_id)
    return TaskAnswer.of(await run_in_threadpool(services.store.task, user.id, map_id, task_id))


@router.delete("/{task_id}", response_model=TaskAnswer, responses=KNOWN | problems(404, 409))
async def cancel_task(map_id: MapId, task_id: TaskId, services: Provided, user: Caller) -> TaskAnswer:
    """Cancel a task: its robot stops within a second. It stays in the list, as one that has ended."""
    await readable_head(services, user, map_id)
    record = await run_in_threadpool(_change, services.store, (user.id, map_id, task_id), _cancelled)
    await _tell(services, record)
    return TaskAnswer.of(record)


@router.post("/{task_id}/confirm", response_model=TaskAnswer, responses=KNOWN | problems(404, 409))
async def confirm_task(map_id: MapId, task_id: TaskId, services: Provided, user: Caller) -> TaskAnswer:
    """Confirm a task whose robot holds at a place: it goes on within a second."""
    await readable_head(services, user, map_id)
    record = await run_in_threadpool(_change, services.store, (user.id, map_id, task_id), _confirmed)
    await _tell(services, record)
    return TaskAnswer.of(record)


def _building_of(store: Store, record: MapTask) -> Building | None:
    found = building_with_map(all_buildings(store), record.user, record.map)
    return None if found is None else found.building


def _add(store: Store, building: Building | None, record: MapTask) -> MapTask:
    if record.task.floors:
        record = replace(record, task=_with_floors(building, record))
    if record.task.named_robot:
        store.robot(record.user, record.task.named_robot)  # raises if there is none
    for before in record.task.after:
        store.task(record.user, record.map, before.task)
    if sum(one.task.is_open for one in store.tasks(record.user, record.map)) >= MOST_OPEN:
        raise QuotaExceeded(
            f"a user may have {MOST_OPEN} tasks on a map that have not ended: cancel some, or wait until some are done"
        )
    store.put_task(record)
    return record


def _with_floors(building: Building | None, record: MapTask) -> Task:
    """Return a task that names the floor of each place; ``InvalidInput`` if its building has no such floor."""
    here = None if building is None else building.floor_of_map(record.map)
    if building is None or here is None:
        raise no_building_of(record.map)
    floors = tuple(floor or here.name for floor in record.task.floors)
    for floor in floors:
        building.floor(floor)
    return replace(record.task, floors=floors)


def _change(store: TaskStore, key: tuple[str, str, str], changed: Callable[[Task], Task]) -> MapTask:
    before = store.task(*key)
    for _ in range(ATTEMPTS):
        if not before.task.is_open:
            raise Conflict(f"task {key[2]!r} has ended already: it is {before.task.state}")
        after = replace(before, task=changed(before.task))
        with suppress(Conflict):
            store.put_task(after, instead_of=before)
            return after
        before = store.task(*key)
    raise before.changed_meanwhile()


def _cancelled(task: Task) -> Task:
    return replace(task, state="cancelled", ended=epoch(), holding=None, reason="")


def _confirmed(task: Task) -> Task:
    if not task.needs_confirmation:
        raise Conflict(f"task {task.id!r} does not wait for a confirmation")
    return replace(task, confirmed=task.leg)


async def _tell(services: Services, record: MapTask) -> None:
    """Ask the master to read the tasks; without one, the next leader does."""
    with suppress(Unavailable):
        await services.cloud.tasks.changed(record.user, record.map)


def _is_sought(state: TaskFilter | None, record: MapTask) -> bool:
    return state in {None, record.task.state} or (state == "open" and record.task.is_open)


def _read(store: TaskStore, group: tuple[str, str], after: str) -> list[MapTask]:
    return store.tasks(*group, after=after, limit=READ_AT_ONCE)
