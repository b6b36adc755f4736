"""3D map of a recorded drive."""

import numpy as np
import pytest

from ppaas.mapping.trajectories import PlanarTrajectory
from ppaas.mapping.volume.exports import octree_of_volume
from ppaas.mapping.volume.offline_volume import OfflineVolume
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.transforms.spatial import Rigid

STAMPS = np.array([10.0, 10.5, 14.0, 10.5])
POSES = np.array([(0.0, 0.0, 3.0), (1.0, 0.0, -3.0), (2.0, 0.0, 0.0), (9.0, 9.0, 0.0)])
POINT = np.array([(1.0, 0.0, 0.5)], np.float32)


def made(*stamps: float) -> OfflineVolume:
    volume = OfflineVolume(PlanarTrajectory(STAMPS, POSES), VolumeParameters(resolution=0.1))
    for stamp in stamps:
        volume.insert(stamp, POINT, Rigid(z=0.5))
    return volume


@pytest.mark.parametrize(("stamp", "place"), [(14.0, (3.0, 0.0)), (10.25, (-0.5, 0.0))])
def test_a_cloud_lies_where_the_robot_was_at_its_time(stamp: float, place: tuple[float, float]) -> None:
    volume = made(stamp)
    tree = octree_of_volume(volume.volume)
    (corner,) = tree.corners[tree.occupied]
    centre = (corner.astype(float) - 32768 + 0.5) * 0.1
    assert volume.inserted == 1
    assert centre == pytest.approx((*place, 0.55), abs=0.1)


@pytest.mark.parametrize("stamp", [9.9, 12.0, 14.1])
def test_a_cloud_without_a_pose_at_its_time_is_left_out(stamp: float) -> None:
    volume = made(stamp)
    assert (volume.inserted, volume.unplaced) == (0, 1)
