"""The other robots of a map: what they tell of themselves, believed as far as it can be."""

import math

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput, TransformError
from ppaas.messages.geometry_msgs import Pose, Twist
from ppaas.messages.ppaas_msgs import RobotState, RobotStates
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import finite_pose

OTHERS_MARGIN = 0.1
"""Added to the radius of another robot [m]: its position is that much in doubt, and it moves."""

FASTEST, LARGEST = 3.0, 2.0
"""No robot is believed to be faster [m/s] or to have a larger radius [m]: it may be anybody's."""


def checked_state(state: RobotState) -> RobotState:
    """Return what a robot tells of itself.

    Raises
    ------
    InvalidInput
        A number is not finite, the orientation is no quaternion, or the radius is negative.
    """
    mover_of(state.pose.pose, state.twist, state.radius)
    return state


def others_of(message: RobotStates, own_radius: float) -> tuple[MovingObstacle, ...]:
    """Return the other robots of a map, with a margin around each.

    Parameters
    ----------
    message : RobotStates
    own_radius : float
        Of those that do not say how large they are [m].

    Raises
    ------
    InvalidInput
        One is not finite, or the numbers of poses, twists and radii differ.
    TransformError
        They are in another frame than that of the map.
    """
    if message.header.frame_id.lstrip("/") != MAP:
        raise TransformError(f"the poses of robots are given in {MAP!r}, not in {message.header.frame_id!r}")
    count = len(message.poses)
    if len(message.twists) not in {0, count} or len(message.radii) not in {0, count}:
        raise InvalidInput(f"of {count} robots all twists and radii are told, or none")
    twists, radii = message.twists or [Twist()] * count, message.radii or [0.0] * count
    movers = map(mover_of, message.poses, twists, radii)
    return tuple(mover._replace(radius=(mover.radius or own_radius) + OTHERS_MARGIN) for mover in movers)


def mover_of(pose: Pose, twist: Twist, radius: float) -> MovingObstacle:
    """Return a robot by its pose, its velocity in its own frame, and its radius [m].

    Raises
    ------
    InvalidInput
        See `checked_state`.
    """
    x, y, theta = finite_pose(pose, "the pose of a robot")
    speed = twist.linear.x
    if not (math.isfinite(speed) and math.isfinite(radius) and radius >= 0.0):
        raise InvalidInput("the speed and the radius of a robot must be finite, and the radius not negative")
    speed = min(max(speed, -FASTEST), FASTEST)
    return MovingObstacle(x, y, speed * math.cos(theta), speed * math.sin(theta), min(radius, LARGEST))
