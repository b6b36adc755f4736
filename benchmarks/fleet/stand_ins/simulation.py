"""Simulation of stand-ins and the coordinator of their traffic, with late and lost messages, and contacts."""

import heapq
import time
from dataclasses import dataclass, field
from random import Random

import numpy as np
from numpy.typing import NDArray

from benchmarks.fleet.stand_ins.robot import PERIOD, FindWay, StandIn, straight
from benchmarks.harness.halls import goal_in
from ppaas.fleet.lattice_roadmap import LatticeRoadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import Roadmap
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.traffic.coordinator import TrafficCoordinator, restore
from ppaas.traffic.settings import TrafficParameters

Places = NDArray[np.float64]

FAR = 9.0
"""Gap before there are two discs [m]."""


class Contacts:
    """Counts the times that two discs begin to touch.

    Attributes
    ----------
    count : int
    nearest : float
        Smallest gap between two discs so far [m]; negative if they touched.
    """

    def __init__(self) -> None:
        self.count, self.nearest = 0, FAR
        self._before: Places = np.empty((0, 2))
        self._touching = np.zeros((0, 0), np.bool_)

    def see(self, places: Places, radii: NDArray[np.float64]) -> None:
        """Take the places of all discs, (n, 2) [m], and their radii, (n,) [m]; new ones are the last."""
        known = len(self._before)
        before = np.concatenate([self._before, places[known:]])
        gaps = _gaps(before, places, radii)
        touching = np.zeros(gaps.shape, np.bool_)
        touching[: len(self._touching), : len(self._touching)] = self._touching
        self.count += int(((gaps <= 0.0) & ~touching).sum()) // 2
        self.nearest = min(self.nearest, float(gaps.min(initial=FAR)))
        self._before, self._touching = places, _gaps(places, places, radii) <= 0.0


def _gaps(before: Places, after: Places, radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smallest gap of each pair of discs on straight ways from one time to another [m]."""
    apart = before[:, None] - before[None]
    change = after[:, None] - after[None] - apart
    squared = np.maximum((change**2).sum(axis=2), 1e-12)
    part = np.clip(-(apart * change).sum(axis=2) / squared, 0.0, 1.0)
    nearest = np.hypot(*(apart + part[..., None] * change).transpose(2, 0, 1))
    gaps: NDArray[np.float64] = nearest - radii[:, None] - radii[None]
    np.fill_diagonal(gaps, FAR)
    return gaps


# -- network between robots and traffic node ---------------------------------------------------------------------------


class LossyNetwork:
    """Messages that arrive late or not at all; a later one may arrive before an earlier one.

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
        """Send a message at a time [s]."""
        if self._rng.random() >= self._loss:
            self._count += 1
            heapq.heappush(self._waiting, (now + self._rng.uniform(0.0, self._delay), self._count, message))

    def arrived(self, now: float) -> list[object]:
        """Return the messages that have arrived by a time [s], the earliest one first."""
        ready = []
        while self._waiting and self._waiting[0][0] <= now:
            ready.append(heapq.heappop(self._waiting)[2])
        return ready


SPACING = 0.6
"""Distance of neighbouring cells [m]: two robots of radius 0.2 m, and a margin of 0.1 m on each side."""

DEADLOCK = 60.0
"""Time after which robots that do not get on count as in a deadlock [s]."""

STALL = 5.0
"""Mean time for which a robot stands that stalls [s]."""


def roadmap_of(text: str) -> MetricRoadmap:
    """Return the roadmap of a hall drawn in text: ``#`` is blocked, each other character a cell."""
    rows = [line for line in text.strip("\n").split("\n") if line]
    width = max(map(len, rows))
    free = np.array([[c != "#" for c in row.ljust(width, "#")] for row in rows])
    return LatticeRoadmap(Roadmap.of_grid(free), SPACING, 0.0, 0.0)


@dataclass
class Simulation:
    """Robots in a hall, and what has become of them.

    Parameters
    ----------
    hall : MetricRoadmap
    seed : int
    delay : float
        Largest delay of a message [s].
    loss : float
        Part of messages that are lost.
    stalls : float
        How often a robot stops for a while [1/s].
    parameters : TrafficParameters
    now : float
        Time [s].
    find_way : callable
        Finds the ways of robots that drive freely.
    beside : float
        Largest distance of goals that are drawn from the centres of cells along x and along y, in distances of
        neighbouring cells.

    Attributes
    ----------
    contacts : Contacts
    cells : list of int
        Cells from which goals are drawn.
    longest : float
        Longest time for which a goal was open [s].
    stood : float
        Longest time in which no robot reached a cell or a goal, although goals were open [s].
    deadlocks : int
        Number of times that this was `DEADLOCK`.
    spent : list of float
        CPU time of the coordinator for each step, reports included [s].
    """

    hall: MetricRoadmap
    seed: int = 0
    delay: float = 0.1
    loss: float = 0.0
    stalls: float = 0.0
    parameters: TrafficParameters = field(default_factory=TrafficParameters)
    now: float = 0.0
    find_way: FindWay = straight
    beside: float = 0.0

    def __post_init__(self) -> None:
        self.rng = Random(self.seed)
        self.network = LossyNetwork(self.rng, self.delay, self.loss)
        self.robots: list[StandIn] = []
        self._names: dict[str, StandIn] = {}
        self.coordinator: TrafficCoordinator | None = TrafficCoordinator(lambda *_: self.hall, self.parameters)
        self.contacts = Contacts()
        self.longest = self.stood = 0.0
        self.deadlocks, self._got_on = 0, self.now
        self.spent: list[float] = []
        self.cells = list(range(len(self.hall.roadmap)))

    def add(self, cell: int, goal: int | None = None, **options: float) -> StandIn:
        """Add a robot at the centre of a cell, with a goal in the centre of another."""
        x, y = self.hall.centre(cell)
        return self.put(x, y, goal, **options)

    def put(self, x: float, y: float, goal: int | None = None, **options: float) -> StandIn:
        """Add a robot at a place [m]."""
        pose = Pose2D(x, y, self.rng.uniform(-3.0, 3.0))
        robot = StandIn(f"tb{len(self.robots)}", pose, find_way=self.find_way, **options)  # type: ignore[arg-type]
        self.robots.append(robot)
        self._names[robot.name] = robot
        if goal is not None:
            robot.head_for(*self.hall.centre(goal), self.now)
        return robot

    def kill_node(self) -> None:
        """Let the coordinator die."""
        self.coordinator = None

    def start_node(self, epoch: int = 0, state: bytes = b"") -> TrafficCoordinator:
        """Start another coordinator, which knows nothing but an epoch, or what is in a checkpoint; return it."""
        self.coordinator = coordinator = TrafficCoordinator(lambda *_: self.hall, self.parameters, epoch, self.now)
        if state:
            restore(coordinator, state, self.now)
        return coordinator

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
                robot.stalled_until = self.now + self.rng.expovariate(1.0 / STALL)
            if again and robot.goal is None:
                cell = self.rng.choice(self.cells)
                robot.head_for(*goal_in(cell, self.hall, robot.radius, self.rng, self.beside), self.now)
            robot.step(self.now)
            report = robot.due_report(self.now)
            if report is not None:
                self.network.send(report, self.now)
        self._deliver()
        self._measure()

    def _deliver(self) -> None:
        reports = []
        for message in self.network.arrived(self.now):
            if isinstance(message, TrafficGrants):
                self._names[message.robot].take(message, self.now)
            elif isinstance(message, TrafficReport):
                reports.append(message)
        if self.coordinator is None:
            return
        began = time.process_time()
        for report in reports:
            self.coordinator.report(report, self.now)
        due = self.coordinator.step(self.now)
        self.spent.append(time.process_time() - began)
        for grants in due:
            self.network.send(grants, self.now)

    def _measure(self) -> None:
        places = np.array([(robot.pose.x, robot.pose.y) for robot in self.robots])
        self.contacts.see(places, np.array([robot.radius for robot in self.robots]))
        active = [robot for robot in self.robots if robot.goal_id]
        self.longest = max([self.longest, *(self.now - robot.goal_since for robot in active)])
        able = [robot for robot in active if not robot.dead and self.now >= robot.stalled_until]
        if not able or any(robot.gets_on for robot in self.robots):
            self._got_on = self.now
        stands = round(self.now - self._got_on, 3)
        self.deadlocks += stands - PERIOD < DEADLOCK <= stands
        self.stood = max(self.stood, stands)

    @property
    def nearest(self) -> float:
        """Smallest gap between two robots so far [m]; negative if they touched."""
        return self.contacts.nearest

    @property
    def misses(self) -> list[float]:
        """Distance from each goal at which it was reached [m]."""
        return [miss for robot in self.robots for miss in robot.misses]

    @property
    def arrived(self) -> int:
        """Number of goals reached."""
        return sum(robot.arrived for robot in self.robots)
