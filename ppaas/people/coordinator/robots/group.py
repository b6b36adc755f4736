"""Robots of a group: their last reports, deviations, offsets and trust."""

from collections import deque
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.people.coordinator.robots.deviation import maximum_position_deviation
from ppaas.people.coordinator.robots.offsets import OffsetFilter
from ppaas.people.coordinator.robots.reports import Report
from ppaas.people.coordinator.robots.robot_clock import RobotClock
from ppaas.people.coordinator.robots.trust import TrustRecord
from ppaas.people.coordinator.robots.world_frame import to_world

Array = NDArray[np.float64]

MOST_ROBOTS = 500
MOST_BOUND = 200
"""Number of torsos of a robot whose people are remembered."""
MOST_REPEATED = 5
"""Number of reports in a row with the same stamp from which a robot is frozen."""
SILENT = "has sent no report for {seconds:.0f} s; check its connection and its detectors"
FROZEN = "repeats a report with the same stamp; check its detectors"


@dataclass(slots=True)
class Robot:
    """A robot of the group.

    Parameters
    ----------
    name : str
        Robot ID.
    report : Report
        Its last report.
    arrived, measured : float
        Times of its arrival and of its measurements by the cloud's clock [s].
    heard : float
        Time at which any report arrived, also a repeated one [s].
    world, spread : (n, 2), (n, 2, 2) array
        Its people in the frame of the map, as the robot itself believes [m], and their covariances with the
        uncertainty of its offset [m²].
    fresh : bool
        Whether the report has not been used yet.
    repeated : int
        Number of reports in a row with the same stamp.
    bound : dict of str to int
        Id of the person that each of its torsos was, the latest last.
    """

    name: str
    report: Report
    arrived: float
    measured: float
    heard: float
    world: Array
    spread: Array
    fresh: bool = True
    repeated: int = 0
    bound: dict[str, int] = field(default_factory=dict)
    clock: RobotClock = field(default_factory=RobotClock)
    offset: OffsetFilter = field(default_factory=OffsetFilter)
    trust: TrustRecord = field(default_factory=TrustRecord)
    deviations: deque[tuple[float, float]] = field(default_factory=deque)

    @property
    def pose(self) -> Pose2D:
        """Its pose without its offset."""
        x, y, yaw = self.offset.mean.tolist()
        own = self.report.pose
        return Pose2D(own.x - x, own.y - y, own.theta - yaw)

    @property
    def deviation(self) -> float:
        """Maximum position deviation over its history [m]."""
        return maximum_position_deviation((deviation for _, deviation in islice(self.deviations, 1)), self.offset.error)

    def bind(self, people: dict[str, int]) -> None:
        """Note the id of the person that each torso of its last report is; earlier torsos may come back."""
        for torso in people:
            self.bound.pop(torso, None)
        for torso in list(islice(self.bound, max(len(self.bound) + len(people) - MOST_BOUND, 0))):
            del self.bound[torso]
        self.bound.update(people)

    @property
    def uncertainty(self) -> float:
        """Maximum position deviation of where it is without its offset [m]."""
        return maximum_position_deviation(
            (deviation for _, deviation in islice(self.deviations, 1)), self.offset.radius
        )

    def note_deviation(self, now: float, deviation: float, oldest: float) -> None:
        """Add a deviation [m] to the history, which then begins at a time [s].

        Only those are kept that are larger than all later ones, so that the first is the maximum.
        """
        while self.deviations and self.deviations[-1][1] <= deviation:
            self.deviations.pop()
        self.deviations.append((now, deviation))
        while self.deviations[0][0] < oldest:
            self.deviations.popleft()

    @property
    def is_frozen(self) -> bool:
        """Whether it repeats its last report."""
        return self.repeated >= MOST_REPEATED

    def torsos(self) -> Array:
        """Return its (n, 2) people in the frame of the map, without its offset [m]."""
        return self.offset.corrected(self.world, (self.report.pose.x, self.report.pose.y))

    def reason(self, now: float, timeout: float) -> str:
        """Return why its reports are not used now; empty if they are."""
        if now - self.heard > timeout:
            return SILENT.format(seconds=now - self.heard)
        if self.is_frozen:
            return FROZEN
        return self.trust.reason


def prior_of(report: Report) -> Array:
    """Return the (3, 3) covariance that a robot claims for its pose, a usual one if it is all zeros."""
    claimed = report.pose_covariance
    return claimed.copy() if np.diag(claimed).any() else np.diag([0.2**2, 0.2**2, 0.05**2])


class Earlier(NamedTuple):
    """Of a robot that a checkpoint knows: the ids of its torsos, and its offset with the covariance."""

    bound: dict[str, int]
    offset: Array
    covariance: Array


class Robots:
    """The robots of a group, by Robot ID.

    Parameters
    ----------
    deviation_history : float
        Time over which the maximum deviation is taken [s].

    Attributes
    ----------
    known : dict of str to Robot
    earlier : dict of str to Earlier
        Robots of a checkpoint that have not reported since.
    """

    def __init__(self, deviation_history: float) -> None:
        self._history = deviation_history
        self.known: dict[str, Robot] = {}
        self.earlier: dict[str, Earlier] = {}

    def take(self, report: Report, now: float) -> None:
        """Add a report that has arrived; of two reports between two cycles the newer one counts."""
        robot = self.known.get(report.robot)
        if robot is None:
            robot = self.known[report.robot] = self._joined(report, now)
        elif robot.report.stamp - 1.0 < report.stamp <= robot.report.stamp:
            robot.repeated += 1
            robot.heard = now
            return
        robot.repeated = 0
        robot.report, robot.arrived, robot.heard, robot.fresh = report, now, now, True
        robot.world, robot.spread = to_world(report.pose, robot.offset.covariance, report.torsos, report.covariances)
        robot.measured = robot.clock.measured_at(report.stamp, now)
        robot.note_deviation(now, report.deviation, now - self._history)

    def _joined(self, report: Report, now: float) -> Robot:
        """Return a robot of which this is the first report."""
        robot = Robot(report.robot, report, now, now, now, np.zeros((0, 2)), np.zeros((0, 2, 2)))
        robot.offset.at, robot.offset.covariance = now, prior_of(report)
        earlier = self.earlier.pop(report.robot, None)
        if earlier is not None:
            robot.bound = earlier.bound
            robot.offset.mean, robot.offset.covariance = earlier.offset, earlier.covariance
        return robot

    def move_times(self, seconds: float) -> None:
        """Add a time [s] to all times."""
        for robot in self.known.values():
            robot.arrived += seconds
            robot.heard += seconds
            robot.measured += seconds
            robot.offset.at += seconds
            robot.deviations = deque((at + seconds, deviation) for at, deviation in robot.deviations)

    def forget(self, oldest: float) -> list[str]:
        """Forget the robots that were last heard before a time [s], and return their names."""
        gone = [name for name, robot in self.known.items() if robot.heard < oldest]
        for name in gone:
            del self.known[name]
        return gone
