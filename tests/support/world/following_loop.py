"""A clone with the node ``follow_person`` in a closed loop, and a person whom the test moves."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import (
    PREDICTED,
    SEEN,
    FollowOrder,
    FollowStatus,
    GroupRobot,
    PeopleState,
    TrackedPerson,
)
from tests.support.world.closed_loop import PERIOD, ClosedLoop
from tests.support.world.planar_world import World

ROBOT = "turtlebot"
RADIUS = 0.2
"""Radius of a person in scans [m]."""

Way = Callable[[float], tuple[float, float]]
"""Returns where a person is at a time since the start [s]: x, y [m]."""


@dataclass
class Walker:
    """A person of the test.

    ``seen`` tells at which times a robot sees the person; otherwise the coordinator predicts the position.
    """

    number: int
    way: Way
    group: int = 0
    seen: Callable[[float], bool] = lambda _: True
    hidden: tuple[float, float, float, float] | None = None

    def velocity(self, now: float) -> tuple[float, float]:
        (x0, y0), (x1, y1) = self.way(max(now - 0.1, 0.0)), self.way(now)
        return (x1 - x0) / 0.1, (y1 - y0) / 0.1


@dataclass
class PeopledWorld(World):
    """A world with people in the scans."""

    people: list[tuple[float, float]] = field(default_factory=list)

    def ranges(self) -> NDArray[np.float64]:
        ranges = super().ranges()
        angles = self.pose.theta + np.linspace(-math.pi, math.pi, self.beams, endpoint=False)
        for x, y in self.people:
            right, up = x - self.pose.x, y - self.pose.y
            along = right * np.cos(angles) + up * np.sin(angles)
            aside = np.abs(up * np.cos(angles) - right * np.sin(angles))
            hit = along - np.sqrt(np.maximum(RADIUS**2 - aside**2, 0.0))
            ranges = np.where((aside < RADIUS) & (along > 0.0), np.minimum(ranges, hit), ranges)
        return ranges


class FollowingLoop(ClosedLoop):
    """The coordinator of the test orders the robot to follow the first of the people."""

    def __init__(self, grid: GridMap, start: Pose2D, people: list[Walker], **parameters: object) -> None:
        self.people = people
        self.began = 0.0
        self.ordered = True
        self.coordinating = True
        self.statuses: list[FollowStatus] = []
        self.distances: list[float] = []
        self.trace: list[tuple[Pose2D, tuple[float, float], float]] = []
        world = PeopledWorld(grid, start, drift=0.1)
        super().__init__(world, parameters={"follow_person": parameters}, robot=ROBOT)
        self.graph.tap("follow_person/status", lambda _, message: self.statuses.append(message))
        self.began = self.clock()
        self._cycle = 0

    @property
    def now(self) -> float:
        return self.clock() - self.began

    def step(self) -> None:
        self.world.people = [walker.way(self.now) for walker in self.people]
        if self.coordinating and self._cycle % 4 == 0:
            self.graph.inject("people_coordinator/state", self.state())
        super().step()
        person = self.people[0].way(self.now)
        self.distances.append(math.dist(person, self.world.pose[:2]))
        self.trace.append((self.world.pose, person, self.command.linear.x))

    def state(self) -> PeopleState:
        now, stamp = self.now, Time.of(self.clock())
        people = []
        for walker in self.people:
            x, y = walker.way(now)
            state = SEEN
            if not walker.seen(now):
                walker.hidden = walker.hidden or (x, y, *walker.velocity(now))
                state, (x, y, vx, vy) = PREDICTED, walker.hidden
            else:
                walker.hidden, (vx, vy) = None, walker.velocity(now)
            covariance = [0.01, 0.0, 0.0, 0.01]
            people.append(
                TrackedPerson(walker.number, Point(x, y), Point(vx, vy), covariance, state=state, group=walker.group)
            )
        orders = [FollowOrder(ROBOT, self.people[0].number, 1.0, Time(1, 0))] if self.ordered else []
        robots = [GroupRobot(ROBOT, Point(*self.world.pose[:2]), 0.1)]
        return PeopleState(Header(stamp=stamp, frame_id="map"), len(people), people, orders, robots, "nearest")

    def follow(self, seconds: float) -> None:
        """Simulate a time [s]."""
        for _ in range(round(seconds / PERIOD)):
            self.step()

    @property
    def status(self) -> FollowStatus:
        return self.statuses[-1]

    @property
    def states(self) -> list[str]:
        """States in order, each once in a row."""
        states = [status.state for status in self.statuses]
        return [state for state, before in zip(states, [None, *states], strict=False) if state != before]


def along(*points: tuple[float, float], speed: float = 0.4, begin: float = 0.0) -> Way:
    """Return the way of a person who walks from point to point at a speed [m/s], from a time on, and then stands."""
    corners = np.array(points, dtype=np.float64)
    lengths = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T)))) if len(points) > 1 else [0.0]

    def way(now: float) -> tuple[float, float]:
        walked = max(now - begin, 0.0) * speed
        return tuple(float(np.interp(walked, lengths, corners[:, axis])) for axis in (0, 1))  # type: ignore[return-value]

    return way
