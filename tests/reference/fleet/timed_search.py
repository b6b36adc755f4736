"""Slow, obvious twin of the timed search: all cells that a robot can be in, step by step."""

from collections.abc import Sequence

from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet.joint_search import has_ring


def earliest(roadmap: Roadmap, others: Sequence[Sequence[int]], start: int, goal: int) -> int | None:
    """Return the earliest time from which a robot can stay at its goal, among the paths of others; None for never.

    All paths have the same number of steps; the robot may use as many.
    """
    steps = len(others[0])
    stays = [not any(path[late] == goal for path in others for late in range(time, steps)) for time in range(steps)]
    reached = {start}
    for time in range(steps):
        if goal in reached and stays[time]:
            return time
        if time + 1 == steps:
            break
        before, after = [tuple(path[moment] for path in others) for moment in (time, time + 1)]
        reached = {
            near
            for cell in reached
            for near in (cell, *(int(one) for one in roadmap.neighbours[cell] if one >= 0))
            if near not in after and not has_ring((cell, *before), (near, *after))
        }
    return None
