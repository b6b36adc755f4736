"""After any sequence of additions, removals and replacements, a store of plans agrees with a plain list."""

import itertools
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from ppaas.errors import Conflict, NotFound
from ppaas.geometry import poses_along
from storage.memory.store import MemoryStore
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import PlanRecord
from storage.sqlite.store import SqliteStore
from storage.versions import without_poses
from tests.reference.plans import plan_bytes
from tests.support.budget import examples
from tests.support.storage.records import plan

STATIONS = [(0.025, 0.025), (3.025, 0.025), (3.025, 3.025), (0.025, 3.025)]

ids = st.sampled_from([f"p{number}" for number in range(6)])
ends = st.sampled_from(range(4))
offsets = st.sampled_from([0.0, 0.05, 0.1])
versions = st.sampled_from(["v1", "v2"])
created = st.sampled_from([1.0, 2.0, 3.5])


def path(plan_id: str, start: int, goal: int, off: float, version: str, made: float, planner: str) -> PlanRecord:
    """Return a plan around a square, from one corner to another; most of it is shared with other plans."""
    corners = [STATIONS[(start + step) % 4] for step in range((goal - start) % 4 + 1)]
    lines = [np.linspace(a, b, 60, endpoint=False) for a, b in itertools.pairwise(corners)]
    points = np.concatenate([*lines, [corners[-1]]])
    points[0] += off
    poses = poses_along(points, off)
    first, last = (tuple(points[end].tolist()) for end in (0, -1))
    return plan(
        plan_id, version=version, planner=planner, created=made, poses=poses.tobytes(), length=3.0 * len(lines) + off,
        start=(*first, 0.0), goal=(*last, off), parameters={"off": off},
    )  # fmt: skip


records = st.builds(path, ids, ends, ends, offsets, versions, created, st.sampled_from(["dijkstra", "astar"]))


class PlansInAnyOrder(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.plain: dict[str, PlanRecord] = {}
        self.stores: tuple[Store, ...] = (MemoryStore(), SqliteStore(Path(self.folder.name) / "store.db"))

    def teardown(self) -> None:
        for store in self.stores:
            store.close()
        self.folder.cleanup()

    def each(self, call: Callable[[Store], Any], expected: Any) -> None:
        for store in self.stores:
            try:
                answer = call(store)
            except (Conflict, NotFound) as error:
                answer = type(error)
            assert answer == expected, type(store)

    @rule(record=records)
    def add(self, record: PlanRecord) -> None:
        self.plain.setdefault(record.id, record)
        self.each(lambda store: store.add_plan(record), None)

    @rule(some=st.lists(records, max_size=4))
    def add_many(self, some: list[PlanRecord]) -> None:
        before = len(self.plain)
        for record in some:
            self.plain.setdefault(record.id, record)
        self.each(lambda store: store.add_plans(some), len(self.plain) - before)

    @rule(plan_id=ids)
    def remove(self, plan_id: str) -> None:
        expected = None if self.plain.pop(plan_id, None) else NotFound
        self.each(lambda store: store.remove_plan(plan_id), expected)

    @rule(map_id=st.sampled_from(["house", "yard"]))
    def remove_all(self, map_id: str) -> None:
        gone = [record.id for record in self.plain.values() if record.map == map_id]
        for plan_id in gone:
            del self.plain[plan_id]
        self.each(lambda store: store.remove_plans(map_id), len(gone))

    @rule(record=records, stale=st.booleans())
    def replace(self, record: PlanRecord, stale: bool) -> None:
        kept = self.plain.get(record.id)
        instead_of = kept if kept is not None and not stale else msgspec.structs.replace(record, seconds=9.0)
        expected = NotFound if kept is None else Conflict if kept != instead_of else None
        if expected is None:
            self.plain[record.id] = record
        self.each(lambda store: store.replace_plan(record, instead_of=instead_of), expected)

    @rule(start=ends, goal=ends, off=offsets, version=versions, tolerance=st.sampled_from([0.0, 0.1, 0.25]))
    def find(self, start: int, goal: int, off: float, version: str, tolerance: float) -> None:
        (x, y), to = STATIONS[start], STATIONS[goal]
        near = [
            without_poses(record)
            for record in self.plain.values()
            if record.version == version
            and plan_bytes.near(record.start[:2], record.goal[:2], (x + off, y), to, tolerance)
        ]
        near.sort(key=lambda record: (record.length, record.id))
        self.each(lambda store: store.find_plans(PlanStoreQuery("house", version, (x + off, y), to, tolerance)), near)

    @rule(start=ends, version=versions)
    def pass_through(self, start: int, version: str) -> None:
        """Each reported passage is right; not all passages must be reported."""
        (ax, ay), (bx, by) = STATIONS[start], STATIONS[(start + 1) % 4]
        first, last = (0.8 * ax + 0.2 * bx, 0.8 * ay + 0.2 * by), (0.2 * ax + 0.8 * bx, 0.2 * ay + 0.8 * by)
        for store in self.stores:
            for passes in store.plans_through(PlanStoreQuery("house", version, first, last, 0.1)):
                points = np.frombuffer(self.plain[passes.head.id].poses).reshape(-1, 7)[:, :2]
                assert passes.head == without_poses(self.plain[passes.head.id])
                assert plan_bytes.near(points[passes.first], points[passes.last], first, last, 0.1)
                assert passes.first < passes.last

    @invariant()
    def plans_equal_those_given(self) -> None:
        for plan_id, record in self.plain.items():
            self.each(lambda store, plan_id=plan_id: store.plan(plan_id), record)
        self.each(lambda store: store.whole_plans(["p9", *self.plain]), self.plain)
        newest = sorted(self.plain.values(), key=lambda record: (record.created, record.id), reverse=True)
        self.each(lambda store: store.plans("house"), [without_poses(record) for record in newest])

    @invariant()
    def no_entry_is_stored_without_a_plan(self) -> None:
        first, *others = (self.contents(store) for store in self.stores)
        assert all(other == first for other in others)
        if not self.plain:
            assert first[0][3] == 0

    def contents(self, store: Store) -> tuple[Any, ...]:
        counts = store.plan_statistics()
        parts = [store.plan_parts(plan_id) for plan_id in sorted(self.plain)]
        entries = {part.entry for each in parts for part in each}
        assert counts.entries == len(entries)
        return (counts.plans, counts.waypoints, counts.kept, counts.entries), parts


TestPlansInAnyOrder = PlansInAnyOrder.TestCase
TestPlansInAnyOrder.settings = settings(max_examples=examples(12), stateful_step_count=20)
