"""Regulated pure pursuit: steers along an arc to a point ahead on the path, at a speed that suits the surroundings.

Macenski, Singh, Martín, Ginés, *Regulated Pure Pursuit for Robot Path Tracking* (2023), as implemented in Nav2.
"""

import itertools
import math
from collections import deque
from typing import Any, ClassVar

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from ppaas.controllers.arrival import turn_by
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.motion import advance, in_force, towards
from ppaas.controllers.obstacles import Room
from ppaas.controllers.path_follower import PathFollower
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, Poses, wrap_angle
from ppaas.parameters import read_parameters

# -- parameters --------------------------------------------------------------------------------------------------------


class PurePursuitParameters(DriveParameters, frozen=True, kw_only=True):
    """Parameters in addition to all local planners' parameters; ``max_vel_x`` is the desired speed in free space.

    Parameters
    ----------
    lookahead_dist : float
        Distance to the point of the path that the robot steers towards (the carrot) [m].
    use_velocity_scaled_lookahead_dist : bool
        Whether that distance is instead the one driven in ``lookahead_time``.
    min_lookahead_dist, max_lookahead_dist : float
        Limits of the scaled distance [m]; if an arc is not free, nearer carrots are tried down to the former.
    lookahead_time : float
        Time of the scaled distance [s].
    use_fixed_curvature_lookahead, curvature_lookahead_dist : bool, float
        Whether the speed depends on the curvature to a point at that fixed distance [m], instead of the carrot's.
    use_rotate_to_heading : bool
        Whether the robot turns in place if the path leads in another direction.
    rotate_to_heading_min_angle, rotate_to_heading_angular_vel : float
        Smallest angle of such a turn [rad], and its speed [rad/s].
    allow_reversing : bool
        Whether the robot reverses towards a carrot behind it, at most at the speed of ``min_vel_x``, and follows plans
        that reverse direction.
    use_regulated_linear_velocity_scaling : bool
        Whether the robot slows down in curves.
    regulated_linear_scaling_min_radius, regulated_linear_scaling_min_speed : float
        Radius of curves below which it slows down [m], and the lowest speed in curves and near obstacles [m/s].
    use_cost_regulated_linear_velocity_scaling : bool
        Whether the robot slows down near obstacles.
    cost_scaling_dist, cost_scaling_gain : float
        Distance to obstacles below which it slows down [m], and the factor of its speed there, at most 1.
    inflation_cost_scaling_factor : float
        Scaling factor of the local costmap, to convert costs into distances [1/m].
    approach_velocity_scaling_dist, min_approach_linear_velocity : float
        Distance from the end of the path at which the robot slows down [m], and its lowest speed there [m/s].
    use_collision_detection, max_allowed_time_to_collision_up_to_carrot : bool, float
        Whether the arc to the carrot must be free of collisions, and for how long [s].

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
    """

    POSITIVE: ClassVar[frozenset[str]] = DriveParameters.POSITIVE | {
        "lookahead_dist", "min_lookahead_dist", "lookahead_time", "curvature_lookahead_dist",
        "rotate_to_heading_angular_vel", "regulated_linear_scaling_min_radius", "cost_scaling_dist",
        "cost_scaling_gain", "inflation_cost_scaling_factor", "approach_velocity_scaling_dist",
        "min_approach_linear_velocity", "max_allowed_time_to_collision_up_to_carrot",
    }  # fmt: skip

    lookahead_dist: float = 0.6
    use_velocity_scaled_lookahead_dist: bool = False
    min_lookahead_dist: float = 0.3
    max_lookahead_dist: float = 0.9
    lookahead_time: float = 1.5
    use_fixed_curvature_lookahead: bool = False
    curvature_lookahead_dist: float = 0.6
    use_rotate_to_heading: bool = True
    rotate_to_heading_min_angle: float = 0.785
    rotate_to_heading_angular_vel: float = 1.8
    allow_reversing: bool = False
    use_regulated_linear_velocity_scaling: bool = True
    regulated_linear_scaling_min_radius: float = 0.9
    regulated_linear_scaling_min_speed: float = 0.25
    use_cost_regulated_linear_velocity_scaling: bool = True
    cost_scaling_dist: float = 0.6
    cost_scaling_gain: float = 1.0
    inflation_cost_scaling_factor: float = COST_SCALING_FACTOR
    approach_velocity_scaling_dist: float = 0.6
    min_approach_linear_velocity: float = 0.05
    use_collision_detection: bool = True
    max_allowed_time_to_collision_up_to_carrot: float = 1.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        super().__post_init__()
        if self.min_lookahead_dist > self.max_lookahead_dist:
            raise InvalidParameter("min_lookahead_dist must be at most max_lookahead_dist")
        if self.cost_scaling_gain > 1.0:
            raise InvalidParameter(f"cost_scaling_gain must be at most 1, not {self.cost_scaling_gain}")
        if self.rotate_to_heading_angular_vel < self.min_vel_theta:
            raise InvalidParameter("rotate_to_heading_angular_vel must be at least min_vel_theta")
        if self.allow_reversing and self.min_vel_x >= 0.0:
            raise InvalidParameter("allow_reversing requires min_vel_x below 0, the fastest speed in reverse")


# -- the point that the robot steers towards, and the legs of a path ---------------------------------------------------

Floats = NDArray[np.float64]

STANDING = 1e-6
"""Distance below which two poses are at the same position [m]."""


def carrot_at(points: Floats, pose: Pose2D, distance: float) -> Pose2D:
    """Return the point where a path first leaves a circle around the robot, in the robot's frame.

    Parameters
    ----------
    points : (m, 2) array
        Path from the robot on [m]; at least one point.
    pose : Pose2D
        Pose of the robot.
    distance : float
        Radius of the circle [m].

    Returns
    -------
    Pose2D
        The first point of the path if all are outside, the last if all are inside. Its heading has no meaning.
    """
    offsets = points - (pose.x, pose.y)
    outside = np.hypot(offsets[:, 0], offsets[:, 1]) >= distance
    last = int(np.argmax(outside)) if outside.any() else len(points) - 1
    x, y = points[last].tolist()
    if last > 0 and outside[last]:
        inner, step = offsets[last - 1], offsets[last] - offsets[last - 1]
        a, b, c = float(step @ step), float(inner @ step), float(inner @ inner) - distance * distance
        part = (-b + math.sqrt(max(b * b - a * c, 0.0))) / a
        x, y = (points[last - 1] + part * step).tolist()
    return pose.inverse() @ Pose2D(x, y, pose.theta)


def curvature_to(carrot: Pose2D) -> float:
    """Return the curvature of the arc from the robot to a point in its frame, positive to the left [1/m]."""
    squared = carrot.x * carrot.x + carrot.y * carrot.y
    return 2.0 * carrot.y / squared if squared > STANDING * STANDING else 0.0


def legs_of(poses: Poses) -> list[Poses]:
    """Split a plan wherever it turns by more than a right angle; each leg starts at the end of the one before."""
    poses = np.asarray(poses, dtype=np.float64)
    steps = np.diff(poses[:, :2], axis=0)
    moves = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > STANDING)
    vectors = steps[moves]
    back = (vectors[:-1] * vectors[1:]).sum(axis=1) < 0.0
    cuts = [0, *moves[1:][back].tolist(), len(poses) - 1]
    return [poses[first : last + 1] for first, last in itertools.pairwise(cuts)]


# -- the controller ----------------------------------------------------------------------------------------------------

SHORTER = 0.75
"""Factor of the lookahead distance for the next try, if the arc to a point is not free."""


class PurePursuit(PathFollower):
    """Drives a differential drive of any outline along a plan, and stays on it: it does not drive around obstacles.

    Within the tolerance of the goal it stops and turns as `dwa` does.

    Parameters
    ----------
    **parameters
        The fields of `PurePursuitParameters`.
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
