"""Rehearsal of a mission before it runs: with the robots and the open tasks of its map, by lengths of its ways."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.tasks.assignment import Distance, labels_of
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.records import Task
from ppaas.tasks.rehearsal import Rehearsal
from ppaas.tasks.ways import ways_by
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

HORIZON = 86400.0
"""Time after which a rehearsal ends [s]."""

MOST_COSTS = 50_000
"""Limit of the costs of a request."""


async def rehearse(
    client: "RestClient", map_id: str, tasks: list[Task], start: float, confirmed_after: float
) -> dict[str, Task]:
    """Return the tasks of a mission, and their next runs, as a rehearsal leaves them, by id.

    Robots of the map that are connected take part, from where they are; if there are none, all robots of the map, from
    their initial poses. Tasks of the map that have not ended come first.

    Raises
    ------
    InvalidInput
        The map has no robots.
    """
    robots = _robots(await client.items(path_of("robots")), map_id)
    stored = [task_of(one) for one in await client.items(path_of("maps", map_id, "tasks"), state="open")]
    distance = await _ways(client, map_id, [*stored, *tasks], robots)
    rehearsal = Rehearsal([*stored, *tasks], robots, distance, start, confirmed_after=confirmed_after)
    rehearsal.run(start + HORIZON)
    others = {task.id for task in stored}
    return {name: task for name, task in rehearsal.tasks.items() if (task.series or name) not in others}


def _robots(listed: list[dict[str, Any]], map_id: str) -> dict[str, RobotNow]:
    here = [robot for robot in listed if robot["map"] == map_id]
    if not here:
        raise InvalidInput(f"you have no robot on the map {map_id}: register one with ppaas robot put")
    there = [robot for robot in here if robot["connected"] and robot["pose"] is not None]
    return {
        robot["id"]: RobotNow(tuple(robot["pose"] if there else robot["initial_pose"]), labels_of(robot["properties"]))
        for robot in there or here
    }


def task_of(answer: dict[str, Any]) -> Task:
    """Return a task of REST."""
    known = {name: value for name, value in answer.items() if value is not None}
    leg = answer["visited"] - (answer["holding"] is not None)
    return from_json(msgspec.json.encode(known | {"leg": leg}), Task)


async def _ways(client: "RestClient", map_id: str, tasks: list[Task], robots: Mapping[str, RobotNow]) -> Distance:
    """Return the lengths of the ways between all places; straight lines between those of too many."""
    goals = list(dict.fromkeys(place for task in tasks for place in task.places))
    starts = list(dict.fromkeys([*(robot.place for robot in robots.values() if robot.place), *goals]))
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
    "kind", "places", "rounds", "priority", "deadline", "labels", "holds", "named_robot", "weight", "not_before",
    "preempts", "repeat",
)  # fmt: skip
