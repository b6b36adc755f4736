"""Simulation of robots and the coordinator of their traffic, with messages between them, in simulated time."""

from dataclasses import dataclass, field
from random import Random

import numpy as np

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import Roadmap
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.traffic.coordinator import Coordinator
from ppaas.traffic.settings import TrafficParameters
from tests.support.traffic.robots import PERIOD, Network, SimulatedRobot

SPACING = 0.6
"""Distance of neighbouring cells [m]: two robots of radius 0.2 m, and a margin of 0.1 m on each side."""


def roadmap_of(text: str) -> MetricRoadmap:
    """Return the roadmap of a hall drawn in text: ``#`` is blocked, each other character a cell."""
    rows = [line for line in text.strip("\n").split("\n") if line]
    width = max(map(len, rows))
    free = np.array([[c != "#" for c in row.ljust(width, "#")] for row in rows])
    return MetricRoadmap(Roadmap.of_grid(free), SPACING, 0.0, 0.0)


@dataclass
class Simulation:
    """Robots in a hall, and what has become of them.

    Attributes
    ----------
    nearest : float
        Smallest distance of two robots less their radii, so far [m]; negative if they touched.
    longest : float
        Longest time for which a goal was open [s].
    stood : float
        Longest time for which no robot with a goal moved [s].
    """

    hall: MetricRoadmap
    seed: int = 0
    delay: float = 0.1
    loss: float = 0.0
    stalls: float = 0.0
    parameters: TrafficParameters = field(default_factory=TrafficParameters)
    now: float = 0.0

    def __post_init__(self) -> None:
        self.rng = Random(self.seed)
        self.network = Network(self.rng, self.delay, self.loss)
        self.robots: list[SimulatedRobot] = []
        self.coordinator: Coordinator | None = Coordinator(lambda *_: self.hall, self.parameters)
        self.nearest, self.longest, self.stood, self._standing = 9.0, 0.0, 0.0, 0.0
        self.again = False
        self.cells = list(range(len(self.hall.roadmap)))

    def add(self, cell: int, goal: int | None = None, **options: float) -> SimulatedRobot:
        """Add a robot at the centre of a cell, with a goal in the centre of another."""
        x, y = self.hall.centre(cell)
        return self.put(x, y, goal, **options)

    def put(self, x: float, y: float, goal: int | None = None, **options: float) -> SimulatedRobot:
        """Add a robot at a place [m]."""
        name = f"tb{len(self.robots)}"
        robot = SimulatedRobot(name, Pose2D(x, y, self.rng.uniform(-3.0, 3.0)), **options)  # type: ignore[arg-type]
        self.robots.append(robot)
        if goal is not None:
            robot.head_for(*self.hall.centre(goal), self.now)
        return robot

    def kill_node(self) -> None:
        """Let the coordinator die."""
        self.coordinator = None

    def start_node(self, epoch: int = 0) -> None:
        """Start another coordinator, which knows nothing but an epoch."""
        self.coordinator = Coordinator(lambda *_: self.hall, self.parameters, epoch, self.now)

    def run(self, seconds: float, *, again: bool = False, until_home: bool = False) -> None:
        """Run for a time [s]; robots that reach a goal get another one if ``again``."""
        end = self.now + seconds
        while self.now < end:
            self.step(again=again)
            if until_home and not any(robot.goal_id for robot in self.robots):
                return

    def step(self, *, again: bool = False) -> None:
        """Run for a control cycle."""
        self.now = round(self.now + PERIOD, 3)
        for robot in self.robots:
            if self.stalls and self.rng.random() < self.stalls * PERIOD:
                robot.stalled_until = self.now + self.rng.expovariate(1.0 / 5.0)
            if again and robot.goal is None:
                robot.head_for(*self.hall.centre(self.rng.choice(self.cells)), self.now)
            robot.step(self.now, self.robots)
            if not robot.silent:
                self.network.send(robot.report(self.now), self.now)
        self._deliver()
        self._measure()

    def _deliver(self) -> None:
        names = {robot.name: robot for robot in self.robots}
        for message in self.network.arrived(self.now):
            if isinstance(message, TrafficReport) and self.coordinator is not None:
                self.coordinator.report(message, self.now)
            elif isinstance(message, TrafficGrants):
                names[message.robot].take(message, self.now)
        for grants in self.coordinator.step(self.now) if self.coordinator is not None else ():
            self.network.send(grants, self.now)

    def _measure(self) -> None:
        places = np.array([(robot.pose.x, robot.pose.y) for robot in self.robots])
        radii = np.array([robot.radius for robot in self.robots])
        apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) - radii[:, None] - radii[None]
        np.fill_diagonal(apart, 9.0)
        self.nearest = min(self.nearest, float(apart.min()))
        active = [robot for robot in self.robots if robot.goal_id]
        self.longest = max([self.longest, *(self.now - robot.goal_since for robot in active)])
        able = [robot for robot in active if not robot.dead and self.now >= robot.stalled_until]
        self._standing = 0.0 if not able or any(robot.moving for robot in self.robots) else self._standing + PERIOD
        self.stood = max(self.stood, self._standing)

    @property
    def arrived(self) -> int:
        """Number of goals reached."""
        return sum(robot.arrived for robot in self.robots)
