"""Bench of heavy bases: how far local planners drive past a goal with brakes that are slow for the speed.

The simulated base keeps within its acceleration, and a command takes effect in the cycle after it is given.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.navigation.control_cycles import MOST, RADIUS, RATE, window
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.motion import advance, towards
from ppaas.controllers.registry import CONTROLLERS, controller_names, create
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, poses_along
from ppaas.maps.grid import GridInfo

LENGTH, MARGIN = 8.0, 3.0
"""Length of the straight way, and free space on all sides of it [m]."""

ACC_LIM_THETA = 1.0
"""Acceleration of turns of a heavy base [rad/s²]."""


class HeavyBase(NamedTuple):
    """Fastest speed of a base [m/s], and the limit of its acceleration and its brakes [m/s²]."""

    max_vel_x: float
    acc_lim_x: float

    @property
    def braking_distance(self) -> float:
        """Distance in which it stops from its fastest speed [m]."""
        return self.max_vel_x**2 / (2.0 * self.acc_lim_x)


BASES = (
    HeavyBase(0.5, 1.0), HeavyBase(0.5, 0.3), HeavyBase(1.0, 0.5), HeavyBase(1.0, 0.3), HeavyBase(1.0, 0.15),
    HeavyBase(1.5, 0.5),
)  # fmt: skip


class DriveStop(NamedTuple):
    """End of a drive: farthest place past the goal [m], whether the goal was reached, and the time [s]."""

    past: float
    arrived: bool
    seconds: float


def stop(planner: str, base: HeavyBase) -> DriveStop:
    """Drive a base straight to a goal by a local planner."""
    controller = create(
        planner, robot_radius=RADIUS, max_vel_x=base.max_vel_x, acc_lim_x=base.acc_lim_x, acc_lim_theta=ACC_LIM_THETA
    )
    costmap, goal = _hall(), MARGIN + LENGTH
    controller.set_plan(poses_along(np.stack([np.arange(MARGIN, goal + 0.01, 0.05), np.full(161, MARGIN)], axis=1)))
    pose, velocity, command, farthest = Pose2D(MARGIN, MARGIN), Velocity(), Velocity(), 0.0
    for cycle in range(round(MOST * RATE)):
        if controller.is_goal_reached(pose, velocity):
            return DriveStop(max(farthest - goal, 0.0), True, cycle / RATE)
        wanted, period = command, 1.0 / RATE
        try:
            command = controller.compute_velocity(ControlRequest(pose, velocity, window(costmap, pose), period))
        except NoValidControl:
            command = Velocity()
        velocity = Velocity(
            towards(velocity.linear, wanted.linear, base.acc_lim_x * period),
            towards(velocity.angular, wanted.angular, ACC_LIM_THETA * period),
        )
        pose = advance(pose, velocity, period)
        farthest = max(farthest, pose.x)
    return DriveStop(max(farthest - goal, 0.0), False, MOST)


def _hall() -> Costmap:
    size = round((LENGTH + 2.0 * MARGIN) / 0.05)
    return Costmap(np.zeros((round(2.0 * MARGIN / 0.05), size), np.uint8), GridInfo(0.05, size, round(MARGIN / 0.025)))


def measure(names: tuple[str, ...], done: Callable[[], object] = lambda: None) -> list[dict[str, Any]]:
    """Return a row for each base, with what each of the named local planners, or all, drives past the goal [m].

    Raises
    ------
    NotFound
        There is no local planner of that name.
    """
    chosen = [CONTROLLERS.own_name(name) for name in names] or list(controller_names())
    rows = []
    for base in BASES:
        row: dict[str, Any] = {"max_vel_x": base.max_vel_x, "acc_lim_x": base.acc_lim_x}
        row["braking_m"] = round(base.braking_distance, 2)
        for name in chosen:
            ended = stop(name, base)
            row[f"{name}_past_m"] = round(ended.past, 3) if ended.arrived else "not reached"
            row[f"{name}_s"] = round(ended.seconds, 1)
            done()
        rows.append(row)
    return rows
