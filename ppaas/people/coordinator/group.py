"""Robots of a group: their last reports, clocks, deviations, offsets and trust."""

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.people.clock_offsets import ClockOffset
from ppaas.people.coordinator.positions import OffsetFilter, maximum_position_deviation, to_world
from ppaas.people.coordinator.reports import Report

# -- clock of a robot, compared with the cloud's by the times at which its reports arrive ------------------------------

LATENCY = 0.1
"""Usual time between a measurement and the arrival of its report [s]."""
SLOWEST = 0.35
"""Least latency of reports above which the robot's clock is taken to be late [s]."""
EARLIEST = -0.02
"""Least latency of reports below which the robot's clock is taken to be early [s]."""
WINDOW = 10.0
"""Time over which the least latency is taken, at least [s]."""
OLDEST = 2.0
"""Limit of the age of a measurement [s]."""


class RobotClock:
    """Offset of the clock of a robot.

    Stamps of a clock that agrees with the cloud's to some 0.3 s are taken unchanged: a delay of the network looks the
    same. A clock that is off by more is corrected so that the fastest reports have the usual latency.
    """

    def __init__(self) -> None:
        self._fastest = ClockOffset(WINDOW)

    def measured_at(self, stamp: float, now: float) -> float:
        """Return the time of a measurement by the cloud's clock [s].

        Parameters
        ----------
        stamp : float
            Its time by the robot's clock [s].
        now : float
            Time of arrival by the cloud's clock [s].
        """
        self._fastest.note(stamp, now)
        return min(max(stamp + self.offset, now - OLDEST), now)

    @property
    def offset(self) -> float:
        """Time to add to stamps [s]; 0 for a clock that agrees."""
        least = self._fastest.seconds
        return 0.0 if EARLIEST <= least <= SLOWEST else least - LATENCY


# -- trust in a robot --------------------------------------------------------------------------------------------------

MEMORY = 10.0
"""Time constant with which evidence is forgotten [s]."""
ENOUGH = 4.0
"""Evidence from which a robot is judged [s]: a person whom others confirm or deny for one second counts one."""
ENOUGH_WALLED = 8.0
"""Evidence from which a robot is judged by the map, which may have obstacles that a camera looks over [s]."""
DENIED = 0.7
"""Share of denied people from which a robot is not trusted."""
BELIEVED = 0.4
"""Share of denied people below which it is trusted again."""
WITNESSES = 2
"""Number of robots that must deny its people, unless one of them is reliable."""
RELIABLE = 2.0
"""Evidence from which a robot is reliable: others confirm its people [s]."""
WALLS = "sees people inside or behind walls: its position on the map may be wrong; localize it again"
ALONE = "sees people where no other robot sees any; check its detector and its position on the map"


class TrustRecord:
    """Evidence for and against the reports of a robot.

    Attributes
    ----------
    reason : str
        Why its reports are not used; empty while it is trusted.
    """

    def __init__(self) -> None:
        self.reason = ""
        self.confirmed = self.denied = self.open = self.walled = 0.0
        self.witnesses: dict[str, float] = {}

    @property
    def trusted(self) -> bool:
        """Whether its reports are used."""
        return not self.reason

    def forget(self, seconds: float) -> None:
        """Fade the evidence over a time [s]."""
        fading = math.exp(-seconds / MEMORY)
        self.confirmed *= fading
        self.denied *= fading
        self.open *= fading
        self.walled *= fading
        self.witnesses = {robot: fading * weight for robot, weight in self.witnesses.items() if weight > 0.05}

    def see(self, seconds: float, *, walled: int, clear: int) -> None:
        """Add a number of people who are in or behind walls, and of others, for a time [s]."""
        self.walled += seconds * walled
        self.open += seconds * clear

    def compare(self, seconds: float, *, confirmed: int, denied: int, witnesses: list[str]) -> None:
        """Add a number of its people whom others confirm or deny for a time [s], and the robots that deny some."""
        self.confirmed += seconds * confirmed
        self.denied += seconds * denied
        for robot in witnesses:
            self.witnesses[robot] = self.witnesses.get(robot, 0.0) + seconds

    @property
    def reliable(self) -> bool:
        """Whether other robots confirm its people."""
        return self.trusted and self.confirmed >= RELIABLE and self.confirmed > self.denied

    def judge(self, reliable: Collection[str]) -> None:
        """Decide whether the robot is trusted, knowing which other robots are reliable."""
        share = DENIED if self.trusted else BELIEVED
        if self.walled + self.open >= ENOUGH_WALLED and self.walled > share * (self.walled + self.open):
            self.reason = WALLS
        elif self._denied(share, reliable):
            self.reason = ALONE
        else:
            self.reason = ""

    def _denied(self, share: float, reliable: Collection[str]) -> bool:
        total = self.confirmed + self.denied
        deny = [robot for robot, weight in self.witnesses.items() if weight > 0.25 * ENOUGH]
        accusers = len(deny) + (WITNESSES - 1 if any(robot in reliable for robot in deny) else 0)
        # A robot that was denied stays so while it reports nobody, until the evidence has faded.
        return (
            total >= 0.5 * ENOUGH * (2.0 if self.trusted else 1.0)
            and self.denied > share * total
            and (accusers >= WITNESSES or (not self.trusted and accusers > 0))
        )


Array = NDArray[np.float64]

# -- robots of a group -------------------------------------------------------------------------------------------------

MOST_ROBOTS = 500
MOST_BOUND = 200
"""Number of torsos of a robot whose people are remembered."""
MOST_REPEATED = 5
"""Number of reports in a row with the same stamp from which a robot is frozen."""
SILENT = "has sent no report for {seconds:.0f} s; check its connection and its detectors"
FROZEN = "repeats a report with the same stamp; check its detectors"


@dataclass(slots=True)
class MemberRobot:
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
    known : dict of str to MemberRobot
    earlier : dict of str to Earlier
        Robots of a checkpoint that have not reported since.
    """

    def __init__(self, deviation_history: float) -> None:
        self._history = deviation_history
        self.known: dict[str, MemberRobot] = {}
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

    def _joined(self, report: Report, now: float) -> MemberRobot:
        """Return a robot of which this is the first report."""
        robot = MemberRobot(report.robot, report, now, now, now, np.zeros((0, 2)), np.zeros((0, 2, 2)))
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
