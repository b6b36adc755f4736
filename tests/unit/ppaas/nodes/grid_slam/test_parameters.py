"""Parameters of ``grid_slam``."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.grid_slam.parameters import LIVE_KEY_FRAMES, GridSlamParameters
from ppaas.parameters import read_parameters


def read(**given) -> GridSlamParameters:
    return read_parameters(GridSlamParameters, "grid_slam", given)


def test_defaults_are_those_of_offline_mapping():
    assert read().front_end() == SlamParameters(max_key_frames=LIVE_KEY_FRAMES)
    assert read().closures() == ClosureParameters()
    assert read().drawing() == DrawingSettings()
    assert read().frames() == FrameNames()


def test_names_of_gmapping_are_read():
    given = read(
        delta=0.1, linearUpdate=0.5, angularUpdate=0.4, maxUrange=12, occ_thresh=0.25, temporalUpdate=-1.0, srr=0.2,
        base_frame="base_footprint", odom_frame="/odom", map_frame="office", throttle_scans=2, map_update_interval=2,
    )  # fmt: skip
    front = given.front_end()
    assert (front.resolution, front.max_laser_range, front.srr) == (0.1, 12, 0.2)
    assert (front.minimum_travel_distance, front.minimum_travel_heading) == (0.5, 0.4)
    assert given.drawing() == DrawingSettings(0.1, 2, 0.25)
    assert given.least_interval == 0.0
    assert given.frames() == FrameNames("odom", "base_footprint", "office")


def test_names_of_slam_toolbox_are_read():
    given = read(
        resolution=0.02, max_laser_range=20.0, minimum_time_interval=0.5, loop_search_maximum_distance=3.0,
        loop_match_minimum_chain_size=10, do_loop_closing=True, paused_new_measurements=True,
    )  # fmt: skip
    assert given.closures() == ClosureParameters(
        loop_search_maximum_distance=3.0, loop_match_minimum_chain_size=10, checked_scans=10
    )
    assert (given.drawing().resolution, given.least_interval) == (0.02, 0.5)
    assert read(do_loop_closing=False).closures() is None


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"particles": 30}, "unknown field `particles`; known: .*angularUpdate.*throttle_scans"),
        ({"throttle_scans": 0}, "throttle_scans must be above 0"),
        ({"delta": -0.05}, "delta must be above 0"),
        ({"maxUrange": 0.01}, "minimum_laser_range must be below max_laser_range"),
        ({"occ_thresh": 25.0}, "occ_thresh, must be at most 1"),
        ({"map_update_interval": float("nan")}, "map_update_interval must be finite"),
        ({"loop_match_minimum_response_coarse": 1.5}, "loop_match_minimum_response_coarse"),
        ({"map_frame": 3}, "map_frame"),
    ],
)
def test_wrong_parameters_are_refused(given, text):
    with pytest.raises(InvalidParameter, match=text):
        read(**given)
