"""Node ``explore``: drives the robot to the frontiers of its map, with the action of Move Base, until none is left."""

from functools import partial
from typing import ClassVar

import msgspec
import numpy as np

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError, TransformError
from ppaas.exploration.choice import NOBODY
from ppaas.exploration.parameters import ExploreParameters
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Duration, Header, String
from ppaas.messages.explore_msgs import ExploreActionGoal, ExploreFeedback, ExploreResult
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav2_msgs import NavigateThroughPosesActionGoal
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation.action_goals import GoalList, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Node, Payload, Timer, Topic
from ppaas.nodes.explore.goals import Exploration, ExplorationGoals
from ppaas.nodes.explore.known_map import Build, KnownMap, Survey
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.nav2_actions import EXPLORE, NAVIGATE_THROUGH_POSES
from ppaas.nodes.other_robots import OTHERS_FRESH, others_of

STATUS_PERIOD = 1.0
ODOMETER_PERIOD = 0.25
LOOK = 1.5
"""Time for which the robot stands until the map shows what it has seen; changes come once a second [s]."""

PAUSES = ("waiting", "recovering")
"""Beginnings of Move Base's texts that say why a robot does not drive."""

NO_MAP = "there is no map yet: no valid message has come on 'map'; the robot must send scan and odom"
"""Reason for which a robot without a map waits."""


class ExploreNode(Node):
    """Serves the action ``explore`` by the topics of a ROS 1 action.

    One goal is active at once; a new one replaces it. Another goal for Move Base, or a cancel of its goal by a client,
    ends the exploration too. A frontier that Move Base cannot reach, or that stays when the robot has seen it, is given
    up. While the robot stands, status and feedback give the reason.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : ExploreParameters
        Named as in explore_lite.
    build : callable
        Returns the layers of a grid for the robot.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "explore"
    subscribes: ClassVar[tuple[Topic, ...]] = (
        EXPLORE.goal, EXPLORE.cancel, topics.MAP, topics.MAP_UPDATES, topics.TF, topics.TF_STATIC,
        topics.MOVE_BASE_GOAL, topics.SIMPLE_GOAL, topics.GOAL_POSE, topics.MOVE_BASE_CANCEL, topics.MOVE_BASE_RESULT,
        topics.MOVE_BASE_STATUS, NAVIGATE_THROUGH_POSES.goal, topics.KEY_FRAMES,
        topics.ROBOTS, topics.GRID_SLAM_STATUS,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (*EXPLORE[2:], topics.MOVE_BASE_GOAL, topics.MOVE_BASE_CANCEL)

    def __init__(
        self, context: Context, parameters: ExploreParameters, build: Build, names: FrameNames | None = None
    ) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._actions: ActionPublisher[Exploration] = ActionPublisher(context, EXPLORE)
        self._frames = FrameListener(names)
        self._map = KnownMap(context, build, parameters.min_frontier_size)
        self._key_frames, self._jumps = NO_KEY_FRAMES, 0
        self._others = float("-inf"), NOBODY
        self._explorations: GoalList[Exploration] = GoalList()
        self._goals: ExplorationGoals | None = None
        self._timers: list[Timer] = []
        self._counter = 0
        self._began = self._well = self._stood = 0.0
        self._odometry: Pose2D | None = None
        self._doing = self._mapping = ""

    @property
    def busy(self) -> bool:
        """Whether the robot explores."""
        return self._explorations.active is not None

    def start(self) -> None:
        """Start publishing the status of goals."""
        self.context.every(STATUS_PERIOD, lambda: self._actions.status(self._explorations))

    # -- messages ------------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message.

        Raises
        ------
        InvalidInput
            The message has another type.
        TransformError
            A transform is not valid.
        """
        if self._map.take(message) or self._take_key_frames(topic, message) or self._take_others(message):
            return
        now = self.context.elapsed()
        match message:
            case TFMessage():
                self._frames.hear(topic, message, now, self.context.now())
            case GoalStatusArray():
                self._on_move_base_status(message)
            case MoveBaseActionResult():
                self._on_result(message.status)
            case ExploreActionGoal():
                self._on_goal(message)
            case GoalID() if topic == EXPLORE.cancel.name:
                self._on_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case GoalID():
                self._on_other_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case MoveBaseActionGoal() | NavigateThroughPosesActionGoal():
                self._on_other_goal(message.goal_id.id)
            case PoseStamped():
                self._on_other_goal("")
            case _:
                raise InvalidInput(f"{self.name} does not accept {type(message).__name__} on topic {topic!r}")

    def _on_goal(self, message: ExploreActionGoal) -> None:
        if self._explorations.knows(message.goal_id.id, self.context.elapsed()):
            return
        self._counter += 1
        stamp = message.goal_id.stamp.seconds() or self.context.now()
        name = message.goal_id.id or f"{self.name}-{self._counter}-{stamp:.3f}"
        if self._explorations.active is not None:
            self._stop(f"Replaced by another goal: {name}")
        self._begin(Exploration(name, stamp, message.goal.return_to_start))

    def _on_cancel(self, event: CancelReceived) -> None:
        if self._explorations.cancelled_by(event):
            self._stop("The goal was cancelled.")

    def _stop(self, text: str) -> None:
        """End the exploration before its goal of Move Base, whose result would look like a cancel by a client."""
        goals = self._goals
        target = self._active.target
        self._end(Status.PREEMPTED, text)
        if goals is not None and target is not None:
            self.context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=target.goal.id))

    # -- Move Base -----------------------------------------------------------------------------------------------------

    def _on_result(self, status: GoalStatus) -> None:
        exploration, goals = self._exploration, self._goals
        if exploration is None or goals is None or exploration.target is None:
            return
        if status.goal_id.id != exploration.target.goal.id:
            return
        if goals.returning:
            self._on_returned(status)
        elif status.status == Status.SUCCEEDED:
            goals.reached()
            self._stood = self.context.elapsed()
            self._say("looking at the frontier")
        elif status.status == Status.ABORTED:
            given_up = goals.failed(status.text)
            self._stood = self.context.elapsed()
            self._say(f"a frontier {'is given up' if given_up else 'was not reached'}: {status.text}")
        else:
            self._end(Status.PREEMPTED, f"Exploring has ended: {status.text}")

    def _on_returned(self, status: GoalStatus) -> None:
        if status.status == Status.SUCCEEDED:
            self._end(Status.SUCCEEDED, f"{self._outcome()} The robot is back.")
        else:
            text = f"{self._outcome()} The robot is not back at its start: {status.text}"
            self._end(Status.ABORTED if status.status == Status.ABORTED else Status.PREEMPTED, text)

    def _on_move_base_status(self, message: GoalStatusArray) -> None:
        """Report why Move Base does not drive."""
        exploration = self._exploration
        if exploration is None or exploration.target is None:
            return
        texts = [each.text for each in message.status_list if each.goal_id.id == exploration.target.goal.id]
        if texts and texts[-1].startswith(PAUSES):
            self._say(f"{self._doing}; {texts[-1]}", doing=self._doing)

    def _on_other_goal(self, goal_id: str) -> None:
        """End for a client's goal while Move Base has none of ours; at other times, the result of ours shows it."""
        exploration = self._exploration
        if exploration is not None and exploration.target is None and not goal_id.startswith(f"{exploration.id}/"):
            self._end(Status.PREEMPTED, f"Replaced by another goal: {goal_id or 'a simple goal'}")

    def _on_other_cancel(self, event: CancelReceived) -> None:
        exploration = self._exploration
        if exploration is not None and exploration.target is None and cancels(event, exploration):
            self._end(Status.PREEMPTED, "The goal was cancelled.")

    def _take_others(self, message: Payload) -> bool:
        """Note where other robots are on the map, or why mapping leaves out scans; return whether a message says so."""
        if isinstance(message, String):
            self._mapping = message.data
            return True
        if not isinstance(message, RobotStates):
            return False
        others = [(other.x, other.y) for other in others_of(message, 0.0)]
        self._others = self.context.elapsed(), np.array(others).reshape(-1, 2)
        return True

    def _take_key_frames(self, topic: str, message: Payload) -> bool:
        """Move what is known with a map that is in another frame from now on; return whether it is of this topic."""
        if topic != topics.KEY_FRAMES.name:
            return False
        before, self._key_frames = self._key_frames, key_frames_of(message)
        motion = self._key_frames.jump_since(before)
        if motion is not None and self._goals is not None and self._exploration is not None:
            self._jumps += 1
            self._frames.restart_localization()
            self._others = float("-inf"), NOBODY
            self._goals.move(motion)
        return True

    # -- exploring -----------------------------------------------------------------------------------------------------

    @property
    def _exploration(self) -> Exploration | None:
        active = self._explorations.active
        return None if active is None else active.goal

    @property
    def _active(self) -> Exploration:
        exploration = self._exploration
        assert exploration is not None, "a goal is active"
        return exploration

    def _begin(self, exploration: Exploration) -> None:
        self._explorations.accept(exploration)
        self._goals = ExplorationGoals(self.context, self._parameters, exploration)
        self._began = self.context.elapsed() - exploration.seconds
        self._well, self._stood = self.context.elapsed(), float("-inf")
        self._odometry = None
        every = self.context.every
        self._timers += [
            every(1.0 / self._parameters.planner_frequency, self._survey),
            every(ODOMETER_PERIOD, self._measure),
            every(STATUS_PERIOD, self._publish_feedback),
        ]
        self._say("looking for frontiers")
        self._survey()

    def _survey(self) -> None:
        """Look for frontiers if the map has changed, or the robot stands."""
        exploration, goals = self._exploration, self._goals
        if exploration is None or goals is None or goals.returning or self._map.surveying:
            return
        if exploration.target is None and self.context.elapsed() - self._stood < LOOK:
            return
        if self._map.has_map and not self._map.has_changed and exploration.target is not None:
            self._check_progress()
            return
        try:
            robot = self._frames.in_map()
        except TransformError as error:
            self._wait(f"the pose of the robot in the map is unknown: {error}; it must send scan and odom")
            return
        exploration.start = exploration.start or robot
        if self._map.has_map:
            self._map.survey(robot, partial(self._on_survey, exploration, self._jumps))
        else:
            self._wait(NO_MAP)

    def _check_progress(self) -> None:
        """Survey again after a while although the map does not change, to notice a robot that is stuck."""
        exploration = self._active
        target = exploration.target
        if target is not None and self.context.elapsed() - target.since > self._parameters.progress_timeout:
            self._map.expect_change()

    def _on_survey(self, exploration: Exploration, jumps: int, surveyed: Survey | PPaaSError) -> None:
        goals = self._goals
        if exploration is not self._exploration or goals is None or jumps != self._jumps:
            return  # the goal has ended meanwhile, or the map is in another frame
        if isinstance(surveyed, PPaaSError) or surveyed.grid is None:
            self._wait(NO_MAP if isinstance(surveyed, Survey) else str(surveyed))
            return
        self._well = self.context.elapsed()
        at, others = self._others
        doing = goals.steer(surveyed, others if self.context.elapsed() - at <= OTHERS_FRESH else NOBODY)
        if doing:
            if doing != self._doing:
                self._say(doing)
        else:
            self._finish(goals)

    def _wait(self, problem: str) -> None:
        """Say why the robot cannot explore now, as mapping does if it knows; abort the goal after too long a time."""
        reason = self._mapping or problem
        waited = self.context.elapsed() - self._well
        if waited > self._parameters.patience:
            goals = self._goals
            if goals is not None:
                goals.drop()
            self._end(Status.ABORTED, f"The robot waited for {waited:.0f} s: {reason}")
        else:
            self._say(f"waiting: {reason}")

    def _finish(self, goals: ExplorationGoals) -> None:
        """End, or return to the start, since no frontier is left."""
        exploration = self._active
        goals.drop()
        if not exploration.reached and exploration.given_up:
            self._end(Status.ABORTED, f"No frontier could be reached. The last reason: {goals.last_reason}")
        elif exploration.return_to_start and exploration.start is not None:
            goals.return_to(exploration.start)
            self._say("returning to the start")
        else:
            self._end(Status.SUCCEEDED, self._outcome())

    def _outcome(self) -> str:
        given_up = self._active.given_up
        if not given_up:
            return "No frontier is left."
        return f"No frontier is left but {given_up} that the robot gave up."

    # -- reports -------------------------------------------------------------------------------------------------------

    def _measure(self) -> None:
        """Add the motion by odometry to the distance driven."""
        try:
            odometry = self._frames.odometry()
        except TransformError:
            return  # no odometry now; the motion is added when it returns
        if self._odometry is not None:
            self._active.distance += self._odometry.distance_to(odometry)
        self._odometry = odometry

    def _say(self, text: str, doing: str | None = None) -> None:
        assert self._explorations.active is not None
        self._doing = text if doing is None else doing
        if self._explorations.active.text != text:
            self._explorations.active.text = text
            self._actions.status(self._explorations)
            self._publish_feedback()

    def _publish_feedback(self) -> None:
        active = self._explorations.active
        if active is None:
            return
        exploration = active.goal
        target = exploration.target
        shown = {} if target is None else {"target": PoseStamped(Header(frame_id=MAP), Pose.of(target.goal.pose))}
        feedback = ExploreFeedback(
            **shown,
            frontiers=exploration.frontiers, unreachable=exploration.given_up, area=exploration.area,
            distance=exploration.distance, exploration_time=self._spent(), text=active.text,
        )  # fmt: skip
        self._actions.feedback(exploration, feedback, active.text)

    def _spent(self) -> Duration:
        return Duration.of(self.context.elapsed() - self._began)

    def _end(self, status: Status, text: str) -> None:
        for timer in self._timers:
            timer.stop()
        self._timers.clear()
        exploration, self._goals = self._active, None
        self._map.cancel()
        self._explorations.end(self.context.elapsed(), status, text)
        result = ExploreResult(
            exploration.frontiers, exploration.given_up, exploration.area, exploration.distance, self._spent()
        )
        self._actions.result(exploration, status, text, result)
        self._actions.status(self._explorations)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the exploration with its progress, as JSON."""
        exploration = self._exploration
        if exploration is not None:
            exploration.seconds = self.context.elapsed() - self._began
        return msgspec.json.encode((exploration, self._counter))

    def restore(self, state: bytes) -> None:
        """Continue the exploration of a checkpoint. Move Base is restored to the same goal."""
        exploration, self._counter = from_json(state, tuple[Exploration | None, int])
        if exploration is not None:
            self._begin(exploration)
