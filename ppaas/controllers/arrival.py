"""How a robot ends at its goal: it stops within the tolerance, turns to the heading asked for, and stands."""

import math
from typing import Protocol

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.kernels.clearance import Body
from ppaas.controllers.motion import TurnLimits, brake, turn
from ppaas.controllers.obstacles import Room
from ppaas.geometry import Pose2D, wrap_angle

SAME_GOAL = 1e-3
"""Two plans whose ends differ by less than this lead to the same goal [m, rad]."""


class GoalTolerances(TurnLimits, Protocol):
    """What of a controller's parameters says when it is there."""

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


class Arrival:
    """Whether the robot is where a plan ends, and how it comes to stand there.

    Once within ``xy_goal_tolerance`` it need not come nearer again, unless it leaves twice that or gets another goal.

    Parameters
    ----------
    parameters : GoalTolerances
    body : Body
        Of the robot.
    """

    def __init__(self, parameters: GoalTolerances, body: Body) -> None:
        self._parameters = parameters
        self._body = body
        self._goal: Pose2D | None = None
        self._arrived = False
        self._long_way = 0.0

    def head_for(self, goal: Pose2D) -> bool:
        """Take the end of a plan; return whether it is another than before."""
        before, self._goal = self._goal, goal
        other = before is None or not _same(before, goal)
        if other:
            self._arrived, self._long_way = False, 0.0
        return other

    def is_reached(self, pose: Pose2D, velocity: Velocity, goal: Pose2D) -> bool:
        """Tell whether the robot stands at the goal, within the tolerances."""
        p = self._parameters
        still = abs(velocity.linear) <= p.trans_stopped_vel and abs(velocity.angular) <= p.rot_stopped_vel
        turned = abs(wrap_angle(goal.theta - pose.theta)) <= p.yaw_goal_tolerance
        return self._at_goal(pose, goal) and turned and still

    def arrive(self, pose: Pose2D, goal: Pose2D) -> bool:
        """Tell whether to drive no nearer: well within the tolerance, or within it and the goal is not in front."""
        if self._arrived:
            self._arrived = self._at_goal(pose, goal)
        elif self._at_goal(pose, goal):
            off = wrap_angle(math.atan2(goal.y - pose.y, goal.x - pose.x) - pose.theta)
            well_within = pose.distance_to(goal) <= 0.5 * self._parameters.xy_goal_tolerance
            self._arrived = well_within or abs(off) > self._parameters.rotate_threshold
        return self._arrived

    def rest(self, pose: Pose2D, goal: Pose2D) -> bool:
        """Drive no nearer, if the robot is within the tolerance; tell whether it is."""
        self._arrived = self._at_goal(pose, goal)
        return self._arrived

    def settle(self, request: ControlRequest, goal: Pose2D, velocity: Velocity) -> Velocity:
        """Return what to drive next to stop and then turn to the goal's heading, to the side where there is room.

        Raises
        ------
        NoValidControl
            A corner of the robot would touch something, whichever side it turned to.
        """
        period, off = request.period, wrap_angle(goal.theta - request.pose.theta)
        if abs(velocity.linear) > 0.0 or abs(off) <= 0.5 * self._parameters.yaw_goal_tolerance:
            return brake(velocity, self._parameters, period)
        if not len(self._body.edges):  # a disc touches nothing by turning
            return turn_by(off, velocity, self._parameters, period)
        return turn(self._roomy(off, request, velocity), velocity, self._parameters, period)

    def _roomy(self, off: float, request: ControlRequest, velocity: Velocity) -> float:
        """Return the turn [rad] by ``off`` or the long way round to the same heading: that for which there is room."""
        p = self._parameters
        room = Room(request.costmap, self._body, request.pose, allow_unknown=p.allow_unknown)
        long_way = _long_way(off)
        # Who has begun to turn the long way goes on, though what was in the way comes and goes with noise.
        begun = self._long_way * long_way > 0.0 or _turns_away(off, velocity)
        for side in (long_way, off) if begun else (off, long_way):
            # To within the tolerance will do.
            if room.is_for(0.0, side - math.copysign(0.5 * p.yaw_goal_tolerance, side)):
                self._long_way = side if side == long_way else 0.0
                return side
        raise NoValidControl(
            f"no room to turn at the goal, x={request.pose.x:.3f} y={request.pose.y:.3f}; plan anew or recover"
        )

    def _at_goal(self, pose: Pose2D, goal: Pose2D) -> bool:
        tolerance = self._parameters.xy_goal_tolerance
        return pose.distance_to(goal) <= (2.0 * tolerance if self._arrived else tolerance)


def turn_by(off: float, velocity: Velocity, limits: TurnLimits, period: float) -> Velocity:
    """Return what to drive next to turn on the spot by ``off`` [rad], to the side that it turns to already."""
    return turn(_long_way(off) if _turns_away(off, velocity) else off, velocity, limits, period)


def _turns_away(off: float, velocity: Velocity) -> bool:
    """Tell whether it turns to the other side, and is to keep it: facing nearly backwards, noise would flip sides."""
    return abs(off) > 0.8 * math.pi and off * velocity.angular < 0.0


def _long_way(off: float) -> float:
    """Return the turn to the other side that leads to the same heading [rad]."""
    return off - math.copysign(math.tau, off)


def _same(one: Pose2D, other: Pose2D) -> bool:
    return one.distance_to(other) <= SAME_GOAL and abs(wrap_angle(one.theta - other.theta)) <= SAME_GOAL
