"""Traffic link: the way that a robot is granted, and its reports to the traffic node of its map."""

import math
from dataclasses import dataclass

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import NO_WAY, MapPoint, TrafficGrants, TrafficReport
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.traffic.granted_way import GrantedWay

REPORT_PERIOD = 0.5
"""Longest time between two reports [s]."""

POSE_PERIOD = 0.2
"""Time between two reports of a robot that moves [s]."""

NODE_SILENCE = 3.0
"""Time without grants after which the traffic node counts as lost [s]: a robot no longer drives freely then."""


@dataclass(frozen=True, slots=True)
class RobotTrafficFacts:
    """What the traffic node has to know of a robot.

    Parameters
    ----------
    name : str
        Robot ID.
    radius : float
        Radius of its circumscribed circle [m].
    speed : float
        Its fastest speed [m/s].
    braking : float
        Distance that it needs to stop from that speed [m].
    tolerance : float
        Distance from its goal within which it counts as reached [m].
    """

    name: str
    radius: float
    speed: float
    braking: float
    tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class Wanted:
    """Goal of the robot.

    Parameters
    ----------
    id : str
    pose : Pose2D
    since : float
        Time at which it was received [s].
    """

    id: str
    pose: Pose2D
    since: float


class TrafficLink:
    """The robot's end of the traffic.

    Parameters
    ----------
    context : Context
        Context of the node that publishes the reports.
    facts : RobotTrafficFacts

    Attributes
    ----------
    way : GrantedWay
    wanted : Wanted or None
        Goal of the robot; None while it has none.
    path_is_final : bool
        Whether the path that it follows ends at its goal.
    stray : bool
        Whether it has left its way.
    aside : str
        Why it follows no grants now, as in its reports; empty if it does.
    approach : list of MapPoint
        Straight way on which it wants to dock or undock, or its place at a dock, as in its reports.
    """

    def __init__(self, context: Context, facts: RobotTrafficFacts) -> None:
        self._context = context
        self.facts = facts
        self.way = GrantedWay(facts.radius)
        self.way.revision = int(context.now()) & 0xFFFFFF  # another revision than an earlier clone's
        self._heard_at = -math.inf
        self._pose: Pose2D | None = None
        self._reported: TrafficReport | None = None
        self._reported_at = -math.inf
        self.wanted: Wanted | None = None
        self.path_is_final = False
        self.stray = False
        self.aside = ""
        self.approach: list[MapPoint] = []
        self._blocked: tuple[MapPoint, ...] = ()

    @property
    def goal_id(self) -> str:
        """Id of the goal; empty without one."""
        return "" if self.wanted is None else self.wanted.id

    @property
    def node_is_lost(self) -> bool:
        """True if nothing has come from the traffic node for `NODE_SILENCE`."""
        return self._context.elapsed() - self._heard_at > NODE_SILENCE

    @property
    def must_stop(self) -> bool:
        """True if the robot has left its way, is asked to give it back, or may no longer drive freely."""
        return self.stray or self.asked_to_give_back() or (self.way.free and self.node_is_lost)

    @property
    def has_to_move(self) -> bool:
        """True if the robot has cells ahead, or has to drive back from where its goal was."""
        return self.way.ahead > 0 or self.way.is_recalled

    def take(self, grants: TrafficGrants) -> bool:
        """Take grants; return whether they are newer than the last. Grants of other robots are ignored."""
        if grants.robot != self.facts.name or self._pose is None:
            return False
        newer = self.way.take(grants, self._pose)
        if newer:
            self._heard_at = self._context.elapsed()
        return newer

    def see(self, pose: Pose2D) -> bool:
        """Take the pose of the robot; return whether it has reached another cell, come back from a spur, or strayed."""
        self._pose = pose
        reached = self.way.advance(pose)
        left = not (self.stray or self.aside) and self.way.is_stray(pose)
        self.stray = self.stray or left
        return reached or left

    def give_back(self) -> None:
        """Give back all that the robot does not touch, where it stands."""
        if self._pose is not None:
            self.way.give_back(self._pose)
            self.stray = False
            self._blocked = ()

    def set_aside(self, why: str) -> None:
        """Follow no grants for a reason, or take part again without one: another way begins where the robot is."""
        if why != self.aside or (why and (self.way.held or self.way.free)):
            self.aside = why
            self.give_back()

    def find_blocked(self, points: tuple[MapPoint, ...]) -> None:
        """Note the cells ahead that something else occupies."""
        self._blocked = points

    def asked_to_give_back(self) -> bool:
        """Return whether the traffic node asks the robot to give back the rest of its way."""
        grants = self.way.grants
        return grants is not None and grants.give_back and grants.revision == self.way.revision

    @property
    def refusal(self) -> str:
        """Reason why the traffic node refuses the goal; empty if it does not."""
        grants = self.way.grants
        return grants.refused if grants is not None and grants.goal_id == self.goal_id else ""

    def lacks_approach(self) -> str:
        """Return why the robot may not drive on its approach, in words; empty if it may."""
        grants = self.way.grants
        if grants is not None and grants.approach == self.approach and not self.node_is_lost:
            return ""
        return self.waits_for()

    def waits_for(self) -> str:
        """Return what the robot waits for, in words."""
        if self.stray:
            return "the robot has left what it was granted"
        if self.way.grants is None:
            return "the traffic of the map has not answered yet"
        if self.node_is_lost:
            return "the traffic of the map does not answer"
        why = self.way.grants.waits_for
        if why == NO_WAY:
            return "no way to the goal is free"
        return f"{why} goes first" if why else "the traffic of the map is being planned"

    def report(self) -> None:
        """Publish a report, if anything has changed or the last one is too old."""
        if self._pose is None:
            return
        now, report = self._context.elapsed(), self._next(self._pose)
        age, last = now - self._reported_at, self._reported
        if last is None or age >= REPORT_PERIOD or _says_more(report, last):
            due = True
        else:
            due = age >= POSE_PERIOD and math.hypot(report.x - last.x, report.y - last.y) > 0.01
        if due:
            self._reported, self._reported_at = report, now
            self._context.publish(topics.TRAFFIC_REPORT.name, report)

    def _next(self, pose: Pose2D) -> TrafficReport:
        way, facts, wanted = self.way, self.facts, self.wanted
        goal = MapPoint(0.0, 0.0) if wanted is None else MapPoint(wanted.pose.x, wanted.pose.y)
        return TrafficReport(
            Header(stamp=Time.of(self._context.now()), frame_id=MAP), facts.name, pose.x, pose.y, pose.theta,
            facts.radius, facts.speed, facts.braking, way.epoch, way.number, way.revision, way.first, way.held,
            way.ahead, way.free, self.stray, list(self._blocked), self.goal_id, goal,
            0.0 if wanted is None else self._context.elapsed() - wanted.since, facts.tolerance, way.spur, self.aside,
            self.approach,
        )  # fmt: skip


def _says_more(one: TrafficReport, last: TrafficReport) -> bool:
    """Return whether a report differs from the last one in more than the pose."""
    return (
        one.epoch != last.epoch
        or one.revision != last.revision
        or (one.first, one.ahead, len(one.way)) != (last.first, last.ahead, len(last.way))
        or (one.free, one.stray, one.goal_id, one.goal) != (last.free, last.stray, last.goal_id, last.goal)
        or (one.blocked, one.spur, one.approach) != (last.blocked, last.spur, last.approach)
    )
