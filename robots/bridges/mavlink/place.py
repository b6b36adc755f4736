"""Place of a vehicle on the map: from north-east-down and degrees to the frames of ROS.

MAVLink's local frame points north, east and down, and a body's forward, right and down; ROS's point east, north and up,
and forward, left and up (REP-103). A heading of MAVLink is clockwise from north.
"""

import math
from dataclasses import dataclass

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.georeference import GeoAnchor
from robots.bridges.mavlink.vehicle import FIX_3D, Vehicle

FRESH = 1.0
"""Largest age of a position or a heading that is used [s]."""

SILENT = 3.0
"""Time without a heartbeat after which a vehicle is lost [s]."""


@dataclass(frozen=True, slots=True)
class VehicleMotion:
    """Pose on the map, and velocity of the body: forward, left [m/s], counter-clockwise [rad/s]."""

    pose: Pose2D
    forward: float
    left: float
    turn: float


def enu_yaw(heading: float) -> float:
    """Return the angle counter-clockwise from east of a heading clockwise from north [rad]."""
    return wrap_angle(0.5 * math.pi - heading)


def body_velocity(north: float, east: float, heading: float) -> tuple[float, float]:
    """Return the velocity forward and to the left of a body with a heading, from one to the north and the east."""
    c, s = math.cos(heading), math.sin(heading)
    return c * north + s * east, s * north - c * east


class VehiclePlace:
    """Place of a vehicle on the map: by its GPS and the anchor of the map, or by its local frame.

    Parameters
    ----------
    anchor : GeoAnchor or None
        Where the map is on the Earth; without it the vehicle's local frame is that of the map, with x to the east,
        until `set_pose`.
    """

    def __init__(self, anchor: GeoAnchor | None) -> None:
        self.anchor = anchor
        self._local = Pose2D(0.0, 0.0)
        self._lost_local = False

    def restarted(self) -> None:
        """Take it that the vehicle has restarted: its local frame begins where it now stands."""
        self._lost_local = self.anchor is None

    def set_pose(self, pose: Pose2D, vehicle: Vehicle) -> bool:
        """Place the local frame so that the vehicle is at a pose; return whether that was possible."""
        here = _local_pose(vehicle)
        if self.anchor is not None or here is None:
            return False
        self._local, self._lost_local = pose @ here.inverse(), False
        return True

    def why_lost(self, vehicle: Vehicle, now: float) -> str:
        """Return why the vehicle has no pose on the map at a time [s]; empty if it has one."""
        if (silence := now - vehicle.heard_at) > SILENT:
            return f"no heartbeat of the vehicle has come for {silence:.0f} s"
        if now - vehicle.yaw_at > FRESH:
            return "the vehicle sends no ATTITUDE"
        if self.anchor is not None:
            return _why_no_geo(vehicle, now)
        if vehicle.local is None or now - vehicle.local_at > FRESH:
            return "the vehicle sends no LOCAL_POSITION_NED; without GPS it needs another source of its position"
        if self._lost_local:
            return "the vehicle has restarted, and its local frame is elsewhere: set its pose, or give --anchor"
        return ""

    def motion(self, vehicle: Vehicle) -> VehicleMotion | None:
        """Return pose and velocity of the vehicle; None if a part of them has never come."""
        position = vehicle.local if self.anchor is None else vehicle.geo
        pose = self._pose(vehicle)
        if position is None or pose is None or vehicle.yaw is None:
            return None
        speeds = vehicle.local or position
        forward, left = body_velocity(speeds.north_speed, speeds.east_speed, vehicle.yaw)
        return VehicleMotion(pose, forward, left, -vehicle.yaw_rate)

    def _pose(self, vehicle: Vehicle) -> Pose2D | None:
        if self.anchor is None:
            here = _local_pose(vehicle)
            return None if here is None else self._local @ here
        if vehicle.geo is None or vehicle.yaw is None:
            return None
        x, y = self.anchor.to_map(vehicle.geo.latitude, vehicle.geo.longitude)
        return Pose2D(x, y, wrap_angle(enu_yaw(vehicle.yaw) - self.anchor.yaw))


def _local_pose(vehicle: Vehicle) -> Pose2D | None:
    if vehicle.local is None or vehicle.yaw is None:
        return None
    return Pose2D(vehicle.local.east, vehicle.local.north, enu_yaw(vehicle.yaw))


def _why_no_geo(vehicle: Vehicle, now: float) -> str:
    if 0 <= vehicle.fix < FIX_3D:
        return f"the vehicle's GPS has no fix in three dimensions (fix type {vehicle.fix})"
    if vehicle.geo is None or now - vehicle.geo_at > FRESH:
        return "the vehicle sends no GLOBAL_POSITION_INT with a position"
    return ""
