"""A clone drives a robot on the map that it makes: it grows, and goals may be in unknown space."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.maps.grid import UNKNOWN, GridMap
from ppaas.maps.occupancy import GridMapMessage
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.slam_toolbox import Clear
from ppaas.nodes.key_frame_path import KeyFramePath
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, walled_map

ROOMS = walled_map(9, 6, [(3.5, 0.0, 3.7, 4.0)])
START = Pose2D(1.0, 1.0, 0.0)
BEHIND_WALL = Pose2D(6.0, 1.0, 0.0)
RADIUS = 0.18


def in_map(pose: Pose2D) -> Pose2D:
    """Return a pose of the world in the frame of the map, which is that of the odometry."""
    return START.inverse() @ pose


def loop(parameters: dict[str, object] | None = None) -> ClosedLoop:
    return ClosedLoop(World(ROOMS, START, range_max=3.0), maps=True, parameters=parameters)


def test_a_robot_without_a_map_drives_through_unknown_space_to_its_goals() -> None:
    driving = loop()
    driving.send_goal(in_map(BEHIND_WALL))
    driving.run(60.0)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert error_of(driving.world.pose, BEHIND_WALL)[0] < 0.25
    assert driving.clearance > RADIUS
    assert "waiting: no map yet: no message has come on 'map'" in driving.texts


def test_goals_in_unknown_space_are_refused_if_the_planner_may_not_lead_there() -> None:
    driving = loop({"dijkstra": {"allow_unknown": False}})
    driving.send_goal(in_map(BEHIND_WALL))
    driving.run(5.0)
    assert driving.last_status() is Status.ABORTED
    assert "is in unknown space" in driving.results[0].status.text
    driving.send_goal(in_map(Pose2D(2.0, 1.5, 0.0)))
    driving.run(20.0)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text


def stopped(driving: ClosedLoop) -> None:
    """Stop the sensors, and wait until the last changes are in the map."""
    driving.run(5.0)
    driving.sensing = False
    driving.run(1.2)


def move_key_frames(driving: ClosedLoop) -> None:
    """Move the key frames along y, as a loop closure does."""
    published = driving.graph.latched("key_frames")
    assert isinstance(published, KeyFramePath)
    poses = published.key_frames.poses.copy()
    poses[1:, 1] += 0.3
    moved = KeyFramePath(KeyFramePoses(published.key_frames.stamps, poses), published.stamp)
    driving.graph.deliver_to("move_base", "key_frames", moved)


def redraw(driving: ClosedLoop) -> None:
    """Publish the map with a cell that has changed."""
    map_ = driving.graph.latched("map")
    assert isinstance(map_, GridMapMessage)
    cells = map_.grid.data.copy()
    cells[0, 0] = 100 - max(cells[0, 0], 0)
    driving.graph.deliver_to("move_base", "map", GridMapMessage(GridMap(cells, map_.grid.info)))
    driving.run(1.1)


def current_goals(driving: ClosedLoop) -> list[PoseStamped]:
    """Return the list to which the current goal is appended when it changes."""
    current: list[PoseStamped] = []
    driving.graph.tap("move_base/current_goal", lambda _, message: current.append(message))  # type: ignore[arg-type]
    return current


def test_a_goal_moves_with_the_key_frame_nearest_to_it() -> None:
    driving = loop()
    current = current_goals(driving)
    driving.send_goal(in_map(BEHIND_WALL))
    stopped(driving)
    move_key_frames(driving)
    driving.run(0.2)
    assert len(current) == 1, "the map is that of the key frames before"
    redraw(driving)
    first, last = (message.pose.planar() for message in (current[0], current[-1]))
    assert last == pytest.approx((first.x, first.y + 0.3, first.theta))


def test_a_goal_that_comes_after_the_key_frames_have_moved_stays() -> None:
    driving = loop()
    driving.send_goal(in_map(BEHIND_WALL))
    stopped(driving)
    move_key_frames(driving)
    current = current_goals(driving)
    given = in_map(Pose2D(2.5, 1.0, 0.0))
    driving.send_goal(given)
    redraw(driving)
    assert {message.pose.planar() for message in current} == {given}


def test_a_goal_waits_for_the_next_map_after_the_map_was_cleared() -> None:
    driving = loop()
    driving.send_goal(in_map(Pose2D(2.5, 1.0, 0.0)))
    driving.run(1.5)
    driving.texts.clear()
    driving.graph.call("clear", Clear.request(), lambda _: None)
    driving.run(30.0)
    assert "waiting: no map yet: no message has come on 'map'" in driving.texts
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text


@pytest.mark.parametrize("tracked", [True, False])
def test_unknown_cells_of_a_published_map_are_free_if_they_are_not_tracked(tracked: bool) -> None:
    cells = walled_map(4, 3, []).data.copy()
    cells[10:50, 40:70] = UNKNOWN
    world = World(GridMap(cells, walled_map(4, 3, []).info), START)
    world.truth[:] = walled_map(4, 3, []).data >= 50
    driving = ClosedLoop(
        world,
        parameters={"static_layer": {"track_unknown_space": tracked}, "dijkstra": {"allow_unknown": False}},
    )
    driving.run(0.3)
    driving.send_goal(Pose2D(2.8, 1.5, 0.0))
    driving.run(20.0)
    assert driving.last_status() is (Status.ABORTED if tracked else Status.SUCCEEDED)
    assert not np.any(driving.layers.grid.data[20, 45:65] != UNKNOWN), "the shared map is not modified"
