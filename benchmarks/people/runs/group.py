"""Group of robots with its coordinator in this process, and the rules that it is compared with."""

from time import thread_time

import msgspec

from benchmarks.people.runs.job import Policy
from benchmarks.people.runs.nearest_robot import NearestRobot
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.messages.people_coordination import PeopleReport, PeopleState
from ppaas.people.coordinator.coordinator import Coordinator
from ppaas.people.settings import PeopleSettings


class Group:
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
        self.coordinator = Coordinator(costmap, settings or PeopleSettings())
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
