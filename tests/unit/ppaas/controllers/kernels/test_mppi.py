import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.footprints import body_of
from ppaas.controllers.kernels import mppi
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.kernels.mppi import Base, Critics, Terrain, fill_blocked
from ppaas.maps.kernels.distance import distance_serial
from tests.reference.driving import controllers

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
    expected = controllers.cost_of_disc(commands[0], start, ground, BASE, 0.18, CRITICS)
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
