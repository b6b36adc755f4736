"""Node ``move_base`` of a robot that makes its map."""

from typing import Any, ClassVar

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses
from ppaas.navigation import events
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.static_layer import StaticLayer

MOST_WAITING = 100
"""Largest number of messages with key frames that wait for a map."""


class MappingMoveBaseNode(MoveBaseNode):
    """Move Base of a robot that makes its map: the static layer is that of the topics ``map`` and ``map_updates``.

    A goal moves with the key frame that is nearest to it, as soon as the map is that of the moved key frames.

    Parameters
    ----------
    context : Context
        The node's context.
    options
        As of `MoveBaseNode`, with ``build``.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (
        *(topic for topic in MoveBaseNode.subscribes if topic is not topics.AMCL_STATUS),
        topics.GRID_SLAM_STATUS, topics.KEY_FRAMES, *StaticLayer.subscribes,
    )  # fmt: skip

    def __init__(self, context: Context, **options: Any) -> None:
        super().__init__(context, **options)
        self._drawn: KeyFramePoses = NO_KEY_FRAMES
        self._key_frames: list[tuple[float, KeyFramePoses]] = []
        self._has_jumped = False

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as that of Move Base does."""
        if topic == topics.KEY_FRAMES.name:
            self._take_key_frames(key_frames_of(message))
        elif self._static_layer is None or not self._static_layer.take(message):
            super().on_message(topic, message)

    def _take_key_frames(self, key_frames: KeyFramePoses) -> None:
        """Keep key frames until the map is drawn of them; if there are none, the map was cleared."""
        last = self._key_frames[-1][1] if self._key_frames else self._drawn
        self._key_frames = [*self._key_frames[-MOST_WAITING:], (self.context.elapsed(), key_frames)]
        if self._static_layer is None:
            return
        if not len(key_frames):
            self._static_layer.forget()
        elif key_frames.jump_since(last) is not None:
            self._jump(self._static_layer, key_frames)

    def _jump(self, static_layer: StaticLayer, key_frames: KeyFramePoses) -> None:
        """Take the goal to another frame at once, since the next one may be given in it, and wait for the map there."""
        before, self._drawn, self._key_frames = self._drawn, key_frames, []
        self._surroundings.frames.restart_localization()
        self._move_goal(before, key_frames)
        static_layer.expect()
        self._has_jumped = True
        self._feed(events.PlanBlocked(self.context.elapsed()))

    def use_layers(self, layers: MapLayers, version: str | None = None) -> None:
        """Replace the map, as Move Base does, and move the goal with the key frames."""
        before = self._drawn
        self._move_goal(before, self._take_drawn())
        super().use_layers(layers, version)
        if self._has_jumped:  # a plan that was made meanwhile is one in the frame before
            self._has_jumped = False
            self._feed(events.PlanBlocked(self.context.elapsed()))

    def _move_goal(self, before: KeyFramePoses, after: KeyFramePoses) -> None:
        active = self._machine.goals.active
        if active is not None and len(before) and after.differs(before):
            pose = carried(active.goal.pose, before, after)
            self._planner.head_for(pose)
            self._executor.progress.aim(pose)
            through = tuple(carried(each, before, after) for each in active.goal.through)
            self._feed(events.GoalMoved(self.context.elapsed(), pose, through))
            self._topics.current_goal(active.goal)

    def _take_drawn(self) -> KeyFramePoses:
        """Return the key frames of which the map of the last build was drawn."""
        began = float("inf") if self._static_layer is None else self._static_layer.began
        known = [key_frames for at, key_frames in self._key_frames if at <= began]
        self._key_frames = self._key_frames[len(known) :]
        self._drawn = known[-1] if known else self._drawn
        return self._drawn


def carried(pose: Pose2D, before: KeyFramePoses, after: KeyFramePoses) -> Pose2D:
    """Return a pose of the map frame that moves with the key frame that was nearest to it."""
    nearest = int(np.argmin(np.hypot(*(before.poses[:, :2] - pose[:2]).T)))
    return after.motion_since(before, float(before.stamps[nearest])) @ pose
