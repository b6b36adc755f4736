"""JSON schemas of tasks."""

from typing import Annotated, Any, Literal

import msgspec
from pydantic import ConfigDict, Field, StrictBool, StrictInt

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, Pose, RequestBody, ResponseBody, Triple, triple
from ppaas.tasks.options import (
    LEAST_PERIOD,
    LONGEST_HOLD,
    LONGEST_PERIOD,
    MOST_BEFORE,
    MOST_CLOCKS,
    MOST_ITEMS,
    MOST_OF_ITEM,
    MOST_RUNS,
    After,
    End,
    PlaceHold,
    Repeat,
)
from ppaas.tasks.records import (
    LAST_TIME,
    MOST_LABELS,
    MOST_PLACES,
    MOST_PRIORITY,
    MOST_ROUNDS,
    MOST_WEIGHT,
    Task,
    TaskKind,
    TaskState,
    Trip,
    check_task,
)
from ppaas.tasks.succession import in_series
from ppaas.zones.schedule import Day
from storage.records import MapTask

Label = Annotated[str, Field(max_length=64)]
TaskFilter = Literal[TaskState, "open"]
"""State of the tasks of a list; ``open``: all that have not ended."""
Time = Annotated[Number, Field(ge=0.0, le=LAST_TIME)]
Clock = Annotated[str, Field(pattern=r"^(([01][0-9]|2[0-3]):[0-5][0-9]|24:00)$", max_length=5)]


class HoldFile(RequestBody):
    """What a robot waits for at a place: a confirmation, a time or a charge, whichever comes first."""

    confirm: StrictBool = Field(False, description="Until `POST …/tasks/TASK/confirm`")
    seconds: Annotated[Number, Field(gt=0.0, le=LONGEST_HOLD, description="For at most this time [s]")] | None = None
    charge: Annotated[Number, Field(gt=0.0, le=1.0, description="Until its battery has this charge")] | None = None
    dispenser: Annotated[str, Field(max_length=64, description="Workcell of Open-RMF that loads it and confirms")] = ""
    ingestor: Annotated[str, Field(max_length=64, description="Workcell that unloads it and confirms")] = ""
    items: dict[Name, Annotated[StrictInt, Field(ge=1, le=MOST_OF_ITEM)]] = Field(
        {}, max_length=MOST_ITEMS, description="Quantities that the workcell is asked for, by type"
    )


class AfterFile(RequestBody):
    """Another task of the caller on the map that must end first."""

    task: Name
    on: Annotated[End, Field(description="How it must end; `ended`: in any way")] = "done"


class RepeatFile(RequestBody):
    """When a task is done again: at local times of day, or after a period."""

    at: list[Clock] = Field([], max_length=MOST_CLOCKS, description="Local times of day, such as 08:30")
    days: list[Day] = Field([], max_length=7, description="Days of the week; all without it")
    zone: Annotated[str, Field(max_length=64, description="Time zone, such as Europe/Berlin")] = "UTC"
    every: (
        Annotated[Number, Field(ge=LEAST_PERIOD, le=LONGEST_PERIOD, description="Period from start to start [s]")]
        | None
    ) = None
    count: Annotated[StrictInt, Field(ge=1, le=MOST_RUNS, description="Number of runs")] | None = None
    until: Annotated[Time, Field(description="No run starts later [s since the epoch]")] | None = None

    def repeat(self) -> Repeat:
        """Return it as a part of a task."""
        return Repeat(**self.model_dump() | {"at": tuple(self.at), "days": tuple(self.days)})


class TaskFile(RequestBody):
    """Task to add."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "pick_drop", "places": [[1.0, 2.0], [4.0, 1.5, 1.57]], "priority": 1}]}
    )

    kind: TaskKind = Field(description="`go_to` one place; `pick_drop`: two places; `patrol` along places")
    places: list[Pose] = Field(min_length=1, max_length=MOST_PLACES, fail_fast=True)
    floors: list[Annotated[str, Field(min_length=1, max_length=64)] | None] = Field(
        [],
        max_length=MOST_PLACES,
        description="Floor of each place, of the building that the map is a floor of; null for the map itself",
    )
    rounds: Annotated[StrictInt, Field(ge=1, le=MOST_ROUNDS, description="Rounds of a patrol")] = 1
    priority: Annotated[
        StrictInt, Field(ge=-MOST_PRIORITY, le=MOST_PRIORITY, description="Tasks of a higher priority go first")
    ] = 0
    deadline: Annotated[Time, Field(description="Without a robot by then, it fails [s since the epoch]")] | None = None
    labels: dict[Name, Label] = Field({}, max_length=MOST_LABELS, description="Properties that its robot must have")
    holds: list[HoldFile | None] = Field(
        [], max_length=MOST_PLACES, description="What its robot waits for at each place; null for nothing"
    )
    named_robot: Annotated[Name, Field(description="The only robot that may do it")] | None = None
    weight: Annotated[
        Number, Field(ge=0.0, le=MOST_WEIGHT, description="Weight to load [kg]; a robot has a property `payload`")
    ] = 0.0
    not_before: Annotated[Time, Field(description="No robot begins it earlier [s since the epoch]")] | None = None
    after: list[AfterFile] = Field([], max_length=MOST_BEFORE, description="Tasks that must end first")
    preempts: StrictBool = Field(False, description="It takes a robot from a task of lower priority without a load")
    repeat: RepeatFile | None = None

    def task(self, task_id: str, created: float) -> Task:
        """Return the task; ``InvalidInput`` if its parts do not fit each other."""
        fields = self.model_dump(exclude={"places", "named_robot"})
        fields |= {
            "id": task_id,
            "created": created,
            "places": tuple(map(triple, self.places)),
            "floors": tuple(floor or "" for floor in self.floors),
            "holds": tuple(None if hold is None else PlaceHold(**hold) for hold in fields["holds"]),
            "after": tuple(After(**before) for before in fields["after"]),
            "repeat": None if self.repeat is None else self.repeat.repeat(),
            "named_robot": self.named_robot or "",
        }
        return in_series(check_task(Task(**fields)), created)


class EstimateAnswer(ResponseBody):
    """When a task would begin and end, if nothing changes."""

    robot: str
    begin: float = Field(description="At its first place [s since the epoch]")
    finish: float = Field(description="[s since the epoch]")
    late: bool = Field(description="Whether it would end after its deadline")


class TaskAnswer(ResponseBody):
    """Task, and what became of it."""

    id: str
    map: str
    kind: TaskKind
    places: list[Triple]
    floors: list[str] = Field(description="Floor of each place; empty if all are on the map")
    rounds: int
    priority: int
    deadline: float | None = Field(description="[s since the epoch]")
    labels: dict[str, str]
    holds: list[dict[str, Any] | None] = Field(description="What its robot waits for at each place; empty for nothing")
    named_robot: str | None
    weight: float = Field(description="[kg]")
    not_before: float | None = Field(description="[s since the epoch]")
    after: list[dict[str, str]]
    preempts: bool
    repeat: dict[str, Any] | None
    run: int = Field(description="Number of this run of a task that repeats")
    series: str = Field(description="Id of the first run")
    trip: Trip | None = Field(description="What the cloud sends its robot for by itself; null for tasks of users")
    state: TaskState = Field(description="`assigned`: a robot drives to the first place; `active`: it has been there")
    robot: str | None = Field(description="Robot that does it or has ended it; null while it is queued")
    visited: int = Field(description="Number of places that have been visited; places of each round of a patrol count")
    holding: float | None = Field(description="Time since which its robot waits at a place [s since the epoch]")
    needs_confirmation: bool = Field(description="Whether it waits for a confirmation now")
    failures: int = Field(description="How often robots have failed it")
    reason: str = Field(description="Why it waits again, or has failed; empty otherwise")
    created: float = Field(description="[s since the epoch], as all times")
    assigned: float | None = Field(description="Time at which its robot was sent to the first place")
    begun: float | None = Field(description="Time at which a robot was at its first place")
    ended: float | None
    estimate: EstimateAnswer | None = Field(
        description="Only when it is added; null if no robot can do it now, or if finding out takes long"
    )

    @classmethod
    def of(cls, record: MapTask, estimate: EstimateAnswer | None = None) -> "TaskAnswer":
        """Return a task as JSON."""
        task = record.task
        fields = msgspec.to_builtins(task, builtin_types=(float,))
        own = ("leg", "attempt", "confirmed", "home")
        known = {name: value for name, value in fields.items() if name not in own}
        return cls(
            **known
            | {
                "map": record.map,
                "named_robot": task.named_robot or None,
                "robot": task.robot or None,
                "series": task.series or task.id,
                "visited": task.leg + (task.holding is not None),
                "needs_confirmation": task.needs_confirmation,
                "estimate": estimate,
            }
        )
