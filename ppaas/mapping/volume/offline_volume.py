"""3D map of a recorded drive: clouds placed at the poses of a trajectory that is known as a whole."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.trajectories import PlanarTrajectory
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.registration import apply
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.transforms.spatial import Rigid, matrix_of

MOST_GAP = 1.0
"""Longest time between two poses between which a cloud is placed [s]."""


class OfflineVolume:
    """Voxels of clouds that were seen along a trajectory.

    Parameters
    ----------
    trajectory : PlanarTrajectory
        Poses of the robot in the map frame, with stamps.
    parameters : VolumeParameters

    Attributes
    ----------
    volume : VoxelVolume
    inserted, unplaced : int
        Number of clouds in it, and of clouds at whose time there is no pose.
    """

    def __init__(self, trajectory: PlanarTrajectory, parameters: VolumeParameters) -> None:
        assert trajectory.stamps is not None
        self._stamps, first = np.unique(trajectory.stamps, return_index=True)
        poses = trajectory.poses[first]
        self._places, self._headings = poses[:, :2], np.unwrap(poses[:, 2])
        self.volume = VoxelVolume(parameters)
        self.inserted = self.unplaced = 0

    def insert(self, stamp: float, points: NDArray[np.float32], sensor: Rigid) -> None:
        """Add points (n, 3) in the frame of the robot [m], of a sensor with a pose there, at a time [s].

        Raises
        ------
        InvalidInput
            The map does not reach the sensor.
        QuotaExceeded
            The map would be too large.
        """
        pose = self._pose(stamp)
        if pose is None:
            self.unplaced += 1
            return
        robot = Rigid.planar(pose)
        placed = robot @ sensor
        self.volume.insert(apply(matrix_of(robot), points), (placed.x, placed.y, placed.z))
        self.inserted += 1

    def _pose(self, stamp: float) -> Pose2D | None:
        after = int(np.searchsorted(self._stamps, stamp))
        known = after < len(self._stamps) and self._stamps[after] == stamp
        if not known and not 0 < after < len(self._stamps):
            return None
        if not known and self._stamps[after] - self._stamps[after - 1] > MOST_GAP:
            return None
        x, y = (float(np.interp(stamp, self._stamps, self._places[:, axis])) for axis in (0, 1))
        return Pose2D(x, y, float(np.interp(stamp, self._stamps, self._headings)))
