"""Commands of an AGV to its robot, and what the robot reports to it."""

import math
from dataclasses import dataclass
from enum import Enum

from ppaas.wire.vda5050.orders import Action


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive to a pose [m, m, rad] in the map; ends with `DriveEnd` of the same number. It replaces the drive before."""

    number: int
    x: float
    y: float
    theta: float


@dataclass(frozen=True, slots=True)
class Stop:
    """End the drive."""


@dataclass(frozen=True, slots=True)
class LimitSpeed:
    """Limit the speed [m/s]; 0 for no limit."""

    speed: float


@dataclass(frozen=True, slots=True)
class Localize:
    """Take a pose [m, m, rad] in the map as the robot's."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True, slots=True)
class Execute:
    """Execute an action that the robot offers."""

    action: Action


@dataclass(frozen=True, slots=True)
class SendFactsheet:
    """Publish the factsheet."""


@dataclass(frozen=True, slots=True)
class UseZones:
    """Use the zones of a set from now on; ``zones_used`` reports the end."""

    zone_set_id: str


Command = Drive | Stop | LimitSpeed | Localize | Execute | SendFactsheet | UseZones


class DriveResult(Enum):
    """End of a drive."""

    REACHED = "reached"
    FAILED = "failed"
    LOST = "lost"
    """The outcome is unknown: the connection to the cloud was lost."""


@dataclass(frozen=True, slots=True)
class RobotPose:
    """Pose of the robot in its map [m, m, rad], and the standard deviation of its position [m]."""

    x: float
    y: float
    theta: float
    deviation: float = 0.0

    def distance(self, x: float, y: float) -> float:
        """Return the distance to a point [m]."""
        return math.hypot(self.x - x, self.y - y)
