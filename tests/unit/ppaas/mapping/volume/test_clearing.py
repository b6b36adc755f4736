"""Clearing of boxes, also of blocks that have moved."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import clear_box
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from tests.reference.mapping.volume import MIDDLE
from tests.unit.ppaas.mapping.volume.test_voxel_volume import cloud, log_odds

PARAMETERS = VolumeParameters(resolution=0.1)


@pytest.mark.parametrize("motion", [Pose2D(0.0, 0.0, 0.0), Pose2D(0.7, -0.2, 0.6)])
def test_known_voxels_with_their_centre_in_the_box_become_free(motion):
    volume = VoxelVolume(PARAMETERS)
    volume.insert(*cloud(2, 60, 1.0))
    before = log_odds(volume)
    low, high = np.array([-0.6, -0.4, -0.5]), np.array([0.8, 0.9, 0.7])
    clear_box(volume.blocks, high, low, PARAMETERS, motion)
    c, s = math.cos(motion.theta), math.sin(motion.theta)
    wanted = {}
    for key, value in before.items():
        x, y, z = (np.array(key) + 0.5 - MIDDLE) * 0.1
        place = np.array([c * x - s * y + motion.x, s * x + c * y + motion.y, z])
        wanted[key] = PARAMETERS.model().least if ((place >= low) & (place <= high)).all() else value
    assert log_odds(volume) == wanted
    assert wanted != before


def test_a_box_that_is_not_finite_is_refused():
    with pytest.raises(InvalidInput, match="must be finite"):
        clear_box(VoxelVolume(PARAMETERS).blocks, (0.0, 0.0, math.nan), (1.0, 1.0, 1.0), PARAMETERS)
