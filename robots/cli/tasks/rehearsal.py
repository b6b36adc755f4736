"""Rehearsal of a mission before it runs: with the robots and the open tasks of its map, by lengths of its ways."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec.structs import replace

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.tasks.assignment import Distance, labels_of
from ppaas.tasks.floors import floor_of, on_floor
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.records import Place, Task
from ppaas.tasks.rehearsal import Rehearsal
from ppaas.tasks.ways import ways_by, ways_by_times
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.cli.tasks.floors import MapFloors
    from robots.client.rest import RestClient

HORIZON = 86400.0
"""Time after which a rehearsal ends [s]."""

MOST_COSTS = 50_000
"""Limit of the costs of a request."""

MOST_PLACES = 200
"""Limit of the starts and of the goals of a request for times over floors."""


async def rehearse(
    client: "RestClient",
    map_id: str,
    tasks: list[Task],
    start: float,
    confirmed_after: float,
    *,
    floors: "MapFloors | None" = None,
) -> dict[str, Task]:
    """Return the tasks of a mission, and their next runs, as a rehearsal leaves them, by id.

    Robots of the map, or of all floors if these are given, that are connected take part, from where they are; if there
    are none, all robots there, from their initial poses. Tasks there that have not ended come first.

    Raises
    ------
    InvalidInput
        The map has no robots.
    """
    maps = {map_id: ""} if floors is None else {name: floor for floor, name in floors.maps.items()}
    robots = _robots(await client.items(path_of("robots")), maps)
    stored = [
        replace(task_of(one), home=floor)
        for name, floor in maps.items()
        for one in await client.items(path_of("maps", name, "tasks"), state="open")
    ]
    places = _places([*stored, *tasks], robots)
    distance = await (_ways(client, map_id, *places) if floors is None else _times(client, floors.building, *places))
    rehearsal = Rehearsal([*stored, *tasks], robots, distance, start, confirmed_after=confirmed_after)
    rehearsal.run(start + HORIZON)
    others = {task.id for task in stored}
    return {name: task for name, task in rehearsal.tasks.items() if (task.series or name) not in others}


def _robots(listed: list[dict[str, Any]], maps: Mapping[str, str]) -> dict[str, RobotNow]:
    """Return the robots on maps, which have floors, by name."""
    here = [robot for robot in listed if robot["map"] in maps]
    if not here:
        on = "maps" if len(maps) > 1 else "map"
        raise InvalidInput(f"you have no robot on the {on} {', '.join(maps)}: register one with ppaas robot put")
    there = [robot for robot in here if robot["connected"] and robot["pose"] is not None]
    return {
        robot["id"]: RobotNow(
            on_floor(tuple(robot["pose"] if there else robot["initial_pose"]), maps[robot["map"]]),
            labels_of(robot["properties"]),
        )
        for robot in there or here
    }


def task_of(answer: dict[str, Any]) -> Task:
    """Return a task of REST."""
    known = {name: value for name, value in answer.items() if value is not None}
    leg = answer["visited"] - (answer["holding"] is not None)
    return from_json(msgspec.json.encode(known | {"leg": leg}), Task)


def _places(tasks: list[Task], robots: Mapping[str, RobotNow]) -> tuple[list[Place], list[Place]]:
    """Return the places where robots set out, and those of tasks."""
    goals = list(dict.fromkeys(place for task in tasks for place in task.stops))
    return list(dict.fromkeys([*(robot.place for robot in robots.values() if robot.place), *goals])), goals


async def _times(client: "RestClient", building: str, starts: list[Place], goals: list[Place]) -> Distance:
    """Return the lengths of the ways between places on the floors of a building, by the times that they take."""
    seconds: list[list[float | None]] = []
    for row in range(0, len(starts), MOST_PLACES):
        rows: list[list[float | None]] = [[] for _ in starts[row : row + MOST_PLACES]]
        for column in range(0, len(goals), MOST_PLACES):
            body = {
                "starts": [_spot(place) for place in starts[row : row + MOST_PLACES]],
                "goals": [_spot(place) for place in goals[column : column + MOST_PLACES]],
            }
            answer = await client.post(path_of("buildings", building, "costs"), body)
            rows = [[*known, *more] for known, more in zip(rows, answer["seconds"], strict=True)]
        seconds += rows
    return ways_by_times(starts, goals, seconds)


def _spot(place: Place) -> dict[str, Any]:
    x, y, yaw = place
    return {"floor": floor_of(place), "x": x, "y": y, "yaw": yaw}


async def _ways(client: "RestClient", map_id: str, starts: list[Place], goals: list[Place]) -> Distance:
    """Return the lengths of the ways between places of a map."""
    costs: list[list[float | None]] = []
    rows = max(1, MOST_COSTS // len(goals))
    resolution = (await client.get(path_of("maps", map_id)))["resolution"]
    for first in range(0, len(starts), rows):
        part = starts[first : first + rows]
        answer = await client.post(path_of("maps", map_id, "cost_matrix"), {"starts": part, "goals": goals})
        costs += answer["costs"]
    return ways_by(starts, goals, costs, resolution)


def request_of(task: Task, ids: Mapping[str, str]) -> dict[str, Any]:
    """Return the body of the request that adds a task of a mission; ``ids`` are those of the tasks before it."""
    fields = json.loads(msgspec.json.encode(task))
    body = {name: fields[name] for name in _OF_REST if fields.get(name) not in (None, "", [], {}, ())}
    body["after"] = [{"task": ids[before.task], "on": before.on} for before in task.after]
    return body


_OF_REST = (
    "kind", "places", "floors", "rounds", "priority", "deadline", "labels", "holds", "named_robot", "weight",
    "not_before", "preempts", "repeat",
)  # fmt: skip
