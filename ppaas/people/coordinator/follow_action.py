"""Step 4: Follow Action Controller, which gives each person to follow to the robot of least cost."""

from collections.abc import Mapping, Sequence

import numpy as np

from ppaas.people.tracks.assignment import assign

Costs = Mapping[int, Mapping[str, float]]
"""Cost of the shortest path from each robot to each person it identified: by person, then by Robot ID."""

BEYOND = 1e9
"""Cost above the cost of any path."""


def cheapest(costs: Mapping[str, float]) -> str | None:
    """Return the robot of least cost, the first by name of equal ones; None if no robot reaches the person."""
    reached = {robot: cost for robot, cost in costs.items() if cost < BEYOND}
    return min(reached, key=lambda robot: (reached[robot], robot), default=None)


def follow_actions(people: Sequence[int], costs: Costs, free: Sequence[str]) -> dict[int, str]:
    """Return which robot follows each person.

    The paper: the "Follow Action Controller" takes the "shortest path by Dijkstra from each robot to each person it
    identified, the cheapest robot follows". Of several people, each has one robot: as many as possible are followed,
    and of all such assignments the one of least total cost is taken. If fewer robots are free than people are to be
    followed, the first people have precedence.

    Parameters
    ----------
    people : sequence of int
        Ids of the people to follow, the most important first.
    costs : Costs
    free : sequence of str
        Robots that may follow.
    """
    robots = sorted(free)
    given: dict[int, str] = {}
    chosen: list[int] = []
    for person in people:
        tried = _assigned([*chosen, person], costs, robots)
        if len(tried) > len(given):
            given, chosen = tried, [*chosen, person]
        if len(given) == len(robots):
            break
    return given


def _assigned(people: Sequence[int], costs: Costs, robots: Sequence[str]) -> dict[int, str]:
    matrix = np.array([[costs.get(person, {}).get(robot, np.inf) for robot in robots] for person in people])
    rows, columns = assign(matrix.reshape(len(people), len(robots)), BEYOND)
    return {people[row]: robots[column] for row, column in zip(rows.tolist(), columns.tolist(), strict=True)}
