"""What drives a robot that has no map: scan matching, a memory of obstacles, and two planners."""

from typing import Any

import numpy as np

from benchmarks.navigation.barn.dead_ends import DeadEnds
from benchmarks.navigation.barn.jackal import RANGE_MAX, WIDTH
from benchmarks.navigation.barn.scan_matching import ScanMatching
from benchmarks.navigation.barn.scan_smoothing import smoothed
from ppaas import controllers, planners
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.errors import PlanningError
from ppaas.geometry import Pose2D, Poses
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.planners.base import PlanRequest

PERIOD = 0.05
"""Of the control cycle [s]."""
PLAN_EVERY = 4
"""Cycles between two plans, as long as the last one can be followed."""
PATIENCE = 40
"""Cycles without a velocity after which what was seen is forgotten, as Move Base's conservative_reset does."""
PADDING = 0.03
"""Added to the radius: a cell is marked by its middle, and what was seen may be nearer [m]."""
KEPT = 1.0
"""What was seen so near is never forgotten [m]."""
MARGIN = 6.0
"""The plane is known to be planned on so far beyond start and goal [m]."""
WINDOW = 10.0
"""Edge of the local costmap [m]."""


class Navigator:
    """Drives to a goal in the frame that the odometry began with, told only what the robot's sensors tell.

    Parameters
    ----------
    goal : Pose2D
        Where to go, from where the robot was switched on [m, rad].
    planner : str
        Local planner, by its plug-in name.
    parameters : dict
        Of the local planner.
    inscribed_radius : float
        No plan brings the middle of the robot nearer to an obstacle [m].
    resolution : float
        Edge of a cell [m].
    inflation_radius, cost_scaling_factor : float
        Of the costmaps [m, 1/m].
    """

    def __init__(
        self,
        goal: Pose2D,
        planner: str,
        parameters: dict[str, Any],
        *,
        inscribed_radius: float = WIDTH / 2 + PADDING,
        resolution: float = 0.05,
        inflation_radius: float = 0.6,
        cost_scaling_factor: float = 9.0,
    ) -> None:
        self._goal = goal
        self._controller = controllers.create(planner, **parameters)
        self._planner = planners.create("dijkstra")
        half = goal.distance_to(Pose2D(0.0, 0.0)) + MARGIN
        cells = round(2.0 * half / resolution)
        free = GridMap(np.zeros((cells, cells), np.int8), GridInfo(resolution, cells, cells, Pose2D(-half, -half)))
        self._layers = build_layers(
            free, robot_radius=inscribed_radius, inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
        )  # fmt: skip
        self._local = LocalCostmap(
            self._layers, width=WINDOW, height=WINDOW, robot_radius=inscribed_radius,
            inflation_radius=inflation_radius, cost_scaling_factor=cost_scaling_factor,
            obstacle_range=RANGE_MAX, raytrace_range=RANGE_MAX, static=False,
        )  # fmt: skip
        self._memory = ObstacleMemory(
            self._layers, robot_radius=inscribed_radius, inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
        )  # fmt: skip
        self._cycle = 0
        self._plan: Poses | None = None
        self._failed = 0
        self._impasses = DeadEnds()
        self._matching = ScanMatching()
        self.costs: Costmap | None = None

    def drive(self, odometry: Odometry, scan: LaserScan) -> Twist:
        """Take what the sensors tell now; return the velocity to drive until the next cycle."""
        odom, twist = odometry.pose.pose.planar(), odometry.twist.twist
        seen = smoothed(LaserReading.of(scan, odom))
        pose = self._matching.correct(odom, seen)
        shut = self._impasses.discs
        self.costs = self._local.update(pose, LaserReading(pose, seen.angles, seen.ranges), shut)
        self._memory.update(self._local.obstacles, shut)
        if self._plan is not None and self._impasses.look(self._cycle * PERIOD, pose, self._plan, self.costs):
            self._plan = None
        if self._plan is None or self._cycle % PLAN_EVERY == 0:
            self._plan_anew(pose)
        self._cycle += 1
        velocity = self._velocity(ControlRequest(pose, Velocity(twist.linear.x, twist.angular.z), self.costs, PERIOD))
        return Twist(Vector3(x=velocity.linear), Vector3(z=velocity.angular))

    def _plan_anew(self, pose: Pose2D) -> None:
        costmap = self._memory.overlay(self._local.overlay(self._layers.costmap))
        try:
            plan = self._planner.plan(costmap, PlanRequest(pose, self._goal, tolerance=MARGIN))
        except PlanningError:
            # The last plan is followed as far as it leads, and what was shut may have been the only way.
            self._impasses.forget()
            return
        self._controller.set_plan(plan.poses)
        self._plan = plan.poses

    def _velocity(self, request: ControlRequest) -> Velocity:
        try:
            if self._plan is None:
                raise NoValidControl("there is no plan yet")
            velocity = self._controller.compute_velocity(request)
        except NoValidControl:
            self._on_no_velocity(request.pose)
            return Velocity()
        self._failed = 0
        return velocity

    def _on_no_velocity(self, pose: Pose2D) -> None:
        self._failed += 1
        if self._failed >= PATIENCE:
            self._failed = 0
            # Not what is near: much of it lies where the laser does not look.
            self._impasses.forget()
            self._local.clear(pose, KEPT)
            self._memory.clear(pose, KEPT)
