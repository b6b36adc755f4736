"""Node ``people_tracker``: tracks the people that a robot sees, and reports them to the coordinator."""

import math
from typing import ClassVar, NamedTuple

import msgspec
import numpy as np

from ppaas.decoding import from_json
from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Point, PoseWithCovarianceStamped, TransformStamped
from ppaas.messages.people_coordination import FollowStatus, PeopleReport, SensorView
from ppaas.messages.people_msgs import People, PositionMeasurement, PositionMeasurementArray
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.vision_msgs import Detection3DArray
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters
from ppaas.nodes.people_tracker.poses import RobotPoses
from ppaas.nodes.people_tracker.readings import PersonFrames, Reading, measured, of_detections, of_frames, of_people
from ppaas.nodes.people_tracker.tracking import ReadingTracker, TrackingState
from ppaas.nodes.robot_scans import WaitingData
from ppaas.people.tracks.tracker import LocalTrack

# -- reports of a people tracker ---------------------------------------------------------------------------------------

HEIGHT_VARIANCE = 0.04
"""Variance of the height of a person's position [m²]."""


class Follower(NamedTuple):
    """What a robot does to follow a person, for its reports: see `PeopleReport`."""

    can_follow: bool = False
    following: int = 0
    gave_up: int = 0

    @classmethod
    def of(cls, status: FollowStatus) -> "Follower":
        """Return it from the status of the robot's follower."""
        return cls(status.can_follow, status.following, status.gave_up)


class SeenPeople(NamedTuple):
    """The people that a robot sees at a time.

    Parameters
    ----------
    stamp : float
        Time by the clock of the odometry [s].
    measurements : PositionMeasurementArray
        In the robot's frame.
    frames : list of TransformStamped
        Frames of those that the robot does not publish itself.
    """

    stamp: float
    measurements: PositionMeasurementArray
    frames: list[TransformStamped]


class Reporter:
    """Makes the messages of a people tracker.

    Parameters
    ----------
    robot : str
        Robot ID.
    poses : RobotPoses
    tracking : ReadingTracker
    frames : PersonFrames
    """

    def __init__(self, robot: str, poses: RobotPoses, tracking: ReadingTracker, frames: PersonFrames) -> None:
        self._robot, self._poses = robot, poses
        self._tracking, self._frames = tracking, frames

    def people(self, base: str, now: float) -> SeenPeople:
        """Return the people that the robot sees at the time of the last measurement.

        Parameters
        ----------
        base : str
            Frame of the robot's body.
        now : float
            Time by the executor's clock [s].

        Raises
        ------
        TransformError
            The pose of the robot at that time is unknown.
        """
        stamp = self._stamp()
        inverse = self._poses.robot(stamp).inverse()
        header = Header(stamp=Time.of(stamp), frame_id=base)
        seen = self._tracking.seen()
        self._frames.ids.keep(self._tracking.tracks())
        taken = self._frames.taken(now)
        people = []
        for each in seen:
            name = self._frames.ids.of(each.id, self._tracking.own_id(each.id), taken)
            people.append(_measurement(header, self._frames.frame(name), name, each, inverse))
        return SeenPeople(stamp, PositionMeasurementArray(header, people), self._frames.transforms(people, now))

    def _stamp(self) -> float:
        """Return the time of the people: of the last measurement, or of the newest pose before the first."""
        newest = self._poses.newest()
        assert newest is not None
        return self._tracking.at if math.isfinite(self._tracking.at) else newest

    def report(self, seen: SeenPeople, follower: Follower, now: float) -> PeopleReport:
        """Return the report to the coordinator.

        Raises
        ------
        TransformError
            The robot is not localized.
        """
        pose = self._poses.in_map(seen.stamp, now)
        header = Header(stamp=Time.of(self._tracking.clocks.here(seen.stamp)), frame_id=MAP)
        return PeopleReport(
            header, self._robot, pose, seen.measurements.people, self._tracking.views(seen.stamp), *follower
        )


def _measurement(header: Header, frame: str, name: str, seen: LocalTrack, to_base: Pose2D) -> PositionMeasurement:
    place = to_base @ Pose2D(seen.x, seen.y)
    cos, sin = math.cos(to_base.theta), math.sin(to_base.theta)
    turn = np.array(((cos, -sin), (sin, cos)))
    xx, xy, yy = seen.covariance
    (a, b), (_, d) = (turn @ np.array(((xx, xy), (xy, yy))) @ turn.T).tolist()
    covariance = [a, b, 0.0, b, d, 0.0, 0.0, 0.0, HEIGHT_VARIANCE]
    return PositionMeasurement(header, frame, name, Point(place.x, place.y, seen.z), seen.score, covariance, 1)


# -- node ``people_tracker`` -------------------------------------------------------------------------------------------

MOST_WAITING = 50
"""Largest number of readings that wait for transforms."""

HEARTBEAT = 1.0
"""Longest time between two reports [s]."""

MEASURED = (topics.LEG_MEASUREMENTS.name, topics.TORSO_MEASUREMENTS.name)
_POSES = (topics.TF.name, topics.TF_STATIC.name, topics.AMCL_POSE.name)

VIEWS = {topics.LEG_VIEW.name: topics.LEG_MEASUREMENTS.name, topics.TORSO_VIEW.name: topics.TORSO_MEASUREMENTS.name}
"""Topics of views, and the topic of the detector that each belongs to."""


class PeopleTrackerState(msgspec.Struct):
    """Checkpoint of the node."""

    tracking: TrackingState
    torso_ids: tuple[int, dict[int, str]]


class PeopleTrackerNode(Node):
    """Subscribes to what detectors find, ``tf`` and ``amcl_pose``; publishes frames of people and reports of them.

    Detections come from ``torso_detector`` and ``leg_detector``, or from the robot itself: as ``people``,
    ``detections``, or frames ``{Robot ID}/{Torso ID}`` on ``tf``. They wait until odometry has reached their stamps.

    Stamps of devices whose clocks differ by more than a delay are corrected by the difference. Reports have the time of
    the computer that runs this node. While nothing is reported, ``people_tracker/status`` gives the reason.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : PeopleTrackerParameters
    robot : str
        Robot ID.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "people_tracker"
    demands: ClassVar[Demands] = Demands(0.05)
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.LEG_MEASUREMENTS, topics.TORSO_MEASUREMENTS, topics.LEG_VIEW, topics.TORSO_VIEW, topics.PEOPLE,
        topics.DETECTIONS, topics.TF, topics.TF_STATIC, topics.AMCL_POSE, topics.FOLLOW_STATUS,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.TF, topics.PEOPLE_MEASUREMENTS, topics.PEOPLE_REPORT, topics.PEOPLE_TRACKER_STATUS,
    )  # fmt: skip

    def __init__(
        self, context: Context, parameters: PeopleTrackerParameters, robot: str, names: FrameNames | None = None
    ) -> None:
        super().__init__(context)
        self._own = parameters
        self._frames = FrameListener(names)
        self._poses = RobotPoses(self._frames)
        self._waiting: WaitingData[Reading] = WaitingData("detections", MOST_WAITING)
        self._tracking = ReadingTracker(self._poses, parameters.view())
        self._person_frames = PersonFrames(robot)
        self._reporter = Reporter(robot, self._poses, self._tracking, self._person_frames)
        self._follower = Follower()
        self._reported_at, self._changed = -HEARTBEAT, False
        self._status = self._left_out = ""

    def start(self) -> None:
        """Report from now on."""
        self.context.every(1.0 / self._own.publish_frequency, self._report)

    # -- messages ------------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle detections, transforms, a pose of the robot, a view, or what the robot does to follow a person.

        Raises
        ------
        InvalidInput
            A number is not finite or out of range, there are too many people, or detections are out of date.
        TransformError
            A transform is invalid, or the frame of detections is unknown.
        """
        now = self.context.elapsed()
        if topic in (topics.TF.name, topics.TF_STATIC.name):
            self._hear(topic, expect(message, TFMessage))
        elif topic == topics.AMCL_POSE.name:
            self._poses.hear(expect(message, PoseWithCovarianceStamped), self.context.now())
        elif topic == topics.FOLLOW_STATUS.name:
            self._follower = Follower.of(expect(message, FollowStatus))
        elif topic in VIEWS:
            self._tracking.use_view(VIEWS[topic], expect(message, SensorView))
        elif topic in MEASURED:
            self._add(measured(topic, expect(message, PositionMeasurementArray), self._own, now))
        elif topic == topics.PEOPLE.name:
            self._add(of_people(topic, expect(message, People), self._own, now))
        elif topic == topics.DETECTIONS.name:
            self._add(of_detections(topic, expect(message, Detection3DArray), self._own, now))
        errors = self._process()
        if errors and topic not in _POSES:
            raise errors[-1]

    def _hear(self, topic: str, message: TFMessage) -> None:
        """Take transforms: people's are detections, unless this node published them."""
        now, stamp = self.context.elapsed(), self.context.now()
        before = self._poses.newest()
        try:
            self._frames.hear(topic, message, now, stamp)
        finally:
            newest = self._poses.newest()
            if newest is not None and newest != before:
                self._tracking.clocks.note_odometry(newest, stamp)
            people = self._person_frames.foreign(message.transforms, now)
            for reading in of_frames(topics.TF.name, people, self._own, now):
                self._add(reading)

    def _add(self, reading: Reading) -> None:
        newest = self._poses.newest()
        stamp = self._tracking.clocks.in_odometry(reading.source, reading.stamp, self.context.now(), newest)
        self._waiting.add(reading._replace(stamp=stamp), newest)

    def _process(self) -> list[PPaaSError]:
        """Use the readings that odometry has reached; return the errors of those that cannot be used."""
        errors = self._waiting.process(self._poses.newest(), self.context.elapsed(), self._use)
        if errors or self._waiting.problem:
            self._left_out = f"detections are left out: {errors[-1]}" if errors else self._waiting.problem
        return errors

    def _use(self, reading: Reading, stamp: float) -> None:
        self._tracking.use(reading, stamp)
        self._changed, self._left_out = True, ""

    # -- reports -------------------------------------------------------------------------------------------------------

    def _report(self) -> None:
        """Publish the people if something was measured since the last report, or if that is long ago."""
        now = self.context.elapsed()
        if not self._changed and now - self._reported_at < HEARTBEAT:
            return
        try:
            self._publish(now)
        except TransformError as error:
            self._tell(str(error))
        else:
            self._tell(self._left_out)
        self._changed, self._reported_at = False, now

    def _publish(self, now: float) -> None:
        if self._poses.newest() is None:
            raise TransformError("no pose of the robot yet: publish odometry and scans, or the pose itself")
        if not self._changed:
            self._tracking.predict()
        seen = self._reporter.people(self._frames.base, now)
        self.context.publish(topics.PEOPLE_MEASUREMENTS.name, seen.measurements)
        if self._own.tf_broadcast and seen.frames:
            self.context.publish(topics.TF.name, TFMessage(seen.frames))
        report = self._reporter.report(seen, self._follower, now)
        self.context.publish(topics.PEOPLE_REPORT.name, report)

    def _tell(self, reason: str) -> None:
        """Publish the reason for which nothing is reported, if it has changed."""
        if reason != self._status:
            self._status = reason
            self.context.publish(topics.PEOPLE_TRACKER_STATUS.name, String(reason))

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the tracks and their Torso IDs, and the views of the detectors."""
        return msgspec.json.encode(PeopleTrackerState(self._tracking.state(), self._person_frames.ids.state()))

    def restore(self, state: bytes) -> None:
        """Go on with the tracks of a checkpoint."""
        restored = from_json(state, PeopleTrackerState)
        self._tracking.restore(restored.tracking)
        self._person_frames.ids.restore(restored.torso_ids)

    def carry_over(self, state: bytes) -> None:
        """Begin without the people of another map."""
