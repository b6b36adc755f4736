"""Queue of planning jobs."""

import weakref

import pytest

from ppaas import planners
from ppaas.errors import NoValidPath, PlanCancelled, Unavailable
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.path_services import ONE_OF, PlanComparison
from ppaas.nodes.planner_server.planner_queue import MAX_WAITING, PlannerQueue
from ppaas.planners.base import PlanRequest
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.tracing.spans import entry, traceparent
from tests.support.recorded_spans import recorded_spans
from tests.support.world.grids import centre, costmap


class LateWorker:
    """A worker that stores jobs until the test runs them."""

    def __init__(self) -> None:
        self.jobs: list = []

    def __call__(self, work, cancelled, done):
        self.jobs.append((work, cancelled, done))

    def run_one(self):
        work, cancelled, done = self.jobs.pop(0)
        try:
            done(work(cancelled))
        except (NoValidPath, PlanCancelled) as error:
            done(error)


def queue() -> tuple[PlannerQueue, LateWorker, list]:
    worker = LateWorker()
    return PlannerQueue(Graph(worker)), worker, []


def test_job_runs_after_the_previous_one_is_done():
    plans, worker, done = queue()
    for name in "abc":
        plans.submit(lambda cancelled, name=name: name, done.append)
    for expected in (["a"], ["a", "b"], ["a", "b", "c"]):
        assert len(worker.jobs) == 1
        worker.run_one()
        assert done == expected


def test_jobs_that_run_at_once_are_done_in_order():
    plans, done = PlannerQueue(Graph()), []
    for name in "abc":
        plans.submit(lambda cancelled, name=name: name, done.append)
    assert done == ["a", "b", "c"]


def test_each_job_works_for_the_trace_that_it_was_submitted_for():
    plans, worker, done = queue()
    with recorded_spans() as recorded:
        for name in ("first", "second"):
            with entry(name, ""):
                plans.submit(lambda cancelled: traceparent(), lambda trace: done.append((trace, traceparent())))
        for _ in range(2):
            worker.run_one()
    wanted = [f"00-{span.trace}-{span.id}-01" for span in recorded]
    assert done == [(trace, trace) for trace in wanted] and len(set(wanted)) == 2


def test_a_job_may_submit_the_next():
    plans, done = PlannerQueue(Graph()), []
    plans.submit(lambda cancelled: "a", lambda _: plans.submit(lambda cancelled: "b", done.append))
    assert done == ["b"]


def test_job_error_is_delivered_and_the_next_job_runs():
    def fail(cancelled):
        raise NoValidPath("no way")

    plans, worker, done = queue()
    plans.submit(fail, done.append)
    plans.submit(lambda cancelled: "b", done.append)
    worker.run_one()
    worker.run_one()
    assert isinstance(done[0], NoValidPath)
    assert done[1] == "b"


def test_running_job_sees_its_cancellation():
    plans, worker, done = queue()
    job = plans.submit(lambda cancelled: cancelled(), done.append)
    job.cancel()
    worker.run_one()
    assert done == [True]


def test_cancelled_waiting_job_is_answered_without_running():
    plans, worker, done = queue()
    plans.submit(lambda cancelled: "a", done.append)
    plans.submit(lambda cancelled: pytest.fail("it was cancelled"), done.append).cancel()
    plans.submit(lambda cancelled: "c", done.append)
    worker.run_one()
    worker.run_one()
    assert done[0] == "a"
    assert isinstance(done[1], PlanCancelled)
    assert done[2] == "c"


def test_too_many_waiting_jobs_are_refused():
    plans, _, done = queue()
    for _ in range(MAX_WAITING + 1):
        plans.submit(lambda cancelled: None, done.append)
    with pytest.raises(Unavailable, match="try again"):
        plans.submit(lambda cancelled: None, done.append)


def test_ticket_does_not_keep_a_done_job_alive():
    class Large:
        """Stands for a large object such as a costmap."""

    plans, large = PlannerQueue(Graph()), Large()
    held = weakref.ref(large)
    ticket = plans.submit(lambda cancelled, large=large: None, lambda result: None)
    del large
    assert held() is None
    ticket.cancel()


MAP = costmap("\n".join(["." * 40] * 30))
REQUEST = PlanRequest(centre(MAP, 1, 1), centre(MAP, 20, 38))


class ComparisonHarness:
    """A plan comparison on a graph that runs jobs at once."""

    def __init__(self) -> None:
        self.noted = list[PlannerHistory]()
        self.comparison = PlanComparison(Graph(), ReuseSetup("house", "v1", note=self.noted.append).processor(MAP, 0.2))

    def see(self, planner: str, times: int = 1) -> None:
        chosen = planners.create(planner)
        for _ in range(times):
            self.comparison.see(chosen, MAP, REQUEST, chosen.plan(MAP, REQUEST))


def test_first_plan_and_every_nth_are_compared() -> None:
    harness = ComparisonHarness()
    harness.see("theta_star")
    (row,) = harness.noted
    assert (row.planner, row.compared, row.queries) == ("theta_star", 1, 0)
    assert 0 < row.millimetres < row.cheapest_millimetres, "a straight line is shorter than one from cell to cell"
    harness.see("theta_star", ONE_OF)
    assert len(harness.noted) == 2


def test_optimal_planner_is_not_compared() -> None:
    harness = ComparisonHarness()
    harness.see("dijkstra", 2)
    assert harness.noted == []
