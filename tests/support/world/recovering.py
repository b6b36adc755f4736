"""Runner of a recovery behavior in a small room, one control cycle after the other."""

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.controllers.motion import advance
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.recoveries import Recovery, RecoveryRequest
from ppaas.recoveries.base import Fits

PERIOD = 0.1
MIDDLE = Pose2D(2.0, 2.0, 0.0)


def room() -> Costmap:
    """Return 4 m by 4 m of free cells."""
    return Costmap(np.zeros((80, 80), np.uint8), GridInfo(0.05, 80, 80))


class Run:
    """One run of a recovery behavior, with a robot that follows every command at once."""

    def __init__(self, recovery: Recovery, costmap: Costmap | None = None, pose: Pose2D = MIDDLE) -> None:
        self.recovery = recovery
        self.costmap = costmap or room()
        self.pose = pose
        self.now = 100.0
        self.cleared: list = []
        self.fits: Fits | None = None
        self.velocities: list[Velocity] = []
        recovery.start(self.request())

    def request(self) -> RecoveryRequest:
        return RecoveryRequest(self.now, self.pose, self.costmap, lambda *area: self.cleared.append(area), self.fits)

    def cycle(self, *, moves: bool = True) -> Velocity | None:
        velocity = self.recovery.step(self.request())
        self.now += PERIOD
        if velocity is not None:
            self.velocities.append(velocity)
            self.pose = advance(self.pose, velocity, PERIOD) if moves else self.pose
        return velocity

    def to_the_end(self, *, moves: bool = True) -> float:
        """Run until the behavior ends; return its duration [s]."""
        for cycle in range(1000):
            if self.cycle(moves=moves) is None:
                return cycle * PERIOD
        raise AssertionError("the recovery behavior did not end")
