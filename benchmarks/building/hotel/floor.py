"""Floor of a house: robots drive in its traffic, as discs that stand in for robots and their clones."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from random import Random

import numpy as np

from benchmarks.building.hotel.house import RADIUS
from benchmarks.fleet.stand_ins.robot import Points, StandIn
from benchmarks.fleet.stand_ins.simulation import LossyNetwork
from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.map_layers import MapLayers
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.planners.batch.path_lengths import PathLengths
from ppaas.traffic.coordinator import TrafficCoordinator
from ppaas.traffic.settings import TrafficParameters

DELAY = 0.1
"""Largest delay of a message between a robot and the traffic [s]."""

GRANTED_EVERY = 0.2
"""Time between two steps of the coordinator [s]."""


@dataclass
class FloorTraffic:
    """Traffic of a floor.

    Parameters
    ----------
    layers : MapLayers
    paths : PathLengths
        Finds the ways of a robot that is alone.
    rng : Random
    """

    layers: MapLayers
    paths: PathLengths
    rng: Random
    robots: dict[str, StandIn] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Begin without robots."""
        self.coordinator = TrafficCoordinator(lambda *_: self.roadmap, TrafficParameters())
        self.coordinator.occupancy.use_zones(self.layers.zones.zones)
        self._network = LossyNetwork(self.rng, DELAY, 0.0)
        self._due = 0.0

    @cached_property
    def roadmap(self) -> MetricRoadmap:
        """Cells of the floor."""
        return roadmaps_of(self.layers)((RADIUS,), TrafficParameters())

    def join(self, name: str, pose: Pose2D) -> StandIn:
        """Add a robot whose clone begins on this map."""
        robot = self.robots[name] = StandIn(name, pose, radius=RADIUS, find_way=self._way)
        return robot

    def leave(self, name: str) -> None:
        """Remove a robot whose clone goes on on another map."""
        del self.robots[name]
        self.coordinator.occupancy.let_go(name)

    def step(self, now: float, moved: Callable[[StandIn], None]) -> None:
        """Drive and grant for a control cycle; ``moved`` is called after each robot."""
        for robot in tuple(self.robots.values()):
            robot.step(now)
            moved(robot)
            report = robot.due_report(now)
            if report is not None:
                self._network.send(report, now)
        for message in self._network.arrived(now):
            if isinstance(message, TrafficGrants) and message.robot in self.robots:
                self.robots[message.robot].take(message, now)
            elif isinstance(message, TrafficReport) and message.robot in self.robots:
                self.coordinator.report(message, now)
        if now >= self._due:
            self._due = now + GRANTED_EVERY
            for grants in self.coordinator.step(now):
                self._network.send(grants, now)

    def _way(self, start: Pose2D, goal: Pose2D) -> Points:
        """Return the shortest way of a robot that drives freely; through doors, which count as walls, straight on."""
        one, other = self.paths.cell(start.x, start.y), self.paths.cell(goal.x, goal.y)
        between: Points = np.array([start[:2]])
        if one is not None and other is not None and len(cells := self.paths.path(one, other)):
            between = self.paths.costmap.info.to_world(cells)
        return np.concatenate([between, [goal[:2]]])
