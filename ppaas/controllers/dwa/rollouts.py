"""Rollouts of one control cycle: samples the dynamic window, and scores the samples with the kernel."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import ControlRequest, Velocity
from ppaas.controllers.dwa.parameters import DwaParameters
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.kernels.dwa import BLOCKED, Frame, OutlineCheck, Scoring, score_velocities
from ppaas.controllers.motion import advance
from ppaas.controllers.obstacles import Room
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap

NOTHING = np.ones((1, 1), np.float32)
"""Placeholder of the distance field for a disc, which is checked against the inflated costmap."""

HEADINGS = 12
"""Number of headings tried on each side of the path for a turn out of a blocked pose."""


class Rollouts:
    """Rolls out velocities from the pose of the robot when they will take effect.

    Parameters
    ----------
    parameters : DwaParameters
    body : RobotOutline
        Outline of the robot.
    path : FollowedPath
        Path on which the robot was located.
    request : ControlRequest
    velocity : Velocity
        Velocity until the new one takes effect, one cycle from now.
    """

    def __init__(
        self,
        parameters: DwaParameters,
        body: RobotOutline,
        path: FollowedPath,
        request: ControlRequest,
        velocity: Velocity,
    ) -> None:
        p = parameters
        self._parameters = p
        self._velocity = velocity
        self._period = request.period
        self._limit = request.speed_limit.of(p.max_vel_x, p.min_vel_trans)
        self._costs = request.costmap.data
        self._frame = frame_of(request.costmap)
        cell = request.costmap.info.cell_of(request.pose.x, request.pose.y)
        self._cost_here = NO_INFORMATION if cell is None else int(self._costs[cell])
        self._to_go = path.to_go(request.pose)
        self._path, self._remaining = path.ahead(
            p.max_vel_x * p.sim_time + p.forward_point_distance + p.robot_radius, request.costmap
        )
        self._begin = advance(request.pose, velocity, request.period)
        self._room: Room | None = None
        self._outline = OutlineCheck(body, NOTHING, 0.0)
        if len(body.edges):
            self._room = Room(request.costmap, body, self._begin, allow_unknown=p.allow_unknown)
            self._outline = OutlineCheck(body, self._room.distance, self._room.least)

    def best(self) -> Velocity | None:
        """Return the best velocity that can be reached within the cycle, or None if all would collide."""
        samples = window(self._velocity, self._fastest(), self._parameters, self._period)
        scores = self._score(samples, self._begin.theta)
        best = int(np.argmin(scores))
        if math.isinf(scores[best]):
            return None
        linear, angular = samples[best].tolist()
        return Velocity(linear, angular)

    def turn_to_free(self, off: float) -> float | None:
        """Return the turn to the best heading in which the robot can drive straight on slowly, or None [rad].

        Only headings within ``rotate_threshold`` of the path's are tried; the path's is ``off`` [rad] from the robot's.
        """
        p = self._parameters
        turns = off + np.linspace(-p.rotate_threshold, p.rotate_threshold, 2 * HEADINGS + 1)
        ahead = np.array([[p.min_vel_trans, 0.0]])
        scores = [float(self._score(ahead, self._begin.theta + turn)[0]) for turn in turns.tolist()]
        best = int(np.argmin(scores))
        return float(turns[best]) if scores[best] < BLOCKED else None

    def can_turn(self, turning: float) -> bool:
        """Return whether the robot can turn in place at this speed [rad/s] until it stops; a disc always can."""
        if self._room is None:
            return True
        p, period = self._parameters, self._period
        turn = turning * 2.0 * period + math.copysign(turning * turning / (2.0 * p.acc_lim_theta), turning)
        return self._room.is_for(0.0, turn)

    def _fastest(self) -> float:
        """Return the speed from which the robot can stop at the goal, reduced near obstacles [m/s]."""
        p = self._parameters
        near = 0.0 if self._cost_here == NO_INFORMATION else min(1.0, self._cost_here / INSCRIBED_INFLATED_OBSTACLE)
        slowed = p.max_vel_x * (1.0 - p.cost_slowdown * near)
        return min(slowed, self._limit, math.sqrt(p.acc_lim_x * self._to_go))

    def _score(self, velocities: NDArray[np.float64], theta: float) -> NDArray[np.float64]:
        scores: NDArray[np.float64] = score_velocities(
            velocities, self._costs, self._frame, self._path, self._remaining,
            self._begin.x, self._begin.y, theta, self._scoring(), self._outline,
        )  # fmt: skip
        return scores

    def _scoring(self) -> Scoring:
        p = self._parameters
        return Scoring(
            sim_time=float(p.sim_time),
            sim_granularity=float(p.sim_granularity),
            reaction=2.0 * self._period,
            acc_lim_x=float(p.acc_lim_x),
            max_vel_x=float(p.max_vel_x),
            path_distance_bias=float(p.path_distance_bias),
            goal_distance_bias=float(p.goal_distance_bias),
            occdist_scale=float(p.occdist_scale),
            forward_point_distance=float(p.forward_point_distance),
            cost_slowdown=float(p.cost_slowdown),
            allow_unknown=p.allow_unknown,
            leaving=not len(self._outline.body.edges) and self._cost_here == INSCRIBED_INFLATED_OBSTACLE,
            way_out=2.0 * p.robot_radius,
        )


def frame_of(costmap: Costmap) -> Frame:
    """Return the origin and resolution of a costmap for the kernel."""
    x, y, theta = costmap.info.origin
    return Frame(float(x), float(y), math.cos(theta), math.sin(theta), float(costmap.info.resolution))


def window(velocity: Velocity, fastest: float, limits: DwaParameters, period: float) -> NDArray[np.float64]:
    """Return samples of the velocities that can be reached within one cycle.

    Standing still and speeds too low for the base are not included, so that a robot in front of an obstacle reports
    that no velocity is valid. If nothing else remains, the slowest speed that the base can follow is included.

    Parameters
    ----------
    velocity : Velocity
        Current velocity.
    fastest : float
        Fastest forward speed [m/s].
    limits : DwaParameters
    period : float
        Duration of a cycle [s].

    Returns
    -------
    (n, 2) array
        Forward [m/s], turning [rad/s].
    """
    lowest = max(limits.min_vel_x, velocity.linear - limits.acc_lim_x * period)
    highest = max(lowest, min(fastest, velocity.linear + limits.acc_lim_x * period))
    forward = np.linspace(lowest, highest, limits.vx_samples)
    forward = forward[np.abs(forward) >= limits.min_vel_trans]
    if not len(forward):
        forward = np.array([limits.min_vel_trans])
    reach = limits.acc_lim_theta * period
    most = limits.max_vel_theta
    right = min(max(velocity.angular - reach, -most), most)
    left = min(max(velocity.angular + reach, -most), most)
    turning = np.linspace(right, left, limits.vth_samples)
    if right < 0.0 < left:
        turning = np.append(turning, 0.0)
    samples = np.empty((len(forward), len(turning), 2))
    samples[:, :, 0] = forward[:, None]
    samples[:, :, 1] = turning
    return samples.reshape(-1, 2)
