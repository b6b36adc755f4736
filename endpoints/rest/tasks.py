"""Tasks: what any capable robot of the caller on a map is to do. Their JSON schemas and routes."""

import secrets
from contextlib import suppress
from functools import partial
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Path, Query
from msgspec.structs import replace
from pydantic import ConfigDict, Field, StrictInt
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page, StatePaging
from endpoints.rest.schemas import Number, Pose, RequestBody, ResponseBody, Triple, triple
from endpoints.rest.strict_json import StrictRoute
from ppaas.clock import epoch
from ppaas.errors import Conflict, QuotaExceeded, Unavailable
from ppaas.tasks.records import (
    LAST_TIME,
    MOST_LABELS,
    MOST_PLACES,
    MOST_PRIORITY,
    MOST_ROUNDS,
    Task,
    TaskKind,
    TaskState,
    check_task,
)
from storage.ports import TaskStore
from storage.records import MapTask

Label = Annotated[str, Field(max_length=64)]
TaskFilter = Literal[TaskState, "open"]
"""State of the tasks of a list; ``open``: all that have not ended."""


class TaskFile(RequestBody):
    """Task to add."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "pick_drop", "places": [[1.0, 2.0], [4.0, 1.5, 1.57]], "priority": 1}]}
    )

    kind: TaskKind = Field(description="`go_to` one place; `pick_drop`: two places; `patrol` along places")
    places: list[Pose] = Field(min_length=1, max_length=MOST_PLACES, fail_fast=True)
    rounds: Annotated[StrictInt, Field(ge=1, le=MOST_ROUNDS, description="Rounds of a patrol")] = 1
    priority: Annotated[
        StrictInt, Field(ge=-MOST_PRIORITY, le=MOST_PRIORITY, description="Tasks of a higher priority go first")
    ] = 0
    deadline: (
        Annotated[
            Number, Field(ge=0.0, le=LAST_TIME, description="Without a robot by then, it fails [s since the epoch]")
        ]
        | None
    ) = None
    labels: dict[Name, Label] = Field({}, max_length=MOST_LABELS, description="Properties that its robot must have")

    def task(self, task_id: str, created: float) -> Task:
        """Return the task; ``InvalidInput`` if the number of places or rounds does not fit its kind."""
        places = tuple(map(triple, self.places))
        fields = self.model_dump(exclude={"places"})
        return check_task(Task(id=task_id, places=places, created=created, **fields))


class TaskAnswer(ResponseBody):
    """Task, and what became of it."""

    id: str
    map: str
    kind: TaskKind
    places: list[Triple]
    rounds: int
    priority: int
    deadline: float | None = Field(description="[s since the epoch]")
    labels: dict[str, str]
    state: TaskState = Field(description="`assigned`: a robot drives to the first place; `active`: it has been there")
    robot: str | None = Field(description="Robot that does it or has ended it; null while it is queued")
    visited: int = Field(description="Number of places that have been visited; places of each round of a patrol count")
    failures: int = Field(description="How often robots have failed it")
    reason: str = Field(description="Why it waits again, or has failed; empty otherwise")
    created: float = Field(description="[s since the epoch], as all times")
    assigned: float | None = Field(description="Time at which its robot was sent to the first place")
    begun: float | None = Field(description="Time at which a robot was at its first place")
    ended: float | None

    @classmethod
    def of(cls, record: MapTask) -> "TaskAnswer":
        """Return a task as JSON."""
        task = record.task
        return cls(
            id=task.id,
            map=record.map,
            kind=task.kind,
            places=[list(place) for place in task.places],
            rounds=task.rounds,
            priority=task.priority,
            deadline=task.deadline,
            labels=task.labels,
            state=task.state,
            robot=task.robot or None,
            visited=task.leg,
            failures=task.failures,
            reason=task.reason,
            created=task.created,
            assigned=task.assigned,
            begun=task.begun,
            ended=task.ended,
        )


router = APIRouter(prefix="/maps/{map_id}/tasks", tags=["tasks"], route_class=StrictRoute)

MOST_OPEN = 1000
"""Limit of the tasks of a user on a map that have not ended."""

READ_AT_ONCE = 128
"""Tasks that are read from the store at once."""

ATTEMPTS = 8
"""Number of attempts to cancel a task that changes at the same time."""

TaskId = Annotated[Name, Path(examples=["018f3c2ab4d0-5e1c9a02"])]


@router.post("", status_code=201, response_model=TaskAnswer, responses=KNOWN | BODY | problems(404, 429))
async def add_task(map_id: MapId, file: TaskFile, services: Provided, user: Caller) -> TaskAnswer:
    """Add a task: one of the caller's robots on the map does it, the best one that has its labels.

    It is kept if no robot is connected, and for 7 days after its end.
    """
    await readable_head(services, user, map_id)
    now = epoch()
    record = MapTask(user.id, map_id, file.task(f"{int(now * 1000.0):012x}-{secrets.token_hex(4)}", now))
    await run_in_threadpool(_add, services.store, record)
    await _tell(services, record)
    return TaskAnswer.of(record)


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
    record = await run_in_threadpool(_cancel, services.store, (user.id, map_id, task_id))
    await _tell(services, record)
    return TaskAnswer.of(record)


def _add(store: TaskStore, record: MapTask) -> None:
    if sum(one.task.is_open for one in store.tasks(record.user, record.map)) >= MOST_OPEN:
        raise QuotaExceeded(
            f"a user may have {MOST_OPEN} tasks on a map that have not ended: cancel some, or wait until some are done"
        )
    store.put_task(record)


def _cancel(store: TaskStore, key: tuple[str, str, str]) -> MapTask:
    before = store.task(*key)
    for _ in range(ATTEMPTS):
        if not before.task.is_open:
            raise Conflict(f"task {key[2]!r} has ended already: it is {before.task.state}")
        after = replace(before, task=replace(before.task, state="cancelled", ended=epoch(), reason=""))
        with suppress(Conflict):
            store.put_task(after, instead_of=before)
            return after
        before = store.task(*key)
    raise before.changed_meanwhile()


async def _tell(services: Services, record: MapTask) -> None:
    """Ask the master to read the tasks; without one, the next leader does."""
    with suppress(Unavailable):
        await services.cloud.tasks.changed(record.user, record.map)


def _is_sought(state: TaskFilter | None, record: MapTask) -> bool:
    return state in {None, record.task.state} or (state == "open" and record.task.is_open)


def _read(store: TaskStore, group: tuple[str, str], after: str) -> list[MapTask]:
    return store.tasks(*group, after=after, limit=READ_AT_ONCE)
