"""AMCL: the map is replaced while the robot drives."""

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.nodes.amcl.continuity import FASTEST, LONGEST_GAP, SLACK, has_driven
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, walled_map

START, GOAL = Pose2D(1.0, 1.0, 0.0), Pose2D(4.5, 2.5, 0.0)
BOX = [(2.6, 0.0, 2.8, 1.6)]


def grown(grid: GridMap, cells: int) -> GridMap:
    """Return a map in the same frame with more unknown cells around it, so that its corner is elsewhere."""
    info = grid.info
    corner = info.origin @ Pose2D(-cells * info.resolution, -cells * info.resolution)
    data = np.pad(grid.data, cells, constant_values=-1)
    return GridMap(data, GridInfo(info.resolution, data.shape[1], data.shape[0], corner))


@pytest.fixture
def driving() -> ClosedLoop:
    """Return a robot whose map lacks a box that is there; it drives to a goal behind it."""
    world = World(walled_map(6, 4, []), START)
    world.truth[:] = walled_map(6, 4, BOX).data >= 50
    return ClosedLoop(world)


def test_the_pose_is_carried_over_and_the_goal_reached(driving: ClosedLoop) -> None:
    driving.send_goal(GOAL)
    driving.run(3.0)
    before = driving.told
    amcl = driving.graph.nodes["amcl"]
    amcl.use_layers(build_layers(grown(walled_map(6, 4, BOX), 17)))  # type: ignore[attr-defined]
    driving.step()
    driving.step()
    assert before is not None and driving.told is not None
    assert error_of(driving.told, driving.world.pose)[0] < 0.06
    driving.run(30.0)
    assert driving.results and driving.worst < 0.1


def test_an_initial_pose_is_checked_by_the_new_map(driving: ClosedLoop) -> None:
    outside = PoseWithCovarianceStamped(
        Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(-0.5, 1.0)), [0.01 * (i % 7 == 0) for i in range(36)])
    )
    with pytest.raises(InvalidInput, match="outside the map"):
        driving.graph.inject("initialpose", outside)
    driving.graph.nodes["amcl"].use_layers(build_layers(grown(driving.world.grid, 20)))  # type: ignore[attr-defined]
    driving.graph.inject("initialpose", outside)


def test_a_lost_robot_is_found_on_the_new_map(driving: ClosedLoop) -> None:
    driving.run(0.5)
    driving.graph.call("global_localization", Empty(), lambda _: None)
    driving.graph.nodes["amcl"].use_layers(build_layers(walled_map(6, 4, BOX)))  # type: ignore[attr-defined]
    for _ in range(40):
        driving.graph.call("request_nomotion_update", Empty(), lambda _: None)
        driving.step()
        driving.step()
    assert driving.told is not None
    assert error_of(driving.told, driving.world.pose)[0] < 0.1


@pytest.mark.parametrize(
    ("metres", "seconds", "expected"),
    [
        (LONGEST_GAP, None, True),
        (LONGEST_GAP, 0.0, True),
        (LONGEST_GAP + 0.1, None, False),
        (LONGEST_GAP + 0.1, -60.0, False),
        (SLACK + 20.0 * FASTEST, 20.0, True),
        (SLACK + 20.0 * FASTEST + 0.1, 20.0, False),
    ],
)
def test_a_robot_has_driven_as_far_as_it_can_in_the_time(metres, seconds, expected):
    assert has_driven(metres, seconds) == expected
