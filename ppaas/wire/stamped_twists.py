"""Velocities with a header, for clients that name a topic of ``geometry_msgs/Twist`` as ``geometry_msgs/TwistStamped``.

Bases of Nav2 and ros2_control come to expect stamped velocities (``enable_stamped_cmd_vel``), while bases of ROS 1 and
most joysticks have plain ones. One robot may have clients of both kinds. So the type belongs to each subscription and
each advertisement, which name it anyway, and is no parameter of the robot.
"""

from collections.abc import Callable

from ppaas.clock import Clock
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import encode

TWIST = "geometry_msgs/Twist"
TWIST_STAMPED = "geometry_msgs/TwistStamped"


def may_be_named(kind: str, name: str) -> bool:
    """Return whether clients may name a topic of the clone of type ``kind`` by the type ``name``, both as in ROS 1."""
    return name == kind or (kind, name) == (TWIST, TWIST_STAMPED)


def stamping(frame: str, now: Clock) -> Callable[[bytes], bytes]:
    """Return what makes a Twist, as JSON, a TwistStamped in a frame, stamped with the time of the call.

    Parameters
    ----------
    frame : str
        Frame of the velocities: the robot's body.
    now : callable
        Returns the time since the epoch [s].
    """

    def stamp(twist: bytes) -> bytes:
        return b'{"header":%b,"twist":%b}' % (encode(Header(stamp=Time.of(now()), frame_id=frame)), twist)

    return stamp
