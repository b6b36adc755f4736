"""Navigator of a robot without a map: scan matching, obstacle memory, dead ends, a global and a local planner."""

import math
from typing import Any

import numpy as np

from benchmarks.navigation.barn.jackal import RANGE_MAX, WIDTH
from benchmarks.navigation.barn.scan_matching import ScanMatching, smoothed
from ppaas import controllers, planners
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import NO_INFORMATION, Costmap
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.moving_obstacles import Disc
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.errors import PlanningError
from ppaas.geometry import Pose2D, Poses
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.navigation.move_base import Oscillation
from ppaas.planners.base import PlanRequest

DISTANCE, TIMEOUT = 0.4, 2.0
"""The robot makes no progress if it has not moved this distance [m] within this time [s]."""
NEAR, AHEAD = 0.55, 1.2
"""Range of distances in which the narrowest place of the plan is sought [m]; closer, the robot needs space to turn."""
RADIUS = 0.15
"""Radius of a blocked disc [m]."""
STEP, BESIDE = 0.1, 0.3
"""Spacing of the recorded positions of the robot, and distance around each within which nothing is blocked [m]."""


class DeadEnds:
    """Checks the robot's progress, and blocks the narrowest place ahead if there is none.

    Attributes
    ----------
    discs : list of (x, y, radius)
        Blocked discs in the frame of the plan [m].
    """

    def __init__(self) -> None:
        self.discs: list[Disc] = []
        self._watch = Oscillation(DISTANCE, TIMEOUT)
        self._trail: list[tuple[float, float]] = []

    def look(self, now: float, pose: Pose2D, plan: Poses, costs: Costmap) -> bool:
        """Block a place if the robot makes no progress; return whether a place was blocked.

        Parameters
        ----------
        now : float
            Current time [s].
        pose : Pose2D
            Pose of the robot.
        plan : (n, 7) array
            Poses of the current plan.
        costs : Costmap
            Local costmap.
        """
        self._remember(pose)
        self._watch.has_left(now, pose)
        if not self._watch.timed_out(now):
            return False
        self._watch.reset(now)
        place = _narrowest(pose, self._untried(plan), costs)
        if place is not None:
            self.discs.append((*place, RADIUS))
        return place is not None

    def forget(self) -> None:
        """Unblock all places."""
        self.discs.clear()

    def _remember(self, pose: Pose2D) -> None:
        if not self._trail or math.dist(self._trail[-1], (pose.x, pose.y)) >= STEP:
            self._trail.append((pose.x, pose.y))

    def _untried(self, plan: Poses) -> Poses:
        """Return the poses of a plan away from the robot's path: a slow turn on the way back is not a dead end."""
        away = plan[:, None, :2] - np.array(self._trail)
        untried: Poses = plan[np.hypot(away[..., 0], away[..., 1]).min(axis=1) > BESIDE]
        return untried


def _narrowest(pose: Pose2D, plan: Poses, costs: Costmap) -> tuple[float, float] | None:
    """Return x, y [m] of the plan's most expensive cell between ``NEAR`` and ``AHEAD``; None without one."""
    if not len(plan):
        return None
    away = np.hypot(plan[:, 0] - pose.x, plan[:, 1] - pose.y)
    nearest = int(np.argmin(away))
    ahead = plan[nearest:][(away[nearest:] > NEAR) & (away[nearest:] < AHEAD)]
    cells = costs.info.to_cells(ahead[:, :2])
    inside = ((cells >= 0) & (cells < costs.info.shape)).all(axis=1)
    cells, ahead = cells[inside], ahead[inside]
    if not len(cells):
        return None
    dear = costs.data[cells[:, 0], cells[:, 1]].astype(np.int64)
    dear[dear == NO_INFORMATION] = 0
    x, y = ahead[int(np.argmax(dear)), :2].tolist()
    return x, y


PERIOD = 0.05
"""Period of the control cycle [s]."""
PLAN_EVERY = 4
"""Number of control cycles between two plans."""
PATIENCE = 40
"""Number of failed cycles after which obstacles are cleared, as by Move Base's conservative_reset."""
PADDING = 0.03
"""Padding of the radius [m]: a cell is marked at its centre, but the obstacle may be closer."""
KEPT = 1.0
"""Distance within which obstacles are never cleared [m]."""
MARGIN = 6.0
"""Margin of the global costmap around start and goal [m]."""
WINDOW = 10.0
"""Edge of the local costmap [m]."""


class BarnNavigator:
    """Drives to a goal by odometry and laser alone; its frame is the odometry frame at the start.

    Parameters
    ----------
    goal : Pose2D
        Goal relative to the robot's start [m, rad].
    planner : str
        Name of the local planner's plug-in.
    parameters : dict
        Parameters of the local planner.
    inscribed_radius : float
        Smallest distance of plans from obstacles [m].
    resolution : float
        Edge of a cell [m].
    inflation_radius, cost_scaling_factor : float
        Inflation of the costmaps [m, 1/m].
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
        self._dead_ends = DeadEnds()
        self._matching = ScanMatching()
        self.costs: Costmap | None = None

    def drive(self, odometry: Odometry, scan: LaserScan) -> Twist:
        """Run a control cycle: process the sensors' messages, and return the velocity until the next cycle."""
        odom, twist = odometry.pose.pose.planar(), odometry.twist.twist
        seen = smoothed(LaserReading.of(scan, odom))
        pose = self._matching.correct(odom, seen)
        shut = self._dead_ends.discs
        self.costs = self._local.update(pose, LaserReading(pose, seen.angles, seen.ranges), shut)
        self._memory.update(self._local.obstacles, shut)
        if self._plan is not None and self._dead_ends.look(self._cycle * PERIOD, pose, self._plan, self.costs):
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
            # Keep the last plan, and unblock all places: one of them may have been the only way.
            self._dead_ends.forget()
            return
        self._controller.set_plan(plan.poses)
        self._plan = plan.poses

    def _velocity(self, request: ControlRequest) -> Velocity:
        try:
            if self._plan is None:
                raise NoValidControl("no plan has been computed yet")
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
            # Keep near obstacles, as many of them are outside the laser's field of view.
            self._dead_ends.forget()
            self._local.clear(pose, KEPT)
            self._memory.clear(pose, KEPT)
