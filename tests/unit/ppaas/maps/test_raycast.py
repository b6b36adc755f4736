"""Rays through a grid."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.kernels import raycast as kernels
from ppaas.maps.raycast import cast_rays
from tests.reference.maps import maps as twin
from tests.support.world.maps import occupied_arrays, poses

HAIR = 1e-5


@given(occupied_arrays(), poses(14.0), st.floats(0.0, 20.0))
def test_range_lies_between_those_to_grown_and_shrunk_cells(occupied, pose, far):
    """A ray that only grazes a corner may hit the cell or not; all others have one correct range."""
    (cast,) = kernels.cast_rays(occupied, pose.x, pose.y, np.array([pose.theta]), far)
    least = twin.cast(occupied, pose, far, HAIR)
    most = twin.cast(occupied, pose, far - 2 * HAIR, -HAIR)
    assert least - HAIR <= cast or cast == least
    assert cast <= most + 1e-3 or cast == most
    assert math.isinf(cast) or cast <= far


@pytest.mark.parametrize("heading", [math.pi / 4, 3 * math.pi / 4, -3 * math.pi / 4, -math.pi / 4])
@pytest.mark.parametrize("start", [10.0, 10.5, 10.1])
@pytest.mark.parametrize("steps", [0, 1, 3, 8])
def test_ray_does_not_pass_between_diagonal_cells(heading, start, steps):
    occupied = np.zeros((21, 21), np.uint8)
    direction = [1 if math.sin(heading) > 0 else -1, 1 if math.cos(heading) > 0 else -1]
    row, column = (math.floor(start + step * (steps + 0.3)) for step in direction)
    occupied[row, column] = 1
    assert kernels.cast_rays(occupied, start, start, np.array([heading]), 30.0)[0] < math.sqrt(2) * (steps + 0.31)


@pytest.mark.parametrize("seed", range(5))
def test_range_agrees_with_fine_steps(seed):
    rng = np.random.default_rng(seed)
    occupied = (rng.random((40, 30)) < 0.03).astype(np.uint8)
    x, y = rng.uniform(0, 30), rng.uniform(0, 40)
    angles = rng.uniform(-4, 4, 40)
    ranges = kernels.cast_rays(occupied, x, y, angles, 35.0)
    for angle, cast in zip(angles, ranges, strict=True):
        stepped = twin.stepped(occupied, Pose2D(x, y, angle), 35.0)
        # A step may jump over a corner, but never hits a cell that the ray misses.
        assert cast <= stepped
        if cast < stepped - 2e-3:
            assert twin.cast(occupied, Pose2D(x, y, angle), 35.0, -2e-3) >= stepped - 0.1


@given(occupied_arrays(), poses(), poses(), st.floats(0.01, 2.0))
def test_ranges_do_not_depend_on_the_pose_of_the_map(occupied, pose, origin, resolution):
    # Positions and angles at which rounding does not decide: not on edges of cells, axes or diagonals.
    pose = Pose2D(pose.x + 0.1234, pose.y + 0.2345, pose.theta + 0.0567)
    height, width = occupied.shape
    angles = np.linspace(-3.0, 3.0, 7)
    straight = cast_rays(occupied, GridInfo(1.0, width, height), pose, angles, 30.0)
    placed = origin @ Pose2D(pose.x * resolution, pose.y * resolution, pose.theta)
    turned = cast_rays(occupied, GridInfo(resolution, width, height, origin), placed, angles, 30.0 * resolution)
    np.testing.assert_allclose(turned / resolution, straight, atol=1e-5)


WALL = np.array([[0, 0, 0, 1]], np.uint8)
INFO = GridInfo(0.5, 4, 1)


@pytest.mark.parametrize(
    ("x", "theta", "far", "expected"),
    [
        (0.25, 0.0, 8.0, 1.25),
        (0.25, 0.0, 1.25, 1.25),
        (0.25, 0.0, 1.24, math.inf),
        (0.25, math.pi, 8.0, math.inf),
        (0.25, math.pi / 2, 8.0, math.inf),
        (1.75, 0.0, 8.0, 0.0),
        (-1.0, 0.0, 8.0, 2.5),
        (3.0, math.pi, 8.0, 1.0),
        (3.0, 0.0, 8.0, math.inf),
        (1.5, math.pi, 8.0, 0.0),
        (1.0, 0.0, 0.0, math.inf),
    ],
)
def test_ranges_match_hand_computed_values(x, theta, far, expected):
    (cast,) = cast_rays(WALL, INFO, Pose2D(x, 0.25, theta), [0.0], far)
    assert cast == pytest.approx(expected)


def test_angles_are_relative_to_the_heading_and_may_be_empty():
    assert cast_rays(WALL, INFO, Pose2D(0.25, 0.25, -1.0), [1.0], 8.0) == pytest.approx(1.25)
    assert cast_rays(WALL, INFO, Pose2D(0.25, 0.25), [], 8.0).size == 0


def test_bool_read_only_and_strided_arrays_are_accepted():
    occupied = np.zeros((8, 8), np.bool_)
    occupied[::2, 6] = True
    occupied.flags.writeable = False
    assert cast_rays(occupied[::2, ::2], GridInfo(1.0, 4, 4), Pose2D(0.5, 0.5), [0.0], 9.0) == pytest.approx(2.5)


@pytest.mark.parametrize("occupied", [np.zeros((4, 1), np.uint8), np.zeros((1, 4), np.int64)])
def test_cells_of_another_grid_are_refused(occupied):
    with pytest.raises(InvalidMap, match="expected"):
        cast_rays(occupied, INFO, Pose2D(0.0, 0.0), [0.0], 8.0)


@pytest.mark.parametrize(
    ("pose", "angles", "far"),
    [
        (Pose2D(math.nan, 0.0), [0.0], 8.0),
        (Pose2D(0.0, 0.0), [math.inf], 8.0),
        (Pose2D(0.0, 0.0), [[0.0]], 8.0),
        (Pose2D(0.0, 0.0), [0.0], math.inf),
        (Pose2D(0.0, 0.0), [0.0], -1.0),
    ],
)
def test_invalid_rays_are_refused(pose, angles, far):
    with pytest.raises(InvalidInput, match="finite"):
        cast_rays(WALL, INFO, pose, angles, far)


def test_very_distant_pose_has_infinite_range():
    assert math.isinf(cast_rays(WALL, INFO, Pose2D(1e300, -1e300, 0.3), [0.0], 1e300)[0])


def test_warm_calls_the_kernel():
    kernels.warm()
    assert kernels.cast_rays.nopython_signatures
