"""Comparison with peers: right answers have no error, and others the right error."""

import numpy as np
import pytest
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.planners import compare, field, grids
from benchmarks.planners.peers import FIELDS, NAVFN, PATHS, Peer, PeerProblem, edges_of
from ppaas.distribution import NAME, install_hint
from ppaas.errors import InvalidParameter, InvalidPlanner, NotFound

GRID = grids.random(24, 20.0)
INSTALLED = [peer for peer in (*FIELDS, *PATHS) if peer.installed]
SCIPY = next(peer for peer in FIELDS if peer.package == "scipy")


def problem() -> PeerProblem:
    goal = grids.goal_in(GRID.costmap)
    return PeerProblem(GRID.costmap, goal, field.farthest(field.grow(GRID.costmap, goal, 1)))


def measure(monkeypatch: pytest.MonkeyPatch, fields: tuple[Peer, ...], paths: tuple[Peer, ...] = ()) -> dict:
    monkeypatch.setattr(compare, "BESIDE", {peer.package: peer for peer in fields})
    monkeypatch.setattr(compare, "PATHS", paths)
    with Progress(disable=True) as progress:
        return compare.measure(GRID, None, [1], (), progress)


def doubled(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values * 2.0


def test_the_exact_field_of_scipy_equals_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    result = measure(monkeypatch, (SCIPY,))
    ours, scipy = result["fields"]
    assert ours["who"] == "ppaas dijkstra, 1 thread"
    assert scipy["off"] < 1e-4 and scipy["other_cells"] == 0
    assert scipy["ratio"] == scipy["seconds"] / ours["seconds"]
    assert (ours["ratio"], result["left_out"]) == (1.0, {})


def test_a_wrong_field_has_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def double_values(values: NDArray[np.float64], problem: PeerProblem) -> NDArray[np.float64]:
        field = doubled(SCIPY.told(values, problem))
        field[problem.goal] = np.inf
        return field

    spoiled = Peer("f", "scipy", SCIPY.module, "twice", SCIPY.prepare, double_values)
    row = measure(monkeypatch, (spoiled,))["fields"][1]
    assert row["off"] == pytest.approx(1.0, rel=1e-3)
    assert row["other_cells"] == 1


def test_an_undrivable_path_is_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = Peer("f", "scipy", "scipy", "a leap", lambda _, task: lambda: [task.start, task.goal],
                lambda cells, _: np.array(cells))  # fmt: skip
    result = measure(monkeypatch, (), (ends,))
    ours = {row["who"]: row for row in result["paths"] if row["ours"]}
    assert ours["ppaas dijkstra"]["walkable"] and ours["ppaas dijkstra"]["off"] == pytest.approx(0.0, abs=1e-9)
    assert not result["paths"][-1]["walkable"] and result["paths"][-1]["off"] < 0.0


def test_the_field_of_navfn_is_close_to_ours_for_the_same_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, navfn = measure(monkeypatch, (NAVFN,))["fields"]
    assert navfn["who"] == "ppaas navfn, 1 thread" and not navfn["ours"]
    assert 0.0 < navfn["off"] < 0.1 and navfn["other_cells"] == 0
    assert ours["ratio"] == 1.0


def test_a_planner_whose_index_takes_too_long_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare, "PATIENCE", -1.0)
    monkeypatch.setattr(compare, "OURS", ("dijkstra", "jps"))
    result = measure(monkeypatch, ())
    assert [row["who"] for row in result["paths"]] == ["ppaas dijkstra"]
    assert result["left_out"] == {"ppaas jps": "its index takes longer than -1 s"}


def test_all_own_planners_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    result = measure(monkeypatch, ())
    assert {row["who"] for row in result["paths"]} >= {"ppaas dijkstra", "ppaas astar"}


def test_an_unknown_peer_is_refused_with_the_known_ones() -> None:
    with Progress(disable=True) as progress, pytest.raises(NotFound, match="tcod"):
        compare.measure(GRID, None, [1], ("tcodd",), progress)


@pytest.mark.parametrize("peer", INSTALLED, ids=lambda peer: f"{peer.package} {peer.name}")
def test_every_installed_peer_answers(peer: Peer) -> None:
    task = problem()
    found = peer.told(peer.call(task)[1](), task)
    if peer in FIELDS:
        exact = field.grow(task.costmap, task.goal, 1).values()
        both = np.isfinite(exact) & (exact > 0.0)
        assert np.isfinite(found[both]).all()
        assert np.abs(found[both] / exact[both] - 1.0).mean() < 0.35
    else:
        assert found[0].tolist() == list(task.start) and found[-1].tolist() == list(task.goal)


def test_a_move_costs_the_weight_of_its_target_and_cuts_no_corner() -> None:
    weights = np.array([[1.0, 2.0], [3.0, np.inf]])
    moves = {(int(a), int(b)): cost for a, b, cost in zip(*edges_of(weights), strict=True)}
    assert moves == {(0, 1): 2.0, (1, 0): 1.0, (0, 2): 3.0, (2, 0): 1.0}
    assert (0, 3) in {(int(a), int(b)) for a, b, _ in zip(*edges_of(np.ones((2, 2))), strict=True)}


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
