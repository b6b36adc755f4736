"""A clone goes on with a joint map in another frame while its robot drives: the robot comes where it was sent."""

import base64
from typing import Any

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.slam_toolbox import GetPoseGraphRequest, UseJointMapRequest
from ppaas.planar_poses import compose
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.exploring_loop import ExploringLoop
from tests.support.world.planar_world import World, error_of, walled_map
from tests.support.world.service_calls import call_service

ROOMS = walled_map(5, 4, [(2.4, 0.0, 2.6, 2.4)])
START = Pose2D(1.0, 1.0, 0.0)
BEHIND_WALL = Pose2D(3.8, 1.0, 0.0)
FRAME = Pose2D(-7.0, 4.0, 2.0)
"""Map frame of the robot in that of the joint map."""


def joint_file(driving: ClosedLoop) -> bytes:
    """Return the robot's own map in another frame, as one that was joined with that of an older robot."""
    page: Any = call_service(driving.graph, "pose_graph", GetPoseGraphRequest(0))
    mapping = unpack_mapping(base64.b64decode(page.data))
    mapping.frames.poses[:] = compose(np.array(FRAME), mapping.frames.poses)
    mapping.graph.move_nodes(mapping.frames.poses)
    return b"".join(pack_mapping(mapping))


def join(driving: ClosedLoop) -> None:
    file = joint_file(driving)
    page = UseJointMapRequest(0, len(file), base64.b64encode(file).decode(), ["tb9"])
    motion = call_service(driving.graph, "grid_slam/use_joint_map", page).motion
    assert (motion.x, motion.y, motion.theta) == pytest.approx(FRAME)


def until_result(driving: ClosedLoop) -> None:
    end = driving.clock() + 60.0
    while not driving.results and driving.clock() < end:
        driving.step()


def test_a_robot_reaches_its_goal_although_the_map_is_in_another_frame_on_the_way() -> None:
    driving = ClosedLoop(World(ROOMS, START, range_max=3.0), maps=True)
    current: list[PoseStamped] = []
    driving.graph.tap("move_base/current_goal", lambda _, message: current.append(message))  # type: ignore[arg-type]
    goal = START.inverse() @ BEHIND_WALL
    driving.send_goal(goal)
    driving.run(4.0)
    before = driving.world.pose
    join(driving)
    assert current[-1].pose.planar() == pytest.approx(FRAME @ goal, abs=1e-6)
    driving.run(0.2)
    assert driving.world.pose.distance_to(before) < 0.1, "it waits for the map"
    until_result(driving)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert error_of(driving.world.pose, BEHIND_WALL)[0] < 0.25
    assert driving.clearance > 0.18
    assert "waiting: the map is in another frame from now on, and is being prepared" in driving.texts


def test_a_goal_in_the_new_frame_is_not_moved_again() -> None:
    driving = ClosedLoop(World(ROOMS, START, range_max=3.0), maps=True)
    driving.run(3.0)
    join(driving)
    there = Pose2D(1.8, 1.5, 0.0)
    driving.send_goal(FRAME @ (START.inverse() @ there))
    until_result(driving)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert error_of(driving.world.pose, there)[0] < 0.25


def test_an_exploring_robot_returns_to_its_start_in_the_new_frame() -> None:
    exploring = ExploringLoop(ClosedLoop(World(ROOMS, START, range_max=4.0), maps=True))
    exploring.send(return_to_start=True)
    exploring.driving.run(4.0)
    join(exploring.driving)
    exploring.run(90.0)
    assert exploring.outcome[0] == Status.SUCCEEDED, exploring.outcome
    assert error_of(exploring.driving.world.pose, START)[0] < 0.3
    assert exploring.results[-1].result.unreachable == 0
    assert exploring.driving.clearance > 0.18
