import math

import numpy as np
import pytest

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.mppi import FAR, terrain_of
from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D, poses_along
from ppaas.maps.grid import GridInfo
from tests.support.world import grids

PARAMETERS = MppiParameters(max_vel_x=0.5)


def path(last=2.5):
    x = np.linspace(0.2, last, 60)
    return FollowedPath(poses_along(np.stack((x, np.full_like(x, 1.0)), axis=1)))


def request(data, pose=Pose2D(0.3, 1.0)):
    return ControlRequest(pose, Velocity(), grids.of(data, 0.05))


def test_seconds_in_free_space_are_those_at_full_speed():
    terrain = terrain_of(request(np.zeros((40, 60), np.uint8)), path(), PARAMETERS)
    cell = terrain.seconds[20, 6]
    assert cell == pytest.approx((2.5 - 0.325) / 0.5, abs=0.1)
    assert terrain.seconds.min() == 0.0
    assert terrain.resolution == 0.05


def test_target_is_where_the_plan_leaves_the_costmap():
    data = np.zeros((40, 60), np.uint8)
    data[:, 50:] = 254
    terrain = terrain_of(request(data), path(9.0), PARAMETERS)
    assert terrain.seconds[20, 49] < 0.2
    assert terrain.seconds[20, 55] == np.float32(FAR)
    assert terrain.distance[20, 40] == pytest.approx(0.5)


def test_higher_costs_take_longer():
    costly = np.full((40, 60), 125, np.uint8)
    seconds = [terrain_of(request(data), path(), PARAMETERS).seconds[20, 6] for data in (costly, np.zeros_like(costly))]
    assert seconds[0] == pytest.approx(3.0 * seconds[1], rel=1e-3)


def test_wall_across_the_plan_raises_no_valid_control():
    data = np.zeros((40, 60), np.uint8)
    data[:, 30] = 254
    with pytest.raises(NoValidControl, match="no path"):
        terrain_of(request(data), path(), PARAMETERS)


def test_robot_in_an_inscribed_cell_needs_a_free_cell_to_leave():
    data = np.zeros((40, 60), np.uint8)
    data[:, :8] = 253
    assert math.isfinite(terrain_of(request(data), path(), PARAMETERS).seconds[20, 6])
    with pytest.raises(NoValidControl, match="no point of the plan"):
        terrain_of(request(np.full((40, 60), 253, np.uint8)), path(), PARAMETERS)


def test_moving_obstacles_are_in_grid_frame_at_the_next_command():
    costmap = grids.of(np.zeros((40, 60), np.uint8), 0.05)
    turned = Costmap(costmap.data, GridInfo(0.05, 60, 40, Pose2D(1.0, 2.0, math.pi / 2)))
    moving = (MovingObstacle(0.0, 3.0, 0.0, 0.5, 0.3),)
    request_ = ControlRequest(turned.info.origin @ Pose2D(0.3, 1.0), Velocity(), turned, movers=moving)
    line = np.array([turned.info.origin @ Pose2D(x, 1.0) for x in np.linspace(0.2, 2.5, 60)])
    terrain = terrain_of(request_, FollowedPath(poses_along(line[:, :2])), MppiParameters(command_delay=0.4))
    assert terrain.movers[0] == pytest.approx((1.2, 1.0, 0.5, 0.0, 0.3))
