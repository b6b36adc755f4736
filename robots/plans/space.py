"""Offline planning in 3D: paths in an octomap file, without a cloud."""

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
"""Default planner."""

HEIGHT = 0.42
"""Height of a Turtlebot2 [m]."""


@dataclass(frozen=True, slots=True)
class SpaceBody:
    """Body of the robot to plan for.

    Parameters
    ----------
    radius, height : float
        Radius and height [m].
    step : float, optional
        Highest step that it climbs [m]; one voxel by default, which is the roughness of the ground in a map.
    flies : bool
        Whether it flies, and so needs no ground.
    """

    radius: float
    height: float = HEIGHT
    step: float | None = None
    flies: bool = False


def costmap_of_file(path: Path, body: SpaceBody, depth: int = DEPTH) -> VoxelCostmap:
    """Return the costmap of an octomap file for a robot.

    Raises
    ------
    InvalidMap
        The file cannot be read, or is too large at this depth.
    InvalidInput
        The depth or the body is invalid.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read {path}: {error.strerror}") from error
    voxels = parse_octomap(data).voxels(depth)
    step = voxels.info.resolution if body.step is None else body.step
    return inflate_voxels(voxels, Cylinder(body.radius, body.height), ground=not body.flies, max_step=step)


def plan(costmap: VoxelCostmap, start: Pose3D, goal: Pose3D, planner: str, tolerance: float) -> PlanResult:
    """Plan a path without a time limit; planned twice, so the reported time excludes loading the kernels.

    Raises
    ------
    NotFound
        There is no such 3D planner; the text lists the planners.
    InvalidInput
        A pose is not finite, or the tolerance is negative.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = create(planner)
    request = PlanRequest3D(start, goal, tolerance, threads=len(os.sched_getaffinity(0)))
    chosen.plan(costmap, request)
    return chosen.plan(costmap, request)
