"""Moving objects in laser scans: detected, tracked, and reported with their velocities."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridMap
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.tracking import FORGET, HITS, MovingObjects, ObjectTracker
from ppaas.perception.unmapped_objects import LARGEST, UnmappedObject, unmapped_objects_in
from robots.sim.laser import Laser, LaserModel
from tests.support.world.rooms import room

GRID = room(10.0, 8.0)
LAYERS = build_layers(GRID, robot_radius=0.18)
MODEL = LaserModel()
PERIOD = 0.1
RADIUS = 0.25
HERE = Pose2D(5.0, 4.0, 0.7)


def reading(*people: tuple[float, float], pose: Pose2D = HERE, seed: int = 1) -> LaserReading:
    """Return a scan of people by a laser with noise."""
    laser = Laser(GRID.data >= 65, GRID.info, MODEL, np.random.default_rng(seed))
    ranges = laser.measure(pose, (np.array(people).reshape(-1, 2), RADIUS))
    return LaserReading(pose, MODEL.angles, ranges)


def walked(moving: MovingObjects, start: tuple[float, float], velocity: tuple[float, float], scans: int) -> None:
    """Feed scans of a walking person to a tracker, one every 0.1 s."""
    for scan in range(scans):
        seconds = scan * PERIOD
        x, y = start[0] + seconds * velocity[0], start[1] + seconds * velocity[1]
        moving.see(reading((x, y), seed=scan), seconds, seconds)


def test_mapped_room_has_no_unmapped_objects() -> None:
    assert unmapped_objects_in(reading(), LAYERS) == []


@given(st.floats(-math.pi, math.pi), st.floats(0.6, 2.8), st.floats(-math.pi, math.pi))
def test_person_is_located_from_any_side(bearing: float, away: float, heading: float) -> None:
    x, y = HERE.x + away * math.cos(bearing), HERE.y + away * math.sin(bearing)
    [thing] = unmapped_objects_in(reading((x, y), pose=Pose2D(HERE.x, HERE.y, heading)), LAYERS)
    assert math.hypot(thing.x - x, thing.y - y) < 0.12
    assert 0.1 < thing.radius < 0.35


def test_two_people_are_separated_and_long_objects_are_ignored() -> None:
    assert len(unmapped_objects_in(reading((6.5, 3.6), (6.5, 4.6)), LAYERS)) == 2
    wall = [(6.5, 3.0 + 0.1 * step) for step in range(round((LARGEST + 1.0) / 0.1))]
    assert unmapped_objects_in(reading(*wall), LAYERS) == []


def test_walls_that_are_not_mapped_yet_are_not_objects() -> None:
    half = GRID.data.copy()
    half[:, GRID.info.width // 2 :] = UNKNOWN
    layers = build_layers(GridMap(half, GRID.info), robot_radius=0.18)
    left, right = (3.6, 4.0), (6.4, 4.0)
    [thing] = unmapped_objects_in(reading(left, right), layers)
    assert math.hypot(thing.x - left[0], thing.y - left[1]) < 0.12


def test_beams_without_a_reading_are_not_objects() -> None:
    blind = LaserReading(HERE, MODEL.angles, np.full(MODEL.beams, math.nan))
    assert unmapped_objects_in(blind, LAYERS) == []


@pytest.mark.parametrize("range_min", [0.0, 0.05])
def test_nothing_stands_around_a_laser_that_says_0_where_it_sees_nothing(range_min) -> None:
    zeros = LaserScan(Header(), -3.14, 3.13, 0.0175, range_min, 8.0, [0.0] * 359)
    assert unmapped_objects_in(LaserReading.of(zeros, HERE), LAYERS) == []
    angles = np.linspace(-3.0, 3.0, 60)
    assert unmapped_objects_in(LaserReading(HERE, angles, np.zeros(60)), LAYERS) == []


@pytest.mark.parametrize("velocity", [(1.0, 0.0), (-0.6, 0.4), (0.0, 1.4)])
def test_a_walking_person_is_reported_with_position_and_velocity(velocity: tuple[float, float]) -> None:
    moving, start = MovingObjects(LAYERS), (5.5, 2.5)
    walked(moving, start, velocity, 15)
    last = 14 * PERIOD
    [mover] = moving.now(last)
    assert (mover.vx, mover.vy) == pytest.approx(velocity, abs=0.2)
    there = start[0] + last * velocity[0], start[1] + last * velocity[1]
    assert math.hypot(mover.x - there[0], mover.y - there[1]) < 0.15


def test_a_standing_person_does_not_move_despite_noise() -> None:
    moving = MovingObjects(LAYERS)
    walked(moving, (6.0, 3.0), (0.0, 0.0), 40)
    assert moving.now(4.0) == ()


def test_a_person_who_is_no_longer_seen_is_forgotten() -> None:
    moving = MovingObjects(LAYERS)
    walked(moving, (4.0, 2.5), (1.0, 0.0), 12)
    assert len(moving.now(1.1)) == 1
    assert moving.now(1.2 + FORGET) == (), "no scan came"
    for scan in range(12, 22):
        moving.see(reading(), scan * PERIOD, scan * PERIOD)
    assert moving.now(2.1) == ()


def test_a_scan_that_is_older_than_the_last_changes_nothing() -> None:
    tracker = ObjectTracker()
    for scan in range(2 * HITS):
        tracker.see([UnmappedObject(0.1 * scan, 0.0, 0.2)], scan * PERIOD)
    before = list(tracker.movers())
    tracker.see([UnmappedObject(5.0, 5.0, 0.2)], 0.0)
    assert list(tracker.movers()) == before
    assert len(before) == 1


@pytest.mark.parametrize("set_by", [-3600.0, -8.0, 8.0, 3600.0])
def test_a_person_is_tracked_after_the_clock_of_the_scans_was_set(set_by: float) -> None:
    moving = MovingObjects(LAYERS)
    walked(moving, (6.0, 3.0), (0.0, 0.8), HITS + 8)
    for scan in range(HITS + 8):
        seconds = 2.0 + scan * PERIOD
        moving.see(reading((6.0, 3.0 + 0.8 * scan * PERIOD), seed=scan), seconds + set_by, seconds)
    [mover] = moving.now(2.0 + (HITS + 7) * PERIOD)
    assert mover.vy == pytest.approx(0.8, abs=0.3)


def test_tracks_are_dropped_after_a_long_gap() -> None:
    tracker = ObjectTracker()
    for scan in range(2 * HITS):
        tracker.see([UnmappedObject(0.1 * scan, 0.0, 0.2)], scan * PERIOD)
    tracker.see([UnmappedObject(1.0, 0.0, 0.2)], 60.0)
    assert list(tracker.movers()) == []


def test_tracks_of_two_passing_people_are_not_swapped() -> None:
    tracker = ObjectTracker()
    for scan in range(20):
        tracker.see([UnmappedObject(0.1 * scan, 0.0, 0.2), UnmappedObject(2.0 - 0.1 * scan, 0.7, 0.2)], scan * PERIOD)
    velocities = sorted(round(mover.vx, 1) for mover in tracker.movers())
    assert velocities == [-1.0, 1.0]


def test_left_places_follow_a_walking_person_once_each() -> None:
    tracker, left = ObjectTracker(), []
    for scan in range(30):
        tracker.see([UnmappedObject(0.1 * scan, 0.0, 0.2)], scan * PERIOD)
        left += tracker.left()
    places = [x for x, _, _ in left]
    assert places == sorted(set(places))
    assert 0.0 < places[0] < 0.3
    assert 2.0 < places[-1] < 2.9 - 0.2 - 0.1
    assert np.diff(places).max() < 0.15


def test_a_standing_person_leaves_no_discs() -> None:
    tracker = ObjectTracker()
    for scan in range(20):
        tracker.see([UnmappedObject(1.0, 0.0, 0.2)], scan * PERIOD)
    assert tracker.left() == []
