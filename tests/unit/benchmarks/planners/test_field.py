"""Results of the field bench."""

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.planners import field, grids
from benchmarks.planners.peers import NAVFN, Peer
from ppaas.distribution import NAME, install_hint
from ppaas.errors import InvalidParameter, InvalidPlanner


def test_every_number_of_threads_is_timed_and_all_cells_are_counted() -> None:
    grid = grids.random(40, 30.0)
    with Progress(disable=True) as progress:
        result = field.measure(grid, None, [1, 2], progress, runs=2)
    assert result["cells"] == 1600
    reached = np.isfinite(field.grow(grid.costmap, tuple(result["goal"]), 1).values()).sum()
    assert result["reached"] == reached > 800
    for n in ("1", "2"):
        assert result["again_seconds"][n] > 0.0
        assert result["ns_per_cell"][n] == pytest.approx(result["seconds"][n] / reached * 1e9)
        assert result["seconds"][n] > 0.0
    assert result["compile_seconds"] >= 0.0


def test_the_time_after_a_pause_is_the_median_without_the_pause(monkeypatch) -> None:
    slept: list[float] = []
    monkeypatch.setattr(field, "sleep", slept.append)
    monkeypatch.setattr(field, "APART", 3)
    monkeypatch.setattr(field, "timed", lambda work: (float(len(slept)), work()))
    with Progress(disable=True) as progress:
        result = field.with_pauses(grids.empty(40), (20, 20), [1, 2], 5.0, progress)
    assert slept == [5.0] * 6
    assert result == {"1": 3.0, "2": 4.0}


def test_others_are_measured_or_left_out_with_a_reason() -> None:
    absent = Peer("f", "absent-peer", "absent_peer", "nothing", NAVFN.prepare, NAVFN.told)
    too_far = Peer("f", NAME, "ppaas", "nothing", lambda *_: raise_too_far, NAVFN.told)
    with Progress(disable=True) as progress:
        others = {"navfn": NAVFN, "absent": absent, "far": too_far}
        result = field.measure(grids.empty(40), None, [1], progress, runs=1, others=others)
    assert set(result["beside"]) == {"navfn"} and result["beside"]["navfn"] > 0.0
    assert result["left_out"] == {"absent": f"not installed: {install_hint('bench')}", "far": "too far"}


def raise_too_far() -> None:
    raise InvalidPlanner("too far")


def test_caches_of_a_map_are_not_used_for_its_copy() -> None:
    costmap = grids.empty(4).costmap
    again = field.uncached(costmap)
    assert again.data is not costmap.data and (again.data == costmap.data).all()
    assert not again.data.flags.writeable


@pytest.mark.parametrize("threads", [[], [0], [1, -1]])
def test_a_field_needs_at_least_one_thread(threads: list[int]) -> None:
    with Progress(disable=True) as progress, pytest.raises(InvalidParameter):
        field.measure(grids.empty(4), None, threads, progress)


def test_the_farthest_cell_has_the_highest_cost() -> None:
    assert field.farthest(field.grow(grids.empty(9).costmap, (1, 1), 1)) == (8, 8)
