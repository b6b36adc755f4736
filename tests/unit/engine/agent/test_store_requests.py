"""Requests of containers to the stores: checkpoints and logs of their own clone, stored plans and history."""

import msgspec
import pytest

from engine.agent import store_requests
from engine.agent.store_requests import LOG_PAGE, CloneService, PlanService, RecentPlans
from engine.protocols import machine_link
from engine.protocols.machine_link import stored_plan
from ppaas.errors import NotFound, NotPermitted
from ppaas.plans.history import LinkHistory, failed_row
from storage.memory.store import MemoryStore
from storage.records import CloneLogChange, PlanRecord
from storage.versions import without_poses
from tests.support.engine.kept_plans import PARAMETERS, record
from tests.support.engine.specs import mapping_spec, planning_spec, robot_spec
from tests.support.storage.records import plan


def test_checkpoint_and_changes_of_logs_are_stored_together() -> None:
    store = MemoryStore()
    service, spec = CloneService(store), robot_spec("c1", "ann", "tb1")
    service.save(spec, machine_link.SaveClone(1, {"amcl": b"{}"}, [CloneLogChange("slam", {1: b"x"})]), "cloud-1")
    assert store.clone("ann", "tb1").nodes["amcl"] == b"{}"
    assert service.log(spec, machine_link.ReadLog(2, "slam", -1)) == machine_link.LogRead(2, [(1, b"x")])
    assert service.log(spec, machine_link.ReadLog(3, "slam", 1)) == machine_link.LogRead(3, [])


def test_a_long_log_is_answered_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_requests, "LOG_BYTES", 1)
    service, spec = CloneService(MemoryStore()), robot_spec("c1", "ann", "tb1")
    entries = {number: bytes(10) for number in range(LOG_PAGE + 1)}
    service.save(spec, machine_link.SaveClone(1, {}, [CloneLogChange("slam", entries)]), "cloud-1")
    first = service.log(spec, machine_link.ReadLog(2, "slam", -1)).entries
    rest = service.log(spec, machine_link.ReadLog(3, "slam", first[-1][0])).entries
    assert (len(first), dict([*first, *rest])) == (LOG_PAGE, entries)


def test_a_container_without_a_clone_is_refused() -> None:
    service, spec = CloneService(MemoryStore()), planning_spec()
    with pytest.raises(NotPermitted, match="has no clone"):
        service.save(spec, machine_link.SaveClone(1, {}), "cloud-1")
    with pytest.raises(NotPermitted, match="has no clone"):
        service.log(spec, machine_link.ReadLog(2, "slam", -1))


SPEC = planning_spec()


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def service(store: MemoryStore) -> PlanService:
    return PlanService(store, "m1")


def find(
    service: PlanService, start: float, goal: float, *, kinematic: bool = False
) -> list[machine_link.PlanCandidate]:
    return service.find(
        SPEC, machine_link.FindPlans(1, (start, 0.0), (goal, 0.0), "dijkstra", PARAMETERS, 0.18, 0.25, kinematic)
    )


def test_plan_of_another_user_is_found_whole(service: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0))
    (found,) = find(service, 0.1, 20.0)
    assert (found.plan, found.whole) == (record("p1", 0.0, 20.0), True)
    assert stored_plan(found).poses.shape == (21, 7)


def test_plans_of_other_versions_or_planners_are_not_found(service: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0, version="v0"))
    store.add_plan(record("p2", 0.0, 20.0, planner="navfn"))
    store.add_plan(record("p3", 0.0, 20.0, map="depot"))
    store.add_plan(record("p4", 0.0, 20.0, parameters={"smooth": True, "bare_map": True}))
    assert find(service, 0.0, 20.0) == []


def test_given_plan_is_found_only_if_shorter_than_a_planned_one(service: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("forged", 0.0, 20.0, origin="given"))
    assert find(service, 0.0, 20.0) == []
    assert find(service, 5.0, 12.0) == [], "nor a segment of it"
    store.add_plan(record("own", 0.0, 20.0, length=23.0))
    assert {found.plan.id for found in find(service, 0.0, 20.0)} == {"forged", "own"}
    assert {stored_plan(found).id: stored_plan(found).given for found in find(service, 0.0, 20.0)} == (
        {"forged": True, "own": False}
    )


def test_segment_of_a_passing_plan_is_found(service: PlanService, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0))
    (found,) = find(service, 5.0, 12.0)
    assert not found.whole
    poses = stored_plan(found).poses
    assert (poses[0, 0], poses[-1, 0]) == (5.0, 12.0)
    assert find(service, 5.0, 12.0, kinematic=True) == []


def test_container_adds_history_of_its_own_map_version_only(service: PlanService, store: MemoryStore) -> None:
    own = (SPEC.map.id, SPEC.map.version, "dijkstra", 3)
    link = LinkHistory("m1", 0.001, 1e8, 1, 5.0)
    service.note(SPEC, [failed_row(own)], link)
    assert (store.history(SPEC.map.id), store.links()) == ([failed_row(own)], [link])
    for rows, measured in (([failed_row(("depot", *own[1:]))], None), ([], LinkHistory("m2", 0.0, 1.0, 1, 0.0))):
        with pytest.raises(NotPermitted):
            service.note(SPEC, rows, measured)
    known = service.history(SPEC)
    assert (known.rows, known.link, known.measured) == ([failed_row(own)], "m1", link)


def test_plans_of_a_map_that_is_not_published_are_neither_stored_nor_found(
    service: PlanService, store: MemoryStore
) -> None:
    spec = mapping_spec()
    plan = record("p1", 0.0, 20.0, user="ann", robot="tb1", map=spec.map.id, version="")
    with pytest.raises(NotPermitted, match="not published"):
        service.keep(spec, plan)
    asked = machine_link.FindPlans(1, (0.0, 0.0), (20.0, 0.0), "dijkstra", PARAMETERS, 0.18, 0.25, False)
    assert service.find(spec, asked) == []
    assert service.history(spec).rows == []


class CountingStore(MemoryStore):
    """Store that counts reads of plans."""

    def __init__(self) -> None:
        super().__init__()
        self.read = 0

    def plan(self, plan_id: str) -> PlanRecord:
        self.read += 1
        return super().plan(plan_id)


def test_plan_is_read_from_the_store_once() -> None:
    store = CountingStore()
    store.add_plan(plan("p1"))
    recent = RecentPlans(store)
    assert [recent.plan(without_poses(plan("p1"))) for _ in range(3)] == [plan("p1")] * 3
    assert store.read == 1


def test_replaced_plan_is_read_again() -> None:
    store, changed = CountingStore(), msgspec.structs.replace(plan("p1"), cost=7.0)
    store.add_plan(plan("p1"))
    recent = RecentPlans(store)
    recent.plan(without_poses(plan("p1")))
    store.replace_plan(changed, instead_of=plan("p1"))
    assert recent.plan(without_poses(changed)) == changed
    assert store.read == 2


def test_cache_evicts_the_least_recently_used_plan() -> None:
    store, plans = CountingStore(), [plan(f"p{number}") for number in range(3)]
    store.add_plans(plans)
    recent = RecentPlans(store, most_bytes=2 * len(plans[0].poses))
    for wanted in (0, 1, 0, 2, 0, 1):
        recent.plan(without_poses(plans[wanted]))
    assert store.read == 4, "the third evicted the second, which was then read again"


def test_removed_plan_is_not_found() -> None:
    with pytest.raises(NotFound):
        RecentPlans(CountingStore()).plan(without_poses(plan("p1")))
