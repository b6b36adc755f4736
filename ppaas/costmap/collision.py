"""Whether a robot of some volume gets along a path: what a plan in the plane does not see."""

import numpy as np

from ppaas.costmap.kernels.collision import first_hit
from ppaas.costmap.volume import Volume
from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.maps.voxels import VoxelGrid, only_read

STEPS = 4
"""Times that a robot is looked at on its way through a voxel."""

MOST_STEPS = 10_000_000
MOST_REACH = 500
"""Voxels that a robot may reach to each side."""


def collides_along(voxels: VoxelGrid, volume: Volume, poses: Poses, *, allow_unknown: bool = True) -> int | None:
    """Return where a robot on a path first overlaps an occupied voxel.

    It stands upright, heads as each pose says, goes straight to the next one and turns there, the shorter way. It is
    looked at whenever it went a quarter of a voxel, or its corners did: with voxels of edge e and a robot of radius r,
    an overlap between two looks is missed only if it is less than about e²/(128·r) deep.

    Parameters
    ----------
    voxels : VoxelGrid
    volume : Volume
        Of the robot; its base is at the z of the poses. What only touches is no collision.
    poses : (n, 7) array
        As of ``PlanResult``, in the frame of the voxels.
    allow_unknown : bool
        Whether the robot may reach into unknown voxels and beyond the map.

    Returns
    -------
    int or None
        Index of the first pose that the robot cannot take, or not come to from the one before; None if it gets along.

    Raises
    ------
    InvalidInput
        The poses are not of that shape, not finite, or too far apart.
    """
    points = np.ascontiguousarray(poses, np.float64)
    if points.ndim != 2 or points.shape[1] != 7 or not np.isfinite(points).all():
        raise InvalidInput("a path is finite rows of x, y, z [m] and a quaternion")
    qx, qy, qz, qw = points[:, 3:].T
    yaws = np.arctan2(2.0 * (qw * qz + qx * qy), qw**2 + qx**2 - qy**2 - qz**2)
    info = voxels.info
    if volume.swept_radius > MOST_REACH * info.resolution:
        raise InvalidInput(f"a robot that reaches {volume.swept_radius:g} m is looked for in coarser voxels")
    local = (points[:, :3] - info.origin) / info.resolution
    length = float(np.linalg.norm(np.diff(local, axis=0), axis=1).sum())
    if length * STEPS > MOST_STEPS or np.abs(local).max(initial=0.0) > MOST_STEPS:
        raise InvalidInput(f"a path of {length * info.resolution:g} m, or so far away, is none in this map")
    sizes = np.array([volume.half_length, volume.half_width, volume.radius, volume.height]) / info.resolution
    hit = first_hit(only_read(voxels.data), local, yaws, sizes, STEPS, allow_unknown)
    return None if hit < 0 else int(hit)
