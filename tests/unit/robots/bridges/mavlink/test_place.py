"""Poses of a vehicle on the map, by known values."""

import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.georeference import GeoAnchor
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.place import VehiclePlace, body_velocity, enu_yaw
from robots.bridges.mavlink.vehicle import Vehicle

EAST, NORTH = 0.0, math.pi / 2.0
"""Angles of ROS."""


def vehicle() -> Vehicle:
    """Return a vehicle that was heard at 0 s."""
    made = Vehicle(1, 1, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    made.take(mavlink.MAVLink_heartbeat_message(10, 3, 1, 4, 4, 3), 0.0)
    return made


def attitude(heading: float, rate: float = 0.0) -> object:
    return mavlink.MAVLink_attitude_message(1000, 0.0, 0.0, heading, 0.0, 0.0, rate)


@pytest.mark.parametrize(
    ("heading", "yaw"), [(0.0, NORTH), (90.0, EAST), (180.0, -NORTH), (-90.0, -math.pi), (45.0, math.pi / 4.0)]
)
def test_headings_clockwise_from_north_become_angles_counter_clockwise_from_east(heading: float, yaw: float) -> None:
    assert enu_yaw(math.radians(heading)) == pytest.approx(yaw)


def test_velocities_of_the_earth_become_those_of_the_body() -> None:
    east = math.radians(90.0)
    assert body_velocity(0.0, 2.0, east) == pytest.approx((2.0, 0.0))
    assert body_velocity(1.0, 0.0, east) == pytest.approx((0.0, 1.0)), "north is to the left of one that looks east"
    assert body_velocity(0.0, 1.0, 0.0) == pytest.approx((0.0, -1.0))


def test_the_local_frame_has_its_x_to_the_east_on_the_map() -> None:
    here, place = vehicle(), VehiclePlace(None)
    assert "LOCAL_POSITION_NED" in place.why_lost(here, 0.1) or "ATTITUDE" in place.why_lost(here, 0.1)
    here.take(attitude(0.0, 0.3), 0.1)
    here.take(mavlink.MAVLink_local_position_ned_message(1000, 5.0, 2.0, -1.0, 0.7, 0.0, 0.0), 0.1)
    assert place.why_lost(here, 0.2) == ""
    motion = place.motion(here)
    assert motion is not None
    assert tuple(motion.pose) == pytest.approx((2.0, 5.0, NORTH))
    assert (motion.forward, motion.left, motion.turn) == pytest.approx((0.7, 0.0, -0.3), abs=1e-6)
    assert "ATTITUDE" in place.why_lost(here, 2.5)
    assert "no heartbeat" in place.why_lost(here, 4.5)


def test_odometry_stands_in_for_a_local_position() -> None:
    here, place = vehicle(), VehiclePlace(None)
    half = math.sqrt(0.5)
    odometry = mavlink.MAVLink_odometry_message(
        0, mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_FRD, 5.0, 2.0, 0.0, [half, 0.0, 0.0, half],
        1.5, 0.2, 0.0, 0.0, 0.0, 0.1, [math.nan] * 21, [math.nan] * 21,
    )  # fmt: skip
    here.take(odometry, 0.1)
    motion = place.motion(here)
    assert motion is not None
    assert tuple(motion.pose) == pytest.approx((2.0, 5.0, EAST), abs=1e-6)
    assert (motion.forward, motion.left, motion.turn) == pytest.approx((1.5, -0.2, -0.1))


def test_gps_is_on_the_map_by_the_anchor_whose_x_axis_may_point_anywhere() -> None:
    anchor = GeoAnchor(47.0, 8.0, math.radians(90.0))  # the map's x axis points north
    here, place = vehicle(), VehiclePlace(anchor)
    here.take(attitude(0.0), 0.1)
    assert "GLOBAL_POSITION_INT" in place.why_lost(here, 0.1)
    here.take(mavlink.MAVLink_gps_raw_int_message(0, 1, 0, 0, 0, 0, 0, 0, 0, 4), 0.1)
    assert "fix type 1" in place.why_lost(here, 0.1)
    here.take(mavlink.MAVLink_gps_raw_int_message(0, 3, 0, 0, 0, 0, 0, 0, 0, 9, 0, 1200), 0.1)
    assert here.deviation == pytest.approx(1.2)
    north = round(470_000_000 + 1e7 * 100.0 / 111_169.0)  # a degree of latitude is 111.169 km there
    here.take(mavlink.MAVLink_global_position_int_message(1000, north, 80_000_000, 0, 0, 50, 0, 0, 0), 0.1)
    assert place.why_lost(here, 0.2) == ""
    motion = place.motion(here)
    assert motion is not None
    assert (motion.pose.x, motion.pose.y) == pytest.approx((100.0, 0.0), abs=0.05)
    assert motion.pose.theta == pytest.approx(0.0)
    assert (motion.forward, motion.left) == pytest.approx((0.5, 0.0))


def test_a_position_that_is_none_does_not_count() -> None:
    here = vehicle()
    for latitude, longitude in ((0, 0), (2_000_000_000, 0), (0, 2_000_000_000)):
        here.take(mavlink.MAVLink_global_position_int_message(1000, latitude, longitude, 0, 0, 0, 0, 0, 0), 0.1)
    here.take(mavlink.MAVLink_local_position_ned_message(1000, math.nan, 0.0, 0.0, 0.0, 0.0, 0.0), 0.1)
    here.take(attitude(math.inf), 0.1)
    assert here.geo is here.local is here.yaw is None


def test_a_local_frame_that_began_again_is_nowhere_until_a_person_says_where() -> None:
    here, place = vehicle(), VehiclePlace(None)
    assert not place.set_pose(Pose2D(1.0, 1.0), here)
    here.take(attitude(math.radians(90.0)), 0.1)
    here.take(mavlink.MAVLink_local_position_ned_message(1000, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0), 0.1)
    place.restarted()
    assert "set its pose" in place.why_lost(here, 0.2)
    assert place.set_pose(Pose2D(10.0, 5.0, NORTH), here)
    assert place.why_lost(here, 0.2) == ""
    motion = place.motion(here)
    assert motion is not None and tuple(motion.pose) == pytest.approx((10.0, 5.0, NORTH))
    here.take(mavlink.MAVLink_local_position_ned_message(1100, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0), 0.3)
    motion = place.motion(here)
    assert motion is not None and tuple(motion.pose) == pytest.approx((10.0, 6.0, NORTH))
    assert not VehiclePlace(GeoAnchor(47.0, 8.0)).set_pose(Pose2D(0.0, 0.0), here)
