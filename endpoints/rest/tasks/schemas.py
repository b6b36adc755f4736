"""JSON schemas of tasks."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, StrictInt

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, Pose, RequestBody, ResponseBody, Triple, triple
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
