"""The way of a robot that docks or undocks, as the traffic of its map learns of it, and whether it is granted."""

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import Path
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP

UNANSWERED = "the traffic of the map has not answered yet"


class DockWay:
    """Publishes the way, and keeps why the robot may not drive there.

    Parameters
    ----------
    context : Context
        Context of the node.
    granted : bool
        Whether the robot takes part in the traffic of its map, which grants its ways.

    Attributes
    ----------
    barred : str
        Why the robot may not drive on its way; empty if it may.
    """

    def __init__(self, context: Context, *, granted: bool) -> None:
        self.barred = ""
        self._context, self._granted = context, granted
        self._way: tuple[Pose2D, ...] = ()

    @property
    def is_driven(self) -> bool:
        """Whether there is a way, and the robot does not stand at its dock."""
        return len(self._way) > 1

    def say(self, way: tuple[Pose2D, ...]) -> None:
        """Publish a way in the frame of the map: both ends, the place of a robot that stands at a dock, or nothing."""
        if way == self._way:
            return
        self._way = way
        self.barred = UNANSWERED if self._granted and self.is_driven else ""
        header = Header(stamp=Time.of(self._context.now()), frame_id=MAP)
        poses = [PoseStamped(header, Pose.of(pose)) for pose in way]
        self._context.publish(topics.DOCK_WAY.name, Path(header, poses))

    def hear(self, why: str) -> None:
        """Take why the robot may not drive there; empty if it may."""
        self.barred = why if self.is_driven else ""
