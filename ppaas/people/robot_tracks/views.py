"""Views of a robot's detectors: whether a place is in one, and whether somebody stands before it."""

import math

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.people_coordination import SensorView

EDGE = 0.1
"""Margin inside the limits of a view, in which people are missed more often [rad, m]."""

BODY = 0.25
"""Half the width of a person who hides another [m]."""


def sees(view: SensorView, robot: Pose2D, x: float, y: float) -> bool:
    """Return whether a point [m] is inside a view, off its edges.

    Parameters
    ----------
    view : SensorView
    robot : Pose2D
        Pose of the robot, in the frame of the point.
    x, y : float
        The point.
    """
    away, bearing = _from(view, robot, x, y)
    wide = view.field_of_view >= 2.0 * math.pi - EDGE or abs(bearing) <= 0.5 * view.field_of_view - EDGE
    return wide and view.range_min + EDGE <= away <= view.range_max - EDGE


def hides(view: SensorView, robot: Pose2D, nearer: tuple[float, float], x: float, y: float) -> bool:
    """Return whether a person at one point hides another from a sensor."""
    away, bearing = _from(view, robot, x, y)
    near, other = _from(view, robot, *nearer)
    return near < away - BODY and abs(wrap_angle(bearing - other)) < math.atan2(BODY, max(near, BODY))


def _from(view: SensorView, robot: Pose2D, x: float, y: float) -> tuple[float, float]:
    """Return the distance of a point from a sensor [m], and its bearing from the axis of the sensor [rad]."""
    sensor = robot @ Pose2D(view.x, view.y, view.yaw)
    off = math.atan2(y - sensor.y, x - sensor.x)
    return math.hypot(x - sensor.x, y - sensor.y), wrap_angle(off - sensor.theta)
