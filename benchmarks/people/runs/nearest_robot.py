"""Baseline of following: the nearest robot at any time, without hysteresis."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.people_coordination import SEEN, FollowOrder, PeopleReport, PeopleState
from ppaas.planners.field.cost_field import cost_field


class NearestRobot:
    """Baseline: at any time the pair of a robot and a person that it sees with the cheapest path, without memory.

    Parameters
    ----------
    costmap : Costmap
    """

    def __init__(self, costmap: Costmap) -> None:
        self._costmap = costmap
        self._can_follow: set[str] = set()
        self._last: list[FollowOrder] = []

    def note(self, report: PeopleReport) -> None:
        """Note whether a robot can follow."""
        (self._can_follow.add if report.can_follow else self._can_follow.discard)(report.robot)

    def orders(self, state: PeopleState, now: float) -> list[FollowOrder]:
        """Return the order of the cheapest pair; while nobody is seen, the last one if its person is still known."""
        costs = list(self._costs(state))
        known = {person.id for person in state.people}
        if not costs:
            return [order for order in self._last if order.person in known]
        cost, robot, person = min(costs)
        since = Time.of(now)
        if self._last and (self._last[0].robot, self._last[0].person) == (robot, person):
            since = self._last[0].since
        self._last = [FollowOrder(robot, person, cost, since, "nearest robot")]
        return self._last

    def _costs(self, state: PeopleState) -> Iterable[tuple[float, str, int]]:
        robots = {robot.robot: robot for robot in state.robots if robot.trusted and robot.robot in self._can_follow}
        for person in state.people:
            watchers = {frame.partition("/")[0] for frame in person.seen_by} & set(robots)
            if person.state != SEEN or not watchers:
                continue
            field = self._field(person.position.x, person.position.y)
            if field is None:
                continue
            for robot in sorted(watchers):
                cell = self._costmap.info.cell_of(robots[robot].position.x, robots[robot].position.y)
                if cell is not None and np.isfinite(field[cell]):
                    yield float(field[cell]), robot, person.id

    def _field(self, x: float, y: float) -> NDArray[np.float64] | None:
        try:
            return cost_field(self._costmap, (x, y))
        except (GoalOccupied, GoalOutsideMap):
            return None
