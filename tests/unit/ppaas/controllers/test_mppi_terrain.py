"""Parts of model predictive path integral control: terrain, deviations, parameters and the kernel of its costs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels import mppi
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.kernels.mppi import Base, Critics, Terrain, fill_blocked
from ppaas.controllers.mppi import FAR, draw, terrain_of
from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, poses_along
from ppaas.maps.grid import GridInfo
from ppaas.maps.kernels.distance import distance_serial
from ppaas.parameters import read_parameters
from tests.reference.driving import controllers as twin
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


@pytest.mark.parametrize("batch_size", [8, 9, 600])
def test_first_deviation_is_zero_and_others_are_mirrored_pairs(batch_size):
    noise = draw(MppiParameters(batch_size=batch_size))
    assert noise.shape == (batch_size, 30, 2)
    assert not noise[0].any()
    pairs = noise[2 : batch_size // 2 * 2].reshape(-1, 2, 30, 2)
    assert (pairs[:, 0] == pairs[:, 1] * (1.0, -1.0)).all()


def test_noise_has_the_given_deviation_and_depends_on_the_seed():
    parameters = MppiParameters(batch_size=4000, vx_std=0.3, wz_std=0.9)
    noise = draw(parameters)
    assert noise.std(axis=(0, 1)) == pytest.approx((0.3, 0.9), rel=0.03)
    assert (noise == draw(parameters)).all()
    assert (noise != draw(MppiParameters(batch_size=4000, vx_std=0.3, wz_std=0.9, seed=1))).any()


def test_consecutive_deviations_are_correlated():
    noise = draw(MppiParameters(batch_size=4000))[2:, :, 0]
    assert np.corrcoef(noise[:, 10], noise[:, 11])[0, 1] == pytest.approx(0.8, abs=0.05)


SQUARE = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]


def test_defaults_are_valid_and_a_json_footprint_is_accepted():
    assert MppiParameters().footprint == ()
    assert read_parameters(MppiParameters, "mppi", {"footprint": SQUARE}).footprint[1] == (-0.2, 0.2)
    assert read_parameters(MppiParameters, "mppi", {"footprint": SQUARE[::-1]}).footprint[0] == (0.2, -0.2)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"batch_size": 0}, "batch_size"),
        ({"batch_size": 7}, "batch_size"),
        ({"batch_size": 1 << 20}, "batch_size"),
        ({"time_steps": 0}, "time_steps"),
        ({"model_dt": 0.0}, "model_dt"),
        ({"temperature": math.nan}, "temperature"),
        ({"iteration_count": 0}, "iteration_count"),
        ({"gamma": -1.0}, "gamma"),
        ({"vx_std": "much"}, "vx_std"),
        ({"max_vel_x": -1.0}, "max_vel_x"),
        ({"min_vel_x": 0.5}, "min_vel_x"),
        ({"min_vel_theta": 2.0}, "min_vel_theta"),
        ({"command_delay": -0.1}, "command_delay"),
        ({"command_delay": 60.0}, "command_delay"),
        ({"allow_unknown": 1}, "allow_unknown"),
        ({"seed": -1}, "seed"),
        ({"footprint": [[0.1, 0.1], [0.2, 0.2]]}, "footprint"),
        ({"footprint": [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]}, "footprint"),
        ({"footprint": [[0.2, math.inf], [-0.2, 0.2], [-0.2, -0.2]]}, "footprint"),
        ({"footprint": "box"}, "footprint"),
        ({"footprint": [[0.2, 0.2, 0.0], [-0.2, 0.2, 0.0], [-0.2, -0.2, 0.0]]}, "footprint"),
        ({"footprint": [[0.2, True], [-0.2, 0.2], [-0.2, -0.2]]}, "footprint"),
    ],
)
def test_invalid_parameters_are_refused_by_name(wrong, named):
    with pytest.raises(InvalidParameter, match=named):
        read_parameters(MppiParameters, "mppi", wrong)


EDGE = 0.05
NOBODY = np.zeros((0, 5))
BASE = Base(0.05, 1.0, 0.9, -0.3, 2.0, 0.1, 0.3, 0.7)
DISC = RobotOutline(np.zeros((0, 5)), 0.18, 0.18)
CRITICS = Critics(100.0, 0.03, 1.5, 0.08, 12.0, 0.1, 5.0, 0.3, 20.0, 0.3)
BOX = ((0.25, 0.2), (-0.25, 0.2), (-0.25, -0.2), (0.25, -0.2))


def terrain(seed, density, size=60):
    rng = np.random.default_rng(seed)
    lethal = rng.random((size, size)) < density
    lethal[0, 0] = True
    seconds = rng.uniform(0.0, 0.2, lethal.shape).cumsum(axis=1).astype(np.float32)
    return lethal, Terrain(distance_serial(lethal.view(np.uint8), EDGE), seconds, EDGE, NOBODY)


@given(
    seed=st.integers(0, 10_000),
    density=st.sampled_from([0.0, 0.002, 0.02]),
    pose=st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 3.0), st.floats(-3.2, 3.2)),
    moving=st.tuples(st.floats(-0.3, 1.0), st.floats(-2.0, 2.0)),
    movers_count=st.integers(0, 3),
)
def test_rollout_of_a_disc_agrees_with_the_twin(seed, density, pose, moving, movers_count):
    _, ground = terrain(seed, density)
    random = np.random.default_rng(seed)
    movers = np.hstack(
        (
            random.uniform(0.0, 3.0, (movers_count, 2)),
            random.normal(0.0, 0.5, (movers_count, 2)),
            random.uniform(0.0, 0.4, (movers_count, 1)),
        )
    )
    ground = ground._replace(movers=movers)
    commands = np.random.default_rng(seed).normal(0.3, 0.6, (1, 12, 2))
    start = np.array((*pose, *moving, *moving))
    expected = twin.cost_of_disc(commands[0], start, ground, BASE, 0.18, CRITICS)
    got = mppi.roll_out_serial(commands.copy(), start, ground, BASE, DISC, CRITICS)
    assert got[0] == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_commands_are_clamped_to_velocity_and_acceleration_limits():
    _, ground = terrain(1, 0.0)
    commands = np.array([[(9.0, 9.0)] * 4 + [(-9.0, -9.0)] * 30])
    mppi.roll_out_serial(commands, np.array((1.5, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0)), ground, BASE, DISC, CRITICS)
    steps = np.diff(np.vstack(((0.0, 0.0), commands[0])), axis=0)
    assert np.abs(steps).max(axis=0) == pytest.approx((0.1, 0.3))
    assert commands[0].max(axis=0) == pytest.approx((0.4, 1.2))
    assert commands[0].min(axis=0) == pytest.approx((-0.3, -2.0))


def test_parallel_rollout_is_bitwise_equal_to_serial():
    _, ground = terrain(3, 0.01)
    commands = np.random.default_rng(0).normal(0.3, 0.5, (200, 20, 2))
    start = np.array((1.5, 1.5, 0.3, 0.2, 0.0, 0.2, 0.0))
    body = body_of(BOX, 0.0)
    one, many = commands.copy(), commands.copy()
    costs = mppi.roll_out_serial(one, start, ground, BASE, body, CRITICS)
    assert (costs == mppi.roll_out_parallel(many, start, ground, BASE, body, CRITICS)).all()
    assert (one == many).all()
    assert len(np.unique(costs)) > 100


def test_later_collision_costs_less_and_none_costs_least():
    lethal = np.zeros((60, 60), np.bool_)
    lethal[:, 40] = True
    ground = Terrain(distance_serial(lethal.view(np.uint8), EDGE), np.zeros((60, 60), np.float32), EDGE, NOBODY)
    commands = np.array([[(speed, 0.0)] * 40 for speed in (1.0, 0.6, 0.0)])
    costs = mppi.roll_out_serial(commands, np.array((1.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0)), ground, BASE, DISC, CRITICS)
    assert costs[0] > costs[1] > 100.0 > costs[2]


def test_blocked_cells_cost_slightly_more_than_their_neighbours():
    inf = math.inf
    seconds = np.array([[1.0, inf, inf], [2.0, inf, inf], [3.0, 4.0, inf]], np.float32)
    fill_blocked(seconds, 0.5, 100.0)
    assert seconds.tolist() == [[1.0, 1.5, 100.0], [2.0, 1.5, 4.5], [3.0, 4.0, 4.5]]


def test_warm_runs():
    mppi.warm()
