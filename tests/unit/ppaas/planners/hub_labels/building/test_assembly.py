"""Indexes short of memory still give shortest paths; a repaired one answers like a new one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.ends import Ends
from ppaas.planners.hub_labels.building import assembly
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.building.graph import build_corner_map, repair_corner_map
from ppaas.planners.hub_labels.kernels.layout import CORNERS, LABELLED
from ppaas.planners.hub_labels.planner import HubIndex, HubLabels, differing
from ppaas.planners.watch import proceed
from tests.reference.planners import hub_labels as twin
from tests.support.world import grids
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps
from tests.unit.ppaas.planners.hub_labels.test_planner import assert_all_paths_are_shortest


@pytest.fixture
def limit_entries(monkeypatch):
    """Return a function that limits the label entries, however few that leaves per corner."""

    def limit(entries: int) -> None:
        monkeypatch.setattr(assembly, "most_label_entries", lambda *_: entries)
        monkeypatch.setattr(assembly, "LEAST_ENTRIES", 0)

    return limit


def index_of(free) -> HubIndex:
    return HubIndex(build_index(free, threads=2, check=proceed))


def some(free, count: int) -> list[tuple[int, int]]:
    cells = np.argwhere(free)
    return [tuple(cells[i].tolist()) for i in np.random.default_rng(1).integers(0, len(cells), count)]


@given(free=maps(12), entries=st.sampled_from([0, 10, 40]), gates=st.sampled_from([0, 6]))
def test_paths_are_shortest_for_any_number_of_labels(free, entries, gates):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(assembly, "most_label_entries", lambda *_: entries)
        patch.setattr(assembly, "LEAST_ENTRIES", 0)
        patch.setattr(assembly, "MANY_GATES", gates)
        index = index_of(free)
    assert_all_paths_are_shortest(free, index, some(free, 5) if free.any() else [])


@pytest.mark.parametrize(("entries", "labelled"), [(0, 0), (4000, 0.25), (14_000, 0.75), (10**6, 1)])
def test_labelled_share_of_corners_follows_the_entry_limit(limit_entries, entries, labelled):
    limit_entries(entries)
    free = np.random.default_rng(6).random((60, 60)) > 0.3
    index = index_of(free)
    assert index.words[LABELLED] / index.words[CORNERS] == pytest.approx(labelled, abs=0.2)
    assert_all_paths_are_shortest(free, index, some(free, 4))


def test_repaired_index_obeys_the_entry_limit(limit_entries):
    limit_entries(3000)
    free = np.random.default_rng(6).random((60, 60)) > 0.3
    index = index_of(free)
    free[20:30, 20:30] = True
    repaired = index.repaired(free, (slice(20, 30), slice(20, 30)), threads=2)
    assert 0 < repaired.words[LABELLED] < repaired.words[CORNERS]
    assert_all_paths_are_shortest(free, repaired, some(free, 4))


@pytest.mark.parametrize("entries", [0, 9000])
def test_core_is_contracted_further_until_its_labels_fit(limit_entries, entries):
    free = np.random.default_rng(5).random((100, 100)) > 0.1
    limit_entries(entries)
    index = index_of(free)
    assert index.words[LABELLED] < index.words[CORNERS] // 2
    assert_all_paths_are_shortest(free, index, some(free, 1))


def repairable_index_of(free) -> HubIndex:
    return HubIndex(build_index(free, threads=1, check=proceed))


def costmap(free, **others):
    return grids.of(np.where(free, 0, 254).astype(np.uint8), **others)


@st.composite
def changes(draw):
    before = draw(maps(12))
    after = before.copy()
    rows, columns = (slice(*sorted(draw(st.tuples(st.integers(0, n), st.integers(0, n))))) for n in before.shape)
    patch = np.random.default_rng(draw(st.integers(0, 99))).random(after[rows, columns].shape)
    after[rows, columns] = patch < draw(st.sampled_from([0.0, 0.5, 1.0]))
    return before, after, (rows, columns)


@given(changes())
def test_repaired_corner_map_equals_a_new_one(change):
    before, after, rectangle = change
    mended = repair_corner_map(
        build_corner_map(before, threads=1, check=proceed).terrain, after, rectangle, check=proceed
    )
    fresh = build_corner_map(after, threads=1, check=proceed)
    np.testing.assert_array_equal(mended.terrain, fresh.terrain)
    np.testing.assert_array_equal(mended.positions, fresh.positions)


@given(changes())
def test_repaired_index_answers_like_a_new_one(change):
    before, after, rectangle = change
    repaired, fresh = repairable_index_of(before).repaired(after, rectangle), repairable_index_of(after)
    cells = [(int(r), int(c)) for r, c in zip(*np.nonzero(after), strict=True)]
    for start in cells[::4]:
        for goal in cells:
            one, other = repaired.path(*start, *goal), fresh.path(*start, *goal)
            assert len(one) == 0 if len(other) == 0 else (tuple(one[0]), tuple(one[-1])) == (start, goal)
            assert twin.length_of(after, one) == pytest.approx(twin.length_of(after, other))


def test_repeatedly_repaired_index_answers_like_a_new_one():
    rng = np.random.default_rng(8)
    free = rng.random((120, 140)) > 0.15
    free[40:80, 50:100] = True
    index = repairable_index_of(free)
    for _ in range(4):
        row, column = rng.integers(0, 100, 2)
        rectangle = slice(row, row + 20), slice(column, column + 20)
        free = free.copy()
        free[rectangle] = rng.random((20, 20)) > 0.3
        index = index.repaired(free, rectangle, threads=2)
        fresh = repairable_index_of(free)
        cells = np.argwhere(free)
        for start, goal in cells[rng.integers(0, len(cells), (200, 2))]:
            one, other = index.path(*start, *goal), fresh.path(*start, *goal)
            assert twin.length_of(free, one) == pytest.approx(twin.length_of(free, other))


def test_differing_returns_the_bounding_rectangle_of_changes():
    before = np.zeros((9, 8), np.bool_)
    now = before.copy()
    assert differing(before, now) == (slice(0, 0), slice(0, 0))
    now[2, 6] = now[5, 3] = True
    assert differing(before, now) == (slice(2, 6), slice(3, 7))


@pytest.fixture
def events(monkeypatch):
    """Return a list of what was built and repaired, in order."""
    events = []
    build, repair = HubLabels.__module__ + ".build_index", HubIndex.repaired

    def built(free, **others):
        events.append("built")
        return build_index(free, **others)

    def repaired(self, *arguments, **others):
        events.append("repaired")
        return repair(self, *arguments, **others)

    monkeypatch.setattr(build, built)
    monkeypatch.setattr(HubIndex, "repaired", repaired)
    return events


def plan(planner, free, **others):
    request = PlanRequest(Pose2D(0.5, 5.5), Pose2D(19.5, 5.5))
    return planner.plan(costmap(free, **others), request)


def test_index_is_repaired_only_for_changes_that_affect_the_path(events):
    planner, free = HubLabels(), np.ones((11, 20), np.bool_)
    free[3, 4] = False
    assert len(plan(planner, free).cells) == 20
    beside = free.copy()
    beside[9, 9] = False
    assert len(plan(planner, beside).cells) == 20
    assert events == ["built"]
    blocked_free = free.copy()
    blocked_free[1:10, 9] = False
    for _ in range(2):
        result = plan(planner, blocked_free)
        assert result.cost / 50 == pytest.approx(twin.lengths_from(blocked_free, (5, 0))[5, 19])
    assert events == ["built", "repaired"]
    opened = free.copy()
    opened[3, 4] = True
    assert len(plan(planner, opened).cells) == 20
    assert events == ["built", "repaired", "repaired"]


@given(changes())
def test_paths_past_obstacles_are_shortest_and_known_changes_make_no_difference(change):
    before, after, window = change
    static = costmap(before).read_only()
    current = static.copied(window)
    current.data[window] = costmap(after).data[window]
    planner = HubLabels()
    cells = np.argwhere(after)
    for start, goal in cells[np.random.default_rng(3).integers(0, len(cells), (5, 2))] if len(cells) else ():
        ends = Ends(tuple(start), tuple(goal), np.empty((0, 2), np.int32), Pose2D(0.0, 0.0))
        found = planner.search(current, ends, threads=1, check=proceed)
        length = twin.lengths_from(after, tuple(start))[tuple(goal)]
        assert twin.length_of(after, found.cells) == pytest.approx(length) if len(found.cells) else length == np.inf


def test_an_index_is_repaired_only_for_known_changes_that_affect_the_path(events):
    planner, free = HubLabels(), np.ones((11, 20), np.bool_)
    free[3, 4] = False
    static, request = costmap(free).read_only(), PlanRequest(Pose2D(0.5, 5.5), Pose2D(19.5, 5.5))

    def plan_with(cells, cost):
        current = static.copied(*((slice(row, row + 1), slice(column, column + 1)) for row, column in cells))
        for cell in cells:
            current.data[cell] = cost
        return planner.plan(current, request)

    assert len(plan_with([(9, 9), (1, 1)], 254).cells) == 20
    assert len(planner.plan(static, request).cells) == 20
    assert events == ["built"], "the map and what a robot sees share the index"
    wall = [(row, 9) for row in range(1, 10)]
    for _ in range(2):
        assert plan_with(wall, 254).cost / 50 > 20.0
    assert events == ["built", "repaired"]
    plan_with([(3, 4)], 0)
    assert events == ["built", "repaired", "repaired"], "a cell is free that the map has blocked"


def test_shared_index_of_the_bare_map_is_used(events):
    free = np.ones((11, 20), np.bool_)
    free[3, 4] = False
    content = memoryview(build_index(free, threads=1, check=proceed)).cast("B")
    blocked_free = free.copy()
    blocked_free[1:10, 9] = False
    plan(HubLabels(), blocked_free, indexes=lambda planner, check: content)
    assert events == ["repaired"]


def test_twin_shares_the_index_of_the_bare_map(events):
    planner, free = HubLabels(), np.ones((11, 20), np.bool_)
    plan(planner, free)
    plan(planner.twin(), free)
    assert events == ["built"]
