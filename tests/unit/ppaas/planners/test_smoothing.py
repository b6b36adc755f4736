"""A smoothed path turns less, keeps its ends, and enters no obstacle."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, NoValidPath, PlanCancelled
from ppaas.geometry import Pose2D, poses_along, yaw_of
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.planners import PlanRequest, create
from ppaas.planners.kernels.smoothing import relax
from ppaas.planners.smoothing import smooth_path
from ppaas.planners.weights import passable
from tests.reference.planners import path
from tests.support.world import grids


def bends(poses):
    """Return the turn of a path at each inner pose [rad]."""
    steps = np.diff(poses[:, :2], axis=0)
    return np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))


def assert_free(map_, poses, allow_unknown=True):
    """Assert that a hundred points of each step are free."""
    parts = np.linspace(0.0, 1.0, 101)[:, None]
    for begin, end in itertools.pairwise(poses[:, :2]):
        cells = map_.info.to_cells(begin + parts * (end - begin))
        assert passable(allow_unknown)[map_.data[tuple(cells.T)]].all()


@given(st.integers(0, 2**32 - 1), st.integers(2, 12), st.sampled_from([0.0, 0.1, 0.3, 2.0]))
def test_relaxed_points_agree_with_the_twin(seed, count, even):
    rng = np.random.default_rng(seed)
    points, near = rng.normal(size=(count, 2)), rng.choice([0.1, 0.2, 3.0, np.inf], count)
    near[[0, -1]] = np.inf
    found = np.empty_like(points)
    relax(points, near, even, found)
    np.testing.assert_allclose(found, path.relax(points.tolist(), near.tolist(), even, rounds=200), atol=1e-6)


@given(grids.cost_arrays(10), st.data(), st.booleans(), st.sampled_from([(0.2, 0.3), (0.0, 1.0), (0.01, 5.0)]))
def test_smoothed_path_keeps_its_ends_and_stays_free(costs, data, allow_unknown, weights):
    free = np.argwhere(passable(allow_unknown)[costs]).tolist()
    assume(free)
    map_ = grids.of(costs, 0.1, Pose2D(1.0, -2.0, 0.7))
    ends = [grids.centre(map_, *data.draw(st.sampled_from(free))) for _ in range(2)]
    try:
        poses = create("dijkstra", allow_unknown=allow_unknown).plan(map_, PlanRequest(*ends)).poses
    except NoValidPath:
        assume(False)
    w_data, w_smooth = weights
    smooth = smooth_path(map_, poses, w_data=w_data, w_smooth=w_smooth, allow_unknown=allow_unknown)
    assert smooth.shape == poses.shape
    assert np.array_equal(smooth[[0, -1]], poses[[0, -1]])
    assert_free(map_, smooth, allow_unknown)


def test_smoothed_real_path_turns_less_and_is_shorter(data):
    file = data / "movingai" / "dao" / "arena2.map"
    map_ = grids.of(np.where(parse_map(file.read_bytes()).data == 0, 0, 254).astype(np.uint8), 0.05)
    queries = parse_scenario(file.with_suffix(".map.scen").read_bytes())
    for at in (-1, -200, -400):
        request = PlanRequest(grids.centre(map_, *queries.starts[at]), grids.centre(map_, *queries.goals[at]))
        path, smooth = (create("dijkstra", smooth=on).plan(map_, request) for on in (False, True))
        assert np.array_equal(path.cells, smooth.cells)
        assert smooth.cost == path.cost
        assert smooth.length < path.length
        assert bends(smooth.poses).max() < bends(path.poses).max()
        assert bends(smooth.poses).sum() <= bends(path.poses).sum() + 1e-6
        assert_free(map_, smooth.poses)


def test_bend_in_free_space_is_cut_with_headings_along_the_path():
    map_ = grids.of(np.zeros((9, 9), np.uint8))
    corner = [(1.5, 1.5 + i) for i in range(6)] + [(1.5 + i, 6.5) for i in range(1, 6)]
    poses = poses_along(np.array(corner), 2.0)
    poses[0, 3:] = 0.0, 0.0, 1.0, 0.0
    poses[:, 2] = 0.25
    smooth = smooth_path(map_, poses)
    assert math.dist(smooth[5, :2], (1.5, 6.5)) > 0.2
    assert yaw_of(*smooth[5, 3:]) == pytest.approx(math.atan2(*(smooth[6, :2] - smooth[5, :2])[::-1]))
    assert np.array_equal(smooth[[0, -1]], poses[[0, -1]])
    assert (smooth[:, 2] == 0.25).all()


def test_only_poses_near_an_obstacle_are_moved_back():
    costs = np.zeros((12, 40), np.uint8)
    costs[:6, 8] = 254
    map_ = grids.of(costs)
    path = create("dijkstra").plan(map_, PlanRequest(Pose2D(1.5, 0.5), Pose2D(38.5, 0.5))).poses
    smooth = smooth_path(map_, path, w_data=0.2, w_smooth=1.0)
    assert_free(map_, smooth)
    unobstructed = smooth_path(grids.of(np.zeros_like(costs)), path, w_data=0.2, w_smooth=1.0)
    apart = np.hypot(*(smooth - unobstructed)[:, :2].T)
    away = np.hypot(path[:, 0] - 8.5, path[:, 1] - 6.5)
    assert apart[away < 2.0].max() > 0.05
    assert apart[away > 9.0].max() < 0.01
    assert np.hypot(*(smooth - path)[:, :2].T)[away > 9.0].max() > 0.1


def test_a_path_that_is_not_free_is_unchanged():
    map_ = grids.costmap("#iii....\n" * 3, resolution=0.1)
    result = create("dijkstra", smooth=True).plan(map_, PlanRequest(grids.centre(map_, 1, 1), grids.centre(map_, 2, 7)))
    straight = create("dijkstra").plan(map_, PlanRequest(grids.centre(map_, 1, 1), grids.centre(map_, 2, 7)))
    assert np.array_equal(result.poses[:3, :2], straight.poses[:3, :2])


def test_poses_far_apart_are_unchanged():
    map_ = grids.of(np.zeros((9, 9), np.uint8))
    poses = poses_along(np.array([(1.5, 1.5), (4.5, 4.5), (1.5, 7.5)]))
    assert np.array_equal(smooth_path(map_, poses)[:, :2], poses[:, :2])


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_path_without_inner_poses_is_unchanged(count):
    poses = poses_along(np.array([(1.5, 1.5), (2.5, 2.5)])[:count])
    smooth = smooth_path(grids.of(np.zeros((9, 9), np.uint8)), poses)
    assert np.array_equal(smooth, poses)
    assert smooth is not poses


@pytest.mark.parametrize("weights", [(0.0, 0.0), (-0.1, 0.3), (0.2, -0.3), (math.nan, 1.0), (1.0, math.inf)])
def test_invalid_weights_are_refused(weights):
    poses = poses_along(np.array([(1.5, 1.5), (2.5, 2.5), (3.5, 3.5)]))
    with pytest.raises(InvalidInput, match="w_data and w_smooth"):
        smooth_path(grids.of(np.zeros((9, 9), np.uint8)), poses, w_data=weights[0], w_smooth=weights[1])


@pytest.mark.parametrize("poses", [np.zeros((4, 3)), np.zeros(7), np.full((3, 7), np.nan)])
def test_an_invalid_path_is_refused(poses):
    with pytest.raises(InvalidInput, match=r"\(n, 7\)"):
        smooth_path(grids.of(np.zeros((9, 9), np.uint8)), poses)


@pytest.mark.parametrize("name", ["dijkstra", "astar", "theta_star", "dstar_lite"])
def test_planners_smooth_on_request(name):
    map_ = grids.of(np.zeros((20, 30), np.uint8))
    map_.data[:15, 12] = 254
    request = PlanRequest(Pose2D(2.5, 2.5), Pose2D(27.5, 4.5))
    rough, smooth = (create(name, smooth=on).plan(map_, request) for on in (False, True))
    assert np.array_equal(rough.cells, smooth.cells)
    assert not np.array_equal(rough.poses, smooth.poses)
    assert smooth.length < rough.length
    assert np.array_equal(create(name).plan(map_, request).poses, rough.poses)


def test_smoothing_can_be_cancelled():
    def cancel():
        raise PlanCancelled("enough")

    poses = poses_along(np.array([(1.5, 1.5), (2.5, 2.5), (3.5, 3.5)]))
    with pytest.raises(PlanCancelled):
        smooth_path(grids.of(np.zeros((9, 9), np.uint8)), poses, check=cancel)
