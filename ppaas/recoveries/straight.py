"""Straight motion over a distance, of the recovery ``back_up`` and the action ``drive_on_heading``.

It follows ``nav2_behaviors/drive_on_heading.hpp``.
"""

import math
from typing import ClassVar

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.recoveries.base import Recovery, RecoveryFailed, RecoveryRequest
from ppaas.recoveries.free_motion import is_free

SLOWEST = 0.05
"""Speed at the end of a motion that brakes [m/s]."""


class StraightRecovery(Recovery):
    """Drives straight on or back while the local costmap in that direction is free.

    Parameters
    ----------
    distance : float
        Distance [m].
    speed : float
        Speed, backwards if negative [m/s].
    time_allowance : float
        Time limit [s].
    simulate_ahead_time : float
        Time ahead for which the robot must be free of collisions [s].
    braking : float
        Deceleration before the end [m/s²]; infinite for none.
    """

    name: ClassVar[str] = "drive_on_heading"
    purpose: ClassVar[str] = "Drives straight by a distance, as far as the costmap ahead of the robot is free."

    def __init__(
        self, distance: float, speed: float, *, time_allowance: float, simulate_ahead_time: float,
        braking: float = math.inf,
    ) -> None:  # fmt: skip
        self._distance, self._speed, self._braking = distance, speed, braking
        self._time_allowance, self._ahead = time_allowance, simulate_ahead_time
        self._from = Pose2D(0.0, 0.0)
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Record the pose and the time."""
        self._from = request.pose
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return the velocity, or None once the distance is driven.

        Raises
        ------
        RecoveryFailed
            There is an obstacle in the way, or the time limit has passed.
        """
        driven = request.pose.distance_to(self._from)
        if driven >= self._distance:
            return None
        verb, side = ("backed up", "behind") if self._speed < 0.0 else ("drove", "ahead")
        limit = self._time_allowance
        if request.now - self._began > limit:
            raise RecoveryFailed(f"{verb} only {driven:.2f} m of {self._distance:g} m in {limit:g} s")
        speed = min(abs(self._speed), max(math.sqrt(2.0 * self._braking * (self._distance - driven)), SLOWEST))
        velocity = Velocity(math.copysign(speed, self._speed), 0.0)
        ahead = min(self._ahead, (self._distance - driven) / speed)
        if not is_free(request.costmap, request.pose, velocity, ahead, request.fits):
            raise RecoveryFailed(f"the space {side} is not free after {driven:.2f} m of {self._distance:g} m")
        return velocity
