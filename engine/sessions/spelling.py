"""Spelling of messages for a client, by the type that it named in its subscription."""

from collections.abc import Callable

from engine.sessions.place.place import Place
from ppaas.clock import epoch
from ppaas.messages.geometry_msgs import Twist
from ppaas.nodes.topics import policy_of
from ppaas.wire.names import ros2_spelling
from ppaas.wire.rosbridge import Respell
from ppaas.wire.stamped_twists import TWIST_STAMPED, stamping


def spelling_at(place: Place) -> Callable[[str, str | None], Respell | None]:
    """Return the function that returns, for a topic of a place and a type, what spells its messages for a client.

    Velocities of the clone get a header for a client that names them ``geometry_msgs/TwistStamped``.
    """

    def spelling_of(topic: str, kind: str | None) -> Respell | None:
        respell = ros2_spelling(kind)
        if policy_of(topic).type is not Twist or (kind or "").replace("/msg/", "/", 1) != TWIST_STAMPED:
            return respell
        stamp = stamping(place.base_frame, epoch)
        return stamp if respell is None else lambda twist: respell(stamp(twist))

    return spelling_of
