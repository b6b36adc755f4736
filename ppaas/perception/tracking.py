"""Follows what stands out in scans from one to the next, and tells of what moves: where it is, and how fast it goes."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import Disc, MovingObstacle
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.perception.unmapped_objects import UnmappedObject, unmapped_objects_in

NEAR = 0.5
"""A thing is not the one that was expected farther away than this [m]."""
FORGET = 0.6
"""What is not seen for so long is followed no more [s]."""
GAP = 1.0
"""After so long without a scan all begins anew [s]."""
HITS = 4
"""Scans in which it must have been seen."""
MOVED = 0.2
"""How far it must have come from where it was seen first [m]."""
SLOWEST = 0.2
"""What is slower stands, and is an obstacle as any [m/s]."""
FASTEST = 3.0
TRAIL_MARGIN = 0.1
"""What it hit beams with lies this near to its outline [m]."""
LONGEST_TRAIL = 50

SIGMA_SEEN = 0.05
"""Of the middle of a thing, as it is seen in a scan [m]."""
SIGMA_PUSH = 1.5
"""How much people change their walk: acceleration [m/s²]."""
SIGMA_FIRST = 1.0
"""Of the velocity of what was not seen before [m/s]."""


@dataclass(slots=True)
class Track:
    """One thing: a Kalman filter of constant velocity, the same along x and y.

    Parameters
    ----------
    x, y, vx, vy : float
        [m, m/s].
    radius : float
        The largest that was seen of it, fading [m].
    first : (x, y)
        Where it was seen first [m].
    seen : float
        When it was seen last [s].
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
        """Let time pass [s]."""
        self.x += self.vx * dt
        self.y += self.vy * dt
        push = SIGMA_PUSH**2
        self.variance += dt * (2.0 * self.mixed + dt * self.variance_v) + 0.25 * push * dt**4
        self.mixed += dt * self.variance_v + 0.5 * push * dt**3
        self.variance_v += push * dt**2

    def correct(self, thing: UnmappedObject, now: float) -> None:
        """Take where it is seen."""
        total = self.variance + SIGMA_SEEN**2
        gain, gain_v = self.variance / total, self.mixed / total
        off_x, off_y = thing.x - self.x, thing.y - self.y
        self.x, self.y = self.x + gain * off_x, self.y + gain * off_y
        self.vx, self.vy = self.vx + gain_v * off_x, self.vy + gain_v * off_y
        self.variance_v -= gain_v * self.mixed
        self.mixed *= 1.0 - gain
        self.variance *= 1.0 - gain
        self.radius = max(thing.radius, 0.9 * self.radius)
        self.trail = [*self.trail[-LONGEST_TRAIL:], (self.x, self.y, self.radius + TRAIL_MARGIN)]
        self.seen, self.hits = now, self.hits + 1

    def leave(self) -> list[Disc]:
        """Return where it was and is no more, once."""
        away = [disc for disc in self.trail if math.hypot(disc[0] - self.x, disc[1] - self.y) > disc[2] + self.radius]
        self.trail = [disc for disc in self.trail if disc not in away]
        return away

    @property
    def moves(self) -> bool:
        """Whether it certainly goes somewhere."""
        speed = math.hypot(self.vx, self.vy)
        come = math.hypot(self.x - self.first[0], self.y - self.first[1])
        return self.hits >= HITS and come >= MOVED and SLOWEST <= speed <= FASTEST


class Tracker:
    """Follows all things around a robot.

    Attributes
    ----------
    at : float
        Of what time `movers` tells [s].
    """

    def __init__(self) -> None:
        self.at = -math.inf
        self._tracks: list[Track] = []

    def see(self, things: Sequence[UnmappedObject], now: float) -> None:
        """Take what stands out in the scan of a time [s]; an older one than the last is of no use."""
        dt = now - self.at
        if dt <= 0.0:
            return
        if dt > GAP:
            self._tracks.clear()
        self.at = now
        for track in self._tracks:
            track.predict(dt)
        rest = self._match(things, now)
        self._tracks = [track for track in self._tracks if now - track.seen <= FORGET]
        self._tracks += [Track(thing.x, thing.y, thing.radius, (thing.x, thing.y), now) for thing in rest]

    def movers(self) -> Iterable[MovingObstacle]:
        """Return what moved as the last scan was taken."""
        return [
            MovingObstacle(track.x, track.y, track.vx, track.vy, track.radius) for track in self._tracks if track.moves
        ]

    def left(self) -> list[Disc]:
        """Return where what moves was and is no more, each place once."""
        return [disc for track in self._tracks if track.moves for disc in track.leave()]

    def _match(self, things: Sequence[UnmappedObject], now: float) -> list[UnmappedObject]:
        """Give each track the thing that is nearest to it, the nearest pairs first; return what nobody takes."""
        pairs = sorted(
            (math.hypot(thing.x - track.x, thing.y - track.y), i, k)
            for i, track in enumerate(self._tracks)
            for k, thing in enumerate(things)
        )
        tracks, taken = set[int](), set[int]()
        for apart, i, k in pairs:
            if apart > NEAR:
                break
            if i not in tracks and k not in taken:
                tracks.add(i)
                taken.add(k)
                self._tracks[i].correct(things[k], now)
        return [thing for k, thing in enumerate(things) if k not in taken]


class MovingObjects:
    """What moves around a robot, as its laser sees it.

    Parameters
    ----------
    layers : MapLayers
        What is in the map does not move.

    Attributes
    ----------
    at : float
        When the last scan came [s].
    """

    def __init__(self, layers: MapLayers) -> None:
        self._layers = layers
        self._tracker = Tracker()
        self.at = -math.inf

    def see(self, reading: LaserReading, stamp: float, now: float) -> None:
        """Take a scan that was taken in the frame of the map at ``stamp`` by the robot's clock, and came by ``now``."""
        self._tracker.see(unmapped_objects_in(reading, self._layers), stamp)
        self.at = now

    def left(self) -> list[Disc]:
        """Return where what moves was and is no more, each place once: what was marked there is not there."""
        return self._tracker.left()

    def now(self, now: float) -> tuple[MovingObstacle, ...]:
        """Return where what moves is, and nothing if the last scan is older than `FORGET`."""
        return tuple(self._tracker.movers()) if now - self.at <= FORGET else ()
