"""Parameters of ``octomap_server``: its names in ROS 1 and ROS 2, and those that are not supported."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters, spelled
from ppaas.parameters import read_parameters


def read(given):
    return read_parameters(OctomapServerParameters, "octomap_server", spelled(given))


@pytest.mark.parametrize(
    "given",
    [
        {"sensor_model/max_range": 4.0, "pointcloud_min_z": -0.5, "ground_filter/distance": 0.1, "filter_ground": True},
        {"sensor_model.max_range": 4.0, "point_cloud_min_z": -0.5, "ground_filter.distance": 0.1,
         "filter_ground_plane": True},
        {"sensor_model": {"max_range": 4.0}, "point_cloud_min_z": -0.5, "ground_filter": {"distance": 0.1},
         "filter_ground": True},
    ],
)  # fmt: skip
def test_names_of_ros_1_and_ros_2_are_read(given):
    parameters = read(given)
    assert (parameters.volume().max_range, parameters.volume().point_cloud_min_z) == (4.0, -0.5)
    assert (parameters.ground_filter().distance, parameters.filter_ground_plane) == (0.1, True)


def test_parameters_of_markers_and_compression_have_no_effect():
    given = {
        "compress_map": False,
        "color": {"r": 1.0},
        "color_free/a": 0.5,
        "max_depth": 16,
        "incremental_2D_projection": True,
    }
    assert read(given) == OctomapServerParameters()


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"colored_map": True}, "no colours"),
        ({"max_depth": 14}, "coarser 'resolution'"),
        ({"octomap_path": "/tmp/a.bt"}, "reads no files"),
        ({"sensor_model/hit": 0.2}, "sensor_model.hit"),
        ({"filter_ground": True, "pointcloud_min_z": 0.5}, "points of the floor"),
        ({"ground_filter/angle": 0.0}, "angle"),
        ({"point_cloud_max_x": float("inf")}, "finite"),
        ({"min_x_size": -1.0}, "min_x_size"),
        ({"max_blocks": 1 << 30}, "at most 1048576"),
        ({"nonsense": 1}, "nonsense"),
    ],
)
def test_parameters_that_are_not_supported_are_refused_with_the_reason(given, why):
    with pytest.raises(InvalidParameter, match=why):
        read(given)
