"""Dijkstra's algorithm in space."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.planners.volume.ends import VoxelEnds
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.volume.voxel_planner import VoxelPlanner


class Dijkstra3D(VoxelPlanner):
    """Grows the field in all directions alike until it reaches the start."""

    name: ClassVar[str] = "dijkstra3d"
    purpose: ClassVar[str] = "Cheapest path in space, without preparation; the baseline for the other."

    def field(self, costmap: VoxelCostmap, ends: VoxelEnds, *, check: Callable[[], None]) -> VoxelField:
        """Return a field that grows outward."""
        return VoxelField(costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, check=check)
