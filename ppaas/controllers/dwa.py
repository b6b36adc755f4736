"""Dynamic window approach: rolls out the velocities reachable within a cycle, and takes the best.

Fox, Burgard, Thrun, *The Dynamic Window Approach to Collision Avoidance* (1997), as in ROS's ``dwa_local_planner``.
"""

import math
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.arrival import turn_by
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.kernels.dwa import BLOCKED, Frame, OutlineCheck, Scoring, score_velocities
from ppaas.controllers.motion import advance, in_force
from ppaas.controllers.obstacles import Room
from ppaas.controllers.path_follower import PathFollower
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter
from ppaas.geometry import wrap_angle
from ppaas.parameters import read_parameters

# -- parameters --------------------------------------------------------------------------------------------------------


class DwaParameters(DriveParameters, frozen=True, kw_only=True):
    """Parameters in addition to the ones that all local planners have.

    Parameters
    ----------
    sim_time : float
        Duration of rollouts [s].
    sim_granularity : float
        Step of a rollout [m].
    vx_samples, vth_samples : int
        Number of forward and turning speeds tried.
    path_distance_bias, goal_distance_bias : float
        Weights of the distance to the path, and of the remaining distance along it [1/m].
    occdist_scale : float
        Weight of the highest cost on the rollout.
    forward_point_distance : float
        Distance in front of the robot of a second point that should be on the path [m].
    cost_slowdown : float
        Part by which the speed is reduced where the cost is highest, from 0 to below 1.
    rotate_threshold : float
        Angle to the path above which the robot turns in place [rad].
    robot_radius : float
        Radius of the robot [m]. Without a footprint, collisions are read from the inflated costmap; the radius then
        sets how far ahead the direction of the path is taken, and how far the robot may drive to leave an inscribed
        cell.

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
    """

    POSITIVE: ClassVar[frozenset[str]] = DriveParameters.POSITIVE | {
        "min_vel_trans", "sim_time", "sim_granularity", "vx_samples", "vth_samples",
    }  # fmt: skip

    sim_time: float = 1.7
    sim_granularity: float = 0.025
    vx_samples: int = 8
    vth_samples: int = 20
    path_distance_bias: float = 32.0
    goal_distance_bias: float = 24.0
    occdist_scale: float = 0.1
    forward_point_distance: float = 0.2
    cost_slowdown: float = 0.5

    def __post_init__(self) -> None:
        """Check the ranges."""
        super().__post_init__()
        if self.cost_slowdown >= 1.0:
            raise InvalidParameter(
                f"cost_slowdown must be below 1, not {self.cost_slowdown}: the robot would stop near obstacles"
            )


# -- rollouts of one control cycle -------------------------------------------------------------------------------------

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


# -- the controller ----------------------------------------------------------------------------------------------------

ALIGNED = 0.2
"""Angle to the path at which a turn in place ends [rad]."""


class DynamicWindow(PathFollower):
    """Drives a differential drive of any outline along a plan.

    If the path leads in another direction, it turns in place. Otherwise it rolls out the velocities that can be
    reached within a cycle, and takes the best. At the goal it stops, then turns to the requested heading; see
    `ppaas.controllers.arrival.ArrivalDetector`.

    Parameters
    ----------
    **parameters
        The fields of `DwaParameters`.
    """

    name: ClassVar[str] = "dwa"
    purpose: ClassVar[str] = "Dynamic window: drives around obstacles near the plan, within acceleration limits."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(DwaParameters, self.name, parameters)
        super().__init__(self.parameters)
        self._commanded = Velocity()
        self._turning = False

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle.

        Raises
        ------
        NoValidControl
            Every velocity would collide: the caller must stop.
        InvalidInput
            No plan was set, or the pose, the velocity or the period is not finite.
        """
        path = self._plan()
        request.check()
        # The odometry is one cycle late: the last command counts as the velocity if it explains the odometry.
        velocity = in_force(self._commanded, request.velocity, self.parameters, 2.0 * request.period)
        try:
            self._commanded = self._choose(path, request, velocity)
        except NoValidControl:
            self._commanded = Velocity()
            raise
        return self._commanded

    def _on_new_goal(self) -> None:
        self._turning = False

    def _choose(self, path: FollowedPath, request: ControlRequest, velocity: Velocity) -> Velocity:
        p, pose = self.parameters, request.pose
        if self._arrival.arrive(pose, path.end):
            return self._arrival.settle(request, path.end, velocity)
        path.locate(pose)
        x, y = path.point_ahead(max(2.0 * p.robot_radius, p.forward_point_distance))
        off = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
        self._turning = abs(off) > (ALIGNED if self._turning else p.rotate_threshold)
        rollouts = Rollouts(p, self._body, path, request, velocity)
        if self._turning:
            command = turn_by(off, velocity, p, request.period)
            if rollouts.can_turn(command.angular):
                return command
        best = rollouts.best()
        if best is not None:
            return best
        free = rollouts.turn_to_free(off)
        if free is not None and abs(free) > p.min_vel_theta * request.period:
            command = turn_by(free, velocity, p, request.period)
            if rollouts.can_turn(command.angular):
                return command
        raise NoValidControl(
            f"every velocity from x={pose.x:.3f} y={pose.y:.3f} leads to a collision; stop, then plan again or recover"
        )
