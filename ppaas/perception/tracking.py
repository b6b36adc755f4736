"""Tracking of unmapped objects over successive scans, which yields the positions and velocities of moving objects."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import Disc, MovingObstacle
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.perception.unmapped_objects import UnmappedObject, unmapped_objects_in

NEAR = 0.5
"""Largest distance between an object's predicted position and an observation that is assigned to it [m]."""
FORGET = 0.6
"""Time without an observation after which a track is deleted [s]."""
GAP = 1.0
"""Difference between the stamps of two scans from which on all tracks are deleted [s]."""
HITS = 4
"""Number of observations from which a track may count as moving."""
MOVED = 0.2
"""Distance from its first position from which a track may count as moving [m]."""
SLOWEST = 0.2
"""Least speed of a moving object; slower ones are ordinary obstacles [m/s]."""
FASTEST = 3.0
"""Largest plausible speed of a moving object [m/s]."""
TRAIL_MARGIN = 0.1
"""Margin around an object within which its hits may have marked cells [m]."""
LONGEST_TRAIL = 50
"""Limit of the number of past positions of a track."""

SIGMA_SEEN = 0.05
"""Standard deviation of an object's observed centre [m]."""
SIGMA_PUSH = 1.5
"""Standard deviation of a person's acceleration [m/s²]."""
SIGMA_FIRST = 1.0
"""Standard deviation of a new track's velocity [m/s]."""


@dataclass(slots=True)
class Track:
    """Track of one object: a Kalman filter with constant velocity, with the same covariance along x and y.

    Parameters
    ----------
    x, y : float
        Position [m].
    radius : float
        Largest observed radius, which decays by 10 % per observation [m].
    first : (x, y)
        First observed position [m].
    seen : float
        Time of the last observation [s].
    vx, vy : float
        Velocity [m/s].
    hits : int
        Number of observations.
    variance, mixed, variance_v : float
        Variance of the position [m²], covariance of position and velocity [m²/s], variance of the velocity [m²/s²].
    trail : list of (x, y, radius)
        Past positions, whose marks may still be in the costmap [m].
    """

    x: float
    y: float
    radius: float
    first: tuple[float, float]
    seen: float
    vx: float = 0.0
    vy: float = 0.0
    hits: int = 1
    variance: float = SIGMA_SEEN**2
    mixed: float = 0.0
    trail: list[Disc] = field(default_factory=list)
    variance_v: float = SIGMA_FIRST**2

    def predict(self, dt: float) -> None:
        """Predict the state after a time [s], with white noise in the acceleration."""
        self.x += self.vx * dt
        self.y += self.vy * dt
        push = SIGMA_PUSH**2
        self.variance += dt * (2.0 * self.mixed + dt * self.variance_v) + 0.25 * push * dt**4
        self.mixed += dt * self.variance_v + 0.5 * push * dt**3
        self.variance_v += push * dt**2

    def correct(self, observed: UnmappedObject, now: float) -> None:
        """Update the state by an observation at time ``now`` [s]."""
        total = self.variance + SIGMA_SEEN**2
        gain, gain_v = self.variance / total, self.mixed / total
        off_x, off_y = observed.x - self.x, observed.y - self.y
        self.x, self.y = self.x + gain * off_x, self.y + gain * off_y
        self.vx, self.vy = self.vx + gain_v * off_x, self.vy + gain_v * off_y
        self.variance_v -= gain_v * self.mixed
        self.mixed *= 1.0 - gain
        self.variance *= 1.0 - gain
        self.radius = max(observed.radius, 0.9 * self.radius)
        self.trail = [*self.trail[-LONGEST_TRAIL:], (self.x, self.y, self.radius + TRAIL_MARGIN)]
        self.seen, self.hits = now, self.hits + 1

    def leave(self) -> list[Disc]:
        """Return, once each, the past discs that the object has left."""
        away = [disc for disc in self.trail if math.hypot(disc[0] - self.x, disc[1] - self.y) > disc[2] + self.radius]
        self.trail = [disc for disc in self.trail if disc not in away]
        return away

    @property
    def moves(self) -> bool:
        """Whether the object is certainly moving."""
        speed = math.hypot(self.vx, self.vy)
        moved = math.hypot(self.x - self.first[0], self.y - self.first[1])
        return self.hits >= HITS and moved >= MOVED and SLOWEST <= speed <= FASTEST


class ObjectTracker:
    """Tracker of all unmapped objects around a robot.

    Attributes
    ----------
    at : float
        Time of the last scan, for which the tracks are valid [s].
    """

    def __init__(self) -> None:
        self.at = -math.inf
        self._tracks: list[Track] = []

    def see(self, objects: Sequence[UnmappedObject], now: float) -> None:
        """Update the tracks by the objects in a scan at time ``now`` [s].

        A scan older than the last is ignored, unless it is older by `GAP`: then the clock was set back.
        """
        dt = now - self.at
        if -GAP <= dt <= 0.0:
            return
        if abs(dt) > GAP:
            self._tracks.clear()
        self.at = now
        for track in self._tracks:
            track.predict(dt)
        rest = self._match(objects, now)
        self._tracks = [track for track in self._tracks if now - track.seen <= FORGET]
        self._tracks += [Track(new.x, new.y, new.radius, (new.x, new.y), now) for new in rest]

    def movers(self) -> Iterable[MovingObstacle]:
        """Return the moving objects at the time of the last scan."""
        return [
            MovingObstacle(track.x, track.y, track.vx, track.vy, track.radius) for track in self._tracks if track.moves
        ]

    def left(self) -> list[Disc]:
        """Return, once each, the discs that moving objects have left."""
        return [disc for track in self._tracks if track.moves for disc in track.leave()]

    def _match(self, objects: Sequence[UnmappedObject], now: float) -> list[UnmappedObject]:
        """Assign objects to tracks greedily, the nearest pairs first; return the objects without a track."""
        pairs = sorted(
            (math.hypot(each.x - track.x, each.y - track.y), i, k)
            for i, track in enumerate(self._tracks)
            for k, each in enumerate(objects)
        )
        tracks, taken = set[int](), set[int]()
        for distance, i, k in pairs:
            if distance > NEAR:
                break
            if i not in tracks and k not in taken:
                tracks.add(i)
                taken.add(k)
                self._tracks[i].correct(objects[k], now)
        return [each for k, each in enumerate(objects) if k not in taken]


class MovingObjects:
    """Moving objects around a robot, seen by its laser.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map, whose obstacles do not move.

    Attributes
    ----------
    at : float
        Time at which the last scan arrived [s].
    """

    def __init__(self, layers: MapLayers) -> None:
        self._layers = layers
        self._tracker = ObjectTracker()
        self.at = -math.inf

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map; the objects that were seen are kept."""
        self._layers = layers

    def see(self, reading: LaserReading, stamp: float, now: float) -> None:
        """Add a scan, in the frame of the map, with the robot's ``stamp`` [s] and its time of arrival ``now`` [s]."""
        self._tracker.see(unmapped_objects_in(reading, self._layers), stamp)
        self.at = now

    def left(self) -> list[Disc]:
        """Return, once each, the discs that moving objects have left, in which marked cells can be freed."""
        return self._tracker.left()

    def now(self, now: float) -> tuple[MovingObstacle, ...]:
        """Return the moving objects, none if the last scan is older than `FORGET`."""
        return tuple(self._tracker.movers()) if now - self.at <= FORGET else ()
