"""Node ``move_base`` of a robot that makes its map."""

from typing import Any, ClassVar, NamedTuple

from ppaas.costmap.map_layers import MapLayers
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses
from ppaas.navigation import events
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.static_layer import StaticLayer

MOST_WAITING = 100
"""Largest number of messages with key frames that wait for a map."""

UPDATES = (topics.GOAL_UPDATE.name, topics.MOVE_BASE_GOAL_UPDATE.name)
"""Topics that move the goal to a pose in the frame of the key frames known now."""


class TimedKeyFrames(NamedTuple):
    """Key frames with the time at which they came.

    Parameters
    ----------
    at : float
        By the executor's clock [s].
    key_frames : KeyFramePoses
    """

    at: float
    key_frames: KeyFramePoses


class MappingMoveBaseNode(MoveBaseNode):
    """Move Base of a robot that makes its map: the static layer comes from the topics ``map`` and ``map_updates``.

    A goal moves with the key frame that is nearest to it, as soon as the map shows the moved key frames. It is
    taken to be given in the frame of the key frames that were known then, although their map may not be drawn yet.

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
        self._drawn_at, self._drawn = float("-inf"), NO_KEY_FRAMES
        self._key_frames: list[TimedKeyFrames] = []
        self._goal, self._goal_frames = "", TimedKeyFrames(float("-inf"), NO_KEY_FRAMES)
        self._has_jumped = False

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as Move Base's method does."""
        if topic == topics.KEY_FRAMES.name:
            self._take_key_frames(key_frames_of(message))
        elif self._static_layer is None or not self._static_layer.take(message):
            super().on_message(topic, message)
        active = self._machine.goals.active
        if active is not None and (active.goal.id != self._goal or topic in UPDATES):
            self._goal = active.goal.id
            self._goal_frames = (
                self._key_frames[-1] if self._key_frames else TimedKeyFrames(self._drawn_at, self._drawn)
            )

    def _take_key_frames(self, key_frames: KeyFramePoses) -> None:
        """Keep key frames until the map is drawn of them; if there are none, the map was cleared."""
        last = self._key_frames[-1][1] if self._key_frames else self._drawn
        self._key_frames = [*self._key_frames[-MOST_WAITING:], TimedKeyFrames(self.context.elapsed(), key_frames)]
        if self._static_layer is None:
            return
        if not len(key_frames):
            self._static_layer.forget()
        elif key_frames.jump_since(last) is not None:
            self._jump(self._static_layer, key_frames)

    def _jump(self, static_layer: StaticLayer, key_frames: KeyFramePoses) -> None:
        """Take the goal to another frame at once, since the next one may be given in it, and wait for the map there."""
        self._drawn_at, self._drawn, self._key_frames = self.context.elapsed(), key_frames, []
        self._surroundings.frames.restart_localization()
        self._move_goal()
        static_layer.expect()
        self._has_jumped = True
        self._feed(events.PlanBlocked(self.context.elapsed()))

    def use_layers(self, layers: MapLayers, version: str | None = None) -> None:
        """Replace the map, as Move Base does, and move the goal with the key frames."""
        self._take_drawn()
        self._move_goal()
        super().use_layers(layers, version)
        if self._has_jumped:  # a plan that was made meanwhile is one in the frame before
            self._has_jumped = False
            self._feed(events.PlanBlocked(self.context.elapsed()))

    def _move_goal(self) -> None:
        """Move the goal with the key frames, to the ones of which the map was drawn; a goal of later ones stays."""
        active, (at, before), after = self._machine.goals.active, self._goal_frames, self._drawn
        if active is None or at > self._drawn_at:
            return
        self._goal_frames = TimedKeyFrames(self._drawn_at, after)
        if len(before) and after.differs(before):
            pose = after.carry(active.goal.pose, before)
            self._planner.head_for(pose)
            self._executor.progress.aim(pose)
            through = tuple(after.carry(each, before) for each in active.goal.through)
            self._feed(events.GoalMoved(self.context.elapsed(), pose, through))
            self._topics.current_goal(active.goal)

    def _take_drawn(self) -> None:
        """Note the key frames of which the map of the last build was drawn."""
        began = float("inf") if self._static_layer is None else self._static_layer.began
        known = [one for one in self._key_frames if one.at <= began]
        self._key_frames = self._key_frames[len(known) :]
        if known:
            self._drawn_at, self._drawn = known[-1]
