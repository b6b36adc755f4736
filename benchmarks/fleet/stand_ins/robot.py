"""Stand-in of a robot and its clone: a disc that drives along its granted way, stops, strays, and falls silent."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants, TrafficReport
from ppaas.nodes.granted_move_base.traffic_link import NODE_SILENCE, POSE_PERIOD, REPORT_PERIOD
from ppaas.traffic.granted_way import GrantedWay, path_along

PERIOD = 0.1
"""Time of a control cycle [s]."""

LOOK_AHEAD = 4
"""Number of poses of the path ahead of the robot that it steers to."""

TURN_RATE = 1.5
"""Fastest turn [rad/s]."""

NEAR = 0.05
"""Distance within which a robot is at the end of its path [m]."""

TOLERANCE = 0.1
"""Distance from its goal within which a robot reports it as reached [m]."""

BRAKING = 0.1
"""Distance in which a robot stops, as it reports it [m]."""

Points = NDArray[np.float64]

FindWay = Callable[[Pose2D, Pose2D], Points]
"""Returns the points of the way of a robot that drives freely, (n, 2) x, y [m]."""


def straight(start: Pose2D, goal: Pose2D) -> Points:
    """Return the straight way between two poses."""
    return np.array([start[:2], goal[:2]])


@dataclass
class StandIn:
    """Disc with differential drive that follows its granted way, and reports as often as a clone does.

    Attributes
    ----------
    radius : float
        Its radius [m].
    speed : float
        Its speed [m/s].
    clock : float
        Time by which its clock is ahead [s].
    stalled_until : float
        Time until which it stands although it could drive [s].
    dead : bool
        Whether its wheels are stopped for ever; it still reports.
    silent : bool
        Whether it reports nothing.
    gets_on : bool
        Whether it reached a cell or a goal in the last control cycle, or drives freely.
    arrived : int
        Number of goals that it has reached.
    goal_since : float
        Time at which it got its goal [s].
    times : list of float
        How long each goal that it reached was open [s].
    misses : list of float
        Distance from each goal when it reported it as reached [m].
    find_way : callable
        Finds its way while it drives freely.
    """

    name: str
    pose: Pose2D
    radius: float = 0.2
    speed: float = 0.5
    clock: float = 0.0
    goal: tuple[float, float] | None = None
    goal_id: str = ""
    stalled_until: float = -1.0
    dead: bool = False
    silent: bool = False
    stray: bool = False
    aside: str = ""
    approach: list[MapPoint] = field(default_factory=list)
    arrived: int = 0
    goal_since: float = 0.0
    refused: list[str] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    misses: list[float] = field(default_factory=list)
    find_way: FindWay = straight

    def __post_init__(self) -> None:
        self.way = GrantedWay(self.radius)
        self.gets_on = False
        self._path: Points = np.empty((0, 2))
        self._leads: object = None
        self._at = 0
        self._heard = 0.0
        self._count = 0
        self._reported: tuple[object, Pose2D, float] = None, self.pose, -math.inf

    def head_for(self, x: float, y: float, now: float) -> None:
        """Get a new goal."""
        self._count += 1
        self.goal, self.goal_id, self.goal_since = (x, y), f"{self.name}-{self._count}", now

    def take(self, grants: TrafficGrants, now: float) -> None:
        """Take grants."""
        if self.way.take(grants, self.pose):
            self._heard = now
            if grants.refused and grants.goal_id in {"", self.goal_id} and self.goal_id:
                self.refused.append(grants.refused)
                self.goal, self.goal_id = None, ""

    # -- reports -------------------------------------------------------------------------------------------------------

    def due_report(self, now: float) -> TrafficReport | None:
        """Return a report if anything has changed, or the last one is too old."""
        if self.silent:
            return None
        way, (said, pose, at) = self.way, self._reported
        says = (
            way.epoch,
            way.revision,
            way.first,
            way.end,
            way.reached,
            way.free,
            self.stray,
            self.goal_id,
            way.spur,
            self.aside,
            self.approach,
        )
        moved = math.hypot(pose.x - self.pose.x, pose.y - self.pose.y) > 0.01
        if says == said and now - at < (POSE_PERIOD if moved else REPORT_PERIOD) - 1e-6:
            return None
        self._reported = says, self.pose, now
        return self.report(now)

    def report(self, now: float) -> TrafficReport:
        """Return what it reports."""
        goal = MapPoint(*(self.goal or (0.0, 0.0)))
        return TrafficReport(
            Header(stamp=Time.of(now + self.clock), frame_id="map"),
            self.name, self.pose.x, self.pose.y, self.pose.theta,
            self.radius, self.speed, BRAKING, self.way.epoch, self.way.number, self.way.revision, self.way.first,
            self.way.held, self.way.ahead, self.way.free, self.stray, [], self.goal_id, goal, now - self.goal_since,
            TOLERANCE, self.way.spur, self.aside, self.approach,
        )  # fmt: skip

    @property
    def may_approach(self) -> bool:
        """Whether it may drive on its approach."""
        grants = self.way.grants
        return grants is not None and bool(grants.approach) and grants.approach == self.approach

    def set_aside(self, why: str, *approach: MapPoint) -> None:
        """Follow no grants for a reason, as a robot that is stopped or driven by hand; take part again without one.

        With an approach it docks or undocks on that, or stands at a dock.
        """
        self.aside, self.approach = why, [*approach]
        self.way.give_back(self.pose)

    # -- driving -------------------------------------------------------------------------------------------------------

    def step(self, now: float) -> None:
        """Drive for a control cycle."""
        way = self.way
        self.gets_on = way.advance(self.pose)
        grants = way.grants
        if grants is None:
            return
        if self.aside:
            if way.held or way.free:
                way.give_back(self.pose)
            return
        asked = grants.give_back and grants.revision == way.revision
        if self.stray or asked or (way.free and now - self._heard > NODE_SILENCE):
            way.give_back(self.pose)
            self.stray = False
            return
        self.stray = way.is_stray(self.pose)  # it stands for this cycle, and reports it
        if self.stray or now < self.stalled_until or self.dead:
            return
        if way.free:
            self._drive_freely(now)
        else:
            self._follow(now)

    def _drive_freely(self, now: float) -> None:
        if self.goal is None:
            return
        goal = Pose2D(*self.goal)
        if self._leads != goal:
            self._take_path(self.find_way(self.pose, goal), goal)
        self.gets_on = True
        if self._drive_on(1):
            self._end_goal(now)

    def _end_goal(self, now: float) -> None:
        self.arrived += 1
        self.gets_on = True
        self.times.append(now - self.goal_since)
        self.misses.append(math.dist(self.pose[:2], self.goal or self.pose[:2]))
        self.goal, self.goal_id = None, ""

    def _follow(self, now: float) -> None:
        way = self.way
        leg, ends = way.leg()
        final = None
        if ends and self.goal is not None and way.leads_to(self.goal_id):
            final = way.stop_at(Pose2D(*self.goal), lambda *_: True)
        if len(leg) < 2 and final is None:
            return
        leads = [(each.x, each.y, each.curved) for each in leg], final
        if leads != self._leads:
            self._take_path(path_along(leg, way.spacing, self.pose, final)[:, :2], leads)
        if self._drive_on(LOOK_AHEAD) and final is not None:
            self._end_goal(now)

    def _take_path(self, path: Points, leads: object) -> None:
        self._path, self._leads, self._at = path, leads, 0

    def _drive_on(self, ahead: int) -> bool:
        """Drive along the path for a control cycle; return whether it is at its end."""
        path = self._path
        near = path[self._at : self._at + 10]
        self._at += int(np.argmin(np.hypot(near[:, 0] - self.pose.x, near[:, 1] - self.pose.y)))
        end = path[-1]
        if self._at >= len(path) - 2 and math.hypot(end[0] - self.pose.x, end[1] - self.pose.y) < NEAR:
            return True
        x, y = path[min(self._at + ahead, len(path) - 1)]
        self._steer(float(x), float(y))
        return False

    def _steer(self, x: float, y: float) -> None:
        dx, dy = x - self.pose.x, y - self.pose.y
        off = wrap_angle(math.atan2(dy, dx) - self.pose.theta)
        turn = max(min(off, TURN_RATE * PERIOD), -TURN_RATE * PERIOD)
        go = 0.0 if abs(off) > 0.6 else min(self.speed * PERIOD * math.cos(off), math.hypot(dx, dy))
        theta = wrap_angle(self.pose.theta + turn)
        self.pose = Pose2D(self.pose.x + go * math.cos(theta), self.pose.y + go * math.sin(theta), theta)
