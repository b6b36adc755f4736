"""Simulated pedestrians, who walk to random destinations.

A pedestrian sees only what is ahead. It steps around people and robots within arm's reach ahead, stops if there is no
space for that, and chooses another destination after a time without progress. It makes no other allowance for robots:
it does not wait for one that comes from the side, nor keep clear of its path.
"""

import math
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from robots.sim.shortest_paths import PathWalk, ShortestPaths

AHEAD = 0.5
"""Lookahead along the path [m]."""
MAX_DEVIATION = 1.0
"""Distance from the path beyond which a pedestrian chooses another destination [m]."""
DECISION_PERIOD = 0.1
"""Time between two decisions [s]."""
ASIDE = tuple(math.radians(turn) for turn in (0, -30, 30, -60, 60, -90, 90, -120, 120))
"""Headings tried to pass an obstacle, relative to the path; right before left [rad]."""
PEOPLE = 0b10
"""Collision category of people."""
MIN_TRIP = 5.0
"""Least distance to a destination, if the map is large enough [m]."""


@dataclass(frozen=True, slots=True)
class PedestrianModel:
    """Parameters of pedestrians.

    Parameters
    ----------
    radius : float
        Radius [m].
    mass : float
        Mass [kg].
    slowest, fastest : float
        Range of the walking speeds, one per pedestrian [m/s].
    aside : float
        Greatest speed of a step aside [m/s].
    acceleration : float
        Greatest acceleration [m/s²].
    reach : float
        Distance ahead, from outline to outline, within which an obstacle is avoided [m].
    beside : float
        Lateral gap needed to pass an obstacle [m].
    patience : float
        Time without progress after which a pedestrian chooses another destination [s].
    longest_stay : float
        Longest stay at a destination [s].
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
        """Least distance of paths from walls [m]."""
        return self.radius + 0.1


class Pedestrian:
    """One pedestrian.

    Parameters
    ----------
    space : pymunk.Space
        Space of the world.
    paths : ShortestPaths
        Paths in the map.
    pose : Pose2D
        Pose at the start.
    model : PedestrianModel
        Parameters.
    rng : numpy.random.Generator
        Random generator of this pedestrian.

    Attributes
    ----------
    sitting : bool
        Whether the person sits.
    facing : float, optional
        Direction that a person faces who does not walk [rad]; the last step's without one.
    """

    def __init__(
        self, space: pymunk.Space, paths: ShortestPaths, pose: Pose2D, model: PedestrianModel, rng: np.random.Generator
    ) -> None:
        self.model = model
        self.body = pymunk.Body(model.mass, math.inf)
        self.body.position = pose.x, pose.y
        self.body.velocity_func = self._set_velocity
        self._space, self._shape = space, pymunk.Circle(self.body, model.radius)
        self._shape.friction = 0.4
        self._shape.filter = pymunk.ShapeFilter(categories=PEOPLE)
        space.add(self.body, self._shape)
        self._paths = paths
        self._rng = rng
        self._speed = float(rng.uniform(model.slowest, model.fastest))
        self._wanted = self._velocity = np.zeros(2)
        self._path: PathWalk | None = None
        self._stays_until = 0.0
        self.sitting = False
        self.facing: float | None = None
        self._progress, self._progress_at = 0, 0.0
        # Pedestrians decide at different moments.
        self._decides_at = float(rng.uniform(0.0, DECISION_PERIOD))

    @property
    def present(self) -> bool:
        """Whether the person is on the map."""
        return True

    def enter(self, space: pymunk.Space, paths: ShortestPaths, pose: Pose2D) -> None:
        """Continue in another space, at a pose there, on other paths."""
        self._space.remove(self.body, self._shape)
        self._space, self._paths, self._path = space, paths, None
        space.add(self.body, self._shape)
        self.body.position = pose.x, pose.y
        space.reindex_shapes_for_body(self.body)

    @property
    def velocity(self) -> tuple[float, float]:
        """Velocity at which the person walks [m/s]."""
        x, y = self._velocity.tolist()
        return x, y

    def walk(self, now: float, others: NDArray[np.float64], dt: float) -> None:
        """Set the velocity for the next step.

        Parameters
        ----------
        now : float
            Simulated time [s].
        others : (n, 3) array
            x, y and radius of all robots and pedestrians, including this one [m].
        dt : float
            Length of the step [s].
        """
        if now >= self._decides_at:
            self._decides_at = now + DECISION_PERIOD
            self._wanted = self._decide(now, others)
        change = self._wanted - self._velocity
        max_change = self.model.acceleration * dt
        self._velocity = self._velocity + change * min(1.0, max_change / max(float(np.hypot(*change)), 1e-9))

    def _decide(self, now: float, others: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocity to aim for [m/s]."""
        if now < self._stays_until:
            return np.zeros(2)
        if self._path is None:
            self._path, self._progress, self._progress_at = self._choose(), 0, now
        x, y = self.body.position
        to_x, to_y = self._path.ahead(x, y, AHEAD)
        if self._path.ended:
            self._arrive(now)
            return np.zeros(2)
        if math.hypot(to_x - x, to_y - y) > MAX_DEVIATION or self._is_stuck(now, self._path):
            self._path = None
            return np.zeros(2)
        ahead = math.atan2(to_y - y, to_x - x)
        for turn in ASIDE:
            if self._is_free(ahead + turn, others):
                speed = self._speed if turn == 0.0 else min(self._speed, self.model.aside)
                return speed * np.array((math.cos(ahead + turn), math.sin(ahead + turn)))
        return np.zeros(2)

    def _is_stuck(self, now: float, path: PathWalk) -> bool:
        """Return whether there was no progress along the path for too long; steps to and fro are not progress."""
        if path.reached > self._progress:
            self._progress, self._progress_at = path.reached, now
        return now - self._progress_at > self.model.patience

    def _arrive(self, now: float) -> None:
        self._path, self._stays_until = None, now + float(self._rng.uniform(0.0, self.model.longest_stay))

    def _choose(self) -> PathWalk:
        here = Pose2D(*self.body.position)
        # After a step aside, the pedestrian may be closer to a wall than paths are.
        start = here if self._paths.allows(here.x, here.y) else self._paths.nearest(here)
        return PathWalk(self._paths.between(start, self._paths.away_from(here, MIN_TRIP)))

    def _is_free(self, heading: float, others: NDArray[np.float64]) -> bool:
        """Return whether there is no obstacle within reach in a direction [rad]."""
        x, y = self.body.position
        cosine, sine = math.cos(heading), math.sin(heading)
        right, up = others[:, 0] - x, others[:, 1] - y
        touch = others[:, 2] + self.model.radius
        near = np.hypot(right, up) < touch + self.model.reach
        # ahead > 0 excludes this pedestrian itself.
        ahead, beside = cosine * right + sine * up, cosine * up - sine * right
        if (near & (ahead > 0.0) & (np.abs(beside) < touch + self.model.beside)).any():
            return False
        return self._paths.allows(x + AHEAD * cosine, y + AHEAD * sine)

    def _set_velocity(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, _dt: float) -> None:
        body.velocity = self.velocity
