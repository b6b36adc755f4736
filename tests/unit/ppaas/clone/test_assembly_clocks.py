"""A clone while clocks of its robot are set: it continues at once, or its status names the cause.

Members of the kind: the robot's clock is set back or ahead by parts of a second (a leap second), by seconds (NTP), by
an hour (daylight saving time written into stamps), or to another year (no battery); the clock of the base or of the
laser alone is set; the two are apart from the start; the robot restarts, so that its odometry is reset, too; and the
clock of the cloud is set. In the code: buffers of transforms, the order of scans, scans that wait, tracks of moving
objects, resets of odometry, the alignment of a robot that stands, every duration of Move Base, leases of nodes on the
robot, and positions of other robots.
"""

import pytest
from msgspec.structs import replace

from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import Odometry
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.places import free_pose, reachable_pose
from tests.support.world.planar_world import error_of
from tests.support.world.simulated_world import SimulatedWorld
from tests.unit.ppaas.clone.test_assembly_bad_senses import Drive, Odometries, shifted

SERVED = 2.0
"""Longest time without a pose after a clock was set [s]."""

STEPS = [-1e9, -3600.0, -12.0, -9.9, -8.0, -5.0, -2.0, -1.0, -0.5, -0.15, 0.3, 1.0, 2.0, 12.0, 3600.0, 1e8]
"""Steps of clocks; the drive begins at 1000 s, and stamps before 1970 do not exist [s]."""


def odometry_shifted(seconds: float) -> Odometries:
    def changed(odometry: Odometry) -> Odometry:
        stamp = Time.of(max(odometry.header.stamp.seconds() + seconds, 1.0))
        return replace(odometry, header=replace(odometry.header, stamp=stamp))

    return changed


class WatchedDrive(Drive):
    """A drive that measures how long no pose is told, by the clock of the cloud."""

    def __init__(self) -> None:
        super().__init__()
        self._last = self.clock()
        self.gap = 0.0
        self.graph.tap("amcl_pose", lambda *_: self._count())

    def _count(self) -> None:
        self.gap = max(self.gap, self.clock() - self._last)
        self._last = self.clock()

    def set_clocks(self, *, base: float, laser: float) -> None:
        """Set the clocks of base and laser by a time [s]."""
        self.failing.odometries, self.failing.scans = odometry_shifted(base), shifted(laser)

    def longest_gap(self) -> float:
        """Return the longest time without a pose so far [s]."""
        return max(self.gap, self.clock() - self._last)


@pytest.mark.parametrize("by", [step for step in STEPS if step > -1000.0] + [-990.0])
def test_a_robot_whose_clock_is_set_goes_on_at_once(by: float) -> None:
    driving = WatchedDrive()
    driving.set_clocks(base=by, laser=by)
    driving.go_on(4.0)
    assert driving.longest_gap() <= 0.5
    assert error_of(driving.told, driving.world.pose)[0] < 0.15
    assert len(driving.refused) <= 3
    assert not any(text.startswith("waiting") for text in driving.texts)


@pytest.mark.parametrize("by", [2.0, 8.0, 3600.0])
def test_a_clock_that_is_set_ahead_and_back_again_is_followed(by: float) -> None:
    driving = WatchedDrive()
    driving.set_clocks(base=by, laser=by)
    driving.go_on(1.0)
    driving.set_clocks(base=0.0, laser=0.0)
    driving.go_on(3.0)
    assert driving.longest_gap() <= 0.5
    driving.end_well()


def test_a_robot_whose_clock_is_set_every_second_is_served() -> None:
    driving = WatchedDrive()
    for second in range(8):
        by = 3.0 if second % 2 else 0.0
        driving.set_clocks(base=by, laser=by)
        driving.go_on(1.0)
    assert driving.longest_gap() <= 0.5


@pytest.mark.parametrize(
    ("base", "laser", "words"),
    [
        (0.0, -2.0, "the scan was taken 2.0 s before the newest odometry"),
        (0.0, -12.0, "the scan was taken 12.0 s before the newest odometry"),
        (3600.0, 0.0, "the scan was taken 3600.0 s before the newest odometry"),
        (0.0, 5.0, "s ahead of the newest odometry: stamp both with the same clock"),
        (0.0, 3600.0, "s ahead of the newest odometry: stamp both with the same clock"),
        (-8.0, 0.0, "s ahead of the newest odometry: stamp both with the same clock"),
        (-600.0, 0.0, "s ahead of the newest odometry: stamp both with the same clock"),
    ],
)
def test_clocks_of_laser_and_base_that_are_apart_are_told(base: float, laser: float, words: str) -> None:
    driving = WatchedDrive()
    driving.set_clocks(base=base, laser=laser)
    driving.texts.clear()
    driving.go_on(SERVED)
    assert any(text.startswith("waiting") and words in text for text in driving.texts), driving.texts
    driving.go_on(20.0)
    driving.set_clocks(base=0.0, laser=0.0)
    driving.go_on(SERVED)
    assert error_of(driving.told, driving.world.pose)[0] < 0.15
    driving.end_well()


@pytest.mark.parametrize(("base", "laser"), [(0.0, 0.3), (0.0, -0.5), (0.2, 0.0)])
def test_clocks_of_laser_and_base_may_be_apart_by_a_little(base: float, laser: float) -> None:
    driving = WatchedDrive()
    driving.set_clocks(base=base, laser=laser)
    driving.go_on(4.0)
    assert driving.longest_gap() <= 0.8
    assert not any(text.startswith("waiting") for text in driving.texts)


@pytest.mark.parametrize("by", [-900.0, -8.0, 3600.0])
def test_a_robot_that_restarts_with_another_clock_has_not_moved(by: float) -> None:
    driving = WatchedDrive()
    driving.go_on(4.0)
    reset = driving.world.odom.inverse() @ Pose2D(7.0, 0.0, 0.0)

    def restarted(odometry: Odometry) -> Odometry:
        pose = reset @ odometry.pose.pose.planar()
        return odometry_shifted(by)(replace(odometry, pose=replace(odometry.pose, pose=Pose.of(pose))))

    driving.failing.odometries, driving.failing.scans = restarted, shifted(by)
    driving.go_on(2.0)
    assert error_of(driving.told, driving.world.pose)[0] < 0.15


@pytest.mark.parametrize("by", [-3600.0, -8.0, 8.0, 3600.0])
def test_a_robot_drives_on_while_the_clock_of_the_cloud_is_set(by: float) -> None:
    driving = WatchedDrive()
    driving.texts.clear()
    driving.cloud_ahead = by
    driving.go_on(4.0)
    assert driving.longest_gap() <= 0.5
    assert not any(text.startswith("waiting") for text in driving.texts)
    driving.end_well()


def test_a_robot_that_falls_silent_is_stopped_although_the_clock_of_the_cloud_was_set_back() -> None:
    driving = WatchedDrive()
    driving.cloud_ahead = -600.0
    driving.sensing = False
    driving.go_on(SERVED)
    assert driving.is_stopped()
    driving.sensing = True
    driving.end_well()


def test_the_heading_of_a_robot_that_stands_stays_known_when_the_clock_of_the_cloud_is_set() -> None:
    driving = WatchedDrive()
    deviations: list[float] = []
    driving.graph.tap("amcl_pose", lambda _, message: deviations.append(message.pose.covariance[35]))
    driving.go_on(1.0)
    driving.cloud_ahead = 7200.0
    driving.go_on(1.0)
    assert max(deviations) < 0.05


@pytest.mark.parametrize("seed", [0, 1])
def test_amcl_corrects_odometry_that_drifts_three_times_as_fast(seed: int) -> None:
    grid = office(seed=1, width=12.0, height=10.0)
    start = free_pose(grid, seed=3)
    world = SimulatedWorld(grid, start, drift=3.0, seed=seed)
    driving = ClosedLoop(world)
    drift: list[float] = []

    def note_drift(_: str, message: object) -> None:
        assert isinstance(message, Odometry)
        drift.append(world.pose.distance_to(start @ message.pose.pose.planar()))

    driving.graph.tap("odom", note_drift)
    for goal in (reachable_pose(grid, start, seed=4, at_least=4.0), start):
        driving.send_goal(goal)
        driving.run(90.0)
        assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert drift[0] < 0.05, "odometry begins at the start"
    assert max(drift) > 0.15, "the drift is real"
    assert driving.worst < max(drift) and driving.worst <= 0.25
    assert world.touched == 0
