"""Halls in which stand-ins drive, and robots that have one for themselves."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from benchmarks.fleet.stand_ins.robot import Points
from benchmarks.fleet.stand_ins.simulation import Simulation
from benchmarks.harness.halls import BESIDE, LANES, largest_part, zones_of_hall
from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap
from ppaas.traffic.settings import TrafficParameters
from robots.sim.shortest_paths import ShortestPaths

HALLS = {
    "warehouse": partial(warehouse, width=60.0, height=40.0),
    "office": partial(office, width=48.0, height=32.0),
    LANES: partial(warehouse, width=60.0, height=40.0),
}
"""Halls that are made up, by name: large enough for hundreds of robots."""

RADIUS = 0.2
"""Radius of robots [m]."""

CLEARANCE = 0.3
"""Least distance from walls of robots that drive freely [m]."""

ALONE, ALONE_SECONDS = 6, 1800.0
"""Number of robots that each have the hall for themselves, and the time for which each drives to goals [s]."""


@dataclass(frozen=True)
class Hall:
    """A hall, its cells, and robots in it.

    Parameters
    ----------
    name : str
        Name of a hall of `HALLS`.
    robots : int
    seed : int

    Raises
    ------
    InvalidInput
        There is no such hall, or no room for so many robots.
    """

    name: str
    robots: int
    seed: int

    def __post_init__(self) -> None:
        if self.name not in HALLS:
            raise InvalidInput(f"there is no hall {self.name!r}; choose one of {', '.join(HALLS)}")
        if not 0 < self.robots <= len(self.cells):
            raise InvalidInput(f"the number of robots must be from 1 to {len(self.cells)}, not {self.robots}")

    @cached_property
    def grid(self) -> GridMap:
        """Its map."""
        return HALLS[self.name](self.seed)

    @cached_property
    def roadmap(self) -> MetricRoadmap:
        """Its cells."""
        zones = zones_of_hall(self.name, self.grid)
        return roadmaps_of(build_layers(self.grid, robot_radius=RADIUS, zones=zones))((RADIUS,), TrafficParameters())

    @cached_property
    def cells(self) -> list[int]:
        """Cells from which starts and goals are drawn."""
        return largest_part(self.roadmap.roadmap)

    @cached_property
    def _paths(self) -> ShortestPaths:
        return ShortestPaths(self.grid, CLEARANCE, np.random.default_rng(self.seed))

    def way(self, start: Pose2D, goal: Pose2D) -> Points:
        """Return the shortest way of a robot that drives freely."""
        return self._paths.between(self._paths.nearest(start), self._paths.nearest(goal))

    def simulation(self, robots: int, seed: int, delay: float = 0.1, loss: float = 0.0) -> Simulation:
        """Return a simulation of robots at random places."""
        simulation = Simulation(self.roadmap, seed, delay, loss, find_way=self.way, beside=BESIDE)
        simulation.cells = self.cells
        for cell in simulation.rng.sample(self.cells, robots):
            simulation.add(cell, radius=RADIUS)
        return simulation

    def goals_alone(self) -> float:
        """Return how many goals a robot that is alone reaches in a second, as a mean of some."""
        goals = 0
        for seed in range(self.seed, self.seed + ALONE):
            alone = self.simulation(1, seed)
            alone.run(ALONE_SECONDS, again=True)
            goals += alone.arrived
        return goals / ALONE / ALONE_SECONDS
