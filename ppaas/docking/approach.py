"""Velocities along the axis of a dock, and whether the way along it is free."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.parameters import Parameters, check_numbers

STEEPEST = 0.7
"""Largest angle to the axis at which a robot drives onto it [rad]."""


class DockControl(Parameters, frozen=True):
    """Parameters of the controller, named as in Nav2's docking server where it has them.

    Parameters
    ----------
    k_phi : float
        Angle to the axis at which the robot drives onto it, per metre beside it [rad/m].
    k_delta : float
        Turning speed per difference to that angle [1/s].
    v_linear_min, v_linear_max : float
        Speeds at the dock and far from it [m/s].
    v_angular_max : float
        Largest turning speed [rad/s].
    slowdown_radius : float
        Distance from the dock from which the robot slows down [m].
    """

    k_phi: float = 3.0
    k_delta: float = 2.0
    v_linear_min: float = 0.04
    v_linear_max: float = 0.15
    v_angular_max: float = 0.75
    slowdown_radius: float = 0.35

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=self.__struct_fields__)


def along_axis(place: Pose2D, control: DockControl, *, to: float, ahead: float = 1.0) -> Velocity:
    """Return the velocity with which a robot drives along the x axis of a frame, and onto it.

    Parameters
    ----------
    place : Pose2D
        Pose of the robot in the frame; heading 0 is along the axis, also for a robot that drives there backwards.
    control : DockControl
    to : float
        Where on the axis it drives to [m].
    ahead : float
        Sign of its velocity when it drives to greater x.
    """
    left = to - place.x
    way = math.copysign(1.0, left)
    slow = min(abs(left) / control.slowdown_radius, 1.0)
    speed = control.v_linear_min + slow * max(control.v_linear_max - control.v_linear_min, 0.0)
    onto_axis = -way * min(max(math.atan(control.k_phi * place.y), -STEEPEST), STEEPEST)
    off = wrap_angle(place.theta - onto_axis)
    angular = min(max(-control.k_delta * off, -control.v_angular_max), control.v_angular_max)
    # A robot that points elsewhere turns first.
    return Velocity(ahead * way * speed * max(math.cos(2.0 * min(abs(off), math.pi / 4.0)), 0.0), angular)


class BodyOutline(NamedTuple):
    """Extent of a robot from its origin [m]: to the front, to the back, to each side."""

    front: float
    back: float
    side: float


MARGIN = 0.05
"""Distance that a robot keeps from what is in its way [m]."""

REACTION = 0.3
"""Time from a command until the base obeys [s]."""


def is_in_way(points: NDArray[np.float64], body: BodyOutline, velocity: Velocity, braking: float) -> bool:
    """Return whether a robot would drive against one of the points before it can stand.

    Parameters
    ----------
    points : (n, 2) array
        In the frame of the robot [m].
    body : BodyOutline
    velocity : Velocity
    braking : float
        Deceleration [m/s²].
    """
    speed = abs(velocity.linear)
    if speed == 0.0 or not len(points):
        return False
    reach = speed * REACTION + speed * speed / (2.0 * braking) + MARGIN
    x = points[:, 0] if velocity.linear > 0.0 else -points[:, 0]
    nose = body.front if velocity.linear > 0.0 else body.back
    ahead = (x > 0.5 * nose) & (x <= nose + reach) & (np.abs(points[:, 1]) <= body.side)
    return bool(ahead.any())


def apart_from_dock(points: NDArray[np.float64], face: Pose2D, protrusion: float = 0.0) -> NDArray[np.float64]:
    """Return the points that do not belong to a dock: those before its face, which is in the frame of the points.

    ``protrusion`` is how far parts of the dock stand before its face [m].
    """
    depth = (points[:, 0] - face.x) * math.cos(face.theta) + (points[:, 1] - face.y) * math.sin(face.theta)
    return points[depth < -MARGIN - protrusion]
