"""Plans in space on a file of OctoMap, without a cloud."""

import os
from dataclasses import dataclass
from pathlib import Path

from ppaas.costmap.volume import Cylinder
from ppaas.costmap.voxels import VoxelCostmap, inflate_voxels
from ppaas.errors import InvalidMap
from ppaas.maps.octomap import parse_octomap
from ppaas.maps.octree import DEPTH
from ppaas.planners.base import PlanResult
from ppaas.planners.volume import PlanRequest3D, Pose3D, create

PLANNER = "astar3d"

HEIGHT = 0.42
"""Of a Turtlebot2 [m]."""


@dataclass(frozen=True, slots=True)
class SpaceBody:
    """For whom a path in space is.

    Parameters
    ----------
    radius, height : float
        Of the robot [m].
    step : float, optional
        Height of a step that it climbs [m]; as much as one voxel by default, since the ground in a map is as rough.
    flies : bool
        Whether it needs no ground.
    """

    radius: float
    height: float = HEIGHT
    step: float | None = None
    flies: bool = False


def costmap_of_file(path: Path, body: SpaceBody, depth: int = DEPTH) -> VoxelCostmap:
    """Return where a robot can be in a map on the disk.

    Raises
    ------
    InvalidMap
        It cannot be read, or is too large at this depth.
    InvalidInput
        No such depth, or no such body.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidMap(f"{path} cannot be read: {error.strerror}") from error
    voxels = parse_octomap(data).voxels(depth)
    step = voxels.info.resolution if body.step is None else body.step
    return inflate_voxels(voxels, Cylinder(body.radius, body.height), ground=not body.flies, max_step=step)


def plan(costmap: VoxelCostmap, start: Pose3D, goal: Pose3D, planner: str, tolerance: float) -> PlanResult:
    """Plan for as long as it takes; the second time, so that the time told of is the planner's alone.

    Raises
    ------
    NotFound
        No such planner in space; the text lists those there are.
    InvalidInput
        A pose that is not finite, or a negative tolerance.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = create(planner)
    request = PlanRequest3D(start, goal, tolerance, threads=len(os.sched_getaffinity(0)))
    chosen.plan(costmap, request)
    return chosen.plan(costmap, request)
