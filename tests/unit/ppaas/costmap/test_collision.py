import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.collision import MOST_REACH, collides_along
from ppaas.costmap.volume import Box, Cylinder
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import poses_along, quaternion_of
from ppaas.maps.voxels import FREE, OCCUPIED, UNKNOWN
from tests.reference.maps import costmaps
from tests.support.world import voxels

TURTLEBOT = Cylinder(0.18, 0.42)
WITH_MAST = Cylinder(0.18, 1.2)


def pose(x, y, z=0.0, yaw=0.0):
    return [x, y, z, *quaternion_of(yaw)]


def path(*points):
    """Return the poses of a path in the plane."""
    return poses_along(np.array(points, float))


def table():
    """Return a room with a table: its top is at 0.7 m, and at scan height it has thin legs only."""
    scene = voxels.room()
    voxels.put(scene, (1.5, 0.8, 0.7), (2.5, 2.2, 0.8))
    for x in (1.5, 2.4):
        for y in (0.8, 2.1):
            voxels.put(scene, (x, y, 0.0), (x + 0.1, y + 0.1, 0.7))
    return scene


COORDINATES = st.floats(-0.3, 1.2)
VOLUMES = st.one_of(
    st.builds(Cylinder, st.floats(0.01, 0.4), st.floats(0.01, 0.8)),
    st.builds(Box, *[st.floats(0.01, 0.8)] * 3),
)


@given(voxels.grid_arrays(), VOLUMES, COORDINATES, COORDINATES, COORDINATES, st.floats(-4.0, 4.0))
def test_collision_agrees_with_the_twin(data, volume, x, y, z, yaw):
    grid = voxels.grid(data, 0.15)
    expected = {costmaps.hits(data, 0.15, volume, (x, y, z + lift, yaw)) for lift in (-1e-6, 0.0, 1e-6)}
    hit = collides_along(grid, volume, np.array([pose(x, y, z, yaw)])) == 0
    if not volume.half_length:
        slim = Cylinder(volume.radius - 1e-6, volume.height)
        expected.add(costmaps.hits(data, 0.15, slim, (x, y, z, yaw)))
    assert hit in expected


@given(st.builds(Box, *[st.floats(0.02, 0.4)] * 3), *[st.floats(-0.35, 0.5)] * 2, st.floats(-4.0, 4.0))
def test_collision_of_box_and_voxel_agrees_with_the_twin(box, x, y, yaw):
    data = np.full((1, 1, 1), OCCUPIED, np.uint8)
    sizes = [(box.length + more, box.width + more, 1.0) for more in (-1e-5, 0.0, 1e-5)]
    expected = {costmaps.overlaps(Box(*size), x, y, yaw, 0, 0, 0.15) for size in sizes}
    assert (collides_along(voxels.grid(data, 0.15), box, np.array([pose(x, y, 0.0, yaw)])) == 0) in expected


def test_only_a_low_robot_passes_under_a_table():
    under = path(*((x, 1.5) for x in np.arange(0.5, 3.5, 0.05)))
    assert collides_along(table(), TURTLEBOT, under) is None
    first = collides_along(table(), WITH_MAST, under)
    assert under[first, 0] == pytest.approx(1.5 - 0.18, abs=0.06)
    around = path(*((x, 0.4) for x in np.arange(0.5, 3.5, 0.05)))
    assert collides_along(table(), WITH_MAST, around) is None


def test_collisions_between_distant_poses_are_found():
    assert collides_along(table(), WITH_MAST, path((0.5, 1.5), (3.5, 1.5))) == 1
    assert collides_along(table(), TURTLEBOT, path((0.5, 1.5), (3.5, 1.5))) is None
    assert collides_along(table(), TURTLEBOT, path((0.5, 0.85), (3.5, 0.85), (3.5, 1.0))) == 1


def test_a_long_robot_passes_a_gap_ahead_but_cannot_turn_in_it():
    scene = voxels.room()
    voxels.put(scene, (1.0, 0.0, 0.0), (3.0, 1.2, 0.5))
    voxels.put(scene, (1.0, 1.8, 0.0), (3.0, 3.0, 0.5))
    robot = Box(1.0, 0.5, 0.4)
    ahead = np.array([pose(0.5, 1.5), pose(3.4, 1.5)])
    assert collides_along(scene, robot, ahead) is None
    turning = np.array([pose(0.5, 1.5), pose(2.0, 1.5), pose(2.0, 1.5, yaw=math.pi)])
    assert collides_along(scene, robot, turning) == 2
    assert collides_along(scene, robot, np.array([pose(2.0, 1.5, yaw=math.pi / 2)])) == 0


def test_touching_is_not_a_collision():
    scene = voxels.room()
    assert collides_along(scene, Cylinder(0.5, 2.0), np.array([pose(0.5, 0.5), pose(3.5, 2.5)])) is None
    assert collides_along(scene, Cylinder(0.501, 2.0), np.array([pose(0.5, 0.5)])) == 0
    assert collides_along(scene, Cylinder(0.5, 2.001), np.array([pose(0.5, 0.5)])) == 0
    assert collides_along(scene, Box(1.0, 1.0, 2.0), np.array([pose(0.5, 0.5)])) is None


@pytest.mark.parametrize("robot", [Cylinder(0.1, 0.2), Box(0.2, 0.2, 0.2)])
def test_unknown_and_outside_collide_only_if_not_allowed(robot):
    data = np.full((3, 5, 9), FREE, np.uint8)
    data[:, :, 6] = UNKNOWN
    scene = voxels.grid(data, 0.1)
    into = np.array([pose(0.2, 0.25), pose(0.4, 0.25), pose(0.55, 0.25)])
    for poses, index in ((into, 2), (np.array([pose(0.05, 0.25)]), 0), (np.array([pose(0.25, 0.25, 0.15)]), 0)):
        assert collides_along(scene, robot, poses) is None
        assert collides_along(scene, robot, poses, allow_unknown=False) == index


def test_empty_path_has_no_collision():
    assert collides_along(table(), TURTLEBOT, np.empty((0, 7))) is None


def test_quaternions_need_not_be_normalised():
    scene = voxels.grid(np.full((1, 1, 1), OCCUPIED, np.uint8), 0.1)
    long = np.array([[0.05, 0.4, 0.0, 0.0, 0.0, 3.0, 3.0]])
    assert collides_along(scene, Box(0.8, 0.1, 0.1), long) == 0
    assert collides_along(scene, Box(0.1, 0.8, 0.1), long) is None


@pytest.mark.parametrize(
    "poses",
    [
        np.zeros((2, 3)),
        np.zeros(7),
        np.array([[math.nan] * 7]),
        np.array([pose(1e300, 0.0)]),
        np.array([pose(0, 0), pose(1e6, 0)]),
    ],
)
def test_a_path_too_long_or_too_far_away_is_refused(poses):
    with pytest.raises(InvalidInput):
        collides_along(table(), TURTLEBOT, poses)


def test_a_robot_far_larger_than_the_voxels_is_refused():
    with pytest.raises(InvalidInput, match="coarser"):
        collides_along(table(), Cylinder(0.1 * MOST_REACH + 1.0, 1.0), path((1, 1), (2, 1)))


def test_swept_radius_reaches_the_corners_of_a_box():
    assert Box(0.6, 0.8, 1.0).swept_radius == pytest.approx(0.5)
    assert Cylinder(0.2, 1.0).swept_radius == 0.2


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf])
def test_invalid_sizes_are_refused(size):
    for kind, sizes in ((Cylinder, (0.2, size)), (Box, (size, 1, 1)), (Box, (1, size, 1)), (Box, (1, 1, size))):
        with pytest.raises(InvalidParameter, match="metres"):
            kind(*sizes)


@pytest.mark.parametrize("radius", [-0.1, math.nan, math.inf])
def test_radius_may_be_zero_but_not_negative(radius):
    assert Cylinder(0.0, 1.0).radius == 0.0
    with pytest.raises(InvalidParameter, match="radius"):
        Cylinder(radius, 1.0)
