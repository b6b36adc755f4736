"""Slow, obvious twin of the times of a plan, and a check of such times that knows nothing of how they are made."""

import itertools
from collections.abc import Iterator, Sequence
from functools import cache

from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet import searches

Steps = Sequence[Sequence[int]]
Stay = tuple[int, float, float]
"""A robot, the time at which it began to move into cells, and the time at which it had left them."""


def times(roadmap: Roadmap, steps: Steps, moves: Sequence[float], turn: float) -> list[list[float]]:
    """Return the time at which each robot reaches its cell of each step; areas with little room are not regarded."""

    @cache
    def reached(step: int, robot: int) -> float:
        if step == 0 or steps[step][robot] == steps[step - 1][robot]:
            return reached(step - 1, robot) if step else 0.0
        cell, path = steps[step][robot], [row[robot] for row in steps[: step + 1]]
        turned = searches.count(roadmap, path) - searches.count(roadmap, path[:-1])
        others = [other for other in range(len(moves)) if other != robot]
        left = [
            reached(late + 1, other)
            for late in range(step)
            for other in others
            if steps[late][other] == cell != steps[late + 1][other]
        ]
        return max(reached(step - 1, robot) + turn * turned, *left, 0.0) + moves[robot]

    return [[reached(step, robot) for robot in range(len(moves))] for step in range(len(steps))]


def stays(
    steps: Steps, found: Steps | Sequence[Sequence[float]], moves: Sequence[float], cells: set[int]
) -> Iterator[Stay]:
    """Yield each stay of a robot in some cells, from when it begins to move into one until it has reached another."""
    for robot, move in enumerate(moves):
        path = [row[robot] for row in steps]
        begin = float("-inf") if path[0] in cells else None
        for step, (here, there) in enumerate(itertools.pairwise(path)):
            reached = found[step + 1][robot]
            if there in cells and here not in cells:
                begin = reached - move
            elif here in cells and there not in cells and begin is not None:
                yield robot, begin, reached
        if path[-1] in cells and begin is not None:
            yield robot, begin, float("inf")


def shared(steps: Steps, found: Sequence[Sequence[float]], moves: Sequence[float]) -> list[tuple[int, Stay, Stay]]:
    """Return each cell that two robots are in, or move into, at the same time."""
    cells = {cell for row in steps for cell in row}
    pairs = ((cell, *pair) for cell in cells for pair in itertools.combinations(stays(steps, found, moves, {cell}), 2))
    return [(cell, one, other) for cell, one, other in pairs if one[1] < other[2] and other[1] < one[2]]


def hasty(
    roadmap: Roadmap, steps: Steps, found: Sequence[Sequence[float]], moves: Sequence[float], turn: float
) -> list[tuple[int, int]]:
    """Return each step and robot that has less time than it needs to turn and to move."""
    faults = []
    for robot, move in enumerate(moves):
        path = [row[robot] for row in steps]
        for step in range(1, len(path)):
            turned = searches.count(roadmap, path[: step + 1]) - searches.count(roadmap, path[:step])
            needed = move + turn * turned if path[step] != path[step - 1] else 0.0
            if found[step][robot] - found[step - 1][robot] < needed:
                faults.append((step, robot))
    return faults


def crowded(roadmap: Roadmap, steps: Steps, found: Sequence[Sequence[float]], moves: Sequence[float]) -> list[int]:
    """Return each area that a robot begins to enter without room."""
    faults = []
    for area, room in enumerate(roadmap.room.tolist()):
        cells = {cell for cell in range(len(roadmap)) if int(roadmap.areas[cell]) >> area & 1}
        inside = list(stays(steps, found, moves, cells))
        for _, begin, _ in inside:
            if begin >= 0.0 and sum(one <= begin < end for _, one, end in inside) > room:
                faults.append(area)
    return faults
