"""A custom recovery behaviour: creeps back a little, if the costmap behind the robot is free all the way."""

from typing import ClassVar

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.recoveries.base import Recovery, RecoveryFailed, RecoveryRequest
from ppaas.recoveries.free_motion import is_free

PATIENCE = 5.0
"""Multiple of the time that the way should take, after which it has failed."""


class Creep(Recovery):
    """Drives `distance` [m] back at `speed` [m/s]."""

    name: ClassVar[str] = "creep"
    purpose: ClassVar[str] = "Creeps back a little, if all the way is free."

    def __init__(self, *, distance: float = 0.2, speed: float = 0.1) -> None:
        if not (0.0 < distance <= 1.0 and 0.0 < speed <= 0.5):
            raise InvalidParameter("distance must be above 0 and at most 1 m, speed above 0 and at most 0.5 m/s")
        self.distance = distance
        self.speed = speed

    def start(self, request: RecoveryRequest) -> None:
        self._origin, self._end = request.pose, request.now + PATIENCE * self.distance / self.speed

    def step(self, request: RecoveryRequest) -> Velocity | None:
        driven = request.pose.distance_to(self._origin)
        if driven >= self.distance:
            return None
        if request.now > self._end:
            raise RecoveryFailed(f"the robot crept back only {driven:.2f} m of {self.distance:g} m")
        back = Velocity(-self.speed)
        if not is_free(request.costmap, request.pose, back, (self.distance - driven) / self.speed, request.fits):
            raise RecoveryFailed(f"the way back is not free after {driven:.2f} m of {self.distance:g} m")
        return back
