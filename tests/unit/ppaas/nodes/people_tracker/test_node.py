"""Node ``people_tracker``: robots of any make report the people they see, each with a frame of its own."""

import contextlib
import math
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, TransformStamped
from ppaas.messages.people_coordination import FOLLOWING, FollowStatus, PeopleReport, SensorView
from ppaas.messages.people_msgs import People, Person, PositionMeasurement, PositionMeasurementArray
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.vision_msgs import Detection3D, Detection3DArray, ObjectHypothesis, ObjectHypothesisWithPose
from ppaas.nodes import topics
from ppaas.nodes.graph import Graph
from ppaas.nodes.people_tracker.node import PeopleTrackerNode
from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters
from ppaas.transforms.planar import transform_message

ROBOT = Pose2D(3.0, 2.0, 0.5)
"""Pose of the robot in the map."""
ODOM = Pose2D(1.0, 0.0, 0.2)
COVARIANCE = [0.04 if k in (0, 7) else 0.01 if k == 35 else 0.0 for k in range(36)]
VIEW = SensorView(0.1, 0.0, 0.0, 1.0, 0.5, 5.0)


class Robot:
    """A graph with the tracker, and a robot that stands in it; its clock may differ from that of the cloud."""

    def __init__(self, ahead: float = 0.0, **parameters: Any) -> None:
        self.clock = ManualClock(1_000.0)
        self.ahead = ahead
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.graph.add(lambda context: PeopleTrackerNode(context, PeopleTrackerParameters(**parameters), "tb1"))
        self.heard: dict[str, list[Any]] = {}
        for topic in (topics.PEOPLE_REPORT, topics.PEOPLE_MEASUREMENTS, topics.PEOPLE_TRACKER_STATUS, topics.TF):
            self.graph.tap(topic.name, lambda name, message: self.heard.setdefault(name, []).append(message))

    @property
    def stamp(self) -> Time:
        return Time.of(self.clock() + self.ahead)

    def stand(self, robot: Pose2D = ROBOT) -> None:
        """Publish odometry and where the robot is."""
        later = Time.of(self.clock() + self.ahead + 0.1)
        correction = transform_message("map", "odom", robot @ ODOM.inverse(), later)
        self.send(topics.TF.name, TFMessage([correction, transform_message("odom", "base_link", ODOM, self.stamp)]))
        pose = PoseWithCovariance(Pose.of(robot), COVARIANCE)
        self.send(topics.AMCL_POSE.name, PoseWithCovarianceStamped(Header(stamp=self.stamp, frame_id="map"), pose))

    def send(self, topic: str, message: Any) -> None:
        self.graph.inject(topic, message)

    def detect(self, *places: tuple[float, float], topic: str = topics.TORSO_MEASUREMENTS.name, **fields: Any) -> None:
        """Publish measurements in the robot's frame."""
        header = Header(stamp=self.stamp, frame_id="base_link")
        people = [PositionMeasurement(header, "detector", str(k), Point(*p), **fields) for k, p in enumerate(places)]
        self.send(topic, PositionMeasurementArray(header, people))

    def tell(self, *people: tuple[str, float, float], frame: str = "base_link", late: float = 0.0) -> None:
        """Publish people as a robot of another make does."""
        header = Header(stamp=Time.of(self.clock() + self.ahead - late), frame_id=frame)
        self.send("people", People(header, [Person(name, Point(x, y)) for name, x, y in people]))

    def pass_time(self, seconds: float = 0.1) -> None:
        self.clock.advance(seconds)
        self.graph.run_due()

    @property
    def report(self) -> PeopleReport:
        """The last report, as it arrives after the wire."""
        report = decode(PeopleReport, encode(self.heard[topics.PEOPLE_REPORT.name][-1]))
        assert isinstance(report, PeopleReport)
        return report


def place_of(person: PositionMeasurement) -> tuple[float, float]:
    return person.pos.x, person.pos.y


def frames_of(heard: Sequence[TFMessage]) -> list[TransformStamped]:
    return [each for message in heard for each in message.transforms if each.child_frame_id.startswith("tb1/")]


def test_person_of_a_detector_is_reported_with_a_frame_the_pose_of_the_robot_and_the_view():
    robot = Robot()
    robot.send(topics.TORSO_VIEW.name, VIEW)
    for _ in range(3):
        robot.stand()
        robot.detect((2.0, 0.5, 1.2), covariance=[0.01, 0, 0, 0, 0.02, 0, 0, 0, 0.01])
        robot.pass_time()
    report = robot.report
    assert (report.robot, report.header.frame_id, report.header.stamp) == ("tb1", "map", Time.of(1_000.2))
    assert report.pose.pose.planar() == pytest.approx(ROBOT, abs=1e-6)
    assert report.pose.covariance == COVARIANCE
    assert report.views == [VIEW]
    [person] = report.people
    assert (person.name, person.object_id) == ("tb1/torso_1", "torso_1")
    assert person.pos == Point(pytest.approx(2.0), pytest.approx(0.5), pytest.approx(1.2))
    assert person.covariance[:5] == pytest.approx([0.01, 0.0, 0.0, 0.0, 0.02])
    frame = frames_of(robot.heard["tf"])[-1]
    assert (frame.header.frame_id, frame.child_frame_id) == ("base_link", "tb1/torso_1")
    assert frame.transform.translation.x == pytest.approx(2.0)
    assert robot.heard[topics.PEOPLE_MEASUREMENTS.name][-1].people == report.people


def test_detector_that_is_silent_has_no_view_in_which_people_would_be_missing():
    robot = Robot()
    robot.send(topics.TORSO_VIEW.name, VIEW)
    for step in range(20):
        robot.stand()
        if step < 5:
            robot.detect((2.0, 0.0))
        robot.pass_time()
    reports = robot.heard[topics.PEOPLE_REPORT.name]
    assert [(len(report.people), len(report.views)) for report in (reports[4], reports[-1])] == [(1, 1), (0, 0)]


def test_report_without_people_follows_once_a_second_and_tells_what_the_robot_does():
    robot = Robot()
    robot.send(topics.FOLLOW_STATUS.name, FollowStatus(Header(), FOLLOWING, 7))
    for _ in range(25):
        robot.stand()
        robot.pass_time()
    reports = robot.heard[topics.PEOPLE_REPORT.name]
    assert 2 <= len(reports) <= 3
    assert (robot.report.people, robot.report.can_follow, robot.report.following) == ([], True, 7)


def test_nothing_is_reported_without_a_pose_and_the_status_says_why():
    robot = Robot()
    robot.detect((2.0, 0.0))
    robot.pass_time(1.0)
    assert "publish odometry" in robot.heard[topics.PEOPLE_TRACKER_STATUS.name][-1].data
    robot.send(topics.TF.name, TFMessage([transform_message("odom", "base_link", ODOM, robot.stamp)]))
    robot.pass_time(1.0)
    assert "not localized yet" in robot.heard[topics.PEOPLE_TRACKER_STATUS.name][-1].data
    assert topics.PEOPLE_REPORT.name not in robot.heard
    robot.stand()
    robot.pass_time(1.0)
    assert "left out" in robot.heard[topics.PEOPLE_TRACKER_STATUS.name][-1].data, "that from before the first odometry"
    robot.stand()
    robot.detect((2.0, 0.0))
    robot.pass_time()
    assert robot.heard[topics.PEOPLE_TRACKER_STATUS.name][-1].data == ""
    assert topics.PEOPLE_REPORT.name in robot.heard


@pytest.mark.parametrize("frame", ["base_link", "map", "odom"])
def test_robot_of_another_make_sends_people_in_any_frame(frame):
    robot = Robot()
    base_in = {"base_link": Pose2D(0.0, 0.0), "map": ROBOT, "odom": ODOM}[frame]
    place = base_in @ Pose2D(2.0, -1.0)
    for _ in range(2):
        robot.stand()
        robot.tell(("alice", place.x, place.y), frame=frame)
        robot.pass_time()
    [person] = robot.report.people
    assert place_of(person) == pytest.approx((2.0, -1.0))
    assert person.object_id == "torso_1"


def test_robot_of_another_make_sends_detections_of_which_people_alone_count():
    robot = Robot()
    header = Header(stamp=robot.stamp, frame_id="base_link")

    def thing(kind: str, x: float) -> Detection3D:
        pose = PoseWithCovariance(Pose.of(Pose2D(x, 0.0)))
        return Detection3D(header, [ObjectHypothesisWithPose(ObjectHypothesis(kind, 0.9), pose)], id=kind)

    robot.stand()
    robot.send("detections", Detection3DArray(header, [thing("person", 2.0), thing("dog", 3.0), Detection3D(header)]))
    robot.pass_time()
    assert [place_of(person) for person in robot.report.people] == [pytest.approx((2.0, 0.0))]


def test_robot_of_another_make_publishes_frames_and_keeps_its_own_torso_ids():
    robot = Robot()
    for _ in range(3):
        robot.stand()
        person = transform_message("base_link", "tb1/17", Pose2D(2.0, 0.3), robot.stamp)
        robot.send(topics.TF.name, TFMessage([person]))
        robot.pass_time()
    [person] = robot.report.people
    assert (person.name, person.object_id) == ("tb1/17", "17")
    assert len(frames_of(robot.heard["tf"])) == 3, "those of the robot alone"


def test_frames_of_people_that_come_back_and_those_of_other_robots_are_no_detections():
    robot = Robot()
    robot.stand()
    robot.detect((2.0, 0.0))
    robot.pass_time()
    own = robot.heard["tf"][-1]
    robot.pass_time(1.0)
    robot.stand()
    robot.send(topics.TF.name, decode(TFMessage, encode(own)))
    other = transform_message("base_link", "tb2/torso_1", Pose2D(4.0, 0.0), robot.stamp)
    wheel = transform_message("base_link", "tb1/wheel_1", Pose2D(0.0, 0.1), robot.stamp)
    robot.send(topics.TF.name, TFMessage([other, wheel]))
    robot.pass_time(1.0)
    assert robot.report.people == []


def test_person_keeps_the_torso_id_while_legs_and_torso_are_detected_in_turn():
    robot, ids = Robot(), set()
    for step in range(30):
        robot.stand()
        x = 2.0 + 0.06 * step
        robot.detect((x, 0.0), topic=(topics.LEG_MEASUREMENTS, topics.TORSO_MEASUREMENTS)[step % 2].name)
        robot.pass_time()
        ids |= {person.object_id for person in robot.report.people}
    assert ids == {"torso_1"}


@pytest.mark.parametrize("ahead", [0.5, -0.5, -1e6])
def test_clock_of_the_robot_that_is_off_is_corrected_in_reports(ahead):
    robot = Robot(ahead)
    for _ in range(3):
        robot.stand()
        robot.detect((2.0, 0.0))
        robot.pass_time()
    assert robot.report.header.stamp.seconds() == pytest.approx(1_000.2, abs=0.01)
    assert len(robot.report.people) == 1


def test_clock_of_a_detector_that_is_off_is_corrected_by_that_of_the_odometry():
    robot = Robot()
    for step in range(20):
        robot.stand(Pose2D(3.0, 2.0, 0.5))
        robot.tell(("a", 2.0 + 0.1 * step, 0.0), late=0.5)
        robot.pass_time()
    assert robot.report.header.stamp.seconds() == pytest.approx(1_001.9, abs=0.01)
    [person] = robot.report.people
    assert place_of(person) == pytest.approx((3.9, 0.0), abs=1e-3)


def test_detections_that_are_out_of_date_are_refused_with_a_reason():
    robot = Robot()
    for _ in range(3):
        robot.stand()
        robot.tell(("a", 2.0, 0.0))
        robot.pass_time()
    with pytest.raises(InvalidInput, match=r"stamped 3\.0 s earlier"):
        robot.tell(("a", 2.0, 0.0), late=3.0)


def test_id_that_a_robot_gives_to_another_person_does_not_move_the_first_one():
    robot = Robot()
    for step in range(12):
        robot.stand()
        robot.tell(("1", *((2.0, 0.0) if step < 6 else (2.0, 3.0))))
        robot.pass_time()
    ids = {person.object_id: place_of(person) for person in robot.report.people}
    assert ids["torso_2"] == pytest.approx((2.0, 3.0))
    assert ids.get("torso_1", (2.0, 0.0)) == pytest.approx((2.0, 0.0), abs=0.1)


@pytest.mark.parametrize(
    "wrong",
    [
        {"pos": Point(math.nan, 0.0)},
        {"pos": Point(1.0, math.inf)},
        {"reliability": 1.5},
        {"reliability": math.nan},
        {"covariance": [math.nan] * 9},
    ],
)
def test_numbers_that_are_not_valid_are_refused_and_the_tracker_goes_on(wrong):
    robot = Robot()
    robot.stand()
    header = Header(stamp=robot.stamp, frame_id="base_link")
    fields: dict[str, Any] = {"pos": Point(1.0, 0.0), **wrong}
    with pytest.raises(InvalidInput, match="person"):
        robot.send(
            topics.TORSO_MEASUREMENTS.name,
            PositionMeasurementArray(header, [PositionMeasurement(header, "t", "1", **fields)]),
        )
    robot.detect((2.0, 0.0))
    robot.pass_time()
    assert len(robot.report.people) == 1


def test_view_that_is_not_valid_is_refused_and_the_one_before_is_reported():
    robot = Robot()
    robot.send(topics.TORSO_VIEW.name, VIEW)
    with pytest.raises(InvalidInput, match="view of the detector"):
        robot.send(topics.TORSO_VIEW.name, SensorView(0.0, 0.0, 0.0, math.nan, 0.5, 5.0))
    robot.stand()
    robot.detect((2.0, 0.0))
    robot.pass_time()
    assert robot.report.views == [VIEW]


def test_unknown_frames_and_crowds_of_thousands_are_refused():
    robot = Robot()
    robot.stand()
    with pytest.raises(TransformError, match="nowhere"):
        robot.tell(("a", 1.0, 0.0), frame="nowhere")
    with pytest.raises(InvalidInput, match="at most 200"):
        robot.tell(*[("a", 1.0, 0.0)] * 201)


def test_covariance_that_no_matrix_can_have_is_limited():
    robot = Robot()
    robot.stand()
    robot.detect((2.0, 0.0), covariance=[-1.0, 9.0, 0, 9.0, 1e9, 0, 0, 0, 1])
    robot.pass_time()
    xx, xy, yx, yy = (robot.report.people[0].covariance[k] for k in (0, 1, 3, 4))
    assert 0.0 < xx < yy <= 4.1
    assert xy == yx
    assert xx * yy > xy * yx


def test_tracker_goes_on_from_a_checkpoint_in_the_other_home():
    robot, other = Robot(), Robot()
    robot.send(topics.TORSO_VIEW.name, VIEW)
    for _ in range(3):
        robot.stand()
        robot.detect((2.0, 0.0), (2.0, 2.0))
        robot.pass_time()
    other.clock.advance(0.3)
    other.graph.restore(robot.graph.checkpoints())
    other.stand()
    other.detect((2.05, 2.0), (2.05, 0.0))
    other.pass_time()
    before = {person.object_id: place_of(person)[1] for person in robot.report.people}
    after = {person.object_id: place_of(person)[1] for person in other.report.people}
    assert after == pytest.approx(before)
    assert other.report.views == [VIEW]


def test_people_of_another_map_are_forgotten():
    robot, other = Robot(), Robot()
    for _ in range(3):
        robot.stand()
        robot.detect((2.0, 0.0))
        robot.pass_time()
    other.graph.restore(robot.graph.checkpoints(), of_other_map=True)
    other.stand()
    other.pass_time()
    assert robot.report.people and not other.report.people


def test_robot_without_odometry_takes_part_by_its_pose_on_the_map():
    robot = Robot()
    for _ in range(4):
        header = Header(stamp=robot.stamp, frame_id="map")
        pose = PoseWithCovarianceStamped(header, PoseWithCovariance(Pose.of(ROBOT), COVARIANCE))
        robot.send(topics.AMCL_POSE.name, pose)
        robot.tell(("a", 2.0, 0.0))
        robot.pass_time()
    assert robot.report.pose.pose.planar() == pytest.approx(ROBOT, abs=1e-6)
    assert [place_of(person) for person in robot.report.people] == [pytest.approx((2.0, 0.0))]


def test_people_are_forgotten_when_the_odometry_jumps():
    robot = Robot()
    for _ in range(3):
        robot.stand()
        robot.detect((2.0, 0.0))
        robot.pass_time()
    jumped = transform_message("odom", "base_link", Pose2D(30.0, 0.0), robot.stamp)
    robot.send(topics.TF.name, TFMessage([jumped]))
    robot.detect((2.0, 0.0))
    robot.pass_time()
    assert [person.object_id for person in robot.report.people] == ["torso_2"]


Numbers = st.floats(allow_nan=True, allow_infinity=True, width=32)
Wild = st.one_of(st.floats(-3.0, 6.0), Numbers)


@given(
    st.lists(
        st.tuples(st.sampled_from([-2.0, -0.5, 0.0, 0.1, 0.7]), st.lists(st.tuples(Wild, Wild, Wild), max_size=3)),
        min_size=1,
        max_size=6,
    )
)
def test_whatever_a_robot_sends_its_reports_are_finite_and_their_covariances_valid(steps):
    robot = Robot()
    robot.send(topics.TORSO_VIEW.name, VIEW)
    for late, people in steps:
        robot.stand()
        header = Header(stamp=Time.of(robot.clock() - late), frame_id="base_link")
        found = [
            PositionMeasurement(header, "t", "1", Point(x, y), 0.9, [c, c, 0.0, c, 1.0, 0.0, 0.0, 0.0, 1.0])
            for x, y, c in people
        ]
        with contextlib.suppress(InvalidInput, TransformError):
            robot.send(topics.TORSO_MEASUREMENTS.name, PositionMeasurementArray(header, found))
        robot.pass_time()
    for report in robot.heard.get(topics.PEOPLE_REPORT.name, []):
        assert len({person.object_id for person in report.people}) == len(report.people)
        for person in report.people:
            assert all(map(math.isfinite, (person.pos.x, person.pos.y, *person.covariance)))
            xx, xy, yy = (person.covariance[k] for k in (0, 1, 4))
            assert xx > 0.0
            assert xx * yy > xy * xy
