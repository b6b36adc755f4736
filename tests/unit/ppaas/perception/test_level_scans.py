"""Scans of lasers that hang upside down or are tilted.

The mounts found on real robots: upside down by roll, by pitch, with any yaw; tilted a little by a crooked mount or a
sloping hull; tilted a lot to see the floor; upright, to see a wall from floor to ceiling.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.localization.beams import scan_points
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.level_scans import level_scan
from ppaas.robot_model.shapes import placed
from ppaas.transforms.spatial import Rigid

ROOM = 3.0
"""Half the side of a square room around the robot [m]."""


def in_room(mount: Rigid, beams: int = 720, height: float = 100.0) -> LaserScan:
    """Return what a laser sees in a square room of tall walls with a floor at z = 0."""
    angles = -math.pi + 2.0 * math.pi / beams * np.arange(beams)
    ranges = []
    for angle in angles.tolist():
        far = mount @ Rigid(math.cos(angle), math.sin(angle))
        direction = np.array(far[:3]) - np.array(mount[:3])
        to_wall = [
            (math.copysign(ROOM, step) - at) / step for step, at in zip(direction[:2], mount[:2], strict=True) if step
        ]
        to_floor = -mount.z / direction[2] if direction[2] < -1e-9 else math.inf
        ranges.append(min(*to_wall, to_floor))
    return LaserScan(
        Header(frame_id="laser"), -math.pi, angles[-1], 2.0 * math.pi / beams, 0.05, height, [float(r) for r in ranges]
    )


def points_of(scan: LaserScan, mount: Rigid, ground: float = 0.0):
    leveled, laser = level_scan(scan, mount, ground)
    return scan_points(leveled, laser)


def off_the_walls(points) -> float:
    """Return the largest distance of a point from the walls of the room [m]."""
    return float(np.abs(np.abs(points).max(axis=1) - ROOM).max())


def test_scan_of_a_level_laser_is_unchanged():
    mount = placed((0.2, 0.1, 0.3), (0.0, 0.0, 0.7))
    scan = in_room(mount)
    leveled, laser = level_scan(scan, mount)
    assert leveled is scan
    assert laser == pytest.approx((0.2, 0.1, 0.7))


@given(st.sampled_from([(math.pi, 0.0), (-math.pi, 0.0), (0.0, math.pi), (3.14, 0.01)]), st.floats(-3.0, 3.0))
def test_scan_of_a_laser_upside_down_is_mirrored(roll_and_pitch, yaw):
    mount = placed((0.3, -0.5, 0.3), (*roll_and_pitch, yaw))
    points = points_of(in_room(mount), mount)
    assert len(points) == 720
    assert off_the_walls(points) < 0.05
    # Not only on the walls: each point is where the beam of that number ended.
    truth = [(mount @ Rigid(r * math.cos(a), r * math.sin(a)))[:2] for r, a in beams_of(in_room(mount))]
    assert np.abs(points - np.array(truth)).max() < 0.05


def beams_of(scan: LaserScan):
    return [(r, scan.angle_min + i * scan.angle_increment) for i, r in enumerate(scan.ranges)]


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3.0, 3.0), st.booleans())
def test_beams_of_a_tilted_laser_are_projected_and_those_on_the_floor_dropped(roll, pitch, yaw, flipped):
    mount = placed((0.3, -0.5, 0.4), (roll + math.pi * flipped, pitch, yaw))
    points = points_of(in_room(mount), mount)
    assert len(points) > 100
    assert off_the_walls(points) < 0.06


def test_floor_is_where_the_ground_of_the_robot_is():
    mount = placed((0.0, 0.0, 0.3), (0.0, 0.15, 0.0))
    lower = mount._replace(z=0.5)  # the same laser, by a robot whose base is 20 cm above the floor
    scan = in_room(lower)
    assert off_the_walls(points_of(scan, mount, ground=-0.2)) < 0.06


def test_beams_of_a_tilted_laser_without_an_echo_say_nothing():
    mount = placed((0.0, 0.0, 0.3), (0.0, 0.1, 0.0))
    scan = LaserScan(Header(frame_id="laser"), -1.0, 1.0, 0.5, 0.05, 8.0, [math.inf, None, 2.0, 0.0, 8.0])
    assert np.isnan(level_scan(scan, mount).scan.ranges).tolist() == [True, True, False, True, True]


def test_upright_laser_is_refused_with_its_name_and_tilt():
    mount = placed((0.0, 0.0, 0.3), (math.pi / 2.0, 0.0, 0.0))
    with pytest.raises(InvalidInput, match="'laser' is tilted by 90°"):
        level_scan(in_room(placed((0, 0, 0.3), (0, 0, 0))), mount)
