"""Passive motion safety: slows a robot down so that it stands before it can touch an approaching person.

Contacts cannot be ruled out, since others move too, but the robot does not cause them (Bouraine, Fraichard, Salhi,
*Provably Safe Navigation for Mobile Robots with Limited Field-of-Views*, 2012). People turn without warning, so a
person counts even if they would pass by if they walked straight on.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D, wrap_angle

REACTION = 0.25
"""Reaction time of the robot: the time of a scan, a control cycle and a command [s]."""

MARGIN = 0.1
"""Distance kept between the outlines, which includes the error of the laser [m]."""


@dataclass(frozen=True, slots=True)
class PassiveSafety:
    """Slows a robot down in front of approaching people.

    Parameters
    ----------
    robot_radius : float
        Radius of the robot [m].
    acc_lim_x : float
        Deceleration of the robot [m/s²].
    """

    robot_radius: float
    acc_lim_x: float

    def slowed(self, velocity: Velocity, pose: Pose2D, movers: Iterable[MovingObstacle]) -> Velocity:
        """Return the velocity, or a slower one along the same arc."""
        heading = pose.theta if velocity.linear > 0.0 else pose.theta + math.pi
        most = min((self._fastest(pose, heading, mover) for mover in movers), default=math.inf)
        if abs(velocity.linear) <= most:
            return velocity
        part = most / abs(velocity.linear)
        return Velocity(part * velocity.linear, part * velocity.angular)

    def _fastest(self, pose: Pose2D, heading: float, mover: MovingObstacle) -> float:
        """Return the speed from which the robot can stop before a mover is there [m/s]; infinite if it moves away."""
        right, up = pose.x - mover.x, pose.y - mover.y
        apart = math.hypot(right, up)
        if apart == 0.0 or abs(wrap_angle(math.atan2(-up, -right) - heading)) >= 0.5 * math.pi:
            return math.inf
        closing = (mover.vx * right + mover.vy * up) / apart
        if closing <= 0.0:
            return math.inf
        # Until it stands, the robot drives speed · REACTION + speed² / (2 acceleration); during that time the mover
        # approaches at its own speed. Solved for the largest speed at which they do not meet.
        room = apart - self.robot_radius - mover.radius - MARGIN - closing * REACTION
        seconds = REACTION + closing / self.acc_lim_x
        return max(self.acc_lim_x * (math.sqrt(max(seconds**2 + 2.0 * room / self.acc_lim_x, 0.0)) - seconds), 0.0)
