"""Group of robots with its coordinator in this process, and the rules that it is compared with."""

from collections.abc import Iterable
from time import thread_time

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.people.runs.job import Policy
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.people_coordination import SEEN, FollowOrder, PeopleReport, PeopleState
from ppaas.people.coordinator.coordinator import PeopleCoordinator
from ppaas.people.settings import PeopleSettings
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


class CoordinatedGroup:
    """Coordinator of some robots, with a policy.

    Parameters
    ----------
    costmap : Costmap
        Static layer, inflated for the robots.
    policy : str
        One of `benchmarks.people.runs.job.POLICIES`.
    settings : PeopleSettings, optional

    Attributes
    ----------
    refused : list of str
        Why reports were refused.
    cycles : list of float
        CPU time of each cycle [s]: several runs may share the cores.
    """

    def __init__(self, costmap: Costmap, policy: Policy, settings: PeopleSettings | None = None) -> None:
        self.coordinator = PeopleCoordinator(costmap, settings or PeopleSettings())
        self.refused: list[str] = []
        self.cycles: list[float] = []
        self._policy = policy
        self._only: str | None = None
        self._nearest = NearestRobot(costmap)

    def report(self, report: PeopleReport, now: float) -> None:
        """Hand a report to the coordinator; with the policy ``single``, only the first robot can follow."""
        self._only = self._only or report.robot
        if self._policy == "single" and report.robot != self._only:
            report = msgspec.structs.replace(report, can_follow=False)
        self._nearest.note(report)
        try:
            self.coordinator.report(report, now)
        except InvalidInput as error:
            self.refused.append(str(error))

    def step(self, now: float) -> PeopleState:
        """Return the state at a time [s since the epoch]."""
        began = thread_time()
        state = self.coordinator.step(now)
        self.cycles.append(thread_time() - began)
        if self._policy == "nearest":
            state = msgspec.structs.replace(state, orders=self._nearest.orders(state, now))
        return state
