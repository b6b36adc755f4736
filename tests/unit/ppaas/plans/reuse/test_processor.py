"""The processor searches for stored plans only if that pays off, checks them, and records each request."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from ppaas import planners
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, PlanCancelled
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.criteria import best_candidates, by_algorithm, by_time, by_version
from ppaas.plans.reuse.processor import REFUSAL_TIME, PlanProcessor, ReuseScope
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.plans.reuse.time_estimates import Estimate
from ppaas.plans.stored import PlanQuery, StoredPlan
from tests.support.world.grids import centre, costmap, of

OPEN = costmap("\n".join(["." * 200] * 3))
START, GOAL = centre(OPEN, 1, 0), centre(OPEN, 1, 199)


class Library:
    """A library whose answers the test sets."""

    def __init__(self) -> None:
        self.plans: Sequence[StoredPlan] | None = ()
        self.queries: list[tuple[PlanQuery, float]] = []
        self.waits = True

    def may_wait(self) -> bool:
        return self.waits

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        self.queries.append((query, within))
        return self.plans


class ProcessorHarness:
    """A processor with its library and recorded history."""

    def __init__(self, seconds: float = 1.0, bare: Costmap = OPEN, keepout: str = "") -> None:
        self.library, self.noted = Library(), list[PlannerHistory]()
        self.setup = setup = ReuseSetup("house", "v1", self.library, note=self.noted.append)
        self.now, self.bare = 0.0, bare
        scope = ReuseScope("house", "v1", bare, 0.2, {"keepout_filter": keepout} if keepout else {})
        times, note = setup.times, setup.note
        self.processor = PlanProcessor(scope, self.library, times, note, clock=lambda: self.now)
        self.planner = planners.create("dijkstra")
        for _ in range(10 if seconds else 0):
            setup.times.computation.note("dijkstra", 199.0, seconds)

    def plan(self, live: Costmap = OPEN, **options: bool) -> PlanResult:
        return self.processor.plan(self.planner, live, PlanRequest(START, GOAL), **options)

    def keep(self, result: PlanResult, **changes: object) -> None:
        kept = StoredPlan(
            result.id, "v1", "dijkstra", tuple(START), tuple(GOAL), result.length, result.poses,
            conditions=result.conditions,
        )  # fmt: skip
        self.library.plans = [replace(kept, **changes)]


def test_unmeasured_planner_computes_without_a_query() -> None:
    harness = ProcessorHarness(seconds=0.0)
    made = harness.plan()
    assert (made.origin, made.reused, harness.library.queries) == ("computed", "", [])
    assert (harness.noted[0].queries, harness.noted[0].computed, harness.noted[0].planner) == (1, 1, "dijkstra")


def test_fast_planner_computes_without_a_query() -> None:
    harness = ProcessorHarness(seconds=0.001)
    assert harness.plan().origin == "computed"
    assert harness.library.queries == []
    assert harness.processor.verdict.criterion == "transmission"


def test_refusal_by_measured_times_is_kept_for_a_while() -> None:
    harness = ProcessorHarness(seconds=0.001)
    harness.keep(harness.plan())
    for _ in range(1000):
        harness.setup.times.computation.note("dijkstra", 199.0, 1.0)
    assert harness.plan().origin == "computed"
    harness.now += REFUSAL_TIME
    assert harness.plan().origin == "reused"


def test_stored_plan_is_returned_unchanged_if_planning_is_slow() -> None:
    harness = ProcessorHarness()
    computed = harness.plan()
    harness.keep(computed)
    found = harness.plan()
    assert (found.origin, found.reused, found.id) == ("reused", computed.id, computed.id)
    assert found.poses.tobytes() == computed.poses.tobytes()
    assert [(row.computed, row.reused) for row in harness.noted] == [(1, 0), (0, 1)]


def test_query_waits_at_most_a_tenth_of_the_planning_time() -> None:
    harness = ProcessorHarness(seconds=2.0)
    harness.library.plans = None
    assert harness.plan().origin == "computed"
    [(_, within)] = harness.library.queries
    assert 0.02 < within < 0.2
    assert harness.processor.verdict.criterion == "late"


def test_no_stored_plan_is_used_without_reuse() -> None:
    harness = ProcessorHarness()
    harness.keep(harness.plan())
    assert harness.plan(reuse=False).origin == "computed"


def test_blocked_stored_plan_is_computed_again() -> None:
    harness = ProcessorHarness()
    harness.keep(harness.plan())
    data = OPEN.data.copy()
    data[1, 100] = 254
    live = of(data)
    found = harness.plan(live)
    assert found.origin == "computed"
    assert harness.processor.verdict.criterion == "costmap"
    assert [1, 100] not in found.cells.tolist()
    assert found.conditions["bare_map"] is False


def test_plan_with_a_keepout_mask_is_reused_with_the_same_mask_only() -> None:
    data = np.zeros((60, 200), np.uint8)
    blocked = data.copy()
    blocked[:59, 100] = 254
    by_mask = ProcessorHarness(bare=of(blocked), keepout="kept@v1")
    detour = by_mask.plan(by_mask.bare)
    assert (detour.conditions["keepout_filter"], detour.conditions["bare_map"]) == ("kept@v1", True)
    by_mask.keep(detour)
    assert by_mask.plan(by_mask.bare).origin == "reused"
    for bare, keepout in ((data, ""), (blocked, "kept@v2")):
        other = ProcessorHarness(bare=of(bare), keepout=keepout)
        other.library.plans = by_mask.library.plans
        found = other.plan(other.bare)
        assert (found.origin, other.processor.verdict.criterion) == ("computed", "bound")
        assert found.id != detour.id
    assert "keepout_filter" not in ProcessorHarness().plan().conditions


def test_first_acceptable_plan_is_taken() -> None:
    harness = ProcessorHarness()
    computed = harness.plan()
    harness.keep(computed)
    assert harness.library.plans
    good = harness.library.plans[0]
    harness.library.plans = [replace(good, id="no", poses=good.poses[:0]), replace(good, id="yes")]
    assert harness.plan().reused == "yes"


def test_plan_is_cancelled_in_a_thread_that_may_not_wait() -> None:
    harness = ProcessorHarness()
    harness.library.waits = False
    with pytest.raises(PlanCancelled):
        harness.plan()
    assert harness.noted == []


def test_a_request_without_a_plan_is_counted_as_failed() -> None:
    harness = ProcessorHarness(seconds=0.0)
    data = OPEN.data.copy()
    data[1, 199] = 254
    with pytest.raises(GoalOccupied):
        harness.plan(of(data))
    assert (harness.noted[0].queries, harness.noted[0].failed) == (1, 1)


def test_equal_plans_have_equal_ids_and_others_differ() -> None:
    harness = ProcessorHarness(seconds=0.0)
    first = harness.plan()
    other = harness.processor.plan(harness.planner, OPEN, PlanRequest(START, centre(OPEN, 2, 199)))
    smooth = harness.processor.plan(planners.create("dijkstra", smooth=True), OPEN, PlanRequest(START, GOAL))
    assert harness.plan().id == first.id
    assert len({first.id, other.id, smooth.id}) == 3
    assert first.conditions == {"allow_unknown": True, "smooth": False, "robot_radius": 0.2, "bare_map": True}


QUERY = PlanQuery(Pose2D(0, 0), Pose2D(10, 0), "v1", "dijkstra", {"smooth": False}, 0.18, 0.25)
HEAD = StoredPlan(
    "p1", "v1", "dijkstra", (0, 0, 0), (10, 0, 0), 12.0, np.empty((0, 7)),
    conditions={"smooth": False, "bare_map": True, "robot_radius": 0.18},
)  # fmt: skip


def estimate(seconds: float, spread: float = 1.0) -> Estimate:
    return Estimate(seconds, seconds / spread, seconds * spread, 10.0)


def test_plan_that_arrives_no_sooner_than_computed_is_refused() -> None:
    assert by_time(estimate(0.01), estimate(0.2)).taken
    assert not by_time(estimate(0.01), estimate(0.05)).taken
    assert not by_time(estimate(0.01, spread=3.0), estimate(0.2)).taken, "the answer may take longer"
    assert not by_time(estimate(0.01), estimate(0.2, spread=3.0)).taken, "the planner may be faster"
    assert by_time(estimate(0.01), estimate(0.02), margin=1.0).taken, "as the paper has it"


def test_stored_plan_is_refused_without_planner_measurements() -> None:
    assert not by_time(estimate(1e-9), None).taken


def test_plan_of_another_map_version_is_refused() -> None:
    assert by_version(HEAD, QUERY).taken
    assert not by_version(replace(HEAD, version="v2"), QUERY).taken


def test_plan_of_another_planner_must_beat_the_requested_one() -> None:
    own = replace(HEAD, id="own", length=13.0)
    other = replace(HEAD, id="other", planner="theta_star", length=11.0)
    elsewhere = replace(own, start=(0.1, 0.0, 0.0))
    assert by_algorithm(own, QUERY, [own]).taken
    assert by_algorithm(other, QUERY, [own, other]).taken
    for worse in ([other], [elsewhere, other], [replace(own, length=11.0), other]):
        assert not by_algorithm(other, QUERY, worse).taken
    assert not by_algorithm(other, replace(QUERY, kinematic=True), [own, other]).taken


def test_given_plan_counts_for_no_planner() -> None:
    given = replace(HEAD, given=True)
    assert not by_algorithm(given, QUERY, [given]).taken
    detour = replace(given, length=99.0)
    other = replace(HEAD, id="other", planner="theta_star", length=11.0)
    assert not by_algorithm(other, QUERY, [detour, other]).taken
    assert by_algorithm(given, QUERY, [given, replace(HEAD, length=13.0)]).taken, "it is shorter than the planner's own"


def test_plan_with_other_parameters_is_refused() -> None:
    assert not by_algorithm(HEAD, replace(QUERY, parameters={"smooth": True}), [HEAD]).taken


def test_shortest_candidate_for_the_query_is_first() -> None:
    near = replace(HEAD, id="near")
    off = replace(HEAD, id="off", start=(0.2, 0, 0), length=11.9)
    short = replace(HEAD, id="short", length=11.0)
    old = replace(HEAD, id="old", version="v0", length=1.0)
    assert [each.id for each in best_candidates(QUERY, [off, near, short, old])] == ["short", "near"]


def test_verdict_states_criterion_and_numbers() -> None:
    text = str(by_time(estimate(0.01), estimate(0.05)))
    assert text.startswith("refused by transmission")
    assert "transmission 0.01" in text
    assert "computation 0.05" in text
