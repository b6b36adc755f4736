"""People who walk about in the simulated world, each to places of their own choice.

They walk as if they were among people: they look where they go, and not behind or beside them. Whoever stands or comes
within arm's reach ahead is stepped around; where there is no room for it they stand, and who gets no farther for a time
goes elsewhere. They do nothing else for a robot: they neither wait for one that comes from the side, nor keep clear of
where it goes.
"""

import math
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from robots.sim.shortest_paths import PathWalk, ShortestPaths

AHEAD = 0.5
"""How far along their way people walk for [m]."""
STRAYED = 1.0
"""Who is farther from their way than this goes elsewhere [m]."""
LOOK = 0.1
"""Seconds between two looks ahead."""
ASIDE = tuple(math.radians(turn) for turn in (0, -30, 30, -60, 60, -90, 90, -120, 120))
"""Ways around somebody, in the order in which they are tried: to the right first [rad]."""
NEAREST = 5.0
"""No place to walk to is nearer than this, where the map is large enough [m]."""


@dataclass(frozen=True, slots=True)
class PedestrianModel:
    """What people are like.

    Parameters
    ----------
    radius : float
        [m].
    mass : float
        [kg].
    slowest, fastest : float
        Each walks at a speed of their own between these [m/s].
    aside : float
        How fast they step aside at most [m/s].
    acceleration : float
        [m/s²].
    reach, beside : float
        Nobody is walked at who is as near as arm's reach, from outline to outline; to pass by, so much must be left
        between them [m].
    patience : float
        After so long without getting farther they go elsewhere [s].
    longest_stay : float
        Up to this they stay where they walked to [s].
    """

    radius: float = 0.25
    mass: float = 70.0
    slowest: float = 0.6
    fastest: float = 1.4
    aside: float = 0.6
    acceleration: float = 3.0
    reach: float = 0.5
    beside: float = 0.15
    patience: float = 3.0
    longest_stay: float = 10.0

    @property
    def clearance(self) -> float:
        """Least distance of their ways from walls [m]."""
        return self.radius + 0.1


class Pedestrian:
    """One person.

    Parameters
    ----------
    space : pymunk.Space
        The world's.
    ways : ShortestPaths
        Where they may walk.
    pose : Pose2D
        Where they stand at first.
    model : PedestrianModel
    rng : numpy.random.Generator
        Their own.
    """

    def __init__(
        self, space: pymunk.Space, ways: ShortestPaths, pose: Pose2D, model: PedestrianModel, rng: np.random.Generator
    ) -> None:
        self.model = model
        self.body = pymunk.Body(model.mass, math.inf)
        self.body.position = pose.x, pose.y
        self.body.velocity_func = self._set_velocity
        shape = pymunk.Circle(self.body, model.radius)
        shape.friction = 0.4
        space.add(self.body, shape)
        self._ways = ways
        self._rng = rng
        self._speed = float(rng.uniform(model.slowest, model.fastest))
        self._wanted = self._velocity = np.zeros(2)
        self._way: PathWalk | None = None
        self._stays_until = 0.0
        self._came, self._came_at = 0, 0.0
        # People do not look up all at the same moment.
        self._looks_at = float(rng.uniform(0.0, LOOK))

    def walk(self, now: float, others: NDArray[np.float64], dt: float) -> None:
        """Decide how to go on for a step.

        Parameters
        ----------
        now : float
            [s].
        others : (n, 3) array
            x, y and radius of everybody, robots and this walker too [m].
        dt : float
            Length of the step [s].
        """
        if now >= self._looks_at:
            self._looks_at = now + LOOK
            self._wanted = self._look(now, others)
        change = self._wanted - self._velocity
        most = self.model.acceleration * dt
        self._velocity = self._velocity + change * min(1.0, most / max(float(np.hypot(*change)), 1e-9))

    def _look(self, now: float, others: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocity to walk at from now on [m/s]."""
        if now < self._stays_until:
            return np.zeros(2)
        if self._way is None:
            self._way, self._came, self._came_at = self._choose(), 0, now
        x, y = self.body.position
        to_x, to_y = self._way.ahead(x, y, AHEAD)
        if self._way.ended:
            self._way, self._stays_until = None, now + float(self._rng.uniform(0.0, self.model.longest_stay))
            return np.zeros(2)
        if math.hypot(to_x - x, to_y - y) > STRAYED or self._is_stuck(now, self._way):
            self._way = None
            return np.zeros(2)
        ahead = math.atan2(to_y - y, to_x - x)
        for turn in ASIDE:
            if self._is_free(ahead + turn, others):
                speed = self._speed if turn == 0.0 else min(self._speed, self.model.aside)
                return speed * np.array((math.cos(ahead + turn), math.sin(ahead + turn)))
        return np.zeros(2)

    def _is_stuck(self, now: float, way: PathWalk) -> bool:
        """Tell whether they lost patience: who steps to and fro before somebody gets no farther either."""
        if way.come > self._came:
            self._came, self._came_at = way.come, now
        return now - self._came_at > self.model.patience

    def _choose(self) -> PathWalk:
        here = Pose2D(*self.body.position)
        # Who stepped aside may stand nearer to a wall than ways lead.
        start = here if self._ways.allows(here.x, here.y) else self._ways.nearest(here)
        return PathWalk(self._ways.between(start, self._ways.away_from(here, NEAREST)))

    def _is_free(self, heading: float, others: NDArray[np.float64]) -> bool:
        """Tell whether nobody is within reach that way, nor a wall."""
        x, y = self.body.position
        cosine, sine = math.cos(heading), math.sin(heading)
        right, up = others[:, 0] - x, others[:, 1] - y
        touch = others[:, 2] + self.model.radius
        near = np.hypot(right, up) < touch + self.model.reach
        # Nobody is ahead of themselves.
        ahead, beside = cosine * right + sine * up, cosine * up - sine * right
        if (near & (ahead > 0.0) & (np.abs(beside) < touch + self.model.beside)).any():
            return False
        return self._ways.allows(x + AHEAD * cosine, y + AHEAD * sine)

    def _set_velocity(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, _dt: float) -> None:
        x, y = self._velocity.tolist()
        body.velocity = x, y
