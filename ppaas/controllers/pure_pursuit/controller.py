"""Regulated pure pursuit: steers along an arc to a point ahead on the path, at a speed that suits the surroundings.

Macenski, Singh, Martín, Ginés, *Regulated Pure Pursuit for Robot Path Tracking* (2023), as implemented in Nav2.
"""

import math
from collections import deque
from typing import Any, ClassVar

from msgspec.structs import replace

from ppaas.controllers.arrival import turn_by
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.motion import advance, in_force, towards
from ppaas.controllers.obstacles import Room
from ppaas.controllers.path_follower import PathFollower
from ppaas.controllers.pure_pursuit.carrot import carrot_at, curvature_to, legs_of
from ppaas.controllers.pure_pursuit.parameters import PurePursuitParameters
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.geometry import Pose2D, Poses, wrap_angle
from ppaas.parameters import read_parameters

SHORTER = 0.75
"""Factor of the lookahead distance for the next try, if the arc to a point is not free."""


class PurePursuit(PathFollower):
    """Drives a differential drive of any outline along a plan, and stays on it: it does not drive around obstacles.

    Within the tolerance of the goal it stops and turns as `dwa` does.

    Parameters
    ----------
    **parameters
        The fields of `ppaas.controllers.pure_pursuit.parameters.PurePursuitParameters`.
    """

    name: ClassVar[str] = "pure_pursuit"
    purpose: ClassVar[str] = "Regulated pure pursuit: stays on its plan, slower in curves and near obstacles."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(PurePursuitParameters, self.name, parameters)
        p = self.parameters
        super().__init__(p)
        self._turning = replace(p, max_vel_theta=min(p.max_vel_theta, p.rotate_to_heading_angular_vel))
        self._legs: deque[FollowedPath] = deque()
        self._commanded = Velocity()

    def set_plan(self, poses: Poses) -> None:
        """Follow this plan from now on; a new plan to the same goal does not undo an arrival.

        Raises
        ------
        InvalidInput
            The plan is empty, has another shape than (n, 7), or is not finite.
        """
        super().set_plan(poses)
        legs = legs_of(poses) if self.parameters.allow_reversing else [poses]
        self._legs = deque(FollowedPath(leg) for leg in legs)

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle.

        Raises
        ------
        NoValidControl
            The path ahead is not free: the caller must stop.
        InvalidInput
            No plan was set, or the pose, the velocity or the period is not finite.
        """
        goal = self._plan().end
        request.check()
        velocity = in_force(self._commanded, request.velocity, self.parameters, 2.0 * request.period)
        self._commanded = Velocity()
        if self._leg(request.pose) is self._legs[-1] and self._arrival.arrive(request.pose, goal):
            self._commanded = self._arrival.settle(request, goal, velocity)
        else:
            self._commanded = self._choose(request, velocity)
        return self._commanded

    def _choose(self, request: ControlRequest, velocity: Velocity) -> Velocity:
        """Return the command towards the farthest point whose arc is free."""
        p, pose = self.parameters, request.pose
        leg = self._legs[0]
        free = _CollisionCheck(p, self._body, request, velocity) if p.use_collision_detection else None
        lookahead = self._lookahead(velocity)
        while True:
            carrot = carrot_at(leg.ahead(2.0 * lookahead, request.costmap)[0], pose, lookahead)
            command = self._command_to(carrot, leg, request, velocity)
            if free is None or free.is_free(command, carrot):
                return command
            if lookahead <= p.min_lookahead_dist:
                raise NoValidControl(
                    f"the plan ahead of x={pose.x:.3f} y={pose.y:.3f} is not free; plan again or recover"
                )
            lookahead = max(SHORTER * lookahead, p.min_lookahead_dist)

    def _leg(self, pose: Pose2D) -> FollowedPath:
        """Return the leg of the plan that the robot is on."""
        while len(self._legs) > 1 and self._is_done(self._legs[0], pose):
            self._legs.popleft()
        self._legs[0].locate(pose)
        return self._legs[0]

    def _is_done(self, leg: FollowedPath, pose: Pose2D) -> bool:
        leg.locate(pose)
        return leg.to_go(pose) <= self.parameters.xy_goal_tolerance

    def _lookahead(self, velocity: Velocity) -> float:
        p = self.parameters
        if not p.use_velocity_scaled_lookahead_dist:
            return p.lookahead_dist
        return min(max(abs(velocity.linear) * p.lookahead_time, p.min_lookahead_dist), p.max_lookahead_dist)

    def _command_to(self, carrot: Pose2D, leg: FollowedPath, request: ControlRequest, velocity: Velocity) -> Velocity:
        p, period = self.parameters, request.period
        backwards = p.allow_reversing and carrot.x < 0.0
        off = math.atan2(carrot.y, carrot.x)
        off = wrap_angle(off + math.pi) if backwards else off
        if p.use_rotate_to_heading and abs(off) > p.rotate_to_heading_min_angle:
            return turn_by(off, velocity, self._turning, period)
        curvature = curvature_to(carrot)
        speed = regulated_speed(p, self._ahead(leg, request, curvature), _cost_at(request), leg.to_go(request.pose))
        speed = min(speed, request.speed_limit.of(p.max_vel_x, p.min_vel_trans))
        wanted = -min(speed, -p.min_vel_x) if backwards else speed
        linear = towards(velocity.linear, wanted, p.acc_lim_x * period)
        turning = min(max(linear * curvature, -p.max_vel_theta), p.max_vel_theta)
        return Velocity(linear, towards(velocity.angular, turning, p.acc_lim_theta * period))

    def _ahead(self, leg: FollowedPath, request: ControlRequest, curvature: float) -> float:
        """Return the curvature that limits the speed [1/m]."""
        p = self.parameters
        if not p.use_fixed_curvature_lookahead:
            return curvature
        points, _ = leg.ahead(2.0 * p.curvature_lookahead_dist, request.costmap)
        return curvature_to(carrot_at(points, request.pose, p.curvature_lookahead_dist))


class _CollisionCheck:
    """Checks commands for collisions, from the pose of the robot when they take effect."""

    def __init__(
        self, p: PurePursuitParameters, body: RobotOutline, request: ControlRequest, velocity: Velocity
    ) -> None:
        self._seconds = p.max_allowed_time_to_collision_up_to_carrot
        begin = advance(request.pose, velocity, request.period)
        self._room = Room(request.costmap, body, begin, allow_unknown=p.allow_unknown)

    def is_free(self, command: Velocity, carrot: Pose2D) -> bool:
        """Return whether the robot can keep a command for the required time, or until it reaches the carrot."""
        seconds = self._seconds
        if command.linear:
            seconds = min(seconds, math.hypot(carrot.x, carrot.y) / abs(command.linear))
        return self._room.is_for(command.linear * seconds, command.angular * seconds)


def _cost_at(request: ControlRequest) -> int:
    cell = request.costmap.info.cell_of(request.pose.x, request.pose.y)
    return NO_INFORMATION if cell is None else int(request.costmap.data[cell])


def regulated_speed(parameters: PurePursuitParameters, curvature: float, cost: int, to_go: float) -> float:
    """Return the speed in either direction [m/s]: slower in curves, near obstacles, and towards the end of the path.

    Parameters
    ----------
    parameters : PurePursuitParameters
    curvature : float
        Curvature of the arc [1/m].
    cost : int
        Cost of the robot's cell.
    to_go : float
        Remaining distance to the end of the path [m].
    """
    p = parameters
    kept = min(_kept_in_curve(p, curvature), _kept_near_obstacle(p, cost))
    speed = max(p.max_vel_x * kept, p.regulated_linear_scaling_min_speed)
    if to_go < p.approach_velocity_scaling_dist:
        part = to_go / p.approach_velocity_scaling_dist
        speed = min(speed, max(p.max_vel_x * part, p.min_approach_linear_velocity))
    # Slow enough to stop at the end with half the braking allowed, and to turn along the arc.
    stoppable = max(math.sqrt(p.acc_lim_x * max(to_go, 0.0)), p.min_approach_linear_velocity)
    turnable = p.max_vel_theta / abs(curvature) if curvature else math.inf
    return min(speed, p.max_vel_x, stoppable, turnable)


def _kept_in_curve(p: PurePursuitParameters, curvature: float) -> float:
    if not p.use_regulated_linear_velocity_scaling:
        return 1.0
    tightness = abs(curvature) * p.regulated_linear_scaling_min_radius
    return 1.0 / tightness if tightness > 1.0 else 1.0


def _kept_near_obstacle(p: PurePursuitParameters, cost: int) -> float:
    if not p.use_cost_regulated_linear_velocity_scaling or cost in {FREE_SPACE, NO_INFORMATION}:
        return 1.0
    graded = min(cost, INSCRIBED_INFLATED_OBSTACLE - 1) / (INSCRIBED_INFLATED_OBSTACLE - 1)
    distance = p.robot_radius - math.log(graded) / p.inflation_cost_scaling_factor
    return min(1.0, p.cost_scaling_gain * distance / p.cost_scaling_dist) if distance < p.cost_scaling_dist else 1.0
