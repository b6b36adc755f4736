"""Parameters of voxel volumes."""

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.parameters import read_parameters


def test_names_are_those_of_octomap_server():
    given = {"resolution": 0.1, "sensor_model.max_range": 5.0, "sensor_model.hit": 0.8, "occupancy_min_z": -0.5}
    parameters = read_parameters(VolumeParameters, "octomap_server", given)
    assert (parameters.resolution, parameters.max_range, parameters.hit) == (0.1, 5.0, 0.8)


def test_log_odds_are_those_of_octomap():
    model = VolumeParameters().model()
    assert all(value.dtype == np.float32 for value in model)
    assert np.allclose(model, [0.8472979, -0.4054651, -1.9924302, 3.4760987])


@pytest.mark.parametrize(
    "wrong",
    [
        {"resolution": 0.0}, {"max_range": 0.0}, {"max_range": -2.0}, {"hit": 0.4}, {"hit": 1.0}, {"miss": 0.6},
        {"miss": 0.0}, {"min": 0.6}, {"max": 0.4}, {"max": 1.0}, {"max_blocks": 0}, {"occupancy_min_z": float("nan")},
    ],
)  # fmt: skip
def test_numbers_out_of_range_are_refused(wrong):
    with pytest.raises(InvalidParameter):
        VolumeParameters(**wrong)
