"""Other robots on the map: checks and limits the states that they report."""

import math
from collections.abc import Sequence

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput, TransformError
from ppaas.messages.geometry_msgs import Pose, Twist
from ppaas.messages.ppaas_msgs import RobotState, RobotStates
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import finite_pose

OTHERS_MARGIN = 0.1
"""Margin added to the radius of another robot, for its motion and the error of its position [m]."""

OTHERS_FRESH = 1.0
"""Age up to which reported positions are used [s]; the robots may be anywhere then."""

FASTEST, LARGEST = 3.0, 2.0
"""Limits of the reported speed [m/s] and radius [m], since other users' robots may report anything."""


def checked_state(state: RobotState) -> RobotState:
    """Return the state that a robot reports, if it is valid.

    Raises
    ------
    InvalidInput
        A number is not finite, the orientation is not a quaternion, or the radius is negative.
    """
    mover_of(state.pose.pose, state.twist, state.radius)
    return state


def others_of(message: RobotStates, own_radius: float) -> tuple[MovingObstacle, ...]:
    """Return the other robots on the map, with a margin around each.

    Parameters
    ----------
    message : RobotStates
    own_radius : float
        Radius of robots that do not report one [m].

    Raises
    ------
    InvalidInput
        A number is not finite, or the numbers of poses, twists and radii differ.
    TransformError
        The frame is not the map frame.
    """
    if message.header.frame_id.lstrip("/") != MAP:
        raise TransformError(f"poses of robots must be in frame {MAP!r}, not {message.header.frame_id!r}")
    count = len(message.poses)
    if any(len(each) not in {0, count} for each in _lists(message)):
        raise InvalidInput(f"twists, radii, granted and names must be empty or have one entry per pose ({count})")
    twists, radii = message.twists or [Twist()] * count, message.radii or [0.0] * count
    movers = map(mover_of, message.poses, twists, radii)
    return tuple(mover._replace(radius=(mover.radius or own_radius) + OTHERS_MARGIN) for mover in movers)


def _lists(message: RobotStates) -> tuple[Sequence[object], ...]:
    return message.twists, message.radii, message.granted, message.names


def mover_of(pose: Pose, twist: Twist, radius: float) -> MovingObstacle:
    """Return a robot as a moving obstacle, from its pose, its velocity in its own frame, and its radius [m].

    Raises
    ------
    InvalidInput
        See `checked_state`.
    """
    x, y, theta = finite_pose(pose, "the pose of a robot")
    speed = twist.linear.x
    if not (math.isfinite(speed) and math.isfinite(radius) and radius >= 0.0):
        raise InvalidInput("the speed and radius of a robot must be finite, and the radius at least 0")
    speed = min(max(speed, -FASTEST), FASTEST)
    return MovingObstacle(x, y, speed * math.cos(theta), speed * math.sin(theta), min(radius, LARGEST))
