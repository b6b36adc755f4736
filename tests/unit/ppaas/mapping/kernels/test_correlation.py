import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.kernels import correlation as kernels
from tests.reference.mapping import scans

seeds = st.integers(0, 2**32 - 1)
BLUR = np.array([(90, 150, 90), (150, 255, 150), (90, 150, 90)], np.uint8)


def frames(rng):
    points = rng.uniform(-3.0, 3.0, (3, 20, 2)).astype(np.float32)
    return rng.uniform(-1.0, 1.0, (3, 3)), points, rng.random((3, 20)) < 0.8


@given(seeds)
def test_grid_agrees_with_the_twin(seed):
    poses, points, valid = frames(np.random.default_rng(seed))
    grid = np.full((50, 60), 7, np.uint8)
    no_normals = np.zeros_like(points)
    kernels.draw(grid, -2.5, -2.0, 0.1, BLUR, np.array([2, 0]), poses[:2], points, no_normals, valid)
    expected = scans.draw(grid.shape, -2.5, -2.0, 0.1, BLUR, poses[:2], points[[2, 0]], valid[[2, 0]])
    assert (grid != expected).mean() < 0.01  # points on the edge of a cell may be rounded to either side


def test_points_on_one_line_are_joined_and_others_are_not():
    points = np.array([[(-1.0, 1.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.5)]], np.float32)
    normals = np.array([[(0.0, -1.0), (0.0, -1.0), (0.0, -1.0), (-1.0, 0.0)]], np.float32)
    grid = np.zeros((40, 40), np.uint8)
    for valid, columns in (((True, True, True, True), range(10, 31)), ((True, False, True, True), (10, 30))):
        kernels.draw(
            grid, -2.05, -2.05, 0.1, np.array([[255]], np.uint8), np.zeros(1, np.int64), np.zeros((1, 3)),
            points, normals, np.array([valid]),
        )  # fmt: skip
        np.testing.assert_array_equal(np.flatnonzero(grid[30]), columns)
        assert np.count_nonzero(grid) == len(columns) + 1


@given(seeds)
def test_search_returns_the_best_pose_of_the_window(seed):
    rng = np.random.default_rng(seed)
    grid = rng.integers(0, 255, (50, 60)).astype(np.uint8)
    points, valid = rng.uniform(-2.0, 2.0, (30, 2)).astype(np.float32), rng.random(30) < 0.8
    start = rng.uniform(-0.5, 0.5, 3)
    pose, score = kernels.search(grid, -2.5, -2.0, 0.1, points, valid, 3, start, 2, 3, 0.05)
    used = points[::3][valid[::3]]

    def rated(u, v, a):
        at = start + np.array((u * 0.1, v * 0.1, a * 0.05))
        found = scans.score(grid, -2.5, -2.0, 0.1, used, at) if len(used) else 0.0
        return found * (1.0 - 0.05 * ((u * u + v * v) / 5.0 + a * a / 10.0)), found

    steps = [(u, v, a) for a in range(-3, 4) for v in range(-2, 3) for u in range(-2, 3)]
    best = max(rated(*step)[0] for step in steps)
    chosen = np.round((pose - start) / (0.1, 0.1, 0.05)).astype(int)
    # A cell of difference where rounding decides.
    assert rated(*chosen)[0] >= best - 1.0 / max(len(used), 1)
    assert abs(score - rated(*chosen)[1]) <= 1.0 / max(len(used), 1)
