"""Many plans on one map, computed on several threads."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput, PlanningError
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.batch.workers import Check, Worker, run_jobs
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


def no_progress(done: int, total: int) -> None:
    """Do nothing: the default progress callback."""


def plan_many(
    planner: Planner,
    costmap: Costmap,
    requests: Sequence[PlanRequest],
    *,
    threads: int = 1,
    check: Check = proceed,
    progress: Progress = no_progress,
) -> list[Answer]:
    """Plan for many requests on one map; each result is the same as from a single call.

    Each thread plans for one request at a time. A planner that prepares maps prepares this one once for all requests.
    ``dijkstra`` grows one field for all requests with the same goal; ``expanded`` of their results then counts the
    cells of that field so far.

    Parameters
    ----------
    planner : Planner
        Must not be used otherwise meanwhile.
    costmap : Costmap
        Only read; it must not change meanwhile.
    requests : sequence of PlanRequest
        The timeout of each counts from when its planning begins. Cancel checkers may be called by other threads than
        the caller's. The requests' ``threads`` are ignored.
    threads : int
        Maximum number of threads in total.
    check : callable
        Called often, by several threads at once; an exception from it ends all the work.
    progress : callable
        Called occasionally, in the caller's thread, with the number of finished requests and their total.

    Returns
    -------
    list
        For each request a ``PlanResult``, or its ``PlanningError``: no path, timeout, cancelled …

    Raises
    ------
    InvalidInput
        A request or ``threads`` is invalid; raised before planning begins.
    """
    _check_all(requests, threads)
    frozen, groups, answered = costmap.read_only(), _groups(planner, requests), 0
    crew = max(1, min(threads, len(groups)))
    if isinstance(planner, PreparedPlanner) and requests:
        planner.prepared(frozen, threads=threads, check=check)

    def worker(own: Planner) -> Worker[Group, list[Answer]]:
        def work(group: Group, check: Check) -> list[Answer]:
            return [_answer(own, frozen, replace(requests[i], threads=threads // crew), check) for i in group]

        return work

    def done(group: Group) -> None:
        nonlocal answered
        answered += len(group)
        progress(answered, len(requests))

    found = run_jobs([worker(own) for own in _planners(planner, crew)], groups, check=check, done=done)
    answers = dict(zip(chain(*groups), chain(*found), strict=True))
    return [answers[i] for i in range(len(requests))]


def _check_all(requests: Sequence[PlanRequest], threads: int) -> None:
    if threads < 1:
        raise InvalidInput(f"threads must be at least 1, not {threads}")
    for number, request in enumerate(requests):
        try:
            Watch(replace(request, threads=threads))
        except InvalidInput as error:
            raise InvalidInput(f"request {number}: {error}") from error


def _groups(planner: Planner, requests: Sequence[PlanRequest]) -> list[Group]:
    """Return groups of request numbers; one planner answers a group in order."""
    if not isinstance(planner, Dijkstra):
        return [[number] for number in range(len(requests))]
    groups: dict[tuple[float, ...], Group] = {}
    for number, request in enumerate(requests):
        groups.setdefault((request.goal.x, request.goal.y, request.tolerance), []).append(number)
    return list(groups.values())


def _planners(planner: Planner, count: int) -> list[Planner]:
    if isinstance(planner, Dijkstra):
        return [_GoalByGoal(planner) for _ in range(count)]
    return [planner, *(planner.twin() for _ in range(count - 1))]


def _answer(planner: Planner, costmap: Costmap, request: PlanRequest, check: Check) -> Answer:
    def cancelled() -> bool:
        check()
        return request.cancelled()

    try:
        return planner.plan(costmap, replace(request, cancelled=cancelled))
    except PlanningError as error:
        check()  # if the whole batch has ended, raise instead of recording this error as an answer
        return error


class _GoalByGoal(Dijkstra):
    """Dijkstra planner that keeps the last field, and grows it further if the next goal is the same; for one map."""

    def __init__(self, like: Dijkstra) -> None:
        super().__init__(**parameters_in_use(like))
        self._goal: Cell | None = None
        self._field: CostField | None = None
        self._check: Check = proceed

    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Check) -> tuple[GridField, bool]:
        """Return a field, and whether it reaches the start, whose value is then final."""
        self._check = check
        field = self._field if self._goal == ends.goal else None
        self._goal = self._field = None  # do not continue an interrupted field
        if field is None:
            goals = np.array([ends.goal])
            field = CostField(costmap, goals, allow_unknown=self.allow_unknown, threads=threads, check=self._run_check)
        reached = field.grow(ends.start)
        self._goal, self._field = ends.goal, field
        return field, reached

    def _run_check(self) -> None:
        self._check()
