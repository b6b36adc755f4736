"""A clone while sensors or base of its robot fail: it stops, states the reason, and continues afterwards."""

import math
from collections.abc import Callable

import pytest
from msgspec.structs import replace

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Point, Pose, Quaternion
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Payload
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, walled_map

START, GOAL = Pose2D(1.0, 1.0, math.pi / 2), Pose2D(6.0, 6.0, 0.0)
RADIUS = 0.18
BLIND = "no beam of the scan has a reading, although by the map half of them should"

Scans = Callable[[LaserScan], LaserScan]
Odometries = Callable[[Odometry], Odometry]
Commands = Callable[[float, float], tuple[float, float]]


class FailingWorld(World):
    """A world in which sensors and base can be made to fail for a time."""

    scans: Scans | None = None
    odometries: Odometries | None = None
    commands: Commands | None = None

    def scan(self, stamp: float) -> LaserScan:
        scan = super().scan(stamp)
        return scan if self.scans is None else self.scans(scan)

    def odometry(self, stamp: float) -> Odometry:
        odometry = super().odometry(stamp)
        return odometry if self.odometries is None else self.odometries(odometry)

    def move(self, linear: float, angular: float, seconds: float, steps: int = 5) -> None:
        if self.commands is not None:
            linear, angular = self.commands(linear, angular)
        super().move(linear, angular, seconds, steps)


class Drive(ClosedLoop):
    """A drive to a goal; the robot receives rejections and continues."""

    def __init__(self) -> None:
        self.refused: list[str] = []
        self.failing = FailingWorld(walled_map(8, 8, [(3.9, 2.2, 4.1, 5.8)]), START)
        super().__init__(self.failing)
        self.go_on(0.3)
        self.send_goal(GOAL)
        self.go_on(3.0)
        assert self.command.linear.x > 0.1

    def sense(self, topic: str, message: Payload) -> None:
        try:
            super().sense(topic, message)
        except PPaaSError as error:
            self.refused.append(str(error))

    def go_on(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.step()

    def is_stopped(self) -> bool:
        return (self.command.linear.x, self.command.angular.z) == (0.0, 0.0)

    def end_well(self) -> None:
        """Repair everything; the robot arrives without having touched anything."""
        self.failing.scans = self.failing.odometries = self.failing.commands = None
        self.run(90.0)
        assert self.last_status() is Status.SUCCEEDED, self.results[-1].status.text
        assert error_of(self.world.pose, GOAL)[0] < 0.2
        assert self.clearance > RADIUS


def all_ranges(value: float | None) -> Scans:
    return lambda scan: replace(scan, ranges=[value] * len(scan.ranges))


def shifted(seconds: float) -> Scans:
    return lambda scan: replace(scan, header=replace(scan.header, stamp=Time.of(scan.header.stamp.seconds() + seconds)))


@pytest.mark.parametrize(
    ("scans", "reason"),
    [
        pytest.param(all_ranges(math.nan), BLIND, id="nan"),
        pytest.param(all_ranges(0.0), BLIND, id="zero"),
        pytest.param(all_ranges(-1.0), BLIND, id="negative"),
        pytest.param(all_ranges(math.inf), BLIND, id="infinite"),
        pytest.param(all_ranges(None), BLIND, id="null"),
        pytest.param(lambda scan: replace(scan, ranges=scan.ranges[:50]), "181 ranges, not 50", id="count"),
        pytest.param(lambda scan: replace(scan, angle_min=math.nan), "must be finite numbers", id="angles"),
        pytest.param(
            lambda scan: replace(scan, header=replace(scan.header, frame_id="mars")), "unknown frame 'mars'", id="frame"
        ),
        pytest.param(shifted(-5.0), "5.0 s before the newest odometry", id="late"),
    ],
)
def test_robot_stops_on_invalid_scans_and_continues_afterwards(scans: Scans, reason: str):
    driving = Drive()
    driving.failing.scans = scans
    driving.go_on(1.3)
    stood = driving.world.pose
    driving.go_on(6.0)
    assert driving.is_stopped()
    assert driving.world.pose == stood
    assert all(reason in refusal for refusal in driving.refused)
    assert len(driving.refused) > 50
    assert any(text.startswith("waiting: no localization for") for text in driving.texts)
    assert not driving.results, "it keeps its goal"
    driving.end_well()


def test_robot_waits_while_scans_are_from_the_future():
    driving = Drive()
    driving.failing.scans = shifted(3.0)
    driving.go_on(2.0)
    assert driving.is_stopped()
    assert any(text.startswith("waiting: no localization for") for text in driving.texts)
    driving.end_well()


def test_non_finite_odometry_stops_the_robot():
    driving = Drive()
    nowhere = Pose(Point(math.nan, 0.0), Quaternion(z=0.0, w=1.0))
    driving.failing.odometries = lambda odometry: replace(odometry, pose=replace(odometry.pose, pose=nowhere))
    driving.go_on(2.0)
    assert driving.is_stopped()
    assert "finite" in driving.refused[-1]
    assert any(text.startswith("waiting: no odometry for") for text in driving.texts)
    driving.end_well()


@pytest.mark.parametrize("back", [5.0, 20.0])
def test_robot_reaches_its_goal_after_its_clock_was_set_back(back: float):
    driving = Drive()
    driving.failing.scans = shifted(-back)
    driving.failing.odometries = lambda odometry: replace(
        odometry, header=replace(odometry.header, stamp=Time.of(odometry.header.stamp.seconds() - back))
    )
    driving.go_on(8.0)
    assert error_of(driving.told, driving.world.pose)[0] < 0.15
    driving.end_well()


def test_restart_of_odometry_at_another_pose_is_tolerated():
    driving = Drive()
    start = Pose2D(3.0, 1.5, 1.0)
    driving.failing.odometries = lambda odometry: replace(
        odometry, pose=replace(odometry.pose, pose=Pose.of(start @ odometry.pose.pose.planar()))
    )
    driving.go_on(4.0)
    assert error_of(driving.told, driving.world.pose)[0] < 0.15
    driving.end_well()


@pytest.mark.parametrize(
    "commands",
    [
        pytest.param(lambda linear, angular: (0.0, 0.0), id="no motion"),
        pytest.param(lambda linear, angular: (0.1 * linear, 0.1 * angular), id="slow motion"),
        pytest.param(lambda linear, angular: (-linear, -angular), id="reversed motion"),
    ],
)
def test_base_that_ignores_commands_is_stopped_and_retried(commands: Commands):
    driving = Drive()
    driving.failing.commands = commands
    start, sent = driving.world.pose, len(driving.commands)
    driving.go_on(10.0)
    assert any(text.startswith("waiting: the base does not follow cmd_vel: ") for text in driving.texts)
    assert start.distance_to(driving.world.pose) < 0.6
    stops = [command.linear.x == 0.0 for command in driving.commands[sent:]]
    assert any(stops)
    assert not driving.results
    driving.end_well()


def test_goal_is_aborted_if_the_base_never_follows_commands():
    driving = Drive()
    driving.failing.commands = lambda linear, angular: (0.0, 0.0)
    driving.run(150.0)
    assert driving.last_status() is Status.ABORTED
    text = driving.results[-1].status.text
    assert text.startswith("Robot does not follow cmd_vel. Even after executing recovery behaviors. ")
    assert "the base does not follow cmd_vel" in text
    assert driving.is_stopped()


def test_moving_goal_is_followed_and_reached():
    driving = Drive()
    driving.go_on(0.05)
    for step in range(12):
        driving.send_goal(Pose2D(6.0, 6.0 - 0.3 * step, 0.0))
        driving.go_on(0.5)
    driving.run(60.0)
    assert [result.status.status for result in driving.results] == [Status.PREEMPTED] * 12 + [Status.SUCCEEDED]
    assert error_of(driving.world.pose, Pose2D(6.0, 2.7, 0.0))[0] < 0.2
    assert driving.clearance > RADIUS
