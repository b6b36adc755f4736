"""Node ``waypoint_follower`` of a robot that makes its map."""

from typing import ClassVar

from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.waypoint_follower.node import WaypointFollowerNode, WaypointFollowerParameters


class MappingWaypointFollowerNode(WaypointFollowerNode):
    """Waypoint follower of a robot that makes its map: waypoints move with the key frames that are nearest to them.

    Move Base moves the waypoint that the robot drives to, once the map shows the moved key frames.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : WaypointFollowerParameters
        Named as in Nav2.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*WaypointFollowerNode.subscribes, topics.KEY_FRAMES)

    def __init__(self, context: Context, parameters: WaypointFollowerParameters) -> None:
        super().__init__(context, parameters)
        self._key_frames = NO_KEY_FRAMES

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as the waypoint follower's method does."""
        if topic != topics.KEY_FRAMES.name:
            super().on_message(topic, message)
            return
        before, after = self._key_frames, key_frames_of(message)
        self._key_frames = after
        active = self._lists.active
        if active is not None and len(before) and len(after) and after.differs(before):
            active.goal.poses = [after.carry(pose, before) for pose in active.goal.poses]
