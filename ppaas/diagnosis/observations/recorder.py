"""Recorder: hears the topics of a robot while somebody watches it, and keeps what the diagnosis needs of them.

A message costs a few microseconds. Of scans only the last one of each laser is kept, by reference.
"""

import math
from collections.abc import Callable
from typing import Any

from ppaas.bounded_dict import BoundedDict
from ppaas.diagnosis.observations.arrivals import Arrivals
from ppaas.diagnosis.observations.facts import GoalFacts, NodeFacts, Observations
from ppaas.diagnosis.observations.frame_watch import FrameWatch
from ppaas.diagnosis.observations.motion import Motion
from ppaas.diagnosis.observations.place import PlaceWatch
from ppaas.diagnosis.observations.scans import scan_facts
from ppaas.diagnosis.observations.watched_robot import WatchedRobot
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import NodeHomes
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics

MOST_LASERS = 8
"""Largest number of lasers that are distinguished."""

SCAN_AGE = 3.0
"""Time after which the last scan of a laser says nothing any more [s]."""

HEARD = (
    topics.SCAN, topics.ODOM, topics.TF, topics.TF_STATIC, topics.CMD_VEL, topics.AMCL_POSE, topics.SLAM_POSE,
    topics.AMCL_STATUS, topics.GRID_SLAM_STATUS, topics.MOVE_BASE_STATUS, topics.MOVE_BASE_RESULT, topics.NODE_HOMES,
)  # fmt: skip
"""Topics that the recorder hears, as far as the clone has them."""

TIMED = (topics.SCAN.name, topics.ODOM.name, topics.CMD_VEL.name)
"""Topics whose arrivals are kept."""


class Recorder:
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
            scans=[scan_facts(scan) for scan in scans],
            motion=self.motion.facts(now),
            frames=self.frames.facts(now),
            place=self.place.facts(now, scans[-1] if scans else None, self.frames.latest, robot),
            goal=self.goal,
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


def _seconds(stamp: Time) -> float:
    """Return a stamp in seconds; one beyond all clocks as infinite."""
    try:
        return stamp.seconds()
    except OverflowError:
        return math.inf
