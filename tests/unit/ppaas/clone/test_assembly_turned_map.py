"""A map whose origin has a yaw: everything works as on the same map without it."""

import math

import numpy as np
import pytest

from ppaas import planners
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D, wrap_angle, yaw_of
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.formats.map_files import load_map, save_map
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.raycast import cast_rays
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.codec import decode, encode
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.planners.base import PlanRequest
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, walled_map

TURN = Pose2D(-3.0, 7.0, 2.1)
"""Pose of the frame of the straight map in the frame of the turned map."""

STRAIGHT = walled_map(8, 6, [(3.9, 0.0, 4.1, 1.0), (3.9, 2.2, 4.1, 6.0), (1.0, 4.0, 2.0, 4.5)])
START, GOAL = Pose2D(1.02, 1.03, 1.2), Pose2D(6.52, 1.63, 0.0)
"""Not on the border of two cells, where rounding decides."""


def turned(grid: GridMap) -> GridMap:
    """Return a map with a yaw, written to files and read again."""
    info = grid.info
    moved = GridMap(grid.data, GridInfo(info.resolution, info.width, info.height, TURN @ info.origin))
    return load_map(*save_map(moved, "turned.pgm"))


@pytest.fixture(scope="module")
def maps() -> tuple[GridMap, GridMap]:
    """Return a map, and the same map with a yaw."""
    return STRAIGHT, turned(STRAIGHT)


def test_map_server_publishes_the_turned_origin(maps):
    graph = Graph()
    messages = []
    graph.add(lambda context: MapServerNode(context, build_layers(maps[1])))
    graph.tap("map", lambda _, payload: messages.append(payload))
    origin = decode(OccupancyGrid, encode(messages[0].to_message())).info.origin
    q = origin.orientation
    assert (origin.position.x, origin.position.y) == (TURN.x, TURN.y)
    assert yaw_of(q.x, q.y, q.z, q.w) == pytest.approx(TURN.theta)


@pytest.mark.parametrize("name", planners.planner_names())
def test_paths_turn_with_the_map(maps, name):
    results = []
    for grid, frame in zip(maps, (Pose2D(0.0, 0.0), TURN), strict=True):
        costmap = build_layers(grid, robot_radius=0.18).costmap
        request = PlanRequest(frame @ START, frame @ GOAL)
        results.append(planners.create(name).plan(costmap, request))
    straight, other = results
    assert np.array_equal(straight.cells, other.cells)
    assert other.cost == pytest.approx(straight.cost)
    for before, after in zip(straight.poses.tolist(), other.poses.tolist(), strict=True):
        expected = TURN @ Pose2D(before[0], before[1], yaw_of(*before[3:]))
        assert after[:2] == pytest.approx(expected[:2])
        assert wrap_angle(yaw_of(*after[3:]) - expected.theta) == pytest.approx(0.0, abs=1e-9)


def test_laser_ranges_do_not_depend_on_the_turn(maps):
    angles = np.linspace(-math.pi, math.pi, 200)
    straight, other = (
        cast_rays(grid.data >= 65, grid.info, frame @ START, angles, 10.0)
        for grid, frame in zip(maps, (Pose2D(0.0, 0.0), TURN), strict=True)
    )
    np.testing.assert_allclose(straight, other, atol=1e-6)


def test_localization_turns_with_the_map(maps):
    """The same particles, rotated, with the same odometry, beams and random numbers."""
    angles = np.linspace(-2.0, 2.0, 60)
    ranges = cast_rays(maps[0].data >= 65, maps[0].info, START, angles, 10.0)
    beams = np.stack((ranges * np.cos(angles), ranges * np.sin(angles)), axis=-1)
    straight, other = (ParticleFilter(build_layers(grid), AmclParameters()) for grid in maps)
    for filter_ in (straight, other):
        filter_.initialise(Pose2D(1.1, 0.9, 1.3), np.diag([0.04, 0.04, 0.02]))
    other.particles = np.array([TURN @ Pose2D(*particle) for particle in straight.particles.tolist()])
    for odom in (Pose2D(0.0, 0.0, 0.0), Pose2D(0.05, 0.02, 0.1)):
        before = straight.update(odom, beams, 10.0).pose
        after = other.update(odom, beams, 10.0).pose
        assert error_of(after, TURN @ before) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert error_of(before, START)[0] < 0.2


def test_robot_drives_and_localizes_on_the_turned_map(maps):
    driving = ClosedLoop(World(maps[1], TURN @ START, drift=2.0))
    for _ in range(6):
        driving.step()
    driving.send_goal(TURN @ GOAL)
    driving.run(60.0)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    distance, turn = error_of(driving.world.pose, TURN @ GOAL)
    assert distance < 0.2
    assert turn < 0.3
    assert driving.clearance > 0.18
    assert driving.worst < 0.15
