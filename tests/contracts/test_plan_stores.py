"""The contract of every ``PlanStore``."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from ppaas.geometry import poses_along
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import PlanRecord, PlanStatistics
from tests.support.storage.records import NOT_NAMES, plan

NAN, INF = math.nan, math.inf


def path(plan_id: str, *points: tuple[float, float], steps: int = 20, **fields: Any) -> PlanRecord:
    """Return a plan along straight lines, ``steps`` waypoints each."""
    corners = np.array(points)
    lines = [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(corners)]
    poses = poses_along(np.concatenate([*lines, corners[-1:]]), 0.0)
    length = float(np.hypot(*np.diff(corners, axis=0).T).sum())
    return plan(plan_id, **({"poses": poses.tobytes(), "length": length, "version": "v1"} | fields))


def head(record: PlanRecord) -> PlanRecord:
    return PlanRecord(**{name: getattr(record, name) for name in record.__struct_fields__} | {"poses": b""})


def test_many_plans_are_added_at_once_and_existing_ones_stay(store: Store) -> None:
    store.add_plan(plan("p1", cost=1.0))
    assert store.add_plans([plan("p1", cost=2.0), plan("p2"), plan("p3"), plan("p2", cost=3.0)]) == 2
    assert store.add_plans([]) == 0
    assert [store.plan(name).cost for name in ("p1", "p2", "p3")] == [1.0, 118.5, 118.5]


def test_many_plans_are_read_at_once(store: Store) -> None:
    kept = [path(f"p{number}", (0, 0), (5, number % 3), steps=90 + number) for number in range(9)] + [plan("q")]
    store.add_plans(kept)
    ids = [record.id for record in kept]
    assert store.whole_plans(["unknown", *ids[::-1], "p1"]) == {record.id: record for record in kept}
    assert store.whole_plans([]) == store.whole_plans(["unknown"]) == {}
    with pytest.raises(InvalidInput):
        store.whole_plans(["p1", "../p2"])


def test_parameters_and_origin_are_stored_with_a_plan(store: Store) -> None:
    kept = plan("p1", parameters={"weight": 1.5, "names": ["a", {"b": None}]}, origin="given")
    store.add_plan(kept)
    kept.parameters["names"].append("later")
    assert store.plan("p1").parameters == {"weight": 1.5, "names": ["a", {"b": None}]}
    assert store.plan("p1").origin == "given"
    assert store.plans("house")[0].origin == "given"


@pytest.mark.parametrize("parameters", [{}, {"names": ["a", {"b": None}]}])
def test_changing_returned_parameters_changes_no_other_plan(store: Store, parameters: dict[str, Any]) -> None:
    store.add_plans([path(name, (0, 0), (5, 0), parameters=parameters) for name in "ab"])
    search = PlanStoreQuery("house", "v1", (0.0, 0.0), (5.0, 0.0), 0.1)
    for _ in range(2):
        returned = [*store.find_plans(search), *store.plans("house"), store.plan("a"), store.plan("b")]
        assert [one.parameters for one in returned] == [parameters] * 6
        for one in returned:
            one.parameters.setdefault("names", []).append("changed")
        assert [one.parameters["names"].count("changed") for one in returned] == [1] * 6


@pytest.mark.parametrize("count", [1, 2, 3, 15, 16, 17, 33, 1000])
@pytest.mark.parametrize("seed", [0, 1])
def test_poses_are_bitwise_equal(store: Store, count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    wild = random.integers(0, 2**64, (count, 7), dtype=np.uint64).view("<f8")
    poses = np.where(np.isfinite(wild), wild, -0.0).tobytes()
    store.add_plan(plan("p1", poses=poses))
    assert store.plan("p1").poses == poses


def test_a_plan_is_replaced(store: Store) -> None:
    before = path("p1", (0, 0), (1, 0))
    after = path("p1", (5, 5), (6, 5), version="v2", map="depot", planner="astar", created=9.0)
    store.add_plan(before)
    store.replace_plan(after, instead_of=before)
    assert store.plan("p1") == after
    assert store.plans("house") == []
    assert store.plans("depot") == [head(after)]
    assert store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (1, 0), 0.1)) == []
    assert store.find_plans(PlanStoreQuery("depot", "v2", (5, 5), (6, 5), 0.1)) == [head(after)]


def test_a_plan_changed_meanwhile_is_not_replaced(store: Store) -> None:
    first = plan("p1", cost=1.0)
    store.add_plan(first)
    with pytest.raises(Conflict):
        store.replace_plan(plan("p1", cost=3.0), instead_of=plan("p1", cost=2.0))
    with pytest.raises(Conflict):
        store.replace_plan(plan("p1", cost=3.0), instead_of=plan("p1", cost=1.0, poses=bytes(56)))
    with pytest.raises(NotFound):
        store.replace_plan(plan("p2"), instead_of=plan("p2"))
    with pytest.raises(InvalidInput):
        store.replace_plan(plan("p1", cost=3.0), instead_of=plan("p2"))
    assert store.plan("p1") == first


def test_plans_are_found_by_their_ends_shortest_first(store: Store) -> None:
    direct = path("a", (0, 0), (3, 0))
    way_round = path("b", (0.1, 0), (1, 1), (3, 0.1))
    store.add_plans([way_round, direct, path("back", (3, 0), (0, 0)), path("far", (0, 0), (3, 0.4))])
    store.add_plans([path("old", (0, 0), (3, 0), version="v0"), path("off", (0, 0), (3, 0), map="depot")])
    found = store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (3, 0), 0.2))
    assert found == [head(direct), head(way_round)]
    assert store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (3, 0), 0.2), limit=1) == [head(direct)]
    assert store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (3, 0), 0.2), limit=0) == []
    assert store.find_plans(PlanStoreQuery("nowhere", "v1", (0, 0), (3, 0), 0.2)) == []


def test_plans_are_found_by_planner(store: Store) -> None:
    one, other = path("a", (0, 0), (3, 0), planner="astar"), path("b", (0, 0), (3, 0), planner="jps")
    store.add_plans([one, other])
    assert store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (3, 0), 0.0, planner="jps")) == [head(other)]
    assert store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (3, 0), 0.0)) == [head(one), head(other)]


@pytest.mark.parametrize("place", [-1000.25, -0.1, 0.0, 0.24999, 0.5])
@pytest.mark.parametrize("tolerance", [0.0, 0.25, 0.5])
def test_plans_are_found_up_to_the_tolerance_from_their_ends(store: Store, place: float, tolerance: float) -> None:
    start, goal = (place, -place), (place + 4, place)
    store.add_plan(path("a", start, goal))
    inside, outside = tolerance * 0.999, tolerance * 1.001 + 1e-6
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (0.6, 0.8)):
        for reach, expected in ((inside, 1), (outside, 0)):
            near = (start[0] + reach * dx, start[1] + reach * dy)
            assert len(store.find_plans(PlanStoreQuery("house", "v1", near, goal, tolerance))) == expected
            near = (goal[0] + reach * dx, goal[1] + reach * dy)
            assert len(store.find_plans(PlanStoreQuery("house", "v1", start, near, tolerance))) == expected


def test_plans_passing_two_places_in_order_are_found(store: Store) -> None:
    long = path("long", (0, 0), (10, 0), (10, 10), steps=100)
    store.add_plans([long, path("other", (0, 5), (8, 5), steps=100)])
    [passes] = store.plans_through(PlanStoreQuery("house", "v1", (3.02, 0.1), (10.1, 4.98), 0.25))
    assert passes.head == head(long)
    assert (passes.first, passes.last) == (30, 150)
    assert store.plans_through(PlanStoreQuery("house", "v1", (10, 5), (3, 0), 0.25)) == []
    assert store.plans_through(PlanStoreQuery("house", "v0", (3, 0), (10, 5), 0.25)) == []
    assert store.plans_through(PlanStoreQuery("house", "v1", (3, 0), (10, 5), 0.25, planner="astar")) == []
    assert store.plans_through(PlanStoreQuery("house", "v1", (3, 0), (10, 5), 0.25), limit=0) == []


def test_removed_plans_are_not_found(store: Store) -> None:
    store.add_plans([path("a", (0, 0), (5, 0), steps=100), path("b", (0, 0), (5, 0), steps=100)])
    store.remove_plan("a")
    assert [p.id for p in store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (5, 0), 0.1))] == ["b"]
    assert [p.head.id for p in store.plans_through(PlanStoreQuery("house", "v1", (1, 0), (4, 0), 0.1))] == ["b"]
    store.remove_plan("b")
    assert store.plan_statistics() == PlanStatistics()


def test_only_the_plans_of_the_given_map_are_removed(store: Store) -> None:
    store.add_plans(
        path(f"{map_id}-{version}{number}", (0, 0), (5, number), map=map_id, version=version, steps=99)
        for map_id, count in (("house", 150), ("house2", 3), ("yard", 2))
        for version in ("v1", "v2")
        for number in range(count)
    )
    others = [store.plan_statistics(map_id) for map_id in ("house2", "yard")]
    assert store.remove_plans("house") == 300
    assert store.plan_maps() == ["house2", "yard"]
    assert store.plans("house") == store.find_plans(PlanStoreQuery("house", "v1", (0, 0), (5, 0), 0.1)) == []
    assert store.plans_through(PlanStoreQuery("house", "v1", (1, 0), (4, 0), 0.1)) == []
    assert store.plan_statistics("house") == PlanStatistics()
    assert [store.plan_statistics(map_id) for map_id in ("house2", "yard")] == others
    with pytest.raises(NotFound):
        store.plan("house-v17")
    assert store.remove_plans("house") == 0
    again = path("house-v17", (0, 0), (5, 7))
    store.add_plan(again)
    assert store.plans("house") == [head(again)]


@pytest.mark.parametrize("name", NOT_NAMES)
def test_an_invalid_map_id_is_refused_by_remove_plans(store: Store, name: str) -> None:
    with pytest.raises(InvalidInput):
        store.remove_plans(name)


def test_statistics_count_plans_and_waypoints_of_a_map(store: Store) -> None:
    store.add_plans([path("a", (0, 0), (5, 0), steps=99), path("b", (0, 0), (5, 0), map="depot", steps=49)])
    statistics = store.plan_statistics("depot")
    assert (statistics.plans, statistics.waypoints) == (1, 50)
    assert 0 < statistics.kept <= 50
    assert statistics.bytes > 0
    statistics = store.plan_statistics()
    assert (statistics.plans, statistics.waypoints) == (2, 150)
    assert store.plan_statistics("nowhere") == PlanStatistics()


BAD = {
    "no pose": {"poses": b""},
    "half a pose": {"poses": bytes(28)},
    "a pose that is not a number": {"poses": np.array([0, 0, NAN, 0, 0, 0, 1.0]).tobytes()},
    "a pose that is infinite": {"poses": np.array([INF, 0, 0, 0, 0, 0, 1.0]).tobytes()},
    "too many poses": {"poses": bytes(56 * ((1 << 20) + 1))},
    "start": {"start": (NAN, 0.0, 0.0)},
    "goal": {"goal": (0.0, INF, 0.0)},
    "negative length": {"length": -1.0},
    "infinite length": {"length": INF},
    "cost": {"cost": NAN},
    "negative cost": {"cost": -1.0},
    "seconds": {"seconds": NAN},
    "created": {"created": INF},
    "no version": {"version": ""},
    "long planner": {"planner": "x" * 300},
    "a lone surrogate": {"user": "\ud800"},
    "parameters that cannot be stored": {"parameters": {"a": object()}},
}


@pytest.mark.parametrize("fields", BAD.values(), ids=list(BAD))
def test_invalid_plans_are_refused_and_nothing_is_stored(store: Store, fields: dict[str, Any]) -> None:
    kept = plan("kept")
    store.add_plan(kept)
    calls: list[Callable[[], object]] = [
        lambda: store.add_plan(plan("bad", **fields)),
        lambda: store.add_plans([plan("good"), plan("bad", **fields)]),
        lambda: store.replace_plan(plan("kept", **fields), instead_of=kept),
    ]
    for call in calls:
        with pytest.raises(InvalidInput):
            call()
    assert store.plans("house") == [head(kept)]
    assert store.plan("kept") == kept


@pytest.mark.parametrize("text", ["'; DROP TABLE plans; --", '"', "%", "v_1", "\0", "ä" * 256])
def test_texts_are_stored_unchanged(store: Store, text: str) -> None:
    record = path("a", (0, 0), (1, 0), user=text, version=text, planner=text, robot=text, parameters={text: text})
    store.add_plan(record)
    assert store.plan("a") == record
    assert store.find_plans(PlanStoreQuery("house", text, (0, 0), (1, 0), 0.1, planner=text)) == [head(record)]
    assert store.find_plans(PlanStoreQuery("house", "v", (0, 0), (1, 0), 0.1)) == []


SEARCHES = {
    "start": ((NAN, 0.0), (1.0, 0.0), 0.1),
    "goal": ((0.0, 0.0), (1.0, -INF), 0.1),
    "tolerance": ((0.0, 0.0), (1.0, 0.0), NAN),
    "negative": ((0.0, 0.0), (1.0, 0.0), -0.1),
    "too far": ((0.0, 0.0), (1.0, 0.0), 1.5),
}


@pytest.mark.parametrize("search", SEARCHES.values(), ids=list(SEARCHES))
def test_invalid_searches_are_refused(search: tuple[Any, Any, float]) -> None:
    with pytest.raises(InvalidInput):
        PlanStoreQuery("house", "v", *search)
    with pytest.raises(InvalidInput):
        PlanStoreQuery("../etc", "v", (0.0, 0.0), (1.0, 0.0), 0.1)


def test_unknown_plans_have_no_parts(store: Store) -> None:
    with pytest.raises(NotFound):
        store.plan_parts("p1")
    with pytest.raises(InvalidInput):
        store.plan_parts("../p1")


def test_only_maps_with_plans_are_listed(store: Store) -> None:
    assert store.plan_maps() == []
    for number, map_id in enumerate(("yard", "House", "house", "house")):
        store.add_plan(plan(f"p{number}", map=map_id))
    assert store.plan_maps() == ["House", "house", "yard"]
    store.remove_plan("p0")
    store.remove_plan("p2")
    assert store.plan_maps() == ["House", "house"]
