"""Simulated drives of the mapping bench."""

import itertools
import math

import numpy as np
import pytest

from benchmarks.mapping.laboratory import CORRIDOR, laboratory
from benchmarks.mapping.office import office, route
from benchmarks.mapping.simulated_drive import cast, drive, odometry, simulate
from benchmarks.mapping.worlds import HALF, OPEN, RECESS, corridor_route, corridors
from ppaas.geometry import Pose2D
from ppaas.planar_poses import relative

ROOM = np.array([(0.0, 0.0, 6.0, 0.0), (6.0, 0.0, 6.0, 4.0), (6.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0)])
SQUARE = np.array([(1.0, 1.0), (5.0, 1.0), (5.0, 3.0), (1.0, 3.0)])


def test_a_robot_visits_all_way_points_without_jumps():
    poses = drive(SQUARE)
    for point in SQUARE:
        assert np.hypot(*(poses[:, :2] - point).T).min() < 0.15
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= 0.025 + 1e-9


def test_scans_are_those_of_the_laser_on_the_robot():
    found = simulate(ROOM, SQUARE, 1, mount=Pose2D(0.3, 0.0))
    ahead = found.log.ranges[0, 90]
    assert ahead == pytest.approx(6.0 - 1.0 - 0.3, abs=0.03)
    assert found.log.geometry.mount == Pose2D(0.3, 0.0)
    assert 0.95 < np.isfinite(found.log.ranges).mean() < 1.0


def test_equal_seeds_give_equal_drives():
    one, same, other = (simulate(ROOM, SQUARE, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.log.ranges, same.log.ranges)
    np.testing.assert_array_equal(one.log.odometry, same.log.odometry)
    assert not np.array_equal(one.log.odometry, other.log.odometry)


def test_a_slow_laser_distorts_scans_while_the_robot_turns():
    fast, slow = (simulate(ROOM, SQUARE, 1, sweep=sweep) for sweep in (0.0, 0.1))
    turning = np.flatnonzero(np.abs(relative(fast.true[:-1], fast.true[1:])[:, 2]) > 0.1) + 1
    difference = np.abs(fast.log.ranges[turning] - slow.log.ranges[turning])
    assert np.nanmax(difference) > 0.05
    np.testing.assert_array_equal(fast.log.ranges[0], slow.log.ranges[0])


def test_odometry_drifts():
    true = drive(SQUARE)[::4]
    found = odometry(true, np.random.default_rng(1))
    steps, told = relative(true[:-1], true[1:]), relative(found[:-1], found[1:])
    assert 1.01 < told[:, 0].sum() / steps[:, 0].sum() < 1.03
    assert np.abs(told[:, 2] - steps[:, 2]).max() > 0.005


def test_the_office_has_a_closed_ring_and_its_route_touches_nothing():
    walls, points = office(0), route()
    assert len(points) > 60
    np.testing.assert_allclose(points[0], points[-1])
    begin, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    for point in drive(points)[::10, :2]:
        place = np.clip(((point - begin) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
        assert np.hypot(*(begin + place[:, None] * along - point).T).min() > 0.3


def distance_by_steps(walls, origin, angle):
    """Naive twin: follow the ray in steps of a millimetre until it is on the other side of a wall."""
    direction = np.array((math.cos(angle), math.sin(angle)))
    best = math.inf
    for x0, y0, x1, y1 in walls.tolist():
        matrix = np.array([direction, (x0 - x1, y0 - y1)]).T
        if abs(np.linalg.det(matrix)) > 1e-12:
            distance, place = np.linalg.solve(matrix, np.array((x0, y0)) - origin)
            if distance > 0.0 and 0.0 <= place <= 1.0:
                best = min(best, distance)
    return best


def test_rays_end_at_the_nearest_wall():
    random = np.random.default_rng(3)
    walls = random.uniform(-5.0, 5.0, (30, 4))
    origins, angles = random.uniform(-4.0, 4.0, (40, 2)), random.uniform(-math.pi, math.pi, 40)
    expected = [distance_by_steps(walls, origin, angle) for origin, angle in zip(origins, angles, strict=True)]
    np.testing.assert_allclose(cast(walls, origins, angles), expected)


def test_a_ray_along_a_wall_passes_it():
    walls = np.array([(1.0, 0.0, 2.0, 0.0), (3.0, -1.0, 3.0, 1.0)])
    origins = np.zeros((2, 2))
    np.testing.assert_allclose(cast(walls, origins, np.array((0.0, math.pi))), (3.0, math.inf))


def test_the_route_of_two_kilometres_stays_inside_the_corridors():
    walls, route = corridors(0), corridor_route()
    for (x0, y0), (x1, y1) in itertools.pairwise(route):
        length, heading = np.hypot(x1 - x0, y1 - y0), np.arctan2(y1 - y0, x1 - x0)
        assert cast(walls, np.array([(x0, y0)]), np.array([heading]))[0] > length
    assert 1800.0 < np.hypot(*np.diff(route, axis=0).T).sum() < 2200.0


def test_equal_corridors_look_alike_at_every_door_and_open_doors_are_deep():
    angles = np.linspace(-2.0, 2.0, 50)
    one, two = (cast(corridors(0, 0.0), np.full((50, 2), (x, 0.0)), angles).clip(max=4.0) for x in (31.8, 43.8))
    np.testing.assert_allclose(one, two, atol=1e-9)
    lowest = [corridors(0, share)[:, [1, 3]].min() for share in (0.0, 0.5)]
    np.testing.assert_allclose(lowest, [-HALF - RECESS, -HALF - OPEN])


@pytest.mark.parametrize("seed", [0, 1])
def test_the_route_enters_every_room_and_touches_nothing(seed):
    found = laboratory(seed)
    for (x0, y0), (x1, y1) in itertools.pairwise(found.route):
        length, heading = np.hypot(x1 - x0, y1 - y0), np.arctan2(y1 - y0, x1 - x0)
        if length > 0.0:
            assert cast(found.walls, np.array([(x0, y0)]), np.array([heading]))[0] > length
    begin, along = found.walls[:, :2], found.walls[:, 2:] - found.walls[:, :2]
    squared = np.maximum((along**2).sum(axis=1), 1e-9)
    for point in drive(found.route)[::20, :2]:
        place = np.clip(((point - begin) * along).sum(axis=1) / squared, 0.0, 1.0)
        assert np.hypot(*(begin + place[:, None] * along - point).T).min() > 0.25


def test_laboratories_differ_in_their_rooms_and_are_half_a_kilometre_long():
    one, same, other = (laboratory(seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.walls, same.walls)
    assert one.walls.shape != other.walls.shape or not np.allclose(one.walls, other.walls)
    assert 400.0 < np.hypot(*np.diff(one.route, axis=0).T).sum() < 500.0
    assert one.walls[:, 0].min() < -CORRIDOR
