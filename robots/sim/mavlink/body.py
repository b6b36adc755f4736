"""Body of the simulated rover: it drives and turns with limited accelerations, and is somewhere on the Earth."""

import math
from dataclasses import dataclass, field

ACCELERATION = 1.5
"""Change of speed [m/s²]."""

_AXIS, _SQUARED = 6_378_137.0, 6.694379990141e-3
"""Semi-major axis [m] and squared eccentricity of the ellipsoid of WGS84."""


@dataclass(slots=True)
class RoverBody:
    """Pose and speed.

    Attributes
    ----------
    latitude, longitude : float
        Where the local frame begins [°].
    heading : float
        Clockwise from north [rad].
    north, east : float
        Position in the local frame [m].
    speed, turn : float
        Forward [m/s], clockwise [rad/s].
    top_speed, top_turn : float
        Limits of both [m/s], [rad/s].
    """

    latitude: float
    longitude: float
    heading: float = 0.0
    north: float = 0.0
    east: float = 0.0
    speed: float = 0.0
    turn: float = 0.0
    top_speed: float = 1.0
    top_turn: float = 1.5
    _radii: tuple[float, float] = field(default=(0.0, 0.0), repr=False)

    def __post_init__(self) -> None:
        sine = math.sin(math.radians(self.latitude))
        square = 1.0 - _SQUARED * sine * sine
        meridian, across = _AXIS * (1.0 - _SQUARED) / square**1.5, _AXIS / math.sqrt(square)
        self._radii = meridian, across * math.cos(math.radians(self.latitude))

    def drive(self, speed: float, turn: float, seconds: float) -> None:
        """Drive for a time [s] with a speed [m/s] and a clockwise turn [rad/s], as far as the limits allow."""
        wanted = min(max(speed, -self.top_speed), self.top_speed)
        most = ACCELERATION * seconds
        self.speed += min(max(wanted - self.speed, -most), most)
        self.turn = min(max(turn, -self.top_turn), self.top_turn)
        self.heading = math.remainder(self.heading + self.turn * seconds, math.tau)
        self.north += self.speed * math.cos(self.heading) * seconds
        self.east += self.speed * math.sin(self.heading) * seconds

    def place(self) -> tuple[float, float]:
        """Return latitude and longitude [°]."""
        north, east = math.degrees(self.north / self._radii[0]), math.degrees(self.east / self._radii[1])
        return self.latitude + north, self.longitude + east

    def offset_of(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return how far to the north and the east a place is from the body [m]."""
        here = self.place()
        north = math.radians(latitude - here[0]) * self._radii[0]
        return north, math.radians(longitude - here[1]) * self._radii[1]

    def restart(self) -> None:
        """Begin the local frame where the body is."""
        self.latitude, self.longitude = self.place()
        self.north = self.east = self.speed = self.turn = 0.0
