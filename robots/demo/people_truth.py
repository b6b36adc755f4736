"""True states of a simulated world that runs in real time, for states of the coordinator that arrive later."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from ppaas.messages.people_coordination import SensorView
from robots.demo.contact_referee import Referee
from robots.demo.people_score import Truth
from robots.demo.people_world import PeopleWorld, present, visible_shares

RATE = 10.0
"""Rate of the true states that are kept [Hz]."""
KEPT = 5.0
"""Time for which true states are kept [s]."""


class TruthRecorder:
    """Keeps the true states of the last seconds, and counts the contacts that robots cause.

    Parameters
    ----------
    stage : PeopleWorld
    robots : sequence of str
        Ids of the robots of the world, in order.

    Attributes
    ----------
    views : dict of str to list of SensorView
        Views of the detectors of each robot.
    """

    def __init__(self, stage: PeopleWorld, robots: Sequence[str]) -> None:
        self.views: dict[str, list[SensorView]] = {robot: [] for robot in robots}
        self._stage = stage
        self._world = stage.world
        self._referees = [Referee(self._world, robot) for robot in self._world.robots]
        self._kept: deque[tuple[float, Truth]] = deque(maxlen=round(RATE * KEPT))
        self._due = 0.0

    def step(self) -> None:
        """Look at the world after one of its steps."""
        for referee in self._referees:
            referee.look()
        if self._world.time() >= self._due:
            self._due = self._world.time() + 1.0 / RATE
            self._kept.append((self._world.stamp(), self._truth()))

    def begin(self) -> None:
        """Start to count contacts."""
        for referee in self._referees:
            referee.begin()
        self._robots_before = self._world.contacts.robot_contacts.total()

    def contacts(self) -> int:
        """Return the number of contacts that robots caused since `begin`, with people, walls and each other."""
        touches = [referee.touches for referee in self._referees]
        among = (self._world.contacts.robot_contacts.total() - self._robots_before) // 2
        return sum(each.walls + each.caused for each in touches) + among

    def at(self, stamp: float) -> Truth | None:
        """Return the true state nearest to a time [s since the epoch]; None if none is kept within a period of it."""
        if not self._kept:
            return None
        at, truth = min(self._kept, key=lambda kept: abs(kept[0] - stamp))
        return truth if abs(at - stamp) <= 1.5 / RATE else None

    def _truth(self) -> Truth:
        people = present(self._world)
        shares = np.zeros(len(people))
        for robot, views in zip(self._world.robots, self.views.values(), strict=True):
            seen = visible_shares(self._stage.surroundings, robot.base.pose, views, people)
            shares = np.maximum(shares, seen)
        places = [robot.base.pose[:2] for robot in self._world.robots]
        return Truth(self._world.time(), people, shares, dict(zip(self.views, places, strict=True)))
