"""Slow, obvious twin of the search with turns: all cells and headings that a robot can have, step by step."""

from collections.abc import Sequence

from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet import turns
from tests.reference.fleet.joint_search import has_ring


def cheapest(
    roadmap: Roadmap, others: Sequence[Sequence[int]], start: int, goal: int, step: int, quarter: int
) -> int | None:
    """Return the least cost of a path to a goal among the paths of others, its turns included; None without a path.

    All paths have the same number of steps; the robot may use as many, and stays at its goal then.
    """
    steps, found = len(others[0]), list[int]()
    reached = {(start, heading): 0 for heading in turns.DIRECTIONS}
    for time in range(steps):
        if not any(path[late] == goal for path in others for late in range(time, steps)):
            found += [step * time + quarter * turned for (cell, _), turned in reached.items() if cell == goal]
        if time + 1 == steps:
            break
        before, after = [tuple(path[moment] for path in others) for moment in (time, time + 1)]
        onward: dict[tuple[int, turns.Direction], int] = {}
        for (cell, heading), turned in reached.items():
            for near in (cell, *(int(one) for one in roadmap.neighbours[cell] if one >= 0)):
                if near in after or has_ring((cell, *before), (near, *after)):
                    continue
                ahead = heading if near == cell else turns.direction(roadmap, cell, near)
                total = turned + turns.quarters(heading, ahead)
                onward[near, ahead] = min(total, onward.get((near, ahead), total))
        reached = onward
    return min(found, default=None)
