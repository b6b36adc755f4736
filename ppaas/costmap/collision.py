"""Collision check of a path in a voxel grid, for the volume of a robot."""

import numpy as np

from ppaas.costmap.kernels.collision import first_hit
from ppaas.costmap.volume import Volume
from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.maps.voxels import VoxelGrid, only_read

STEPS = 4
"""Number of checked poses per voxel of path length."""

MOST_STEPS = 10_000_000
"""Limit of the number of checked poses."""

MOST_REACH = 500
"""Limit of the robot's swept radius [voxels]."""


def collides_along(voxels: VoxelGrid, volume: Volume, poses: Poses, *, allow_unknown: bool = True) -> int | None:
    """Return the pose of a path at which a robot first overlaps an occupied voxel.

    The robot stands upright with the heading of each pose, moves straight to the next pose, and turns there in the
    shorter direction. It is checked whenever it or its corners have moved by a quarter of a voxel. With voxels of edge
    e and a robot of radius r, an overlap is missed only if it is less than about e²/(128·r) deep.

    Parameters
    ----------
    voxels : VoxelGrid
        The map.
    volume : Volume
        Volume of the robot, whose base is at the z of the poses. Touching is not a collision.
    poses : (n, 7) array
        Path as in ``PlanResult``, in the frame of the map.
    allow_unknown : bool
        Whether the robot may enter unknown voxels and space outside the map.

    Returns
    -------
    int or None
        Index of the first pose that collides, or that the robot cannot reach from the pose before; None if the path is
        free.

    Raises
    ------
    InvalidInput
        The poses have another shape or are not finite, the path is too long or too far from the map, or the voxels are
        too small for the robot.
    """
    points = np.ascontiguousarray(poses, np.float64)
    if points.ndim != 2 or points.shape[1] != 7 or not np.isfinite(points).all():
        raise InvalidInput("a path must be finite rows of x, y, z [m] and a quaternion")
    qx, qy, qz, qw = points[:, 3:].T
    yaws = np.arctan2(2.0 * (qw * qz + qx * qy), qw**2 + qx**2 - qy**2 - qz**2)
    info = voxels.info
    if volume.swept_radius > MOST_REACH * info.resolution:
        raise InvalidInput(
            f"the robot's radius of {volume.swept_radius:g} m is more than {MOST_REACH} voxels of "
            f"{info.resolution:g} m: use coarser voxels"
        )
    local = (points[:, :3] - info.origin) / info.resolution
    length = float(np.linalg.norm(np.diff(local, axis=0), axis=1).sum())
    if length * STEPS > MOST_STEPS or np.abs(local).max(initial=0.0) > MOST_STEPS:
        raise InvalidInput(
            f"the path is too long ({length * info.resolution:g} m) or too far from the map for voxels of "
            f"{info.resolution:g} m"
        )
    sizes = np.array([volume.half_length, volume.half_width, volume.radius, volume.height]) / info.resolution
    hit = first_hit(only_read(voxels.data), local, yaws, sizes, STEPS, allow_unknown)
    return None if hit < 0 else int(hit)
