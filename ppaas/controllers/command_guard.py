"""Command guard: slows a commanded velocity so that the robot stops before it touches an obstacle."""

from collections.abc import Iterator

from ppaas.controllers.base import Velocity, VelocityLimits
from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.controllers.obstacles import Room
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D

STEPS = 8
"""Number of speeds that are tried, from the commanded one down."""


class CommandGuard:
    """Checks a command by the way that the robot drives until it stands.

    Parameters
    ----------
    body : RobotOutline
        Outline of the robot.
    limits : VelocityLimits
        Limits of the base.
    reaction : float
        Time for which the robot keeps a velocity before it brakes [s].
    """

    def __init__(self, body: RobotOutline, limits: VelocityLimits, reaction: float) -> None:
        self._body = body
        self._limits = limits
        self._reaction = reaction

    def allowed(self, wanted: Velocity, pose: Pose2D, costmap: Costmap) -> Velocity:
        """Return the fastest velocity on the same arc from which the robot can stop in time.

        A robot that cannot drive on at all may still turn in place as commanded. One that touches an obstacle already
        may move away from it, but not nearer. Unknown cells are free.

        Parameters
        ----------
        wanted : Velocity
        pose : Pose2D
            Of the robot, in the frame of the costmap.
        costmap : Costmap
            Window around the robot.
        """
        if wanted == Velocity():
            return wanted
        room = Room(costmap, self._body, pose, allow_unknown=True)
        return next((each for each in _slower(wanted) if self._may_drive(each, room)), Velocity())

    def _may_drive(self, velocity: Velocity, room: Room) -> bool:
        linear, angular, limits = *velocity, self._limits
        braking = max(abs(linear) / limits.acc_lim_x, abs(angular) / limits.acc_lim_theta)
        seconds = self._reaction + 0.5 * braking
        return room.is_for(linear * seconds, angular * seconds)


def _slower(wanted: Velocity) -> Iterator[Velocity]:
    for motion in (wanted, Velocity(0.0, wanted.angular)) if wanted.linear and wanted.angular else (wanted,):
        for step in range(STEPS, 0, -1):
            yield Velocity(motion.linear * step / STEPS, motion.angular * step / STEPS)
