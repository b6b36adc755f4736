"""Simulated robot with localization, whose errors are measured while it drives."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.localization.crowd import Crowd, CrowdedWorld, Inching
from benchmarks.localization.localizer import Localizer
from benchmarks.localization.route import Route
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from robots.sim.shortest_paths import ShortestPaths

ODOM_STEPS, SCAN_STEPS = 3, 5
"""Steps of the world (20 ms) between two messages: odometry at 17 Hz, scans at 10 Hz."""

Errors = Iterator[tuple[float, float, float]]
"""Driven distance [m] and errors of localization [m, rad] at each scan."""


class LocalizationScene:
    """A robot at a random pose of a map.

    Parameters
    ----------
    grid : GridMap
    parameters : dict
        Parameters of amcl.
    rng : numpy.random.Generator
        Random source of the start, the route and the people.
    told : bool
        Whether localization gets the initial pose.

    Attributes
    ----------
    localizer : Localizer
    """

    def __init__(self, grid: GridMap, parameters: dict[str, Any], rng: np.random.Generator, *, told: bool) -> None:
        self._rng = rng
        self._route = Route(grid, rng)
        start = self._route.anywhere()
        self._world = CrowdedWorld(grid, int(rng.integers(1 << 30)))
        self._robot = self._world.add_robot(start)
        self.localizer = Localizer(build_layers(grid), start if told else self._route.anywhere(), parameters)
        self._route.begin(start)
        if not told:
            self.localizer.look_everywhere()

    @property
    def way(self) -> float:
        """Driven distance [m]."""
        return self._robot.base.travelled

    def drive(self, metres: float) -> Errors:
        """Drive a distance [m]; yield the errors at each scan."""
        end = self.way + metres
        return self._errors(self._route.steer, lambda: self.way >= end)

    def jam(self, people: int, seconds: float) -> Errors:
        """Crowd the robot with people for a time [s]; yield the errors at each scan."""
        world, rng = self._world, self._rng
        world.crowd = Crowd(self._robot, ShortestPaths(world.grid, world.pedestrian_model.clearance, rng), people, rng)
        end = world.time() + seconds
        yield from self._errors(Inching(self._route, world, rng).steer, lambda: world.time() >= end)
        world.crowd = None

    def stand(self, seconds: float) -> Errors:
        """Leave the robot where it is for a time [s]; yield the errors at each scan."""
        end = self._world.time() + seconds
        return self._errors(lambda _: Twist(), lambda: self._world.time() >= end)

    def creep(self, seconds: float) -> Errors:
        """Drive very slowly for a time [s]; yield the errors at each scan."""
        end = self._world.time() + seconds
        return self._errors(self._route.creep, lambda: self._world.time() >= end)

    def carry_off(self) -> None:
        """Kidnap the robot: move it to a random pose without odometry."""
        there = self._route.anywhere()
        self._robot.base.carry_to(there)
        self._route.begin(there)

    def _errors(self, steer: Callable[[Pose2D], Twist], ended: Callable[[], bool]) -> Errors:
        world, robot = self._world, self._robot
        while not ended():
            if world.steps % ODOM_STEPS == 0 or world.steps % SCAN_STEPS == 0:
                self.localizer.odometry(robot.odometry())
            if world.steps % SCAN_STEPS == 0:
                true = robot.base.pose
                robot.command(steer(true))
                told = self.localizer.scan(robot.scan())
                if told is not None:
                    yield self.way, told.distance_to(true), abs(wrap_angle(told.theta - true.theta))
            world.step()
