"""Contact counter: counts each contact of a robot once, however long it lasts and however often it flickers."""

from collections import Counter
from collections.abc import Callable, Iterable

import pymunk

SETTLE = 0.3
"""Contacts that reappear within this time count as the same contact [s]."""

WALL = -1
"""Stands for all walls, in place of the other robot's index."""

PERSON = -2
"""Stands for all people, in place of the other robot's index."""


class ContactCounter:
    """Counts the contacts of each robot; checks their bodies after every step.

    All walls count as one object: a robot that slides from one wall rectangle to the next has one contact.

    Parameters
    ----------
    clock : callable
        Returns the simulated time [s].
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
        """Count the contacts of a body as a robot's."""
        self._robots[body] = robot

    def add_person(self, body: pymunk.Body) -> None:
        """Count contacts with this body as contacts with a person."""
        self._people.add(body)

    def total(self, robot: int) -> int:
        """Return the number of contacts of a robot with walls, robots and people."""
        return self.wall_contacts[robot] + self.robot_contacts[robot] + self.person_contacts[robot]

    def update(self, bodies: Iterable[pymunk.Body]) -> None:
        """Count the contacts of robots, given by their bodies, that began in the last step."""
        now = self._clock()
        for robot, other in self._touching(bodies):
            before = self._last_touched.get((robot, other), float("-inf"))
            self._last_touched[robot, other] = now
            if now - before > SETTLE:
                self._counter(other)[robot] += 1

    def _counter(self, other: int) -> Counter[int]:
        return {WALL: self.wall_contacts, PERSON: self.person_contacts}.get(other, self.robot_contacts)

    def _index(self, body: pymunk.Body) -> int:
        return PERSON if body in self._people else self._robots.get(body, WALL)

    def _touching(self, bodies: Iterable[pymunk.Body]) -> set[tuple[int, int]]:
        found: set[tuple[int, int]] = set()

        def note(arbiter: pymunk.Arbiter, robot: int) -> None:
            found.update((robot, self._index(body)) for body in arbiter.bodies)

        for body in bodies:
            body.each_arbiter(note, self._robots[body])
        return {(robot, other) for robot, other in found if robot != other}
