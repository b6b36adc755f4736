"""Node ``diagnostics``: a robot is watched while somebody asks, and each kind of fault in its messages is found."""

import math
from collections.abc import Callable

import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.rules.place import place
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist, Vector3
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray, DiagnosticStatus
from ppaas.messages.health.watching import ObserveRequest
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.diagnostics.node import IDLE, MOST_REPORTS
from ppaas.transforms.planar import transform_message
from ppaas.zones.zone import KeepOut, ZoneSet
from tests.support.world.diagnosed_robot import DiagnosedRobot, kinds
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

Sends = Callable[[DiagnosedRobot, int], None]


def test_healthy_robot_has_no_warning() -> None:
    found = DiagnosedRobot().findings(DiagnosedRobot.well)
    assert kinds(found) == ["localization-silent"]  # there is no amcl in this graph


# -- faults in messages ------------------------------------------------------------------------------------------------


def only_scans(robot: DiagnosedRobot, number: int) -> None:
    robot.send("scan", robot.scan())


def unknown_frame(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    robot.send("scan", robot.scan("laser"))


def five_behind(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry(late=5.0))
    robot.send("scan", robot.scan(late=5.0))


def scans_behind(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    robot.send("scan", robot.scan(late=4.0))


def clock_set_back(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    robot.send("odom", robot.odometry(late=0.5))


def slow_scans(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    if number % 20 == 0:
        robot.send("scan", robot.scan())


def in_millimetres(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    robot.send("scan", robot.scan(ranges=[2000.0] * 180))


def in_degrees(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    robot.send("scan", robot.scan(angle_increment=2.0))


def blind(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry())
    robot.send("scan", robot.scan(ranges=[None] * 180))


def of_a_camera(robot: DiagnosedRobot, number: int) -> None:
    robot.send("scan", robot.scan())
    robot.send("odom", robot.odometry(child="camera_pose_frame"))


def two_odometries(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    pose = Pose2D(3.0 * (number % 2), 0.0, 0.0)
    robot.send("tf", TFMessage([transform_message("odom", "base_link", pose, robot.stamp)]))


def two_parents(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    parent = "odom_combined" if number % 2 else "odom"
    robot.send("tf", TFMessage([transform_message(parent, "base_link", Pose2D(0.0, 0.0, 0.0), robot.stamp)]))


def in_a_loop(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    for parent, child in (("wheel", "axle"), ("axle", "wheel")):
        robot.send("tf", TFMessage([transform_message(parent, child, Pose2D(0.0, 0.0, 0.0), robot.stamp)]))


def stands(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    robot.graph.publish("cmd_vel", Twist(Vector3(x=0.3), Vector3()))


def turns_the_other_way(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry(Pose2D(0.0, 0.0, -0.02 * number)))
    robot.send("scan", robot.scan())
    robot.graph.publish("cmd_vel", Twist(Vector3(), Vector3(z=0.4)))


def jumps(robot: DiagnosedRobot, number: int) -> None:
    robot.send("odom", robot.odometry(Pose2D(5.0 if number == 40 else 0.0, 0.0, 0.0)))
    robot.send("scan", robot.scan())


def teleoperated(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    robot.send("cmd_vel", Twist(), sender=7)


def waits(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    goal = GoalStatus(GoalID(id="g1"), Status.ACTIVE, "waiting: the path is blocked by people")
    robot.graph.publish("move_base/status", GoalStatusArray(status_list=[goal]))


def without_localization(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    robot.graph.publish("amcl/status", String("scans are stamped 3.0 s ahead of the newest odometry"))


def reports_its_battery(robot: DiagnosedRobot, number: int) -> None:
    robot.well(number)
    robot.send("diagnostics", DiagnosticArray(status=[DiagnosticStatus(1, "battery", "21 %")]))


@pytest.mark.parametrize(
    ("sends", "kind", "words"),
    [
        (lambda robot, number: None, "scan-missing", "No scan has come"),
        (only_scans, "odom-missing", "No odometry has come"),
        (unknown_frame, "frames-laser-unknown", "'laser', has no transform to 'base_link'"),
        (five_behind, "clock-skew", "5.0 s behind"),
        (scans_behind, "scan-odom-clocks", "4.0 s before"),
        (clock_set_back, "stamps-backwards", "Stamps of 'odom' ran backwards"),
        (slow_scans, "scan-slow", "1.0 Hz only"),
        (in_millimetres, "scan-no-readings", "outside range_min and range_max"),
        (in_degrees, "scan-angles", "more than one turn"),
        (blind, "scan-no-readings", "null, NaN or infinite"),
        (of_a_camera, "messages-refused", "camera_pose_frame"),
        (two_odometries, "frames-two-senders", "'base_link': it jumps to and fro"),
        (two_parents, "frames-two-parents", "odom"),
        (in_a_loop, "frames-loop", "wheel"),
        (stands, "base-does-not-follow", "odometry moved 0.00 m"),
        (turns_the_other_way, "turn-reversed", "wrong sign"),
        (jumps, "odom-jumps", "5.0 m"),
        (teleoperated, "cmd-vel-others", "Another client"),
        (waits, "goal-waits", "blocked by people"),
        (without_localization, "localization-without-scans", "3.0 s ahead"),
        (reports_its_battery, "robot-reports", "battery: 21 %"),
    ],
)
def test_each_fault_of_a_robot_is_found_in_its_messages(sends: Sends, kind: str, words: str) -> None:
    found = DiagnosedRobot().findings(sends)
    [finding] = [each for each in found if each.kind == kind]
    assert words in finding.text
    assert finding.level != "ok"


@pytest.mark.parametrize(
    ("x", "sigma", "kind"),
    [(50.0, 0.01, "pose-outside-map"), (0.02, 0.01, "pose-in-obstacle"), (0.15, 0.01, "footprint-in-obstacle"),
     (1.5, 3.0, "localization-lost")],
)  # fmt: skip
def test_place_of_the_robot_is_compared_with_its_map(x: float, sigma: float, kind: str) -> None:
    layers = build_layers(walled_map(4, 4, []))
    robot = DiagnosedRobot(WatchedRobot(layers=lambda: layers, radius=lambda: 0.3))
    answers = robot.ask(1.0)
    robot.node._heard("amcl_pose", pose_at(x, sigma))
    robot.run(1.1, DiagnosedRobot.well)
    [seen] = answers
    assert seen.place.pose == pytest.approx((x, 2.0, 0.0))
    expected = {"pose-outside-map": "outside", "pose-in-obstacle": "occupied"}.get(kind, "free")
    assert seen.place.cell == expected
    assert kind in kinds(list(place(seen)))
    assert seen.place.deviation == pytest.approx(math.sqrt(2.0) * sigma)


def test_a_robot_in_a_keep_out_zone_is_told_its_name() -> None:
    layers = build_layers(walled_map(4, 4, []), zones=ZoneSet([rectangle(KeepOut(name="spill"), 1.0, 1.0, 3.0, 3.0)]))
    robot = DiagnosedRobot(WatchedRobot(layers=lambda: layers, radius=lambda: 0.3))
    answers = robot.ask(1.0)
    robot.node._heard("amcl_pose", pose_at(1.5, 0.01))
    robot.run(1.1, DiagnosedRobot.well)
    [finding] = [each for each in place(answers[0]) if each.kind == "pose-in-zone"]
    assert "the robot is in the keep-out zone 'spill'." in finding.text


def pose_at(x: float, sigma: float) -> PoseWithCovarianceStamped:
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = sigma**2
    header = Header(stamp=Time(), frame_id="map")
    return PoseWithCovarianceStamped(header, PoseWithCovariance(Pose.of(Pose2D(x, 2.0, 0.0)), covariance))


# -- when it watches ---------------------------------------------------------------------------------------------------


def test_nothing_is_heard_until_somebody_asks_and_some_time_after() -> None:
    robot = DiagnosedRobot()
    robot.run(2.0, DiagnosedRobot.well)
    assert not robot.node.watches
    assert not robot.graph.has_taps("scan")
    robot.ask()
    assert robot.graph.has_taps("scan")
    robot.run(IDLE + 2.0, DiagnosedRobot.well, period=0.5)
    assert not robot.node.watches
    assert not robot.graph.has_taps("scan")


def test_first_answer_waits_and_the_next_ones_come_at_once() -> None:
    robot = DiagnosedRobot()
    first = robot.ask(2.0)
    robot.run(1.9, DiagnosedRobot.well)
    assert first == []
    robot.run(0.2, DiagnosedRobot.well)
    assert [round(seen.seconds, 1) for seen in first] == [2.0]
    assert len(robot.ask(2.0)) == 1
    robot.run(5.0, DiagnosedRobot.well)
    assert len(first) == 1


@pytest.mark.parametrize("seconds", [-1.0, 9.0, math.nan, math.inf])
def test_time_out_of_range_is_refused(seconds: float) -> None:
    answers: list[object] = []
    DiagnosedRobot().graph.call("diagnostics/observe", ObserveRequest(seconds), answers.append)
    assert isinstance(answers[0], InvalidInput)


def test_findings_are_published_once_a_second_while_a_client_subscribes() -> None:
    robot, heard = DiagnosedRobot(), []
    untap = robot.graph.tap("diagnostics", lambda topic, message: heard.append(message))
    robot.run(5.0, unknown_frame)
    assert len(heard) in (4, 5)
    levels = {status.name: status.level for status in heard[-1].status}
    assert levels["ppaas: frames-laser-unknown"] == 2
    assert "advice" in {value.key for value in heard[-1].status[0].values}
    untap()
    robot.run(3.0, unknown_frame)
    assert len(heard) in (4, 5)


def test_own_findings_are_not_taken_for_reports_of_the_robot() -> None:
    robot = DiagnosedRobot()
    robot.graph.tap("diagnostics", lambda topic, message: None)
    robot.run(4.0, unknown_frame)
    assert robot.ask()[0].reports == []


def test_number_of_reports_is_bounded_and_old_ones_expire() -> None:
    robot = DiagnosedRobot()
    statuses = [DiagnosticStatus(1, f"part {number}" + "x" * 999, "y" * 999) for number in range(2 * MOST_REPORTS)]
    robot.send("diagnostics", DiagnosticArray(status=statuses))
    [seen] = robot.ask()
    assert len(seen.reports) == MOST_REPORTS
    assert max(len(report.name) + len(report.text) for report in seen.reports) == 400
    robot.run(11.0, DiagnosedRobot.well, period=0.5)
    assert robot.ask()[0].reports == []


def test_stamp_beyond_all_clocks_does_no_harm() -> None:
    robot = DiagnosedRobot()
    robot.ask()
    scan = robot.scan()
    scan.header.stamp = Time(10**400)
    robot.node._heard("scan", scan)
    robot.run(3.0, DiagnosedRobot.well)
    assert robot.ask()[0].topic("scan").rate > 5.0
