"""The costmap in space: what it costs a robot of some volume to be somewhere."""

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
"""Voxels that a robot and its inflation may reach to each side."""

_SLACK = 1e-6
"""What only touches is not hit, though its distance was rounded; in squared half voxels."""


@dataclass(frozen=True, slots=True)
class VoxelCostmap:
    """What each place costs the robot. A voxel stands for one place of its frame: the middle of the voxel's floor.

    Parameters
    ----------
    data : (depth, height, width) uint8 array
        0 free, 1–252 graded, 253 the robot would collide, or has nothing to stand on, 254 its place itself is occupied,
        255 it would reach into the unknown; layer 0 is the lowest. Planners only read it.
    info : VoxelInfo
        Where it lies.

    Raises
    ------
    InvalidMap
        An array of another shape or type.
    """

    data: NDArray[np.uint8]
    info: VoxelInfo

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 voxels of shape {self.info.shape}, got {self.data.dtype} of {self.data.shape}"
            )

    def places(self, voxels: ArrayLike) -> NDArray[np.float64]:
        """Return the places that voxels stand for: (..., 3) x, y, z [m] of (..., 3) layer, row, column."""
        middles = np.asarray(voxels, dtype=np.float64)[..., ::-1] + (0.5, 0.5, 0.0)
        return np.asarray(middles * self.info.resolution + self.info.origin)

    def nearest(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the voxels whose places are nearest to points, (..., 3); outside the map where a point is."""
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
    """Return where a robot can be, and what it costs.

    A robot is blocked where it would overlap an occupied voxel, whichever way it turns. On a straight way between two
    neighbouring places it is nowhere nearer to a voxel than at one of the places around the way, and planners take a
    way only where all of those are free. So between places a robot touches nothing either.

    Parameters
    ----------
    voxels : VoxelGrid
        What lies outside of it is unknown.
    volume : Volume
        Of the robot; a box counts as the cylinder in which it can turn.
    ground : bool
        Whether the robot stands on something: a voxel right below its place, or at most ``max_step`` deeper, must be
        occupied. Else it flies.
    max_step : float
        Height of a step that a robot on the ground climbs [m].
    inflation_radius : float
        Up to this horizontal distance from an obstacle a place costs 252 · exp(−factor · (distance − r)) [m].
    cost_scaling_factor : float
        [1/m].

    Raises
    ------
    InvalidParameter
        A radius, factor or step that is negative or not finite, or a robot too large for voxels so small.
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
    """Return the cost by the squared distance from an obstacle, in half voxels; what is farther away costs nothing."""
    collides = max((2.0 * radius / edge) ** 2, 1.0) - _SLACK  # within its own column even a robot without any width
    last = max(collides, (2.0 * inflation_radius / edge) ** 2 + _SLACK)
    if last > (2.0 * MOST_REACH) ** 2:
        raise InvalidParameter(
            f"{max(radius, inflation_radius):g} m around a robot are more than {MOST_REACH} voxels of {edge:g} m: "
            "plan at a coarser depth"
        )
    squares = np.arange(math.ceil(last) + 1)
    decay = np.exp(-factor * np.maximum(0.0, np.sqrt(squares) * (edge / 2.0) - radius))
    costs = ((INSCRIBED_INFLATED_OBSTACLE - 1) * decay).astype(np.uint8)
    costs[squares > (2.0 * inflation_radius / edge) ** 2 + _SLACK] = 0
    costs[squares < collides] = INSCRIBED_INFLATED_OBSTACLE
    return costs
