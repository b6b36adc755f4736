"""Simulated people who follow a script: they meet and talk, sit, walk to and fro, or leave the map and come back."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from robots.sim.pedestrian import Pedestrian, PedestrianModel
from robots.sim.shortest_paths import PathWalk, ShortestPaths

STEP_SPEED = 0.5
"""Speed of a step to a seat [m/s]."""
AT_SEAT = 0.03
"""Distance at which a step has arrived [m]."""
PARKED = -1_000.0
"""Position of people who have left the map, out of reach of all sensors [m]."""
ROOM_TO_RETURN = 0.7
"""Distance to others that someone needs who comes back [m]."""


@dataclass(frozen=True, slots=True)
class Walk:
    """Walk on the shortest path to a place."""

    to: Pose2D


@dataclass(frozen=True, slots=True)
class StepTo:
    """Step straight to a position [m], whatever is there."""

    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Stay:
    """Stand or sit for a time [s], and face a direction [rad]."""

    seconds: float
    facing: float | None = None
    sitting: bool = False


@dataclass(frozen=True, slots=True)
class LeaveMap:
    """Leave the map here, and come back to the same place after a time [s]."""

    seconds: float


Activity = Walk | StepTo | Stay | LeaveMap
Script = Iterator[Activity]


class Actor(Pedestrian):
    """Person who follows a script, and stays once it has ended.

    Parameters
    ----------
    space, paths, pose, model, rng
        As in `Pedestrian`.
    script : iterator of Activity
        Taken one by one.
    """

    def __init__(
        self,
        space: pymunk.Space,
        paths: ShortestPaths,
        pose: Pose2D,
        model: PedestrianModel,
        rng: np.random.Generator,
        *,
        script: Script,
    ) -> None:
        super().__init__(space, paths, pose, model, rng)
        self._script = script
        self._destination: Pose2D | None = None
        self._step: StepTo | None = None
        self._door: tuple[float, float] | None = None

    @property
    def present(self) -> bool:
        """Whether the person is on the map."""
        return self._door is None

    def _decide(self, now: float, others: NDArray[np.float64]) -> NDArray[np.float64]:
        if now < self._stays_until:
            return np.zeros(2)
        if self._door is not None and not self._return(others):
            return np.zeros(2)
        if self._destination is None and self._step is None:
            self._begin(next(self._script, Stay(math.inf)), now)
        if self._step is not None:
            return self._toward(self._step)
        return super()._decide(now, others) if self._destination is not None else np.zeros(2)

    def _begin(self, activity: Activity, now: float) -> None:
        self.sitting, self.facing = False, None
        match activity:
            case Walk(to):
                self._destination = to
            case StepTo():
                self._step = activity
            case Stay(seconds, facing, sitting):
                self.sitting, self.facing, self._stays_until = sitting, facing, now + seconds
            case LeaveMap(seconds):
                self._door = self.body.position.x, self.body.position.y
                self._move_to(PARKED, PARKED)
                self._stays_until = now + seconds

    def _return(self, others: NDArray[np.float64]) -> bool:
        """Come back if the place is free; return whether the person has."""
        assert self._door is not None
        x, y = self._door
        if (np.hypot(others[:, 0] - x, others[:, 1] - y) < others[:, 2] + ROOM_TO_RETURN).any():
            return False
        self._move_to(x, y)
        self._door = None
        return True

    def _move_to(self, x: float, y: float) -> None:
        self.body.position = x, y
        self._velocity = np.zeros(2)

    def _toward(self, step: StepTo) -> NDArray[np.float64]:
        offset = np.array((step.x - self.body.position.x, step.y - self.body.position.y))
        distance = float(np.hypot(*offset))
        if distance < AT_SEAT:
            self._step = None
            return np.zeros(2)
        return offset * min(STEP_SPEED / distance, 2.0)

    def _choose(self) -> PathWalk:
        assert self._destination is not None
        here = Pose2D(*self.body.position)
        start, end = (
            place if self._paths.allows(place.x, place.y) else self._paths.nearest(place)
            for place in (here, self._destination)
        )
        return PathWalk(self._paths.between(start, end))

    def _arrive(self, now: float) -> None:
        self._path = self._destination = None


# -- scripts -----------------------------------------------------------------------------------------------------------


def wander(paths: ShortestPaths, rng: np.random.Generator, longest_stay: float = 10.0) -> Script:
    """Walk to random places, and stay up to ``longest_stay`` [s] at each."""
    while True:
        yield Walk(paths.anywhere())
        yield Stay(float(rng.uniform(0.0, longest_stay)))


def talk(at: Pose2D, seconds: float, then: Script) -> Script:
    """Walk to a place, stand there for a time [s] and face along its pose, then follow another script.

    Two who talk stand at places that face each other.
    """
    yield Walk(at)
    yield StepTo(at.x, at.y)
    yield Stay(seconds, at.theta)
    yield from then


def sit(seat: Pose2D, seconds: float, then: Script, before: float = 0.6) -> Script:
    """Walk to a seat, sit for a time [s] and face along its pose, then stand up and follow another script.

    Parameters
    ----------
    seat : Pose2D
        Pose of the chair.
    seconds : float
        Time on the chair [s].
    then : iterator of Activity
    before : float
        Distance in front of the seat where the person stands before and after [m].
    """
    front = seat @ Pose2D(before, 0.0)
    yield Walk(front)
    yield StepTo(seat.x, seat.y)
    yield Stay(seconds, seat.theta, sitting=True)
    yield StepTo(front.x, front.y)
    yield from then


def come_and_go(door: Pose2D, paths: ShortestPaths, rng: np.random.Generator, away: float = 30.0) -> Script:
    """Leave the map at a door and come back after up to ``away`` [s], to walk to a random place and back."""
    while True:
        yield Walk(paths.anywhere())
        yield Stay(float(rng.uniform(0.0, 5.0)))
        yield Walk(door)
        yield LeaveMap(float(rng.uniform(0.3, 1.0)) * away)
