"""Mission files: tasks by name, at places by name, that follow each other."""

import json
from collections.abc import Mapping
from difflib import get_close_matches
from graphlib import CycleError, TopologicalSorter
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple, TypeVar

import msgspec
from msgspec import Meta

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.records import Place, Task, TaskKind, check_task
from ppaas.tasks.succession import in_series

# -- parts of a file ---------------------------------------------------------------------------------------------------

MOST_TASKS = 1000
"""Limit of the tasks of a mission."""

Name = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_.-]+$", max_length=64)]
Coordinates = Annotated[tuple[float, ...], Meta(min_length=2, max_length=3)]


class MissionHold(PlaceHold, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """What a robot waits for at a place: a confirmation, a time or a charge, whichever comes first."""


class MissionAfter(After, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Another task of the file that must end first."""


class MissionRepeat(Repeat, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a task is done again: at local times of day, or after a period."""


class MissionPlace(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A place on a floor of the building that the map is a floor of.

    Parameters
    ----------
    floor : str
    at : str or tuple
        Name of a station of the map of the floor, or x, y [m] and, optionally, yaw [rad].
    """

    floor: Annotated[str, Meta(min_length=1, max_length=64)]
    at: str | Coordinates


class MissionTask(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A task of a mission.

    Parameters
    ----------
    name : str
        Its name in the file.
    kind : {"go_to", "pick_drop", "patrol"}
    at : tuple
        Places: names of ``places`` of the file or of stations of the map, or x, y [m] and, optionally, yaw [rad]; those
        on another floor with it.
    start : float, optional
        No robot begins it earlier [s after the start of the mission].
    deadline : float, optional
        A task that no robot has begun by then fails [s after the start of the mission].
    robot : str
        The only robot that may do it; empty for any.
    """

    name: Name
    kind: TaskKind
    at: Annotated[tuple[str | Coordinates | MissionPlace, ...], Meta(min_length=1, max_length=64)]
    rounds: int = 1
    priority: int = 0
    start: float | None = None
    deadline: float | None = None
    labels: dict[str, str] = {}
    holds: tuple[MissionHold | None, ...] = ()
    robot: str = ""
    weight: float = 0.0
    after: tuple[MissionAfter, ...] = ()
    preempts: bool = False
    repeat: MissionRepeat | None = None


class MissionFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A mission.

    Parameters
    ----------
    map : str
        Id of the map.
    tasks : tuple of MissionTask
    places : dict of str to tuple of float
        Places by name: x, y [m] and, optionally, yaw [rad] on the map; others have a floor.
    """

    map: str
    tasks: Annotated[tuple[MissionTask, ...], Meta(min_length=1, max_length=MOST_TASKS)]
    places: dict[str, Coordinates | MissionPlace] = {}

    @property
    def floors(self) -> list[str]:
        """Floors that are named."""
        named = [*self.places.values(), *(place for task in self.tasks for place in task.at)]
        return sorted({place.floor for place in named if isinstance(place, MissionPlace)})


def schema() -> dict[str, Any]:
    """Return the JSON schema of mission files."""
    found: dict[str, Any] = json.loads(msgspec.json.encode(_described(msgspec.json.schema(MissionFile))))
    return found


def _described(value: Any) -> Any:
    """Return a part of a schema with the first lines of docstrings as descriptions."""
    if isinstance(value, list):
        return [_described(item) for item in value]
    if not isinstance(value, dict):
        return value
    lines = {"description": value["description"].partition("\n")[0]} if "description" in value else {}
    return {name: _described(item) for name, item in value.items()} | lines


Stations = Mapping[str, tuple[float, ...]]
"""Stations of a map: x, y [m] and, optionally, yaw [rad]."""

NO_FLOORS: Mapping[str, Stations] = MappingProxyType({})
"""Stations of the other floors of a mission on one map."""


# -- tasks of a file ---------------------------------------------------------------------------------------------------


def mission_in(content: bytes) -> MissionFile:
    """Return the mission in a file; ``InvalidInput`` with the place of what is wrong."""
    try:
        json.loads(content)
    except ValueError as error:
        raise InvalidInput(f"the mission is not JSON: {error}") from error
    try:
        mission = from_json(content, MissionFile)
    except msgspec.MsgspecError as error:
        raise InvalidInput(f"the mission is malformed: {error}") from error
    names = [task.name for task in mission.tasks]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InvalidInput(f"two tasks of the mission have the name {twice[0]!r}")
    return mission


def tasks_of(
    mission: MissionFile,
    stations: Stations,
    start: float,
    *,
    home: str = "",
    others: Mapping[str, Stations] = NO_FLOORS,
) -> list[Task]:
    """Return the tasks of a mission, those that come first before others; the names are their ids.

    Parameters
    ----------
    mission : MissionFile
    stations : mapping of str to tuple of float
        Stations of the map: x, y [m] and, optionally, yaw [rad].
    start : float
        Time at which the mission starts [s since the epoch].
    home : str
        Floor of the map; empty if it is of no building.
    others : mapping of str to mapping
        Stations of the maps of the floors that the mission names.

    Raises
    ------
    InvalidInput
        A place or a task is not known, tasks wait for each other, or a task makes no sense.
    """
    known = _Places(dict(stations) | mission.places, others, home)
    tasks = {task.name: _task(task, known, start) for task in mission.tasks}
    for task in tasks.values():
        for before in task.after:
            if before.task not in tasks:
                raise InvalidInput(f"task {task.id!r} waits for {before.task!r}, which is not in the mission")
    try:
        order = TopologicalSorter({name: [before.task for before in task.after] for name, task in tasks.items()})
        return [tasks[name] for name in order.static_order()]
    except CycleError as error:
        circle = " waits for ".join(repr(name) for name in reversed(error.args[1]))
        raise InvalidInput(f"tasks of the mission wait for each other: {circle}") from error


def _task(task: MissionTask, known: "_Places", start: float) -> Task:
    def at(seconds: float | None) -> float | None:
        return None if seconds is None else start + seconds

    try:
        found = [known.find(place) for place in task.at]
        floors = tuple(floor for _, floor in found)
        made = Task(
            id=task.name,
            kind=task.kind,
            places=tuple(place for place, _ in found),
            floors=tuple(floor or known.home for floor in floors) if any(floors) else (),
            home=known.home,
            not_before=at(task.start),
            deadline=at(task.deadline),
            named_robot=task.robot,
            created=start,
            **{name: getattr(task, name) for name in _SAME},
        )
        return in_series(check_task(made), start)
    except InvalidInput as error:
        raise InvalidInput(f"task {task.name!r}: {error}") from error


_SAME = ("rounds", "priority", "labels", "holds", "weight", "after", "preempts", "repeat")
"""Members that a task has by the same name."""

_Found = TypeVar("_Found")


class _Places(NamedTuple):
    """Places of a mission by name: of its map and of the file, and the stations of other floors."""

    named: Mapping[str, tuple[float, ...] | MissionPlace]
    others: Mapping[str, Stations]
    home: str

    def find(self, place: str | tuple[float, ...] | MissionPlace) -> tuple[Place, str]:
        """Return a place and its floor, which is empty if it has none of its own."""
        if isinstance(place, str):
            place = _named(place, self.named, "the map")
        if not isinstance(place, MissionPlace):
            return _pose(place), ""
        at = place.at
        if isinstance(at, str):
            at = _named(at, self.others.get(place.floor, {}), f"floor {place.floor!r}")
        return _pose(at), place.floor


def _named(name: str, places: Mapping[str, _Found], of: str) -> _Found:
    if name not in places:
        near = get_close_matches(name, places, 3, 0.4) or sorted(places)[:10]
        known = f"; do you mean {', '.join(map(repr, near))}?" if near else f": {of} has no stations"
        raise InvalidInput(f"there is no place {name!r}{known}")
    return places[name]


def _pose(place: tuple[float, ...]) -> Place:
    x, y, *yaw = place
    return x, y, yaw[0] if yaw else 0.0
