"""How fast a robot drives towards those who come towards it: so that it stands before they could touch.

That is passive motion safety: not every touch can be kept from, since others move too, but none is the robot's doing
(Bouraine, Fraichard and Salhi, *Provably safe navigation for mobile robots with limited field-of-views*, 2012). People
turn without a warning, so it does not count that somebody would pass by if they walked straight on.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D, wrap_angle

REACTION = 0.25
"""From when somebody is somewhere until the robot brakes because of it: a scan, a cycle and a command [s]."""
MARGIN = 0.1
"""What is left between them, and how far off an outline may be seen [m]."""


@dataclass(frozen=True, slots=True)
class GivingWay:
    """Slows a robot down before those who come near.

    Parameters
    ----------
    robot_radius : float
        [m].
    acc_lim_x : float
        How the robot brakes [m/s²].
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
        """Return from which speed it can stop before a mover is there [m/s]; infinite for who does not come near."""
        right, up = pose.x - mover.x, pose.y - mover.y
        apart = math.hypot(right, up)
        if apart == 0.0 or abs(wrap_angle(math.atan2(-up, -right) - heading)) >= 0.5 * math.pi:
            return math.inf
        closing = (mover.vx * right + mover.vy * up) / apart
        if closing <= 0.0:
            return math.inf
        # Until it stands, the robot comes speed · REACTION + speed² / (2 acceleration) nearer, and the mover as long
        # as that takes, at its own speed.
        room = apart - self.robot_radius - mover.radius - MARGIN - closing * REACTION
        seconds = REACTION + closing / self.acc_lim_x
        return max(self.acc_lim_x * (math.sqrt(max(seconds**2 + 2.0 * room / self.acc_lim_x, 0.0)) - seconds), 0.0)
