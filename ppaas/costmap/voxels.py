"""Costmap in space: the cost of each position for the volume of a robot."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR
from ppaas.costmap.kernels.voxels import inflate_layers, keep_to_ground
from ppaas.costmap.volume import Volume
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.maps.voxels import VoxelGrid, VoxelInfo, only_read

MOST_REACH = 500
"""Limit of the robot's radius and of the inflation radius [voxels]."""

_SLACK = 1e-6
"""Tolerance for rounded distances, so that touching does not count as collision [squared half voxels]."""


@dataclass(frozen=True, slots=True)
class VoxelCostmap:
    """Cost of each voxel. A voxel represents one position of the robot's frame: the centre of the voxel's floor.

    Parameters
    ----------
    data : (depth, height, width) uint8 array
        0 free; 1–252 graded; 253 the robot would collide, or has no ground; 254 the voxel itself is occupied; 255 the
        robot would reach into unknown space. Layer 0 is the lowest. Planners only read it.
    info : VoxelInfo
        Geometry of the grid.

    Raises
    ------
    InvalidMap
        The array has another shape or type.
    """

    data: NDArray[np.uint8]
    info: VoxelInfo

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 voxels of shape {self.info.shape}, not {self.data.dtype} of shape {self.data.shape}"
            )

    def places(self, voxels: ArrayLike) -> NDArray[np.float64]:
        """Return the positions that voxels represent: (..., 3) x, y, z [m] from (..., 3) layer, row, column."""
        middles = np.asarray(voxels, dtype=np.float64)[..., ::-1] + (0.5, 0.5, 0.0)
        return np.asarray(middles * self.info.resolution + self.info.origin)

    def nearest(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the voxels whose positions are nearest to points, (..., 3); outside the map if the point is."""
        return self.info.to_voxels(np.add(points, (0.0, 0.0, self.info.resolution / 2.0)))


def inflate_voxels(
    voxels: VoxelGrid,
    volume: Volume,
    *,
    ground: bool = False,
    max_step: float = 0.0,
    inflation_radius: float = 0.0,
    cost_scaling_factor: float = COST_SCALING_FACTOR,
) -> VoxelCostmap:
    """Return the costs of all positions of a robot.

    A position is blocked if the robot would overlap an occupied voxel there with any heading. This makes moves safe as
    well: on a straight move between two neighbouring positions, the robot is never nearer to a voxel than at one of the
    positions around the move, and planners use a move only if all of these are free.

    Parameters
    ----------
    voxels : VoxelGrid
        The map; space outside it is unknown.
    volume : Volume
        Volume of the robot; a box counts as the cylinder in which it can turn.
    ground : bool
        Whether the robot needs ground: an occupied voxel directly below its position, or at most ``max_step`` lower.
        Else the robot flies.
    max_step : float
        Highest step that a robot on the ground can climb [m].
    inflation_radius : float
        Horizontal distance from an obstacle up to which a position costs 252 · exp(−factor · (distance − r)), where r
        is the radius of the robot [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance [1/m].

    Raises
    ------
    InvalidParameter
        A radius, the factor or the step is negative or not finite, or the voxels are too small for the robot.
    """
    for name, value in (
        ("max_step", max_step),
        ("inflation_radius", inflation_radius),
        ("cost_scaling_factor", cost_scaling_factor),
    ):
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidParameter(f"{name} must be finite and not negative, not {value}")
    edge, depth = voxels.info.resolution, voxels.info.depth
    table = _table(volume.swept_radius, inflation_radius, cost_scaling_factor, edge)
    layers = min(max(1, math.ceil(volume.height / edge - _SLACK)), depth + 1)
    costs = np.empty(voxels.info.shape, np.uint8)
    inflate_layers(only_read(voxels.data), layers, table, costs)
    if ground:
        steps = min(1 + math.floor(max_step / edge + _SLACK), depth)
        keep_to_ground(only_read(voxels.data), steps, costs)
    return VoxelCostmap(costs, voxels.info)


def _table(radius: float, inflation_radius: float, factor: float, edge: float) -> NDArray[np.uint8]:
    """Return the cost by the squared distance from an obstacle [squared half voxels]; beyond the table it is 0."""
    collides = max((2.0 * radius / edge) ** 2, 1.0) - _SLACK  # even a robot of radius 0 collides in its own column
    last = max(collides, (2.0 * inflation_radius / edge) ** 2 + _SLACK)
    if last > (2.0 * MOST_REACH) ** 2:
        raise InvalidParameter(
            f"the radius of {max(radius, inflation_radius):g} m around the robot is more than {MOST_REACH} voxels of "
            f"{edge:g} m: plan at a coarser depth"
        )
    squares = np.arange(math.ceil(last) + 1)
    decay = np.exp(-factor * np.maximum(0.0, np.sqrt(squares) * (edge / 2.0) - radius))
    costs = ((INSCRIBED_INFLATED_OBSTACLE - 1) * decay).astype(np.uint8)
    costs[squares > (2.0 * inflation_radius / edge) ** 2 + _SLACK] = 0
    costs[squares < collides] = INSCRIBED_INFLATED_OBSTACLE
    return costs
