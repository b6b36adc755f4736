"""Arrival at a goal: stops within the tolerance, and turns to the requested heading."""

import math
from typing import Protocol

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.motion import TurnLimits, brake, turn
from ppaas.controllers.obstacles import Room
from ppaas.geometry import Pose2D, wrap_angle

SAME_GOAL = 1e-3
"""Difference below which the ends of two plans are the same goal [m, rad]."""


class GoalTolerances(TurnLimits, Protocol):
    """Parameters of a controller that define when the goal is reached."""

    @property
    def xy_goal_tolerance(self) -> float: ...  # noqa: D102
    @property
    def yaw_goal_tolerance(self) -> float: ...  # noqa: D102
    @property
    def trans_stopped_vel(self) -> float: ...  # noqa: D102
    @property
    def rot_stopped_vel(self) -> float: ...  # noqa: D102
    @property
    def rotate_threshold(self) -> float: ...  # noqa: D102
    @property
    def allow_unknown(self) -> bool: ...  # noqa: D102


class ArrivalDetector:
    """Detects that the robot has arrived at the end of a plan, and brings it to rest there.

    Once within ``xy_goal_tolerance`` the robot need not drive nearer, unless it leaves twice that tolerance or gets
    another goal.

    Parameters
    ----------
    parameters : GoalTolerances
    body : RobotOutline
        Outline of the robot.
    """

    def __init__(self, parameters: GoalTolerances, body: RobotOutline) -> None:
        self._parameters = parameters
        self._body = body
        self._goal: Pose2D | None = None
        self._arrived = False
        self._long_way = 0.0

    def head_for(self, goal: Pose2D) -> bool:
        """Set the goal; return whether it differs from the one before."""
        before, self._goal = self._goal, goal
        other = before is None or not _same(before, goal)
        if other:
            self._arrived, self._long_way = False, 0.0
        return other

    def is_reached(self, pose: Pose2D, velocity: Velocity, goal: Pose2D) -> bool:
        """Return whether the robot stands still at the goal, within the tolerances."""
        p = self._parameters
        still = abs(velocity.linear) <= p.trans_stopped_vel and abs(velocity.angular) <= p.rot_stopped_vel
        turned = abs(wrap_angle(goal.theta - pose.theta)) <= p.yaw_goal_tolerance
        return self._at_goal(pose, goal) and turned and still

    def arrive(self, pose: Pose2D, goal: Pose2D) -> bool:
        """Return whether to stop driving: within half the tolerance, or within it with the goal not in front."""
        if self._arrived:
            self._arrived = self._at_goal(pose, goal)
        elif self._at_goal(pose, goal):
            off = wrap_angle(math.atan2(goal.y - pose.y, goal.x - pose.x) - pose.theta)
            well_within = pose.distance_to(goal) <= 0.5 * self._parameters.xy_goal_tolerance
            self._arrived = well_within or abs(off) > self._parameters.rotate_threshold
        return self._arrived

    def rest(self, pose: Pose2D, goal: Pose2D) -> bool:
        """Stop driving if the robot is within the tolerance; return whether it is."""
        self._arrived = self._at_goal(pose, goal)
        return self._arrived

    def settle(self, request: ControlRequest, goal: Pose2D, velocity: Velocity) -> Velocity:
        """Return the velocity for stopping, then turning to the goal's heading in a direction that is free.

        Raises
        ------
        NoValidControl
            A corner of the robot would touch something in either direction.
        """
        period, off = request.period, wrap_angle(goal.theta - request.pose.theta)
        if abs(velocity.linear) > 0.0 or abs(off) <= 0.5 * self._parameters.yaw_goal_tolerance:
            return brake(velocity, self._parameters, period)
        if not len(self._body.edges):  # a disc that turns in place touches nothing new
            return turn_by(off, velocity, self._parameters, period)
        return turn(self._free_turn(off, request, velocity), velocity, self._parameters, period)

    def _free_turn(self, off: float, request: ControlRequest, velocity: Velocity) -> float:
        """Return a turn to the goal's heading that is free of collision, by ``off`` or the other way round [rad]."""
        p = self._parameters
        room = Room(request.costmap, self._body, request.pose, allow_unknown=p.allow_unknown)
        long_way = _long_way(off)
        # A turn the long way round is continued even if sensor noise makes the short way look free again.
        begun = self._long_way * long_way > 0.0 or _turns_away(off, velocity)
        for side in (long_way, off) if begun else (off, long_way):
            # A turn to within half the tolerance is enough.
            if room.is_for(0.0, side - math.copysign(0.5 * p.yaw_goal_tolerance, side)):
                self._long_way = side if side == long_way else 0.0
                return side
        raise NoValidControl(
            f"no room to turn at the goal, x={request.pose.x:.3f} y={request.pose.y:.3f}; plan again or recover"
        )

    def _at_goal(self, pose: Pose2D, goal: Pose2D) -> bool:
        tolerance = self._parameters.xy_goal_tolerance
        return pose.distance_to(goal) <= (2.0 * tolerance if self._arrived else tolerance)


def turn_by(off: float, velocity: Velocity, limits: TurnLimits, period: float) -> Velocity:
    """Return the velocity for turning in place by ``off`` [rad], keeping the current direction of a half turn."""
    return turn(_long_way(off) if _turns_away(off, velocity) else off, velocity, limits, period)


def _turns_away(off: float, velocity: Velocity) -> bool:
    """Return whether the robot already turns the other way and must keep to it: near 180°, noise flips the sign."""
    return abs(off) > 0.8 * math.pi and off * velocity.angular < 0.0


def _long_way(off: float) -> float:
    """Return the turn in the other direction that leads to the same heading [rad]."""
    return off - math.copysign(math.tau, off)


def _same(one: Pose2D, other: Pose2D) -> bool:
    return one.distance_to(other) <= SAME_GOAL and abs(wrap_angle(one.theta - other.theta)) <= SAME_GOAL
