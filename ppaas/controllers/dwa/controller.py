"""Dynamic window approach: rolls out the velocities reachable within a cycle, and takes the best.

Fox, Burgard, Thrun, *The Dynamic Window Approach to Collision Avoidance* (1997), as in ROS's ``dwa_local_planner``.
"""

import math
from typing import Any, ClassVar

from ppaas.controllers.arrival import turn_by
from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.dwa.parameters import DwaParameters
from ppaas.controllers.dwa.rollouts import Rollouts
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.motion import in_force
from ppaas.controllers.path_follower import PathFollower
from ppaas.geometry import wrap_angle
from ppaas.parameters import read_parameters

ALIGNED = 0.2
"""Angle to the path at which a turn in place ends [rad]."""


class DynamicWindow(PathFollower):
    """Drives a differential drive of any outline along a plan.

    If the path leads in another direction, it turns in place. Otherwise it rolls out the velocities that can be
    reached within a cycle, and takes the best. At the goal it stops, then turns to the requested heading; see
    `ppaas.controllers.arrival.Arrival`.

    Parameters
    ----------
    **parameters
        The fields of `ppaas.controllers.dwa.parameters.DwaParameters`.
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
