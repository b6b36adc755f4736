"""A* in space: the same path costs as Dijkstra's algorithm, with fewer expanded voxels."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.planners.volume.ends import VoxelEnds
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.volume.voxel_planner import VoxelPlanner


class AStar3D(VoxelPlanner):
    """Grows the field from the goal towards the start, guided by the least cost of the remaining distance."""

    name: ClassVar[str] = "astar3d"
    purpose: ClassVar[str] = "Cheapest path in space where the straight line is nearly free: the first to try."

    def field(self, costmap: VoxelCostmap, ends: VoxelEnds, *, check: Callable[[], None]) -> VoxelField:
        """Return a field that grows towards the start."""
        goal = np.array([ends.goal])
        return VoxelField(costmap, goal, target=ends.start, allow_unknown=self.allow_unknown, check=check)
