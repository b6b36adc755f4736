import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping import map_drawing
from ppaas.mapping.kernels import occupancy as kernels
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.map_drawing import DrawingSettings, bounds, count_beams, draw_map
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo
from tests.reference.mapping import scans as twin
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, scan_at

POSES = np.array([(x, y, x + y) for x in np.arange(-3.0, 3.5, 0.5) for y in (-2.0, -1.0, 0.0, 0.7)])


@pytest.fixture(scope="module")
def frames():
    frames = KeyFrames(ALL_ROUND)
    for number, pose in enumerate(POSES):
        frames.add(scan_at(pose, ALL_ROUND, noise=0.005, seed=number), number, Pose2D(*pose), np.zeros(6))
    return frames


def test_walls_are_occupied_and_the_inside_is_free(frames):
    grid = draw_map(frames, POSES)
    info = grid.info
    rows, columns = np.nonzero(grid.data == OCCUPIED)
    x, y = info.origin.x + (columns + 0.5) * info.resolution, info.origin.y + (rows + 0.5) * info.resolution
    near = np.minimum.reduce([np.abs(x + 4.0), np.abs(x - 4.0), np.abs(x - 6.0), np.abs(y + 3.0), np.abs(y - 3.0)])
    near = np.minimum(near, np.minimum(np.abs(y - 1.0), np.maximum(np.abs(x + 0.5) - 0.5, np.abs(y - 1.75) - 0.25)))
    assert near.max() < 0.06
    assert len(rows) > 0.8 * 32.0 / info.resolution
    inside = grid.data[int((-2.5 - info.origin.y) / 0.05) : int((0.8 - info.origin.y) / 0.05)]
    inside = inside[:, int((-3.8 - info.origin.x) / 0.05) : int((3.8 - info.origin.x) / 0.05)]
    assert (inside == FREE).mean() > 0.99
    assert (grid.data[[0, -1]] == UNKNOWN).all()


def test_person_who_left_leaves_no_trace(frames):
    passing = KeyFrames(ALL_ROUND)
    for number, pose in enumerate(POSES):
        scan = frames.scan_points(number)
        points = scan.points.copy()
        if number == 20:
            points[100:110] *= 0.5
        passing.add(scan._replace(points=points), number, Pose2D(*pose), np.zeros(6))
    grid, same = draw_map(passing, POSES), draw_map(frames, POSES)
    assert ((grid.data == OCCUPIED) != (same.data == OCCUPIED)).sum() <= 3


def test_cells_seen_by_too_few_beams_are_unknown(frames):
    least, many = (draw_map(frames, POSES, DrawingSettings(min_pass_through=n)).data for n in (1, 200))
    assert (many == UNKNOWN).sum() > (least == UNKNOWN).sum()


def test_map_of_too_many_cells_is_refused(frames, monkeypatch):
    monkeypatch.setattr(map_drawing, "MOST_CELLS", 1000)
    with pytest.raises(QuotaExceeded, match="coarser resolution"):
        draw_map(frames, POSES)


def test_a_beam_without_a_reading_is_free_up_to_its_point() -> None:
    info = GridInfo(0.1, 40, 5, Pose2D(-0.55, -0.25, 0.0))
    poses, points = np.zeros((2, 3)), np.zeros((2, 3, 2), np.float32)
    points[0, 0], points[1, 1], points[1, 2] = (1.0, 0.0), (2.0, 0.0), (0.5, 0.0)
    valid = np.array([[False, False, False], [False, False, True]])
    ended, passed = np.zeros(info.shape, np.uint16), np.zeros(info.shape, np.uint16)
    passed[2, 6] = 65535
    count_beams((ended, passed), info, poses, points, valid)
    assert np.argwhere(ended).tolist() == [[2, 10]]
    expected = np.zeros(40, int)
    expected[5:15] += 1
    expected[5:25] += 1
    expected[5:10] += 1
    expected[6] = 65535
    assert passed[2].tolist() == expected.tolist()
    assert passed.sum() == expected.sum()
    assert bounds(poses, points, valid) == (0.0, 0.0, 2.0, 0.0)


@settings(max_examples=examples(15))
@given(st.integers(0, 2**32 - 1))
def test_counts_agree_with_the_twin(seed):
    rng = np.random.default_rng(seed)
    poses = rng.uniform(-1.0, 1.0, (2, 3))
    points, valid = rng.uniform(-1.4, 1.4, (2, 12, 2)).astype(np.float32), rng.random((2, 12)) < 0.8
    ended, passed = np.zeros((80, 90), np.uint16), np.zeros((80, 90), np.uint16)
    kernels.count_beams(ended, passed, -4.0, -3.9, 0.1, poses, points, valid)
    ends, passes = twin.count_beams(ended.shape, -4.0, -3.9, 0.1, poses, points, valid)
    assert (ended != ends).sum() <= 2  # an end on the edge of a cell
    # Samples of the twin may miss corners of cells.
    assert (passed != passes).sum() <= 0.03 * passes.sum() + 3
    assert ended.sum() == valid.sum()


def test_counts_do_not_overflow():
    poses, points = np.zeros((70_000, 3)), np.full((70_000, 1, 2), 0.25, np.float32)
    ended, passed = np.zeros((2, 2), np.uint16), np.zeros((2, 2), np.uint16)
    kernels.count_beams(ended, passed, -0.05, -0.05, 0.2, poses, points, np.ones((70_000, 1), np.bool_))
    assert ended[1, 1] == passed[0, 0] == 65535
    assert ended.astype(int).sum() == 65535


def test_bounds_contain_poses_and_points():
    poses, points = np.array([(1.0, 2.0, np.pi / 2.0)]), np.array([[(3.0, 0.0), (99.0, 0.0)]], np.float32)
    found = kernels.bounds(poses, points, np.array([[True, False]]))
    np.testing.assert_allclose(found, (1.0, 2.0, 1.0, 5.0), atol=1e-12)
