"""Counts what robots bump into: one for a touch that begins, however long it lasts and however it chatters."""

from collections import Counter
from collections.abc import Callable

import pymunk

SETTLE = 0.3
"""A touch that ends and comes again within so many seconds is still the same touch [s]."""

WALL = -1
"""Stands for all walls, where the other robot's index would be."""

PERSON = -2
"""Stands for all people."""


class ContactCounter:
    """Counts the touches of each robot, looking after every step who touches what.

    All walls count as one: a robot that slides along from one piece to the next has touched once.

    Parameters
    ----------
    clock : callable
        Seconds of the simulated world.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._robots: dict[pymunk.Body, int] = {}
        self._people: set[pymunk.Body] = set()
        self._last_touched: dict[tuple[int, int], float] = {}
        self.wall_contacts: Counter[int] = Counter()
        self.robot_contacts: Counter[int] = Counter()
        self.person_contacts: Counter[int] = Counter()

    def watch(self, body: pymunk.Body, robot: int) -> None:
        """Count the touches of this body as those of this robot."""
        self._robots[body] = robot

    def know_person(self, body: pymunk.Body) -> None:
        """Count what this body is touched by apart from walls."""
        self._people.add(body)

    def total(self, robot: int) -> int:
        """Return how often a robot touched a wall, another robot or a person."""
        return self.wall_contacts[robot] + self.robot_contacts[robot] + self.person_contacts[robot]

    def look(self) -> None:
        """Count the touches that began in the step that was just taken."""
        now = self._clock()
        for robot, other in self._touching():
            before = self._last_touched.get((robot, other), float("-inf"))
            self._last_touched[robot, other] = now
            if now - before > SETTLE:
                self._counter(other)[robot] += 1

    def _counter(self, other: int) -> Counter[int]:
        return {WALL: self.wall_contacts, PERSON: self.person_contacts}.get(other, self.robot_contacts)

    def _index(self, body: pymunk.Body) -> int:
        return PERSON if body in self._people else self._robots.get(body, WALL)

    def _touching(self) -> set[tuple[int, int]]:
        found: set[tuple[int, int]] = set()

        def note(arbiter: pymunk.Arbiter, robot: int) -> None:
            found.update((robot, self._index(body)) for body in arbiter.bodies)

        for body, robot in self._robots.items():
            body.each_arbiter(note, robot)
        return {(robot, other) for robot, other in found if robot != other}
