"""Driving over a costmap has the cost and the collisions of its twin."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import convex_outline
from ppaas.planners.lattice.kernels.driving import DrivingSurface, drive, fits, flat_surface
from tests.reference.planners import driving as twin

SEEDS = st.integers(0, 2**32 - 1)
NOTHING = np.empty((0, 3))


def random_surface(rng, *, outlined):
    costs = rng.choice([0, 0, 0, 0, 0, 0, 50, 252, 253, 254], (12, 14)).astype(np.uint8)
    corners = convex_outline(rng.normal(0.0, 1.2, (6, 2))) if outlined else np.empty((0, 2))
    sums = np.zeros((12, 15), np.int32)
    np.cumsum(costs == 254, axis=1, out=sums[:, 1:])
    reach = float(np.hypot(*corners.T).max(initial=0.0))
    return DrivingSurface(costs, rng.uniform(0.5, 3.0, 256), corners, reach, sums, bool(rng.integers(2)), 0.0, 0.0, 0.0)


@given(SEEDS)
def test_outline_check_agrees_with_the_twin(seed):
    rng = np.random.default_rng(seed)
    surface = random_surface(rng, outlined=True)
    pose = (*rng.uniform(-1.0, 14.0, 2).tolist(), rng.uniform(-7.0, 7.0))
    free = fits(surface, pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2]))
    corners = twin.placed(surface.corners.tolist(), pose)
    assert free == twin.outline_is_free(surface.costs == 254, corners, surface.outside)


@given(SEEDS, st.booleans())
def test_cost_and_end_of_a_piece_agree_with_the_twin(seed, outlined):
    rng = np.random.default_rng(seed)
    surface = random_surface(rng, outlined=outlined)
    start = (*rng.uniform((0.0, 0.0), (14.0, 12.0)).tolist(), rng.uniform(-4.0, 4.0))
    piece = float(rng.choice([0.0, 0.3, -1.0])), rng.uniform(-4.0, 4.0)
    reached = drive(surface, *start, *piece, False, NOTHING)
    cost = twin.drive(surface.costs, surface.rates, start, piece, surface.corners.tolist(), surface.outside)
    assert reached.cost == pytest.approx(cost)
    if math.isfinite(cost):
        np.testing.assert_allclose(reached[1:4], twin.pose_along(start, *piece), atol=1e-9)


def test_samples_are_less_than_a_cell_apart():
    surface = flat_surface(np.zeros((40, 40), np.uint8))
    points = np.full((40, 3), np.nan)
    reached = drive(surface, 5.0, 5.0, 0.5, 0.1, 20.0, False, points)
    count = int(np.isfinite(points[:, 0]).sum())
    assert tuple(points[count - 1]) == pytest.approx((reached.x, reached.y, reached.theta))
    steps = np.hypot(*np.diff(np.vstack(([5.0, 5.0], points[:count, :2])), axis=0).T)
    assert steps.max() < 1.0


@pytest.mark.parametrize("start", [(1.5, 0.5), (0.5, 1.5)])
def test_diagonal_past_an_obstacle_is_blocked(start):
    costs = np.zeros((3, 3), np.uint8)
    costs[1, 1] = 253
    surface = flat_surface(costs)
    theta = math.atan2(start[0] - start[1], start[1] - start[0])
    assert drive(surface, *start, theta, 0.0, math.sqrt(2.0), False, NOTHING).cost == math.inf


def test_robot_may_leave_inscribed_cells_but_not_reenter_them():
    costs = np.array([[253, 253, 0, 0, 253, 0], [254, 0, 0, 0, 0, 0]], np.uint8)
    surface = flat_surface(costs)._replace(x=0.5, y=0.5, escape=3.0)
    east, north = 0.0, math.pi / 2
    assert math.isfinite(drive(surface, 0.5, 0.5, east, 0.0, 3.0, True, NOTHING).cost)
    assert not drive(surface, 0.5, 0.5, east, 0.0, 3.0, True, NOTHING).leaving
    assert drive(surface, 0.5, 0.5, east, 0.0, 1.0, True, NOTHING).leaving
    assert drive(surface, 0.5, 0.5, east, 0.0, 4.5, True, NOTHING).cost == math.inf
    assert drive(surface, 0.5, 0.5, north, 0.0, 1.0, True, NOTHING).cost == math.inf
    assert drive(surface, 0.5, 0.5, east, 0.0, 3.0, False, NOTHING).cost == math.inf
    assert drive(surface._replace(escape=0.5), 0.5, 0.5, east, 0.0, 3.0, True, NOTHING).cost == math.inf
