"""The three criteria decide, and report the numbers behind a decision."""

from dataclasses import replace

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.plans.reuse.criteria import best_candidates, by_algorithm, by_time, by_version
from ppaas.plans.reuse.time_estimates import Estimate
from ppaas.plans.stored import PlanQuery, StoredPlan

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
