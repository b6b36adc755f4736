"""Recorder: hears the topics of a robot while somebody watches it, and keeps what the diagnosis needs of them.

A message costs a few microseconds. Of scans only the last one of each laser is kept, by reference.
"""

import itertools
import math
import statistics
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ppaas.bounded import BoundedDict
from ppaas.diagnosis.observations.arrivals import Arrivals
from ppaas.diagnosis.observations.facts import (
    FrameFacts,
    GoalFacts,
    HandFacts,
    MotionFacts,
    NodeFacts,
    Observations,
)
from ppaas.diagnosis.observations.place import PlaceWatch, WatchedRobot
from ppaas.diagnosis.observations.scans import scan_facts
from ppaas.geometry import wrap_angle
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped, TransformStamped, Twist
from ppaas.messages.health.stops import StopState
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.operators.teleoperation import TeleopState
from ppaas.messages.ppaas_msgs import NodeHomes
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import MAX_FRAMES, TFMessage
from ppaas.nodes import topics
from ppaas.nodes.frames import PERSON
from ppaas.transforms.spatial import LatestFrames

# -- motion of a robot by its commands and by its odometry, over the same seconds --------------------------------------

WINDOW = 10.0
"""Time for which commands and poses are kept [s]."""

MOST = 2000
"""Largest number of commands, and of poses, that are kept."""

ARM = 0.2
"""Distance from the centre at which a turn counts as a path [m]."""

LONGEST_COMMAND = 0.5
"""Time for which a command holds without another one [s], as base controllers have it."""

Sample = tuple[float, float, float, float]
"""Time [s], and either x [m], y [m], yaw [rad], or velocities [m/s, m/s, rad/s]."""


class Motion:
    """Commands and odometry of the last `WINDOW` seconds."""

    def __init__(self) -> None:
        self._commands: deque[Sample] = deque(maxlen=MOST)
        self._poses: deque[Sample] = deque(maxlen=MOST)
        self._frames = "", ""

    def command(self, twist: Twist, now: float) -> None:
        """Note a command that arrived at monotonic time ``now`` [s]."""
        self._commands.append((now, twist.linear.x, twist.linear.y, twist.angular.z))

    def odometry(self, message: Odometry, now: float) -> None:
        """Note a message of the odometry; a pose that is not valid is left out."""
        self._frames = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
        pose = message.pose.pose.planar()
        if all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            self._poses.append((now, pose.x, pose.y, pose.theta))

    def facts(self, now: float) -> MotionFacts:
        """Return what was ordered and what was moved until ``now`` [s]."""
        for kept in (self._commands, self._poses):
            while kept and now - kept[0][0] > WINDOW:
                kept.popleft()
        ordered, ordered_turn, ordered_path = _ordered(self._commands, now)
        moved, moved_turn, moved_path, jump = _moved(self._poses)
        return MotionFacts(
            commands=len(self._commands),
            ordered=ordered,
            ordered_turn=ordered_turn,
            ordered_path=ordered_path,
            moved=moved,
            moved_turn=moved_turn,
            moved_path=moved_path,
            parent=self._frames[0],
            child=self._frames[1],
            jump=jump,
        )


def _ordered(commands: deque[Sample], now: float) -> tuple[float, float, float]:
    forward = turn = path = 0.0
    ends = [*(command[0] for command in itertools.islice(commands, 1, None)), now]
    for (at, x, y, yaw_rate), end in zip(commands, ends, strict=False):
        seconds = min(end - at, LONGEST_COMMAND)
        forward += x * seconds
        turn += yaw_rate * seconds
        path += (math.hypot(x, y) + ARM * abs(yaw_rate)) * seconds
    return forward, turn, path


def _moved(poses: deque[Sample]) -> tuple[float, float, float, float]:
    forward = turn = path = jump = 0.0
    for (_, x, y, yaw), (_, next_x, next_y, next_yaw) in itertools.pairwise(poses):
        dx, dy, turned = next_x - x, next_y - y, wrap_angle(next_yaw - yaw)
        forward += dx * math.cos(yaw) + dy * math.sin(yaw)
        turn += turned
        step = math.hypot(dx, dy)
        path += step + ARM * abs(turned)
        jump = max(jump, step)
    return forward, turn, path, jump


# -- frames of a robot as ``tf`` and ``tf_static`` give them -----------------------------------------------------------

MOST_POSITIONS = 40
"""Number of positions of a moving frame that are compared."""

FAR, NEAR = 0.05, 0.3
"""Two senders take turns if successive positions are farther apart than `FAR` [m] in the median, while every second one
is nearer than this part of that."""

MOST_PARENTS = 4
"""Largest number of parents of a frame that are kept."""

PARENT_AGE = 5.0
"""Time after which an earlier parent of a frame counts as given up [s]."""


@dataclass(slots=True)
class _Frame:
    parents: dict[str, float] = field(default_factory=dict)
    static: bool = False
    at: float = 0.0
    positions: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=MOST_POSITIONS))


class FrameWatch:
    """Frames that transforms name.

    Attributes
    ----------
    latest : LatestFrames
        Latest transform of each frame.
    """

    def __init__(self) -> None:
        self.latest = LatestFrames()
        self._frames: BoundedDict[str, _Frame] = BoundedDict(MAX_FRAMES)

    def hear(self, transforms: list[TransformStamped], now: float, *, static: bool) -> None:
        """Note the transforms of a message that arrived at monotonic time ``now`` [s]."""
        self.latest.hear(transforms)
        for transform in transforms:
            child, parent = transform.child_frame_id.lstrip("/"), transform.header.frame_id.lstrip("/")
            if "/" in child and PERSON.fullmatch(child):
                continue  # people come and go, and nothing of the robot is mounted on them
            frame = self._frames.get(child)
            if frame is None:
                frame = self._frames[child] = _Frame()
            frame.parents.pop(parent, None)
            frame.parents[parent] = now
            if len(frame.parents) > MOST_PARENTS:
                del frame.parents[next(iter(frame.parents))]
            frame.static, frame.at = static, now
            if not static:
                frame.positions.append((transform.transform.translation.x, transform.transform.translation.y))

    def facts(self, now: float) -> list[FrameFacts]:
        """Return the facts of all frames that have a parent, sorted by their names."""
        return [
            FrameFacts(
                name=name,
                parents=tuple(each for each, at in frame.parents.items() if at == frame.at or now - at < PARENT_AGE),
                static=frame.static,
                silence=now - frame.at,
                alternates=alternates([*frame.positions]),
            )
            for name, frame in sorted(self._frames.items())
        ]


def alternates(positions: list[tuple[float, float]]) -> bool:
    """Return whether positions jump to and fro, as with two senders that take turns."""
    if len(positions) < 8:
        return False
    steps, doubles = (
        statistics.median(math.dist(a, b) for a, b in zip(positions, positions[apart:], strict=False))
        for apart in (1, 2)
    )
    return steps > FAR and doubles < NEAR * steps


# -- recorder ----------------------------------------------------------------------------------------------------------

MOST_LASERS = 8
"""Largest number of lasers that are distinguished."""

SCAN_AGE = 3.0
"""Time after which the last scan of a laser says nothing any more [s]."""

HEARD = (
    topics.SCAN, topics.ODOM, topics.TF, topics.TF_STATIC, topics.CMD_VEL, topics.AMCL_POSE, topics.SLAM_POSE,
    topics.AMCL_STATUS, topics.GRID_SLAM_STATUS, topics.MOVE_BASE_STATUS, topics.MOVE_BASE_RESULT, topics.NODE_HOMES,
    topics.STOP_STATE, topics.TELEOP_STATE,
)  # fmt: skip
"""Topics that the recorder hears, as far as the clone has them."""

HAND_AGE = 1.0
"""Time after which the last state of driving by hand says nothing any more [s]; they come at 10 Hz."""

TIMED = (topics.SCAN.name, topics.ODOM.name, topics.CMD_VEL.name)
"""Topics whose arrivals are kept."""


class ObservationRecorder:
    """Observations of one robot, from the moment somebody begins to watch it.

    Parameters
    ----------
    now : float
        Monotonic time [s].
    """

    def __init__(self, now: float) -> None:
        self.since = now
        self.arrivals: dict[str, Arrivals] = {topic: Arrivals() for topic in TIMED}
        self.motion = Motion()
        self.frames = FrameWatch()
        self.place = PlaceWatch()
        self.goal = GoalFacts()
        self.nodes: list[NodeFacts] = []
        self.stopped = ""
        self._hand: tuple[float, HandFacts] = (-math.inf, HandFacts())
        self._scans: BoundedDict[str, tuple[float, LaserScan]] = BoundedDict(MOST_LASERS)
        self._hear: dict[type[Message], Callable[[str, Any, float], None]] = {
            LaserScan: self._on_scan,
            Odometry: self._on_odometry,
            TFMessage: self._on_transforms,
            Twist: self._on_command,
            PoseWithCovarianceStamped: self._on_pose,
            String: self._on_text,
            GoalStatusArray: self._on_statuses,
            MoveBaseActionResult: self._on_result,
            NodeHomes: self._on_homes,
            StopState: self._on_stop,
            TeleopState: self._on_hand,
        }

    def take(self, topic: str, message: object, now: float, wall: float) -> None:
        """Note a message that arrived now: monotonic, and since the epoch [s]."""
        arrivals = self.arrivals.get(topic)
        if arrivals is not None:
            header = message.header if isinstance(message, LaserScan | Odometry) else None
            arrivals.note(now, wall, *((None, "") if header is None else (_seconds(header.stamp), header.frame_id)))
        hear = self._hear.get(type(message))  # type: ignore[arg-type]  # other types are not in it
        if hear is not None:
            hear(topic, message, now)

    def observations(self, now: float, robot: WatchedRobot) -> Observations:
        """Return what was observed until monotonic time ``now`` [s], without the topics and the reports."""
        scans = [scan for at, scan in self._scans.values() if now - at <= SCAN_AGE]
        return Observations(
            robot=robot.id,
            seconds=now - self.since,
            base=robot.names.base,
            prefix=robot.names.prefix,
            makes_map=robot.makes_map,
            camera=robot.camera,
            follows_paths=robot.follows_paths,
            localizes_itself=robot.localizes_itself,
            scans=[scan_facts(scan) for scan in scans],
            motion=self.motion.facts(now),
            frames=self.frames.facts(now),
            place=self.place.facts(now, scans[-1] if scans else None, self.frames.latest, robot),
            goal=self.goal,
            stopped=self.stopped,
            hand=self._hand[1] if now - self._hand[0] <= HAND_AGE else HandFacts(),
            nodes=self.nodes,
        )

    # -- messages ------------------------------------------------------------------------------------------------------

    def _on_scan(self, _topic: str, scan: LaserScan, now: float) -> None:
        self._scans[scan.header.frame_id] = now, scan

    def _on_odometry(self, _topic: str, odometry: Odometry, now: float) -> None:
        self.motion.odometry(odometry, now)

    def _on_transforms(self, topic: str, message: TFMessage, now: float) -> None:
        self.frames.hear(message.transforms, now, static=topic == topics.TF_STATIC.name)

    def _on_command(self, _topic: str, twist: Twist, now: float) -> None:
        self.motion.command(twist, now)

    def _on_pose(self, _topic: str, pose: PoseWithCovarianceStamped, now: float) -> None:
        self.place.localized(pose, now)

    def _on_text(self, _topic: str, text: String, _now: float) -> None:
        self.place.problem = text.data

    def _on_statuses(self, _topic: str, statuses: GoalStatusArray, _now: float) -> None:
        if statuses.status_list:
            newest = statuses.status_list[-1]
            self.goal = GoalFacts(name=newest.goal_id.id, status=newest.status, text=newest.text)

    def _on_result(self, _topic: str, result: MoveBaseActionResult, _now: float) -> None:
        status = result.status
        self.goal = GoalFacts(name=status.goal_id.id, status=status.status, text=status.text)

    def _on_homes(self, _topic: str, homes: NodeHomes, _now: float) -> None:
        self.nodes = [
            NodeFacts(name=each.node, home=each.home, wanted=each.wanted, reasons=tuple(each.reasons))
            for each in homes.nodes
        ]

    def _on_stop(self, _topic: str, state: StopState, _now: float) -> None:
        self.stopped = state.text

    def _on_hand(self, _topic: str, state: TeleopState, now: float) -> None:
        driver = (state.driver or state.id) if state.id else ""
        self._hand = now, HandFacts(driver=driver, mode=state.mode, text=state.text)


def _seconds(stamp: Time) -> float:
    """Return a stamp in seconds; one beyond all clocks as infinite."""
    try:
        return stamp.seconds()
    except OverflowError:
        return math.inf
