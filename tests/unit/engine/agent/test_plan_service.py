"""Plan service: stored plans that a container finds, and history that it may add."""

import pytest

from engine.agent.plan_service import PlanService
from engine.protocols import machine_link
from engine.protocols.plan_candidates import stored_plan
from ppaas.errors import NotPermitted
from ppaas.plans.history import LinkHistory, failed_row
from storage.memory.store import MemoryStore
from tests.support.engine.kept_plans import PARAMETERS, record
from tests.support.engine.specs import planning_spec

SPEC = planning_spec()


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def desk(store: MemoryStore) -> PlanService:
    return PlanService(store, "m1")


def find(desk: PlanService, start: float, goal: float, *, kinematic: bool = False) -> list[machine_link.Candidate]:
    return desk.find(
        SPEC, machine_link.FindPlans(1, (start, 0.0), (goal, 0.0), "dijkstra", PARAMETERS, 0.18, 0.25, kinematic)
    )


def test_a_plan_of_another_user_on_the_same_map_is_found_whole(desk: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0))
    (found,) = find(desk, 0.1, 20.0)
    assert (found.plan, found.whole) == (record("p1", 0.0, 20.0), True)
    assert stored_plan(found).poses.shape == (21, 7)


def test_of_another_version_or_planner_none_is_found(desk: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0, version="v0"))
    store.add_plan(record("p2", 0.0, 20.0, planner="navfn"))
    store.add_plan(record("p3", 0.0, 20.0, map="depot"))
    store.add_plan(record("p4", 0.0, 20.0, parameters={"smooth": True, "bare_map": True}))
    assert find(desk, 0.0, 20.0) == []


def test_what_a_program_gave_is_found_only_where_it_is_shorter_than_what_the_planner_did(
    desk: PlanService, store: MemoryStore
) -> None:
    store.add_plan(record("forged", 0.0, 20.0, origin="given"))
    assert find(desk, 0.0, 20.0) == []
    assert find(desk, 5.0, 12.0) == [], "nor a stretch of it"
    store.add_plan(record("own", 0.0, 20.0, length=23.0))
    assert {found.plan.id for found in find(desk, 0.0, 20.0)} == {"forged", "own"}
    assert {stored_plan(found).id: stored_plan(found).given for found in find(desk, 0.0, 20.0)} == (
        {"forged": True, "own": False}
    )


def test_of_a_plan_that_passes_by_the_stretch_between_is_found(desk: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0))
    (found,) = find(desk, 5.0, 12.0)
    assert not found.whole
    poses = stored_plan(found).poses
    assert (poses[0, 0], poses[-1, 0]) == (5.0, 12.0)
    assert find(desk, 5.0, 12.0, kinematic=True) == []


def test_a_container_notes_what_it_planned_on_its_own_map_version_only(desk: PlanService, store: MemoryStore) -> None:
    own = (SPEC.map.id, SPEC.map.version, "dijkstra", 3)
    link = LinkHistory("m1", 0.001, 1e8, 1, 5.0)
    desk.note(SPEC, [failed_row(own)], link)
    assert (store.history(SPEC.map.id), store.links()) == ([failed_row(own)], [link])
    for rows, measured in (([failed_row(("depot", *own[1:]))], None), ([], LinkHistory("m2", 0.0, 1.0, 1, 0.0))):
        with pytest.raises(NotPermitted):
            desk.note(SPEC, rows, measured)
    known = desk.history(SPEC)
    assert (known.rows, known.link, known.measured) == ([failed_row(own)], "m1", link)
