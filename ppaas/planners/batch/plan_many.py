"""Many plans on one map, on all cores."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput, PlanningError
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.batch.workers import Check, Worker, work_off
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.field.base import GridField
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.watch import Watch, proceed
from ppaas.plugins import parameters_in_use

Answer = PlanResult | PlanningError
Progress = Callable[[int, int], None]
Group = list[int]
Plan = Callable[[PlanRequest], PlanResult]


def unseen(done: int, total: int) -> None:
    """Be the progress callback that nobody looks at."""


def plan_many(
    planner: Planner,
    costmap: Costmap,
    requests: Sequence[PlanRequest],
    *,
    threads: int = 1,
    check: Check = proceed,
    progress: Progress = unseen,
) -> list[Answer]:
    """Plan for many requests on one map; each is answered as it would be alone.

    Each thread plans for one request at a time. A planner that prepares maps prepares this one once for all, and
    ``dijkstra`` grows one field for all requests of the same goal; what such an answer says was expanded is then
    counted for all of them so far.

    Parameters
    ----------
    planner : Planner
        Not to be used otherwise meanwhile.
    costmap : Costmap
        Only read; it must not change meanwhile.
    requests : sequence of PlanRequest
        Each with its own timeout, from when its turn comes, and cancel checker, which other threads than the caller's
        may ask. Their ``threads`` do not count.
    threads : int
        Most threads to use in all.
    check : callable
        Called often, by several threads at a time; what it raises ends all the work.
    progress : callable
        Called now and then, in the caller's thread, with how many requests are answered and how many there are.

    Returns
    -------
    list
        For each request a ``PlanResult``, or the ``PlanningError`` that it met: no way, no time, cancelled …

    Raises
    ------
    InvalidInput
        A request or a number of threads that cannot be; before anything is planned.
    """
    _check_all(requests, threads)
    frozen, groups, answered = _unwritable(costmap), _groups(planner, requests), 0
    crew = max(1, min(threads, len(groups)))
    if isinstance(planner, PreparedPlanner) and requests:
        planner.prepared(frozen, threads=threads, check=check)

    def worker(own: Planner) -> Worker[Group, list[Answer]]:
        def work(group: Group, asked: Check) -> list[Answer]:
            return [_answer(own, frozen, replace(requests[i], threads=threads // crew), asked) for i in group]

        return work

    def done(group: Group) -> None:
        nonlocal answered
        answered += len(group)
        progress(answered, len(requests))

    found = work_off([worker(own) for own in _planners(planner, crew)], groups, check=check, done=done)
    answers = dict(zip(chain(*groups), chain(*found), strict=True))
    return [answers[i] for i in range(len(requests))]


def _check_all(requests: Sequence[PlanRequest], threads: int) -> None:
    if threads < 1:
        raise InvalidInput(f"planning takes at least one thread, not {threads}")
    for number, request in enumerate(requests):
        try:
            Watch(replace(request, threads=threads))
        except InvalidInput as error:
            raise InvalidInput(f"request {number}: {error}") from error


def _unwritable(costmap: Costmap) -> Costmap:
    """Return the same map so that planners know that it does not change meanwhile."""
    if not costmap.data.flags.writeable:
        return costmap
    data = costmap.data.view()
    data.flags.writeable = False
    return Costmap(data, costmap.info)


def _groups(planner: Planner, requests: Sequence[PlanRequest]) -> list[Group]:
    """Return the requests, by their numbers, that one planner should answer one after the other."""
    if not isinstance(planner, Dijkstra):
        return [[number] for number in range(len(requests))]
    groups: dict[tuple[float, ...], Group] = {}
    for number, request in enumerate(requests):
        groups.setdefault((request.goal.x, request.goal.y, request.tolerance), []).append(number)
    return list(groups.values())


def _planners(planner: Planner, count: int) -> list[Planner]:
    if isinstance(planner, Dijkstra):
        return [_OneGoalAfterTheOther(planner) for _ in range(count)]
    return [planner, *(planner.twin() for _ in range(count - 1))]


def _answer(planner: Planner, costmap: Costmap, request: PlanRequest, asked: Check) -> Answer:
    def cancelled() -> bool:
        asked()
        return request.cancelled()

    try:
        return planner.plan(costmap, replace(request, cancelled=cancelled))
    except PlanningError as error:
        asked()  # so that the end of all is not taken for an answer
        return error


class _OneGoalAfterTheOther(Dijkstra):
    """Keeps the field of the goal before, which only grows further if the next goal is the same; for one map."""

    def __init__(self, like: Dijkstra) -> None:
        super().__init__(**parameters_in_use(like))
        self._goal: Cell | None = None
        self._field: CostField | None = None
        self._check: Check = proceed

    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Check) -> tuple[GridField, bool]:
        """Return a field, and whether it reaches the start, whose value is then final."""
        self._check = check
        field = self._field if self._goal == ends.goal else None
        self._goal = self._field = None  # what is interrupted is not gone on with
        if field is None:
            goals = np.array([ends.goal])
            field = CostField(costmap, goals, allow_unknown=self.allow_unknown, threads=threads, check=self._asked)
        reached = field.grow(ends.start)
        self._goal, self._field = ends.goal, field
        return field, reached

    def _asked(self) -> None:
        self._check()
