"""Tasks: what is to be done on a map, by whom it is done, and what became of it."""

import math
from typing import Literal

import msgspec

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.tasks.floors import on_floor
from ppaas.tasks.options import MOST_BEFORE, After, PlaceHold, Repeat, check_hold, check_repeat

TaskKind = Literal["go_to", "pick_drop", "patrol"]
"""Go to a place; pick at one place and drop at another; go along places, again and again."""

Trip = Literal["charge", "park"]
"""What a dispatcher sends a robot for by itself: to charge at a charger, or to park at a spot."""

TaskState = Literal["queued", "assigned", "active", "done", "failed", "cancelled"]
"""``assigned``: a robot drives to the first place, and another may still take over. ``active``: it has been there."""

OPEN: frozenset[TaskState] = frozenset({"queued", "assigned", "active"})
"""States of tasks that have not ended."""

MOST_PLACES = 64
"""Limit of the places of a task."""

MOST_ROUNDS = 1000
"""Limit of the rounds of a patrol."""

MOST_PRIORITY = 100
"""Largest priority; the least is its negative."""

MOST_LABELS = 16
"""Limit of the labels of a task."""

MOST_WEIGHT = 1e6
"""Limit of the weight that a task loads [kg]."""

MAX_COORDINATE = 1e9
"""Limit of the coordinates of a place [m]."""

LAST_TIME = float(1 << 40)
"""Limit of a deadline, and of other times of a task [s since the epoch]."""

Place = tuple[float, float, float]
"""x, y [m], yaw [rad] in the frame of the map."""

_PLACES = {"go_to": (1, 1), "pick_drop": (2, 2), "patrol": (1, MOST_PLACES)}


class Task(msgspec.Struct, frozen=True, kw_only=True):
    """A task.

    Parameters
    ----------
    id : str
        Unique among the tasks of a user on a map.
    kind : {"go_to", "pick_drop", "patrol"}
    places : tuple of Place
        Places in the order in which they are visited.
    floors : tuple of str
        Floor of each place, of the building whose floor the map of the task is; empty if all are on that map.
    rounds : int
        Number of times that a patrol visits its places.
    priority : int
        Tasks of a higher one go first.
    deadline : float, optional
        Time at which a task that no robot has begun fails [s since the epoch].
    labels : dict of str to str
        Labels that a robot must have.
    holds : tuple of PlaceHold or None
        What its robot waits for at each place before it goes on; empty if it waits nowhere.
    named_robot : str
        The only robot that may do it; empty for any.
    weight : float
        Weight that its robot must be able to load [kg]; see ``PAYLOAD``.
    not_before : float, optional
        Time before which no robot begins it [s since the epoch].
    after : tuple of After
        Tasks that must end first.
    preempts : bool
        It may take a robot from an active task of a lower priority that carries nothing.
    repeat : Repeat, optional
        When it is done again.
    run : int
        Number of this run of a task that repeats.
    series : str
        Id of the first run; empty for the first one itself.
    trip : Trip, optional
        What its robot goes for; None for a task of a user.
    state : TaskState
    robot : str
        Robot that does it, or that ended it; empty while it is queued.
    leg : int
        Number of places that have been visited: the next one is ``places[leg % len(places)]``.
    attempt : int
        Number of goals that were given up or taken away; part of the id of the next one.
    failures : int
        How many of them robots failed.
    holding : float, optional
        Time since which its robot holds at the next place of ``leg`` [s since the epoch]; None while it does not.
    confirmed : int, optional
        Leg at whose place the last hold was confirmed.
    reason : str
        Why it waits, or why it ended; empty if it was done.
    created : float
        Time at which it was added [s since the epoch].
    assigned, begun, ended : float, optional
        Times at which its robot got it, was at its first place, and ended it [s since the epoch].
    home : str
        Floor of the map on which it was added, while it is led; empty if that is of no building, and in stored records.
    """

    id: str
    kind: TaskKind
    places: tuple[Place, ...]
    floors: tuple[str, ...] = ()
    rounds: int = 1
    priority: int = 0
    deadline: float | None = None
    labels: dict[str, str] = {}
    holds: tuple[PlaceHold | None, ...] = ()
    named_robot: str = ""
    weight: float = 0.0
    not_before: float | None = None
    after: tuple[After, ...] = ()
    preempts: bool = False
    repeat: Repeat | None = None
    run: int = 1
    series: str = ""
    trip: Trip | None = None
    state: TaskState = "queued"
    robot: str = ""
    leg: int = 0
    attempt: int = 0
    failures: int = 0
    holding: float | None = None
    confirmed: int | None = None
    reason: str = ""
    created: float = 0.0
    assigned: float | None = None
    begun: float | None = None
    ended: float | None = None
    home: str = ""

    @property
    def is_open(self) -> bool:
        """Return whether the task has not ended."""
        return self.state in OPEN

    @property
    def legs(self) -> int:
        """Number of places that are visited in all."""
        return len(self.places) * (self.rounds if self.kind == "patrol" else 1)

    @property
    def target(self) -> Place:
        """Place to which its robot drives next, with its floor."""
        return self._stop(self.leg % len(self.places))

    @property
    def stops(self) -> tuple[Place, ...]:
        """Places with their floors."""
        return tuple(map(self._stop, range(len(self.places))))

    def _stop(self, number: int) -> Place:
        return on_floor(self.places[number], self.floors[number] if self.floors else self.home)

    @property
    def is_loaded(self) -> bool:
        """Return whether its robot carries what it has picked, so that no other one can go on."""
        return self.kind == "pick_drop" and (self.leg > 0 or self.holding is not None)

    @property
    def hold(self) -> PlaceHold | None:
        """What its robot waits for at the next place; None if it goes on at once."""
        return self.holds[self.leg % len(self.places)] if self.holds else None

    @property
    def needs_confirmation(self) -> bool:
        """Whether its robot holds until somebody confirms it."""
        return (
            self.holding is not None and self.hold is not None and self.hold.is_confirmed and self.confirmed != self.leg
        )

    @property
    def may_start(self) -> float:
        """Time from which a robot may begin it [s since the epoch]."""
        return self.created if self.not_before is None else max(self.created, self.not_before)

    @property
    def goal_id(self) -> str:
        """Id of the goal by which its robot drives to the next place: the same after a restart of the dispatcher."""
        return f"{GOALS}{self.id}-{self.leg}-{self.attempt}"


PAYLOAD = "payload"
"""Label of a robot with the weight that it can load [kg]; one without it loads nothing."""

GOALS = "task-"
"""Beginning of the ids of goals of tasks."""


def check_task(task: Task) -> Task:
    """Return a task; ``InvalidInput`` if it makes no sense; the text says what to change."""
    least, most = _PLACES[task.kind]
    if not least <= len(task.places) <= most:
        number = str(least) if least == most else f"{least} to {most}"
        raise InvalidInput(f"a task {task.kind!r} needs {number} places, not {len(task.places)}")
    if not all(map(_is_place, task.places)):
        raise InvalidInput(f"places must be x, y [m], yaw [rad]: numbers up to {MAX_COORDINATE:g}")
    if not 1 <= task.rounds <= (MOST_ROUNDS if task.kind == "patrol" else 1):
        raise InvalidInput(f"rounds must be 1, or up to {MOST_ROUNDS} for a patrol, not {task.rounds}")
    if abs(task.priority) > MOST_PRIORITY:
        raise InvalidInput(f"priority must be between {-MOST_PRIORITY} and {MOST_PRIORITY}, not {task.priority}")
    if task.deadline is not None and not 0.0 <= task.deadline <= LAST_TIME:
        raise InvalidInput("deadline must be a time in seconds since 1970")
    if len(task.labels) > MOST_LABELS:
        raise InvalidInput(f"a task may require {MOST_LABELS} labels at most, not {len(task.labels)}")
    return _check_options(task)


def _check_options(task: Task) -> Task:
    if task.floors and len(task.floors) != len(task.places):
        raise InvalidInput(f"'floors' must be one a place, {len(task.places)} in all, or none, not {len(task.floors)}")
    if task.holds and len(task.holds) != len(task.places):
        raise InvalidInput(f"'holds' must be one a place, {len(task.places)} in all, or none, not {len(task.holds)}")
    for hold in task.holds:
        if hold is not None:
            check_hold(hold)
    if not 0.0 <= task.weight <= MOST_WEIGHT:
        raise InvalidInput(f"weight must be 0 to {MOST_WEIGHT:g} kg, not {task.weight:g}")
    if task.not_before is not None and not 0.0 <= task.not_before <= LAST_TIME:
        raise InvalidInput("not_before must be a time in seconds since 1970")
    if len(task.after) > MOST_BEFORE:
        raise InvalidInput(f"a task may wait for {MOST_BEFORE} others at most, not {len(task.after)}")
    if task.repeat is not None:
        check_repeat(task.repeat)
    return task


def _is_place(place: Place) -> bool:
    return all(math.isfinite(number) and abs(number) <= MAX_COORDINATE for number in place)


def pose_of(place: Place) -> Pose2D:
    """Return a place as a pose."""
    return Pose2D(*place)
