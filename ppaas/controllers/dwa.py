"""The dynamic window approach: try what can be reached within a cycle, and take what serves the plan best."""

import math
from typing import Any, ClassVar

from ppaas.controllers.base import Controller, ControlRequest, NoValidControl, Velocity
from ppaas.controllers.dwa_parameters import DwaParameters
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.motion import brake, turn
from ppaas.controllers.rollouts import Rollouts
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, Poses, wrap_angle

ALIGNED = 0.2
"""A turn on the spot ends when the path leads off by less than this [rad]."""
SAME_GOAL = 1e-3
"""Two plans whose ends differ by less than this lead to the same goal [m, rad]."""


class DynamicWindow(Controller):
    """Drives a disc-shaped differential drive along a plan.

    Far off the path's heading it turns on the spot. Otherwise it rolls out the velocities that can be reached within
    a cycle and takes the best. At the goal it stops, then turns to the heading asked for; once within
    ``xy_goal_tolerance`` it need not come nearer again unless it leaves twice that (or gets another goal).

    Parameters
    ----------
    **parameters
        The fields of `ppaas.controllers.dwa_parameters.DwaParameters`.
    """

    name: ClassVar[str] = "dwa"
    purpose: ClassVar[str] = "Dynamic window: drives around what the plan does not know of, within acceleration limits."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = DwaParameters(**parameters)
        self._path: FollowedPath | None = None
        self._commanded = Velocity()
        self._turning = False
        self._arrived = False

    def set_plan(self, poses: Poses) -> None:
        """Follow this plan from now on; to the same goal, what was reached of it stays reached.

        Raises
        ------
        InvalidInput
            No pose, not rows of 7, or not finite.
        """
        path = FollowedPath(poses)
        if self._path is None or not _same(self._path.end, path.end):
            self._arrived = False
            self._turning = False
        self._path = path

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
        _check(request)
        velocity = self._velocity_now(request)
        try:
            self._commanded = self._choose(path, request, velocity)
        except NoValidControl:
            self._commanded = Velocity()
            raise
        return self._commanded

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Tell whether the robot stands at the end of the plan, within the tolerances."""
        path, p = self._plan(), self.parameters
        still = abs(velocity.linear) <= p.trans_stopped_vel and abs(velocity.angular) <= p.rot_stopped_vel
        turned = abs(wrap_angle(path.end.theta - pose.theta)) <= p.yaw_goal_tolerance
        return self._at_goal(pose, path.end) and turned and still

    def _plan(self) -> FollowedPath:
        if self._path is None:
            raise InvalidInput("no plan to follow: call set_plan first")
        return self._path

    def _at_goal(self, pose: Pose2D, goal: Pose2D) -> bool:
        tolerance = self.parameters.xy_goal_tolerance
        return pose.distance_to(goal) <= (2.0 * tolerance if self._arrived else tolerance)

    def _arrive(self, pose: Pose2D, goal: Pose2D) -> bool:
        """Tell whether to drive no nearer: well within the tolerance, or within it and the goal is not in front."""
        if self._arrived:
            self._arrived = self._at_goal(pose, goal)
        elif self._at_goal(pose, goal):
            off = wrap_angle(math.atan2(goal.y - pose.y, goal.x - pose.x) - pose.theta)
            well_within = pose.distance_to(goal) <= 0.5 * self.parameters.xy_goal_tolerance
            self._arrived = well_within or abs(off) > self.parameters.rotate_threshold
        return self._arrived

    def _velocity_now(self, request: ControlRequest) -> Velocity:
        """Return the last command if odometry, one cycle late, can be explained by it, else what was measured."""
        p, late = self.parameters, 2.0 * request.period
        linear_off = abs(self._commanded.linear - request.velocity.linear)
        angular_off = abs(self._commanded.angular - request.velocity.angular)
        explained = linear_off <= p.acc_lim_x * late and angular_off <= p.acc_lim_theta * late
        return self._commanded if explained else request.velocity

    def _choose(self, path: FollowedPath, request: ControlRequest, velocity: Velocity) -> Velocity:
        p, pose = self.parameters, request.pose
        if self._arrive(pose, path.end):
            return self._settle(path.end, request, velocity)
        path.locate(pose)
        x, y = path.point_ahead(max(2.0 * p.robot_radius, p.forward_point_distance))
        off = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
        self._turning = abs(off) > (ALIGNED if self._turning else p.rotate_threshold)
        if self._turning:
            return self._turn_by(off, request, velocity)
        rollouts = Rollouts(p, path, request, velocity)
        best = rollouts.best()
        if best is not None:
            return best
        free = rollouts.turn_to_free(off)
        if free is not None and abs(free) > p.min_vel_theta * request.period:
            return self._turn_by(free, request, velocity)
        raise NoValidControl(
            f"every velocity from x={pose.x:.3f} y={pose.y:.3f} leads into an obstacle; stop, then plan anew or recover"
        )

    def _settle(self, goal: Pose2D, request: ControlRequest, velocity: Velocity) -> Velocity:
        """Stop, then turn to the goal's heading."""
        off = wrap_angle(goal.theta - request.pose.theta)
        if abs(velocity.linear) > 0.0 or abs(off) <= 0.5 * self.parameters.yaw_goal_tolerance:
            return brake(velocity, self.parameters, request.period)
        return self._turn_by(off, request, velocity)

    def _turn_by(self, off: float, request: ControlRequest, velocity: Velocity) -> Velocity:
        # Facing nearly backwards, noise would flip the nearer side from cycle to cycle: keep the side.
        if abs(off) > 0.8 * math.pi and off * velocity.angular < 0.0:
            off = -off
        return turn(off, velocity, self.parameters, request.period)


def _same(one: Pose2D, other: Pose2D) -> bool:
    return one.distance_to(other) <= SAME_GOAL and abs(wrap_angle(one.theta - other.theta)) <= SAME_GOAL


def _check(request: ControlRequest) -> None:
    if not (request.pose.is_finite() and all(map(math.isfinite, request.velocity))):
        raise InvalidInput("the pose and the velocity of the robot must be finite; correct odometry or localization")
    if not (math.isfinite(request.period) and request.period > 0.0):
        raise InvalidInput(f"the period must be a positive number of seconds, not {request.period}")
