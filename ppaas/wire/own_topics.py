"""Topics that the cloud itself publishes to the clients of a robot, whatever its clone publishes."""

from ppaas.errors import NotPermitted
from ppaas.messages import type_name
from ppaas.messages.base.std_msgs import Bool, Header

HEARTBEAT = "ppaas/heartbeat"
"""Messages once a second, by which a client knows that its connection is alive."""

PRESENCE = "ppaas/robot_connected"
"""Whether the robot itself is connected; latched."""

OWN_TOPICS = {HEARTBEAT: type_name(Header), PRESENCE: type_name(Bool)}
"""Their types."""


def check_not_own(topic: str) -> None:
    """Raise unless clients may publish a topic.

    Raises
    ------
    NotPermitted
        The cloud itself publishes it.
    """
    if topic in OWN_TOPICS:
        raise NotPermitted(f"only the cloud publishes {topic!r}")
