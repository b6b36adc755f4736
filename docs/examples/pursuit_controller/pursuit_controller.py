"""A custom local planner: pure pursuit (Coulter, 1992), which steers along an arc to a point ahead on its plan."""

import math
from typing import ClassVar

from ppaas.controllers.base import Controller, ControlRequest, NoValidControl, Velocity
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.motion import towards
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, Poses, wrap_angle
from ppaas.recoveries.free_motion import is_free

NEAR, ALIGNED, STILL, TURN_FIRST = 0.1, 0.15, 0.05, 1.0  # [m], [rad], [m/s and rad/s], [rad]


class Pursuit(Controller):
    """Pursues a point `lookahead` [m] ahead on the plan; the other parameters are limits of the robot's body."""

    name: ClassVar[str] = "pursuit"
    purpose: ClassVar[str] = "A small pure pursuit, to learn from."

    def __init__(self, *, max_vel_x: float = 0.5, max_vel_theta: float = 1.5, acc_lim_x: float = 1.0,
                 acc_lim_theta: float = 3.0, lookahead: float = 0.5) -> None:  # fmt: skip
        if not 0.1 <= lookahead <= 5.0:
            raise InvalidParameter(f"lookahead must be from 0.1 to 5 m, not {lookahead}")
        self.max_vel_x, self.max_vel_theta, self.lookahead = max_vel_x, max_vel_theta, lookahead
        self.acc_lim_x, self.acc_lim_theta = acc_lim_x, acc_lim_theta

    def set_plan(self, poses: Poses) -> None:  # called before each of the others
        self._path = FollowedPath(poses)

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        request.check()
        wanted, (v, w) = self._wanted(self._path, request), request.velocity
        v = towards(v, wanted.linear, self.acc_lim_x * request.period)
        command = Velocity(v, towards(w, wanted.angular, self.acc_lim_theta * request.period))
        if not is_free(request.costmap, request.pose, command, seconds=1.0):
            raise NoValidControl("the arc to the plan ahead is not free; plan again or recover")
        return command

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        end = self._path.end
        aligned = abs(wrap_angle(end.theta - pose.theta)) <= ALIGNED
        return pose.distance_to(end) <= NEAR and aligned and max(map(abs, velocity)) <= STILL

    def _wanted(self, path: FollowedPath, request: ControlRequest) -> Velocity:
        path.locate(request.pose)
        to_go = path.to_go(request.pose)
        ahead = request.pose.inverse() @ Pose2D(*path.point_ahead(self.lookahead))
        off = wrap_angle(path.end.theta - request.pose.theta) if to_go <= NEAR else math.atan2(ahead.y, ahead.x)
        if to_go <= NEAR or abs(off) > TURN_FIRST:
            turning = min(max(abs(off), 0.2), self.max_vel_theta) if abs(off) > ALIGNED / 2 else 0.0
            return Velocity(0.0, math.copysign(turning, off))
        curvature = 2.0 * ahead.y / (ahead.x**2 + ahead.y**2)
        fastest = min(request.speed_limit.of(self.max_vel_x, 0.05), 0.05 + to_go)
        speed = min(fastest, self.max_vel_theta / max(abs(curvature), 1e-6))
        return Velocity(speed, speed * curvature)
