"""Orders to follow people: who follows whom by least cost, since when, why, and when another robot takes over."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.tracks.assignment import assign

Costs = Mapping[int, Mapping[str, float]]
"""Cost of the shortest path from each robot to each person it identified: by person, then by Robot ID."""

# -- step 4: each person to follow is given to the robot of least cost -------------------------------------------------

BEYOND = 1e9
"""Cost above the cost of any path."""


def cheapest(costs: Mapping[str, float]) -> str | None:
    """Return the robot of least cost, the first by name of equal ones; None if no robot reaches the person."""
    reached = {robot: cost for robot, cost in costs.items() if cost < BEYOND}
    return min(reached, key=lambda robot: (reached[robot], robot), default=None)


def follow_actions(people: Sequence[int], costs: Costs, free: Sequence[str]) -> dict[int, str]:
    """Return which robot follows each person.

    The paper: the "Follow Action Controller" takes the "shortest path by Dijkstra from each robot to each person it
    identified, the cheapest robot follows". Of several people, each has one robot: as many as possible are followed,
    and of all such assignments the one of least total cost is taken. If fewer robots are free than people are to be
    followed, the first people have precedence.

    Parameters
    ----------
    people : sequence of int
        Ids of the people to follow, the most important first.
    costs : Costs
    free : sequence of str
        Robots that may follow.
    """
    robots = sorted(free)
    given: dict[int, str] = {}
    chosen: list[int] = []
    for person in people:
        tried = _assigned([*chosen, person], costs, robots)
        if len(tried) > len(given):
            given, chosen = tried, [*chosen, person]
        if len(given) == len(robots):
            break
    return given


def _assigned(people: Sequence[int], costs: Costs, robots: Sequence[str]) -> dict[int, str]:
    matrix = np.array([[costs.get(person, {}).get(robot, np.inf) for robot in robots] for person in people])
    rows, columns = assign(matrix.reshape(len(people), len(robots)), BEYOND)
    return {people[row]: robots[column] for row, column in zip(rows.tolist(), columns.tolist(), strict=True)}


# -- step 5: when one robot takes a person over from another -----------------------------------------------------------


def takes_over(current: float, other: Sequence[float], samples: int) -> bool:
    """Return whether robot R′ takes the followed person over from robot R.

    The paper: "switch to R′ only if R′'s cost is strictly decreasing over the observed history and smaller than R's".

    Parameters
    ----------
    current : float
        Cost of the shortest path from R to the person now.
    other : sequence of float
        Costs of R′ over the observed history, the newest last.
    samples : int
        Length of the history; with fewer costs R keeps the person.
    """
    if len(other) < samples or not math.isfinite(other[-1]):
        return False
    decreasing = all(later < earlier for earlier, later in pairwise(other[-samples:]))
    return decreasing and other[-1] < current


# -- orders to follow people -------------------------------------------------------------------------------------------


@dataclass(slots=True)
class FollowAssignment:
    """A robot follows a person.

    Parameters
    ----------
    person : int
    robot : str
    since : float
        [s]
    cost : float
        Cost of the shortest path when it was last known.
    reason : str
    saw : float
        Time at which the robot last saw the person [s].
    began : bool
        Whether the robot has reported that it follows the person.
    """

    person: int
    robot: str
    since: float
    cost: float
    reason: str
    saw: float
    began: bool = False


@dataclass(frozen=True, slots=True)
class FollowScene:
    """The robots and people that orders depend on.

    Parameters
    ----------
    now : float
        [s]
    targets : sequence of int
        People to follow, the most important first.
    known : mapping of int to set of str
        The people who may be followed, and the robots that see each.
    costs : Costs
        Costs of paths, of robots that see a person or follow one whom another robot sees.
    fresh : set of int
        People whose costs are of this cycle.
    able : set of str
        Robots that can follow, and whose reports are used.
    kept : set of str
        Robots that keep their orders.
    following : mapping of str to int
        Whom each robot follows by its own report; 0 for nobody.
    reasons : mapping of int to str
        Why each target was chosen.
    """

    now: float
    targets: Sequence[int]
    known: Mapping[int, set[str]]
    costs: Costs
    fresh: set[int]
    able: set[str]
    kept: set[str]
    following: Mapping[str, int]
    reasons: Mapping[int, str] = field(default_factory=dict)


class FollowController:
    """Follow Action Controller with the switch rule, over time.

    Parameters
    ----------
    parameters : CoordinatorParameters

    Attributes
    ----------
    orders : dict of int to FollowAssignment
        By person.
    given_up : dict of (str, int) to float
        Time until which a robot does not get a person again that it gave up [s].
    """

    def __init__(self, parameters: CoordinatorParameters) -> None:
        self._parameters = parameters
        self.orders: dict[int, FollowAssignment] = {}
        self.given_up: dict[tuple[str, int], float] = {}
        self._history: dict[int, deque[tuple[float, dict[str, float]]]] = {}
        self._handed_over: dict[int, tuple[str, float]] = {}

    def update(self, scene: FollowScene) -> None:
        """Update the orders."""
        self.given_up = {pair: until for pair, until in self.given_up.items() if until > scene.now}
        self._drop(scene)
        for order in list(self.orders.values()):
            self._refresh(order, scene)
            self._switch(order, scene)
        self._assign(scene)
        self._handed_over = {
            person: (robot, at) for person, (robot, at) in self._handed_over.items()
            if scene.now - at < self._parameters.hold
        }  # fmt: skip
        self._history = {person: seen for person, seen in self._history.items() if person in self.orders}

    def merge(self, kept: int, dropped: int) -> None:
        """Follow one person instead of another who turned out to be the same."""
        order = self.orders.pop(dropped, None)
        if order is not None and kept not in self.orders:
            order.person = kept
            self.orders[kept] = order

    def move_times(self, seconds: float) -> None:
        """Add a time [s] to all times."""
        for order in self.orders.values():
            order.since += seconds
            order.saw += seconds
        self.given_up = {pair: until + seconds for pair, until in self.given_up.items()}
        self._handed_over = {person: (robot, at + seconds) for person, (robot, at) in self._handed_over.items()}
        self._history = {
            person: deque((at + seconds, costs) for at, costs in seen) for person, seen in self._history.items()
        }

    def _drop(self, scene: FollowScene) -> None:
        """Drop orders that cannot go on: the robot left or gave up, the person is forgotten or not wanted any more."""
        for person, order in list(self.orders.items()):
            order.began |= scene.following.get(order.robot, 0) == person
            gave_up = order.began and scene.following.get(order.robot, person) == 0
            if gave_up:
                self.given_up[order.robot, person] = scene.now + self._parameters.give_up_for
            if order.robot not in scene.kept or gave_up:
                self._handed_over[person] = order.robot, scene.now
            if gave_up or order.robot not in scene.kept or person not in scene.known or person not in scene.targets:
                del self.orders[person]

    def _refresh(self, order: FollowAssignment, scene: FollowScene) -> None:
        """Note what an order costs now, and the costs of all robots that see the person."""
        seers = scene.known[order.person]
        if order.robot in seers:
            order.saw = scene.now
        costs = self._able(order.person, scene)
        order.cost = scene.costs.get(order.person, {}).get(order.robot, order.cost)
        history = self._history.setdefault(order.person, deque())
        apart = self._parameters.switch_history / (self._parameters.switch_samples - 1)
        if order.person in scene.fresh and (not history or scene.now - history[-1][0] >= apart - 0.05):
            history.append((scene.now, dict(costs)))
        while history and history[0][0] < scene.now - 2.0 * self._parameters.switch_history:
            history.popleft()

    def _switch(self, order: FollowAssignment, scene: FollowScene) -> None:
        """Hand a person over to another robot, by the switch rule or since the robot does not see the person.

        A robot that does not see the person drives to where the others see the person: it is replaced at once only by
        a robot that is nearer.
        """
        free = self._free(scene)
        costs = {robot: cost for robot, cost in self._able(order.person, scene).items() if robot in free}
        other = cheapest(costs)
        if other is None:
            return
        own = scene.costs.get(order.person, {}).get(order.robot, math.inf)
        unseen, p = scene.now - order.saw, self._parameters
        if unseen > (p.lost_sight if costs[other] < own else p.without_sight):
            self._give(order.person, other, scene, f"{order.robot} does not see the person; {other} is the nearest")
            return
        past = [robot_costs for _, robot_costs in self._history[order.person]]
        if order.person not in scene.fresh:
            return
        for robot in sorted(costs, key=lambda robot: (costs[robot], robot)):
            trend = [each[robot] for each in past if robot in each]
            if takes_over(own, trend, p.switch_samples):
                reason = f"its cost has been falling, to {costs[robot]:.0f}, below the {own:.0f} of {order.robot}"
                self._give(order.person, robot, scene, reason)
                return

    def _assign(self, scene: FollowScene) -> None:
        """Give the people who nobody follows yet to free robots."""
        waiting = [person for person in scene.targets if person not in self.orders and person in scene.known]
        costs = {person: self._able(person, scene) for person in waiting}
        for person, robot in follow_actions(waiting, costs, self._free(scene)).items():
            self._give(person, robot, scene, scene.reasons.get(person, ""))

    def _give(self, person: int, robot: str, scene: FollowScene, reason: str) -> None:
        order = self.orders.get(person)
        if order is not None:
            self._handed_over[person] = order.robot, scene.now
        cost = scene.costs.get(person, {}).get(robot, math.inf)
        self.orders[person] = FollowAssignment(person, robot, scene.now, cost, reason, scene.now)
        self._history.pop(person, None)

    def _free(self, scene: FollowScene) -> list[str]:
        busy = {order.robot for order in self.orders.values()}
        return sorted(scene.able - busy)

    def _able(self, person: int, scene: FollowScene) -> dict[str, float]:
        """Return the costs of the robots that see a person, can follow and did not give the person up."""
        return {
            robot: cost
            for robot, cost in scene.costs.get(person, {}).items()
            if robot in scene.able and robot in scene.known[person] and (robot, person) not in self.given_up
            if robot != self._left_by(person, scene.now)
        }

    def _left_by(self, person: int, now: float) -> str | None:
        """Return the robot that handed a person over so recently that it must not get the person back."""
        robot, at = self._handed_over.get(person, (None, -math.inf))
        return robot if now - at < self._parameters.hold else None
