"""Slow, obvious twins of a path's poses and cost, cell by cell."""

import itertools
import math

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, quaternion_of


def slow_poses(costmap: Costmap, cells: list[tuple[int, int]], start: Pose2D, goal: Pose2D) -> list[tuple[float, ...]]:
    """Return the poses of a path through the centres of cells."""
    places = [tuple(costmap.info.to_world(cell).tolist()) for cell in cells]
    places[0] = start.x, start.y
    places[-1] = goal.x, goal.y
    poses = []
    for at, place in enumerate(places):
        yaw = start.theta
        if at == len(places) - 1:
            yaw = goal.theta
        elif at > 0:
            ahead = places[at + 1]
            yaw = math.atan2(ahead[1] - place[1], ahead[0] - place[0])
        poses.append((*place, 0.0, *quaternion_of(yaw)))
    return poses


def slow_cost(costmap: Costmap, cells: list[tuple[int, int]]) -> float:
    """Return the cost of the moves of a path."""
    return math.fsum(
        (50.0 + 0.8 * float(costmap.data[here])) * math.dist(here, there) for here, there in itertools.pairwise(cells)
    )
