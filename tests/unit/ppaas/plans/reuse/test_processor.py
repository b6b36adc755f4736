"""The processor searches for stored plans only if that pays off, checks them, and records each request."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from ppaas import planners
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, PlanCancelled
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.processor import REFUSAL_TIME, PlanProcessor
from ppaas.plans.reuse.scope import ReuseScope
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.plans.stored import PlanQuery, StoredPlan
from tests.support.world.grids import centre, costmap, of

OPEN = costmap("\n".join(["." * 200] * 3))
START, GOAL = centre(OPEN, 1, 0), centre(OPEN, 1, 199)


class Library:
    """A library whose answers the test sets."""

    def __init__(self) -> None:
        self.plans: Sequence[StoredPlan] | None = ()
        self.asked: list[tuple[PlanQuery, float]] = []
        self.waits = True

    def may_wait(self) -> bool:
        return self.waits

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        self.asked.append((query, within))
        return self.plans


class Home:
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


def test_a_planner_that_was_never_measured_computes_and_asks_nobody() -> None:
    home = Home(seconds=0.0)
    made = home.plan()
    assert (made.origin, made.reused, home.library.asked) == ("computed", "", [])
    assert (home.noted[0].queries, home.noted[0].computed, home.noted[0].planner) == (1, 1, "dijkstra")


def test_a_planner_that_is_quick_computes_and_asks_nobody() -> None:
    home = Home(seconds=0.001)
    assert home.plan().origin == "computed"
    assert home.library.asked == []
    assert home.processor.verdict.criterion == "transmission"


def test_what_measured_times_refuse_is_refused_for_a_while_and_then_asked_anew() -> None:
    home = Home(seconds=0.001)
    home.keep(home.plan())
    for _ in range(1000):
        home.setup.times.computation.note("dijkstra", 199.0, 1.0)
    assert home.plan().origin == "computed"
    home.now += REFUSAL_TIME
    assert home.plan().origin == "reused"


def test_where_planning_takes_long_a_kept_plan_is_given_as_it_was() -> None:
    home = Home()
    computed = home.plan()
    home.keep(computed)
    found = home.plan()
    assert (found.origin, found.reused, found.id) == ("reused", computed.id, computed.id)
    assert found.poses.tobytes() == computed.poses.tobytes()
    assert [(row.computed, row.reused) for row in home.noted] == [(1, 0), (0, 1)]


def test_who_looks_waits_for_a_tenth_of_what_computing_takes_at_most() -> None:
    home = Home(seconds=2.0)
    home.library.plans = None
    assert home.plan().origin == "computed"
    [(_, within)] = home.library.asked
    assert 0.02 < within < 0.2
    assert home.processor.verdict.criterion == "late"


def test_who_wants_no_kept_plan_gets_none() -> None:
    home = Home()
    home.keep(home.plan())
    assert home.plan(reuse=False).origin == "computed"


def test_a_kept_plan_that_is_blocked_now_is_computed_anew() -> None:
    home = Home()
    home.keep(home.plan())
    data = OPEN.data.copy()
    data[1, 100] = 254
    live = of(data)
    found = home.plan(live)
    assert found.origin == "computed"
    assert home.processor.verdict.criterion == "costmap"
    assert [1, 100] not in found.cells.tolist()
    assert found.conditions["bare_map"] is False


def test_what_keeps_out_by_a_mask_proves_nothing_to_those_who_have_none_or_another() -> None:
    data = np.zeros((60, 200), np.uint8)
    barred = data.copy()
    barred[:59, 100] = 254
    by_mask = Home(bare=of(barred), keepout="kept@v1")
    detour = by_mask.plan(by_mask.bare)
    assert (detour.conditions["keepout_filter"], detour.conditions["bare_map"]) == ("kept@v1", True)
    by_mask.keep(detour)
    assert by_mask.plan(by_mask.bare).origin == "reused"
    for bare, keepout in ((data, ""), (barred, "kept@v2")):
        other = Home(bare=of(bare), keepout=keepout)
        other.library.plans = by_mask.library.plans
        found = other.plan(other.bare)
        assert (found.origin, other.processor.verdict.criterion) == ("computed", "bound")
        assert found.id != detour.id
    assert "keepout_filter" not in Home().plan().conditions


def test_of_several_the_first_that_will_do_is_taken() -> None:
    home = Home()
    computed = home.plan()
    home.keep(computed)
    assert home.library.plans
    good = home.library.plans[0]
    home.library.plans = [replace(good, id="no", poses=good.poses[:0]), replace(good, id="yes")]
    assert home.plan().reused == "yes"


def test_in_a_thread_that_may_not_wait_the_job_is_given_up_to_be_begun_again() -> None:
    home = Home()
    home.library.waits = False
    with pytest.raises(PlanCancelled):
        home.plan()
    assert home.noted == []


def test_a_request_without_a_plan_is_counted_as_failed() -> None:
    home = Home(seconds=0.0)
    data = OPEN.data.copy()
    data[1, 199] = 254
    with pytest.raises(GoalOccupied):
        home.plan(of(data))
    assert (home.noted[0].queries, home.noted[0].failed) == (1, 1)


def test_the_same_plan_has_the_same_id_and_another_has_not() -> None:
    home = Home(seconds=0.0)
    first = home.plan()
    other = home.processor.plan(home.planner, OPEN, PlanRequest(START, centre(OPEN, 2, 199)))
    smooth = home.processor.plan(planners.create("dijkstra", smooth=True), OPEN, PlanRequest(START, GOAL))
    assert home.plan().id == first.id
    assert len({first.id, other.id, smooth.id}) == 3
    assert first.conditions == {"allow_unknown": True, "smooth": False, "robot_radius": 0.2, "bare_map": True}
