"""Simulated robots that drive by grants: late, with messages that are delayed and lost, and who stop and stray."""

import math
from dataclasses import dataclass, field
from random import Random

import numpy as np

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants, TrafficReport
from ppaas.traffic.granted_way import GrantedWay
from ppaas.traffic.leg_path import path_along

PERIOD = 0.1
"""Time of a control cycle [s]."""

LOOK_AHEAD = 4
"""Number of poses of the path ahead of the robot that it steers to."""

NODE_SILENCE = 3.0
"""Time without grants after which a robot no longer drives freely [s]."""


@dataclass
class SimulatedRobot:
    """Disc with differential drive that follows its granted way.

    Attributes
    ----------
    stalled_until : float
        Time until which it stands although it could drive [s].
    dead : bool
        Whether its wheels are stopped for ever; it still reports.
    silent : bool
        Whether it reports nothing.
    """

    name: str
    pose: Pose2D
    radius: float = 0.2
    speed: float = 0.5
    goal: tuple[float, float] | None = None
    goal_id: str = ""
    stalled_until: float = -1.0
    dead: bool = False
    silent: bool = False
    stray: bool = False
    arrived: int = 0
    goal_since: float = 0.0
    refused: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.way = GrantedWay(self.radius)
        self._path: np.ndarray | None = None
        self._leg: object = None
        self._at = 0
        self._heard = 0.0
        self._count = 0
        self.moving = False

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

    def report(self, now: float) -> TrafficReport:
        """Return what it reports."""
        goal = MapPoint(*(self.goal or (0.0, 0.0)))
        return TrafficReport(
            Header(stamp=Time.of(now), frame_id="map"), self.name, self.pose.x, self.pose.y, self.pose.theta,
            self.radius, self.speed, 0.1, self.way.epoch, self.way.number, self.way.revision, self.way.first,
            self.way.held, self.way.ahead, self.way.free, self.stray, [], self.goal_id, goal, now - self.goal_since,
        )  # fmt: skip

    def step(self, now: float, others: "list[SimulatedRobot]") -> None:
        """Drive for a control cycle."""
        self.moving = False
        way = self.way
        way.advance(self.pose)
        grants = way.grants
        if grants is None:
            return
        if way.free and now - self._heard > NODE_SILENCE:
            way.give_back(self.pose)
        asked = grants.give_back and grants.revision == way.revision
        if asked and (way.free or way.ahead or way.held or grants.give_back):
            way.give_back(self.pose)
            return
        self.stray = way.is_stray(self.pose)
        if self.stray:
            way.give_back(self.pose)
            self.stray = False
            return
        if now < self.stalled_until or self.dead:
            return
        if way.free:
            self._drive_freely()
        else:
            self._follow(now)

    def _drive_freely(self) -> None:
        if self.goal is None:
            return
        self._steer(*self.goal, slow=False)
        if math.hypot(self.goal[0] - self.pose.x, self.goal[1] - self.pose.y) < 0.05:
            self._end_goal()

    def _end_goal(self) -> None:
        self.arrived += 1
        self.goal, self.goal_id = None, ""

    def _follow(self, now: float) -> None:
        way = self.way
        leg, ends = way.leg()
        arrives = ends and self.goal is not None and way.leads_to(self.goal_id)
        if len(leg) < 2 and not arrives:
            return
        final = None
        if arrives and self.goal is not None:
            last = leg[-1]
            margin = way.margin
            x = min(max(self.goal[0], last.x - margin), last.x + margin)
            y = min(max(self.goal[1], last.y - margin), last.y + margin)
            final = Pose2D(x, y, 0.0)
        key = [(each.x, each.y, each.curved) for each in leg], final
        if key != self._leg:
            self._leg = key
            self._path = path_along(leg, way.spacing, self.pose, final)[:, :2]
            self._at = 0
        path = self._path
        assert path is not None
        near = path[self._at : self._at + 10]
        self._at += int(np.argmin(np.hypot(near[:, 0] - self.pose.x, near[:, 1] - self.pose.y)))
        end = path[-1]
        if math.hypot(end[0] - self.pose.x, end[1] - self.pose.y) < 0.05 and self._at >= len(path) - 2:
            if final is not None:
                self._end_goal()
            return
        x, y = path[min(self._at + LOOK_AHEAD, len(path) - 1)]
        self._steer(float(x), float(y), slow=True)

    def _steer(self, x: float, y: float, *, slow: bool) -> None:
        dx, dy = x - self.pose.x, y - self.pose.y
        off = wrap_angle(math.atan2(dy, dx) - self.pose.theta)
        turn = max(min(off, 1.5 * PERIOD), -1.5 * PERIOD)
        go = 0.0 if abs(off) > 0.6 else min(self.speed * PERIOD * math.cos(off), math.hypot(dx, dy))
        theta = wrap_angle(self.pose.theta + turn)
        self.moving = go > 0.0 or abs(turn) > 1e-6
        self.pose = Pose2D(self.pose.x + go * math.cos(theta), self.pose.y + go * math.sin(theta), theta)


class Network:
    """Messages that arrive late or not at all.

    Parameters
    ----------
    rng : Random
    delay : float
        Largest delay of a message [s].
    loss : float
        Part of messages that are lost.
    """

    def __init__(self, rng: Random, delay: float = 0.1, loss: float = 0.0) -> None:
        self._rng, self._delay, self._loss = rng, delay, loss
        self._waiting: list[tuple[float, int, object]] = []
        self._count = 0

    def send(self, message: object, now: float) -> None:
        """Send a message."""
        if self._rng.random() >= self._loss:
            self._count += 1
            self._waiting.append((now + self._rng.uniform(0.0, self._delay), self._count, message))

    def arrived(self, now: float) -> list[object]:
        """Return the messages that have arrived."""
        ready = sorted(each for each in self._waiting if each[0] <= now)
        self._waiting = [each for each in self._waiting if each[0] > now]
        return [message for _, _, message in ready]
