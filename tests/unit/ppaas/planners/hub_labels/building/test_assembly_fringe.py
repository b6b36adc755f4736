"""If memory for labels is short, the least important corners get none, and paths stay shortest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.hub_labels.building import assembly
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.kernels.layout import CORNERS, LABELLED
from ppaas.planners.hub_labels.planner import HubIndex
from ppaas.planners.watch import proceed
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
